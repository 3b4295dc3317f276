"""Command-line options and their ini twins."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

DEFAULT_GLOBS = ["scenarios/**/*.yaml", "**/scenarios/**/*.yaml"]
ASSERTIONS = ("trial", "rate", "none")
REPORTS = ("auto", "none")
PARTS = ("start", "goal", "obstacles")
CHECKED = 6  # trials per planner


def add_options(parser: pytest.Parser) -> None:
    """Add the plugin's options to pytest's parser."""
    group = parser.getgroup("lpb", "pytest-lpb: benchmark local motion planners")
    group.addoption(
        "--lpb-planners", metavar="A,B", help="planners to run: NAME, PATH.yaml or NAME=PATH, comma-separated"
    )
    group.addoption("--lpb-trials", type=int, metavar="N", help="trials per scenario and planner")
    group.addoption("--lpb-seed", type=int, metavar="S", help="first seed: seeds S..S+N-1")
    for part in PARTS:
        group.addoption(
            f"--lpb-random-{part}",
            action="store_true",
            help=f"draw the {part} from the scenario's ranges",
        )
    group.addoption(
        "--lpb-assert",
        choices=ASSERTIONS,
        help="what fails: every failed trial (default), a planner's success rate, or software faults only",
    )
    group.addoption("--lpb-problems", metavar="RUN", help="run the problems of an old run, under their names and seeds")
    group.addoption("--lpb-resume", metavar="RUN", help="finish a run that was interrupted: run what is missing")
    group.addoption("--lpb-kpis", metavar="A,B", help="KPIs to evaluate (default: all)")
    group.addoption("--lpb-title", metavar="TEXT", help="heading of the run's report (default: that of the study)")
    group.addoption("--lpb-reports", metavar="DIR", help="parent of run folders (default: reports)")
    group.addoption(
        "--lpb-report",
        choices=REPORTS,
        help="tables and report at the end of the run (default: auto), or none: lpb-report makes them later",
    )
    group.addoption("--lpb-render", action="store_true", help="show trials in the simulator's window, in real time")
    group.addoption(
        "--lpb-check-isolation",
        action="store_true",
        help="run some trials again, alone and in reverse order: do they come out the same? And move scenes: "
        "do planners look at them?",
    )
    group.addoption(
        "--lpb-check-trials", type=int, metavar="N", help=f"trials of each planner to check (default: {CHECKED})"
    )
    _add_gate_options(group, parser)
    parser.addini("lpb_planners", "planners to run (as --lpb-planners)", type="args", default=[])
    parser.addini("lpb_planners_dir", "folder of planner configurations", type="string", default="")
    parser.addini("lpb_scenarios", "globs of scenario files below the rootdir", type="args", default=DEFAULT_GLOBS)
    parser.addini("lpb_title", "heading of the run's report", type="string", default="")
    parser.addini("lpb_reports", "parent of run folders", type="string", default="")
    parser.addini("lpb_report", "tables and report at the end (as --lpb-report)", type="string", default="")
    parser.addini("lpb_plugins", "modules with KPIs and plots of your own", type="args", default=[])


def _add_gate_options(group: pytest.OptionGroup, parser: pytest.Parser) -> None:
    group.addoption(
        "--lpb-baseline", metavar="RUN_OR_FILE", help="regression gate: compare with this run, file or planner:NAME"
    )
    group.addoption("--lpb-fail-on", metavar="KPI:MARGIN,..", help="losses that close the gate (default: success:5%%)")
    group.addoption(
        "--lpb-inconclusive", choices=("pass", "fail"), help="what the gate does when it cannot tell (default: pass)"
    )
    parser.addini("lpb_baseline", "regression gate (as --lpb-baseline)", type="string", default="")
    parser.addini("lpb_fail_on", "losses that close the gate (as --lpb-fail-on)", type="args", default=[])
    parser.addini("lpb_inconclusive", "what the gate does when it cannot tell", type="string", default="")


def split_names(text: str | list[str]) -> list[str]:
    """Names of a comma-separated option, or of an ini value with blanks or commas."""
    parts = [text] if isinstance(text, str) else text
    return [name.strip() for part in parts for name in part.split(",") if name.strip()]


def chosen_planners(config: pytest.Config) -> list[str]:
    """References of the planners to run; none, as with an empty `--lpb-planners=`: the plugin stays inert."""
    given = config.getoption("--lpb-planners")
    return split_names(config.getini("lpb_planners") if given is None else given)


def named_study(config: pytest.Config) -> Path | None:
    """The first study file among the arguments."""
    folder = config.invocation_params.dir
    texts = [argument.partition("::")[0] for argument in config.args]
    named = [Path(os.path.normpath(folder / text)) for text in texts if text.endswith((".yaml", ".yml"))]
    if not named:
        return None
    from pytest_lpb.documents.recognition import is_study

    return next((path for path in named if is_study(path)), None)


def is_active(config: pytest.Config) -> bool:
    """Whether there are planners to run: chosen, of a study, or of a run to finish."""
    asked = chosen_planners(config) or config.getoption("--lpb-resume") or config.getoption("--lpb-problems")
    return bool(asked) or named_study(config) is not None


def is_worker(config: pytest.Config) -> bool:
    """Whether this process is one of xdist's workers."""
    return hasattr(config, "workerinput")
