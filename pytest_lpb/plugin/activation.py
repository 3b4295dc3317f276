"""Turns the options into a session, or into a usage error."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.errors import LpbError, in_one_line
from pytest_lpb.kpis.registry import default_registry, load_builtin
from pytest_lpb.planner.files import find_planners, parted, with_path
from pytest_lpb.plugin.collection import CollectionPlugin, register_tags
from pytest_lpb.plugin.expectation import check_known_failures
from pytest_lpb.plugin.gating import checked_gate, gate_options, restore_gate
from pytest_lpb.plugin.options import CHECKED, PARTS, chosen_planners, split_names
from pytest_lpb.plugin.orphans import end_with_parent
from pytest_lpb.plugin.session import SESSION, WORKER_CONTROLLER, WORKER_ROOT, WORKER_RUN, LpbSession, Source
from pytest_lpb.plugin.sources import as_arguments, restore, run_folder_of, study_of, take_problems, typed_options
from pytest_lpb.plugin.worker import WorkerPlugin
from pytest_lpb.run.folder import RUN_FILE, RunFolder, check_writable, new_run_folder
from pytest_lpb.run.plan import trials_of
from pytest_lpb.run.plugins import load_kpi_entry_points
from pytest_lpb.scenario.schema.file import MAX_TRIALS
from pytest_lpb.scenario.schema.success import MAX_SEED
from pytest_lpb.study.recorded import recorded_families
from pytest_lpb.study.study import Study


def activate(config: pytest.Config) -> None:
    """Set the session up and register the hooks. Raises UsageError for options that are wrong."""
    try:
        session = _session(config)
    except LpbError as error:
        raise pytest.UsageError(str(error)) from error
    config.stash[SESSION] = session
    register_tags(config)
    manager = config.pluginmanager
    manager.register(CollectionPlugin(session), "lpb-collection")
    manager.register(WorkerPlugin(), "lpb-worker")
    if is_worker(config):
        end_with_parent(config.workerinput[WORKER_CONTROLLER])  # type: ignore[attr-defined] # xdist adds it
    else:
        # Tables and reports are the controller's business: workers start without pandas and the like.
        from pytest_lpb.plugin.controller import ControllerPlugin
        from pytest_lpb.plugin.termination import TerminationPlugin

        termination = TerminationPlugin()
        controller = ControllerPlugin(session, config, termination)
        manager.register(controller, "lpb-controller")
        manager.register(termination, "lpb-termination")
        if manager.hasplugin("xdist"):
            from pytest_lpb.plugin.crashes import CrashPlugin

            manager.register(CrashPlugin(session, controller.tell), "lpb-crashes")


def is_worker(config: pytest.Config) -> bool:
    """Whether this process is one of xdist's workers."""
    return hasattr(config, "workerinput")


def _session(config: pytest.Config) -> LpbSession:
    resumed = _resumed(config)
    problems = _problems(config)
    typed = typed_options(config)
    study = study_of(config)
    references = chosen_planners(config)
    if not references:
        raise LpbError("--lpb-problems: choose planners to run the problems with: --lpb-planners=A,B")
    for name, least, most in (("trials", 1, MAX_TRIALS), ("seed", 0, MAX_SEED - MAX_TRIALS)):
        value = config.getoption(f"lpb_{name}")
        if value is not None and not least <= value <= most:
            raise LpbError(f"--lpb-{name}: found {value}; allowed are {least} to {most}")
    for folder in (config.invocation_params.dir, config.rootpath):
        # Planners' modules are looked up here; scenarios elsewhere move the rootdir, not the planner repository.
        if str(folder) not in sys.path:
            sys.path.insert(0, str(folder))
    modules = _load_plugins(config)
    if config.getoption("lpb_render"):
        from pytest_lpb.environment.picture import check_display

        check_display()
    resolved = _from_folder(references, config)
    planners = find_planners(resolved, _planner_folders(config))
    for planner in planners:
        check_known_failures(planner)
    reports = _reports_folder(config)
    kpis = _kpis(config)
    planners = planners if study is None else study.planners(planners)
    gate, checked = None, None
    if not is_worker(config):
        gate = gate_options(config, _ini_folder(config))
        checked = checked_gate(gate, config.invocation_params.dir, [planner.name for planner in planners], kpis)
    session = LpbSession(
        planners=planners,
        references=_shown_references(resolved, config.invocation_params.dir),
        flags=tuple(part for part in PARTS if config.getoption(f"lpb_random_{part}")),
        first_seed=config.getoption("lpb_seed"),
        trials=config.getoption("lpb_trials"),
        assertion=config.getoption("lpb_assert") or "trial",
        render=config.getoption("lpb_render"),
        kpis=kpis,
        modules=modules,
        reports=reports,
        run=_run_path(config, reports, resumed),
        rootdir=_rootdir(config),
        invocation=config.invocation_params.dir,
        workers=_workers(config),
        options=typed,
        planned=None if resumed is None else trials_of(resumed.info()["planned"]),
        gate=gate,
        checked_gate=checked,
        checked_trials=_checked_trials(config),
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


def _run_path(config: pytest.Config, reports: Path, resumed: RunFolder | None) -> Path:
    """The run folder: a new one, the one to finish, or in workers what the controller said."""
    if is_worker(config):
        return Path(config.workerinput[WORKER_RUN])  # type: ignore[attr-defined] # xdist adds it
    if resumed is not None:
        return resumed.path
    if not config.option.collectonly:
        check_writable(reports)
    return new_run_folder(reports)


def _rootdir(config: pytest.Config) -> Path:
    """The controller's rootdir: workers, which see the arguments only, may find another."""
    root: Path | str = config.workerinput[WORKER_ROOT] if is_worker(config) else config.rootpath  # type: ignore[attr-defined] # xdist adds it
    return Path(root)


def _shown_references(references: list[str], folder: Path) -> dict[str, str]:
    """By planner name, the reference to type in a folder to choose the planner again."""
    return {
        parted(reference)[0]: with_path(reference, lambda path: os.path.relpath(path, folder))
        for reference in references
    }


def _from_folder(references: list[str], config: pytest.Config) -> list[str]:
    """References whose paths are absolute: options speak of the invocation directory, ini values of the ini file's."""
    from_option = config.getoption("--lpb-planners") is not None
    folder = config.invocation_params.dir if from_option else _ini_folder(config)
    return [with_path(reference, lambda path: str(folder / path)) for reference in references]


def _ini_folder(config: pytest.Config) -> Path:
    folder: Path = config.inipath.parent if config.inipath else config.rootpath
    return folder


def _planner_folders(config: pytest.Config) -> list[Path]:
    given = config.getini("lpb_planners_dir")
    if given:
        return [_ini_folder(config) / given]
    return list(dict.fromkeys([config.invocation_params.dir / "planners", config.rootpath / "planners"]))


def _reports_folder(config: pytest.Config) -> Path:
    option, ini = config.getoption("lpb_reports"), config.getini("lpb_reports")
    folder, given = (_ini_folder(config), ini) if ini and not option else (config.invocation_params.dir, option)
    # The same folder must have the same path wherever it is met: `..` is taken out.
    return Path(os.path.normpath(folder / (given or "reports")))


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
