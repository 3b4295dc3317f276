"""Planner repositories for tests: scenario files, planner files, runs of pytest, and what they leave."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.trial.files import read_trial

# One cheap KPI: evaluating and drawing all of them takes most of a small run's time.
FAST = "--lpb-kpis=time_to_goal_s"
# Plugins that have nothing to do with what is tested, and are slow to import in each process.
LEAN = ("-p", "no:hypothesispytest", "-p", "no:cacheprovider")

# The point reaches its goal at once and stays: success after the hold time.
SCENARIO = """\
version: 1
tags: [planar]
robot: {model: point, body_radius: 0.2}
environment: {dt: 0.05, duration: 0.5}
start: {q: [0, 0]}
goal:
  - {name: reach, type: position, link: body, target: [0.05, 0.0], tolerance: 0.1}
success: {hold_time: 0.2}
"""
# The goal is too far for the duration: a timeout.
UNSOLVED = SCENARIO.replace("[0.05, 0.0]", "[3.0, 0.0]")
# Problems differ by seed.
DRAWN = SCENARIO + "randomize: {draw: [goal], goal: [[-0.06, 0.06], [-0.06, 0.06]]}\n"

Row = Mapping[str, str]

# Processes of a shell's background jobs are born deaf to Ctrl-C; these are to hear it wherever the tests run.
BOOT = (
    "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
    "import pytest; sys.exit(pytest.main(sys.argv[1:]))"
)


class Project:
    """A planner repository in pytester's folder."""

    def __init__(self, pytester: pytest.Pytester) -> None:
        self.pytester = pytester
        self.path = pytester.path

    def write(self, path: str, content: str) -> Path:
        """Write a file, with its folders."""
        file = self.path / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content, encoding="utf-8")
        return file

    def scenario(self, path: str = "scenarios/point/x.yaml", content: str = SCENARIO) -> Path:
        """Write a scenario file."""
        return self.write(path, content)

    def ini(self, *lines: str) -> Path:
        """Write pytest.ini."""
        return self.write("pytest.ini", "\n".join(["[pytest]", *lines, ""]))

    def run(self, *arguments: str | Path, planners: str | None = "pd", fast: bool = True) -> pytest.RunResult:
        """Run pytest in this process."""
        with warnings.catch_warnings():
            # The run is not to inherit that warnings are errors in the run of these tests.
            warnings.simplefilter("default")
            return self.pytester.runpytest_inprocess(*self._arguments(arguments, planners, fast))

    def run_workers(self, *arguments: str | Path, planners: str | None = "pd", workers: int = 2) -> pytest.RunResult:
        """Run pytest with workers; the controller is in this process."""
        return self.run("-n", str(workers), *LEAN, *arguments, planners=planners)

    def start(self, *arguments: str | Path, planners: str | None = "pd") -> subprocess.Popen[bytes]:
        """Start pytest in a process group of its own, and do not wait; its output goes to the file `output`."""
        command = [sys.executable, "-c", BOOT, *LEAN, *map(str, self._arguments(arguments, planners, fast=True))]
        with self.output.open("wb") as output:
            # A pipe that nobody reads would stop the process.
            return subprocess.Popen(
                command, cwd=self.path, stdout=output, stderr=subprocess.STDOUT, start_new_session=True
            )

    @property
    def output(self) -> Path:
        """What a started process has printed."""
        return self.path / "output"

    @staticmethod
    def _arguments(arguments: tuple[str | Path, ...], planners: str | None, fast: bool) -> list[str | Path]:
        chosen = [] if planners is None else [f"--lpb-planners={planners}", *([FAST] if fast else [])]
        # The option that comes last holds, so a test may name KPIs of its own.
        return [*chosen, *arguments]

    def runs(self, reports: str = "reports") -> list[Path]:
        """Run folders, the oldest first."""
        folder = self.path / reports
        found = [file.parent for file in folder.glob("*/run.json") if not file.parent.is_symlink()]
        return sorted(found, key=lambda path: (path / "run.json").stat().st_mtime_ns)

    def rows(self, run: Path | None = None) -> list[Row]:
        """The rows of trials.csv of a run, by default the last."""
        return read_table((run or self.runs()[-1]) / "trials.csv")

    def row(self) -> Row:
        """The single row of the last run's trials.csv."""
        (row,) = self.rows()
        return row

    def hashes(self) -> dict[tuple[str, str, str], str]:
        """Trajectory hash of each trial of the last run."""
        return hashes_of(self.runs()[-1])


