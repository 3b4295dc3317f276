"""Turns the options into a session."""

from __future__ import annotations

import os
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.errors import LpbError, in_one_line
from pytest_lpb.kpis.registry import default_registry, load_builtin
from pytest_lpb.names import listed, suggestion
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.files import find_planners, parted, with_path
from pytest_lpb.plugin.expectation import check_known_failures
from pytest_lpb.plugin.gating import checked_gate, gate_options, restore_gate
from pytest_lpb.plugin.options import CHECKED, PARTS, REPORTS, chosen_planners, is_worker, split_names
from pytest_lpb.plugin.places import (
    extend_search_path,
    ini_folder,
    planner_folders,
    reports_folder,
    rootdir_of,
    run_path,
)
from pytest_lpb.plugin.session import LpbSession, Source
from pytest_lpb.plugin.sources import as_arguments, restore, run_folder_of, study_of, take_problems, typed_options
from pytest_lpb.run.folder import RUN_FILE, RunFolder
from pytest_lpb.run.plan import trials_of
from pytest_lpb.run.plugins import load_kpi_entry_points
from pytest_lpb.run.title import checked_title, title_from, title_of
from pytest_lpb.scenario.schema.file import MAX_TRIALS
from pytest_lpb.scenario.schema.success import MAX_SEED
from pytest_lpb.study.recorded import recorded_families
from pytest_lpb.study.study import Study


def resolved_session(config: pytest.Config) -> LpbSession:
    """What the options, the ini file, a study or an old run ask for. Raises LpbError for what is wrong."""
    # These take what a study or an old run says as options; all that follows reads options alone.
    resumed, problems, typed, study = _resumed(config), _problems(config), typed_options(config), study_of(config)
    _check_numbers(config)
    extend_search_path(config)
    modules = _load_plugins(config)
    if config.getoption("lpb_render"):
        from pytest_lpb.environment.picture import check_display

        check_display()
    references = _from_folder(_asked_for(config), config)
    planners, kpis, reports = _planners(references, study, config), _kpis(config), reports_folder(config)
    gate = None if is_worker(config) else gate_options(config, ini_folder(config))
    session = LpbSession(
        planners=planners,
        references=_shown_references(references, config.invocation_params.dir),
        flags=tuple(part for part in PARTS if config.getoption(f"lpb_random_{part}")),
        first_seed=config.getoption("lpb_seed"),
        trials=config.getoption("lpb_trials"),
        assertion=config.getoption("lpb_assert") or "trial",
        render=config.getoption("lpb_render"),
        kpis=kpis,
        modules=modules,
        reports=reports,
        run=run_path(config, reports, resumed),
        rootdir=rootdir_of(config),
        invocation=config.invocation_params.dir,
        workers=_workers(config),
        options=typed,
        planned=None if resumed is None else trials_of(resumed.info()["planned"]),
        gate=gate,
        checked_gate=checked_gate(gate, config.invocation_params.dir, [planner.name for planner in planners], kpis),
        reported=_reported(config),
        checked_trials=_checked_trials(config),
        title=_title(config, study, resumed),
    )
    return replace(session, source=_source(session, study, problems, typed))


def _resumed(config: pytest.Config) -> RunFolder | None:
    """The run to finish, its options taken."""
    value = config.getoption("lpb_resume")
    if value is None:
        return None
    run = run_folder_of(config, "resume", value)
    restore(config, run)
    restore_gate(config, run)
    return run


def _problems(config: pytest.Config) -> RunFolder | None:
    """The old run whose problems are asked for, as the run's only argument."""
    value = config.getoption("lpb_problems")
    if value is None:
        return None
    run = run_folder_of(config, "problems", value)
    # `latest` leads to the new run soon: what is recorded, and repeats trials, names the folder itself.
    config.option.lpb_problems = os.path.relpath(run.path, config.invocation_params.dir)
    take_problems(config, run)
    return run


def _check_numbers(config: pytest.Config) -> None:
    for name, least, most in (("trials", 1, MAX_TRIALS), ("seed", 0, MAX_SEED - MAX_TRIALS)):
        value = config.getoption(f"lpb_{name}")
        if value is not None and not least <= value <= most:
            raise LpbError(f"--lpb-{name}: found {value}; allowed are {least} to {most}")


