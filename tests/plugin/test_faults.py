"""Each fault of a planner is its own trial's outcome, and nothing of it reaches the trials beside it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.files import read_trial
from pytest_lpb.trial.specification import usable_cores

from .faults import FATAL, FAULTS, ISOLATED, conftest
from .projects import FAST, LEAN, SCENARIO, read_table, trial_files

WORKERS = (0, 2)
PATIENCE_S = 300.0


def run(
    folder: Path, scenarios: str, planners: list[str], workers: int, trials: int = 2
) -> tuple[Path, subprocess.CompletedProcess[str]]:
    """Run pytest in a process of its own; the newest run folder, and what was printed."""
    command = [sys.executable, "-m", "pytest", *LEAN, "-n", str(workers), FAST, f"--lpb-trials={trials}"]
    process = subprocess.run(
        [*command, f"--lpb-planners={','.join(planners)}", scenarios],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
        env={**os.environ, "PYTEST_ADDOPTS": ""},
    )
    files = (file for file in (folder / "reports").glob("*/run.json") if not file.parent.is_symlink())
    found = sorted(files, key=lambda path: path.stat().st_mtime_ns)
    assert found, process.stdout + process.stderr
    return found[-1].parent, process


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A repository with every faulty planner, and a neighbour under several names."""
    folder = tmp_path_factory.mktemp("faults")
    codes = {name: fault.code for name, fault in (FAULTS | ISOLATED).items()}
    (folder / "conftest.py").write_text(conftest(codes))
    (folder / "scenarios").mkdir()
    for name in FAULTS:
        (folder / f"scenarios/{name}.yaml").write_text(SCENARIO)
    for name in ("fatal", "isolated", "undisturbed"):
        (folder / name).mkdir()
        (folder / f"{name}/x.yaml").write_text(SCENARIO)
    (folder / "planners").mkdir()
    for name in ("before", "after"):
        (folder / f"planners/{name}.yaml").write_text("planner: neighbour\n")
    for name, isolated in ISOLATED.items():
        (folder / f"planners/isolated_{name}.yaml").write_text(f"planner: {name}\n{isolated.keys}\n")
    return folder


@pytest.fixture(scope="module", params=WORKERS, ids=lambda count: f"-n {count}")
def faulty_run(request: pytest.FixtureRequest, project: Path) -> tuple[Path, str]:
    """A run of all faults, with a neighbour after each; its folder and what it printed."""
    planners = ["faulty", "raises_in_constructor", "neighbour"]
    folder, process = run(project, "scenarios", planners=planners, workers=request.param)
    return folder, process.stdout + process.stderr


@pytest.fixture(scope="module")
def undisturbed_hashes(project: Path) -> dict[str, str]:
    """Trajectory hashes of the neighbour, by seed, in a run without faults."""
    folder, process = run(project, "undisturbed/x.yaml", planners=["neighbour"], workers=0)
    assert process.returncode == 0, process.stdout
    return {row["seed"]: row["trajectory_hash"] for row in read_table(folder / "trials.csv")}


def trials_of(folder: Path, fault: str, planner: str) -> Iterator[Trajectory]:
    """Both trials of a planner beside a fault, or of the fault itself."""
    for seed in (0, 1):
        yield read_trial(folder / f"trials/{fault}/{planner}/seed{seed}.parquet")


@pytest.mark.parametrize("fault", FAULTS)
def test_fault(faulty_run: tuple[Path, str], fault: str) -> None:
    if fault == "pins_itself_to_a_core" and usable_cores() < 2:
        pytest.skip("there is one core only")
    expected = FAULTS[fault]
    planner = fault if fault == "raises_in_constructor" else "faulty"
    for trajectory in trials_of(faulty_run[0], fault, planner):
        assert trajectory.outcome == expected.outcome, trajectory.metadata["message"]
        assert expected.text in trajectory.metadata["message"]
        assert expected.details in trajectory.metadata["details"]
        # What is not the planner's doing is not laid at its door.
        assert expected.details or "changed by the planner" not in trajectory.metadata["details"]
        assert len(trajectory.metadata["message"]) < 2_000
        assert len(trajectory.metadata["details"]) < 25_000


@pytest.mark.parametrize("fault", FAULTS)
def test_neighbours_are_bit_identical(
    faulty_run: tuple[Path, str], undisturbed_hashes: dict[str, str], fault: str
) -> None:
    assert len(set(undisturbed_hashes.values())) == 2
    for seed, trajectory in enumerate(trials_of(faulty_run[0], fault, "neighbour")):
        assert trajectory.metadata["trajectory_hash"] == undisturbed_hashes[str(seed)]