def read_table(path: Path) -> list[Row]:
    """A CSV file."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def hashes_of(run: Path) -> dict[tuple[str, str, str], str]:
    """Trajectory hash of each trial of a run."""
    rows = read_table(run / "trials.csv")
    return {(row["scenario"], row["planner"], row["seed"]): row["trajectory_hash"] for row in rows}


def read_run(run: Path) -> dict[str, Any]:
    """run.json."""
    content: dict[str, Any] = json.loads((run / "run.json").read_text("utf-8"))
    return content


def text_of(result: pytest.RunResult) -> str:
    """All that a run printed."""
    return f"{result.stdout.str()}\n{result.stderr.str()}"


def node_ids(result: pytest.RunResult) -> list[str]:
    """What `--collect-only -q` listed."""
    return [line for line in result.stdout.lines if "::" in line]


def trial_files(run: Path) -> list[str]:
    """Trial files of a run, relative to its folder of trials."""
    return sorted(path.relative_to(run / "trials").as_posix() for path in (run / "trials").rglob("*.parquet"))


def attempt_of(path: Path) -> int:
    """Which attempt a trial file holds."""
    attempt: int = read_trial(path).metadata["attempt"]
    return attempt


def run_without_pytest(folder: Path) -> Path:
    """Run trials through the same functions as the plugin, without pytest. Returns the run folder."""
    import pytest_lpb.cli
    import pytest_lpb.plugin.activation
    import pytest_lpb.plugin.controller
    import pytest_lpb.plugin.unchosen  # noqa: F401 - imported for later
    from pytest_lpb.kpis.registry import load_builtin
    from pytest_lpb.planner.files import find_planners
    from pytest_lpb.report.build import write_results
    from pytest_lpb.run.evaluation import evaluate
    from pytest_lpb.run.folder import RunFolder, new_run_folder
    from pytest_lpb.run.provenance import run_information
    from pytest_lpb.scenario.draw import draw_problem
    from pytest_lpb.scenario.load import load_scenario
    from pytest_lpb.study.family import FileFamily
    from pytest_lpb.trial.files import write_trial
    from pytest_lpb.trial.specification import TrialSpecification
    from pytest_lpb.trial.trial import run_trial

    load_builtin()
    files = {"drawn": DRAWN, "unsolved": UNSOLVED}
    for name, content in files.items():
        (folder / f"{name}.yaml").write_text(content, encoding="utf-8")
    planners = find_planners(["pd", "potential_field"], [])
    options: dict[str, Any] = {
        "kpis": None,
        "plugins": [],
        "seeds": {"first": None, "trials": 2},
        "workers": 1,
        "invocation": str(folder),
    }
    information = run_information(
        ["pytest"], planners, {name: FileFamily(name, folder / f"{name}.yaml") for name in files}, options, folder
    )
    run = RunFolder.create(new_run_folder(folder / "reports"), information)
    for name in files:
        scenario = load_scenario(folder / f"{name}.yaml")
        for planner in planners:
            for seed in (0, 1):
                problem = draw_problem(scenario, seed, (), name).to_dict()
                node_id = f"{name}.yaml::{planner.name}::seed{seed}"
                specification = TrialSpecification(problem, planner, name, node_id, f"pytest {node_id}")
                write_trial(run.path, run_trial(specification))
    write_results(evaluate(run), run.path)
    return run.path