def _reported(config: pytest.Config) -> bool:
    """Whether tables and report are made at the end."""
    found: str = config.getoption("lpb_report") or config.getini("lpb_report") or REPORTS[0]
    if found not in REPORTS:
        raise LpbError(f"ini lpb_report: found {found!r}; allowed are {listed(REPORTS)}{suggestion(found, REPORTS)}")
    return found == REPORTS[0]


def _checked_trials(config: pytest.Config) -> int | None:
    """How many trials of each planner are run again; None without `--lpb-check-isolation`."""
    count: int | None = config.getoption("lpb_check_trials")
    if not config.getoption("lpb_check_isolation"):
        if count is not None:
            raise LpbError("--lpb-check-trials says how many trials --lpb-check-isolation runs again: give both")
        return None
    if count is not None and count < 1:
        raise LpbError(f"--lpb-check-trials: found {count}; allowed are 1 and more")
    return CHECKED if count is None else count


def _title(config: pytest.Config, study: Study | None, resumed: RunFolder | None) -> str:
    """The title of the option, else of the study, else of the ini file; a run that is finished keeps its own."""
    given: str | None = config.getoption("lpb_title")
    title = "" if given is None else checked_title(given, "--lpb-title")
    if resumed is not None:
        own = title_of(resumed.info())
        if given is not None and title != own:
            raise LpbError(
                f"--lpb-resume: {resumed.path.name} has {f'the title {own!r}' if own else 'no title'}, and keeps it: "
                "leave --lpb-title out"
            )
        return own
    if given is not None:
        return title
    if study is not None:
        return title_from(study.content.study)
    return checked_title(config.getini("lpb_title"), "ini lpb_title")


def _load_plugins(config: pytest.Config) -> list[str]:
    """Import what registers KPIs and plots; the names of `lpb_plugins`, which the run records."""
    load_builtin()
    load_kpi_entry_points()
    modules = split_names(config.getini("lpb_plugins"))
    for module in modules:
        try:
            import_module(module)
        except LpbError:
            raise
        except Exception as error:
            # A module may raise anything while it is imported.
            raise LpbError(f"lpb_plugins: cannot import {module!r}: {in_one_line(error)}") from error
    return modules


def _asked_for(config: pytest.Config) -> list[str]:
    """References of the planners to run."""
    references = chosen_planners(config)
    if not references:
        raise LpbError("--lpb-problems: choose planners to run the problems with: --lpb-planners=A,B")
    return references


def _from_folder(references: list[str], config: pytest.Config) -> list[str]:
    """References whose paths are absolute: options speak of the invocation directory, ini values of the ini file's."""
    from_option = config.getoption("--lpb-planners") is not None
    folder = config.invocation_params.dir if from_option else ini_folder(config)
    return [with_path(reference, lambda path: str(folder / path)) for reference in references]


def _planners(references: list[str], study: Study | None, config: pytest.Config) -> list[PlannerConfiguration]:
    planners = find_planners(references, planner_folders(config))
    for planner in planners:
        check_known_failures(planner)
    return planners if study is None else study.planners(planners)


def _shown_references(references: list[str], folder: Path) -> dict[str, str]:
    """By planner name, the reference to type in a folder to choose the planner again."""
    return {
        parted(reference)[0]: with_path(reference, lambda path: os.path.relpath(path, folder))
        for reference in references
    }


def _kpis(config: pytest.Config) -> list[str] | None:
    """Names of the KPIs asked for, checked; None: all."""
    given = config.getoption("lpb_kpis")
    if given is None:
        return None
    names = split_names(given)
    if not names:
        raise LpbError("--lpb-kpis: found no name; leave the option out for all KPIs")
    default_registry.select(names)
    return names


def _workers(config: pytest.Config) -> int:
    """Processes that run trials at the same time."""
    if is_worker(config):
        return int(config.workerinput["workercount"])  # type: ignore[attr-defined] # xdist adds it
    specifications = [spec.partition("*") for spec in getattr(config.option, "tx", None) or []]
    return max(1, sum(int(count) if star else 1 for count, star, _ in specifications))


def _source(
    session: LpbSession, study: Study | None, problems: RunFolder | None, typed: dict[str, Any]
) -> Source | None:
    """What names the problems, unless scenario files do."""
    options = as_arguments(typed)
    if study is not None:
        families = study.families(session.scenario_key)
        return Source(study.path, families, study.swept(families), options)
    if problems is not None:
        return Source(problems.path / RUN_FILE, recorded_families(problems.path), {}, options)
    return None