def test_the_run_itself(faulty_run: tuple[Path, str]) -> None:
    folder, output = faulty_run
    rows = read_table(folder / "trials.csv")
    assert len(rows) == 4 * len(FAULTS)
    failed = sum(fault.outcome != "success" for fault in FAULTS.values())
    assert re.search(rf"\b{2 * failed} failed, {4 * len(FAULTS) - 2 * failed} passed\b", output), output[-3000:]
    assert "INTERNALERROR" not in output
    # Of what planners print, beginning and end are shown.
    assert "characters left out" in output
    assert len(output) < 1_000_000
    assert "local planner benchmark" in output


@pytest.fixture(scope="module")
def fatal_run(project: Path) -> tuple[Path, str]:
    """A run with workers of the faults that take a process down; its folder and what it printed."""
    folder, process = run(project, "fatal/x.yaml", planners=["before", *FATAL, "after"], workers=2)
    assert process.returncode == 1, process.stdout
    return folder, process.stdout


@pytest.mark.parametrize("fault", FATAL)
def test_fatal_fault_with_workers(fatal_run: tuple[Path, str], undisturbed_hashes: dict[str, str], fault: str) -> None:
    folder, output = fatal_run
    rows = read_table(folder / "trials.csv")
    assert [row["outcome"] for row in rows if row["planner"] == fault] == ["worker_crash"] * 2
    beside = {(row["planner"], row["seed"]): row["trajectory_hash"] for row in rows if row["planner"] not in FATAL}
    assert beside == {(name, seed): undisturbed_hashes[seed] for name in ("before", "after") for seed in ("0", "1")}
    assert f"2 trials of {fault}: worker_crash: the process that ran the trial died; run it alone to see why" in output


@pytest.mark.parametrize("fault", FATAL)
def test_fatal_fault_without_workers(project: Path, fault: str) -> None:
    folder, process = run(project, "fatal/x.yaml", planners=["before", fault, "after"], workers=0)
    assert "local planner benchmark" not in process.stdout
    assert trial_files(folder) == ["fatal/x/before/seed0.parquet", "fatal/x/before/seed1.parquet"]
    for seed in (0, 1):
        assert read_trial(folder / f"trials/fatal/x/before/seed{seed}.parquet").outcome == "success"


def test_workers_finish_a_run_that_a_fault_has_ended(project: Path, undisturbed_hashes: dict[str, str]) -> None:
    folder, _ = run(project, "fatal/x.yaml", planners=["before", "leaves_at_once", "after"], workers=0)
    resumed = subprocess.run(
        [sys.executable, "-m", "pytest", *LEAN, "-n", "2", f"--lpb-resume={folder}"],
        cwd=project,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    rows = read_table(folder / "trials.csv")
    assert [row["outcome"] for row in rows if row["planner"] == "leaves_at_once"] == ["worker_crash"] * 2, (
        resumed.stdout
    )
    others = [row for row in rows if row["planner"] != "leaves_at_once"]
    assert len(others) == 4
    assert all(row["trajectory_hash"] == undisturbed_hashes[row["seed"]] for row in others)


@pytest.fixture(scope="module", params=WORKERS, ids=lambda count: f"-n {count}")
def isolated_run(request: pytest.FixtureRequest, project: Path) -> tuple[Path, str]:
    """A run of the faults of planners in processes of their own; its folder and what it printed."""
    planners = ["before", *(f"isolated_{name}" for name in ISOLATED), "after"]
    folder, process = run(project, "isolated/x.yaml", planners=planners, workers=request.param, trials=1)
    assert process.returncode == 1, process.stdout
    return folder, process.stdout


@pytest.mark.parametrize("fault", ISOLATED)
def test_fault_of_an_isolated_planner(isolated_run: tuple[Path, str], fault: str) -> None:
    expected = ISOLATED[fault]
    trajectory = read_trial(isolated_run[0] / f"trials/isolated/x/isolated_{fault}/seed0.parquet")
    assert trajectory.outcome == expected.outcome
    assert expected.text in trajectory.metadata["message"]
    assert len(trajectory.t) >= (1 if "setup" in fault else 3)  # what it did before is kept


def test_neighbours_of_isolated_planners(isolated_run: tuple[Path, str], undisturbed_hashes: dict[str, str]) -> None:
    folder, output = isolated_run
    rows = {row["planner"]: row for row in read_table(folder / "trials.csv")}
    assert len(rows) == len(ISOLATED) + 2
    assert {rows[name]["trajectory_hash"] for name in ("before", "after")} == {undisturbed_hashes["0"]}
    assert "local planner benchmark" in output
    assert not {row["outcome"] for row in rows.values()} & {"worker_crash", "environment_error"}


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_nothing_of_isolated_planners_is_left(isolated_run: tuple[Path, str], project: Path) -> None:
    """Neither what hung nor a child that was left behind."""
    left = [link.parent.name for link in Path("/proc").glob("[0-9]*/cwd") if leads_to(link, project)]
    assert left == []


def leads_to(link: Path, folder: Path) -> bool:
    """Whether a link leads to a folder; processes end while one looks."""
    try:
        return link.resolve(strict=True) == folder
    except OSError:
        return False
