"""Run folders of strangers: `lpb-report` refuses what no run has in words, runs none of it, and writes nothing else."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest

from pytest_lpb.cli import EXIT_WARNINGS, main
from pytest_lpb.commands import EXIT_USAGE
from pytest_lpb.errors import RecordingError
from pytest_lpb.run.run_file import read_run_file
from pytest_lpb.trial.files import METADATA_KEY, read_trial, trial_path, write_trial
from tests.report.runs import make_problem, make_trajectory

SCENARIO, PLANNER = "point/two_obstacles", "pd"


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run folder with one trial, in a project."""
    folder = tmp_path / "mine" / "reports" / "run"
    folder.mkdir(parents=True)
    (tmp_path / "mine" / "pytest.ini").write_text("[pytest]\n")
    node = f"scenarios/{SCENARIO}.yaml::{PLANNER}::seed0"
    trajectory = make_trajectory(make_problem(SCENARIO, 0), node, 1.0, rows=20)
    more = {"message": "", "command": "", "failed_criteria": [], "workers": 1, "cores": 2}
    trajectory.metadata = {**trajectory.metadata, **more}
    for name in ("clearance_body", "clearance_obstacle"):
        trajectory.columns = {**trajectory.columns, name: trajectory.columns[name].astype(object)}
    write_trial(folder, trajectory)
    write(folder, {"schema_version": 1})
    return folder


def write(run: Path, info: Any) -> None:
    (run / "run.json").write_text(info if isinstance(info, str) else json.dumps(info))


@pytest.mark.parametrize(
    ("info", "message"),
    [
        ("[" * 100_000, "cannot read .*run.json: "),
        ("\0", "cannot read .*run.json: "),
        ([], "run.json: the file: found a list of 0"),
        ({"plugins": "os"}, "run.json: plugins: found the text 'os'"),
        ({"plugins": [{"module": 1, "file": None}]}, r"run.json: plugins\[0\].module: found 1"),
        ({"planners": ["pd"]}, "run.json: planners: found a list of 1"),
        ({"planners": {"../../pd": {}}}, r"run.json: planners.../../pd.*is no name"),
        ({"planners": {"pd": {"parameters": "x"}}}, "run.json: planners.pd.parameters: found the text 'x'"),
        ({"scenarios": {"../x": {}}}, "is no name"),
        ({"planned": {"x": {"..": "0"}}}, "is no name"),
        ({"planned": {"x": {"pd": "0-9,x"}}}, r"run.json: planned.*found the seeds '0-9,x'; allowed are such as"),
        ({"planned": {"x": {"pd": "0-9999999999"}}}, "run.json: planned.*plans more trials than 10000000"),
        ({"machine": {"cores": "many"}}, "run.json: machine.cores: found the text 'many'"),
        ({"machine": {"memory_gib": float("nan")}}, "run.json: machine.memory_gib: found nan"),
        ({"kpis": [1]}, r"run.json: kpis\[0\]: found 1"),
        ({"command": {"a": 1}}, "run.json: command"),
    ],
)
def test_a_run_file_of_wrong_types(run: Path, info: Any, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    write(run, info)
    with pytest.raises(RecordingError, match=message):
        read_run_file(run / "run.json")
    assert main([str(run)]) == EXIT_USAGE
    assert capsys.readouterr().err.startswith("lpb-report: error: ")
    assert sorted(path.name for path in run.iterdir()) == ["run.json", "trials"]


def test_scenarios_lie_in_folders_of_any_name(run: Path) -> None:
    write(run, {"scenarios": {"my scenarios/$x/y": {}}, "planned": {"my scenarios/$x/y": {"pd": "0"}}})
    assert read_run_file(run / "run.json")["planned"]


def test_what_is_no_run_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "run.json")
    with pytest.raises(RecordingError, match=r"run\.json: is no regular file"):
        read_run_file(tmp_path / "run.json")


def rewritten(run: Path, **changes: Any) -> Path:
    """The trial's file with metadata changed, or with other columns."""
    path = trial_path(run, SCENARIO, PLANNER, 0)
    table = pyarrow.parquet.read_table(path)
    metadata = {**json.loads(table.schema.metadata[METADATA_KEY]), **changes.pop("metadata", {})}
    text = changes.pop("text", json.dumps(metadata))
    columns = changes.pop("columns", {name: table.column(name) for name in table.column_names})
    pyarrow.parquet.write_table(pyarrow.table(columns).replace_schema_metadata({METADATA_KEY: text}), path)
    return path


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"columns": {"t": pyarrow.nulls(2_000_000, pyarrow.float64())}}, "it has 2000000 rows; a trial has at most"),
        ({"columns": {f"c{i}": [0.0] for i in range(20_001)}}, "it has 20001 columns; a trial has at most 20000"),
        ({"columns": {"t": [[1.0]]}}, "its column 't' holds list"),
        ({"text": "[" * 100_000}, "its metadata are damaged"),
        ({"text": "[]"}, "its metadata are damaged: no mapping"),
        ({"metadata": {"scenario": "../../../x"}}, "holds the data of another trial"),
        ({"metadata": {"seed": "x"}}, "holds the data of another trial"),
        ({"metadata": {"problem": []}}, "cannot read"),
    ],
)  # fmt: skip
def test_a_trial_file_that_no_trial_wrote(
    run: Path, changes: dict[str, Any], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    rewritten(run, **changes)
    assert main([str(run)]) in (EXIT_USAGE, EXIT_WARNINGS)
    assert message in capsys.readouterr().err.replace("\n", " ")


@pytest.mark.parametrize("file", ["/etc/passwd", "../../../secret.obj", "link.obj"])
def test_files_of_a_recorded_problem_outside_of_the_project_are_not_read(run: Path, tmp_path: Path, file: str) -> None:
    (tmp_path / "secret.obj").write_text("v 0 0 0\n")
    (run / "link.obj").symlink_to(tmp_path / "secret.obj")
    path = trial_path(run, SCENARIO, PLANNER, 0)
    problem = json.loads(pyarrow.parquet.read_schema(path).metadata[METADATA_KEY])["problem"]
    problem["obstacles"][0] = {"name": "left", "shape": "mesh", "file": file, "position": [0, 0, 0]}
    rewritten(run, metadata={"problem": problem})
    with pytest.raises(RecordingError, match=r"the file .* of its problem lies outside of .*/mine; allowed"):
        read_trial(path)


def test_results_are_not_led_elsewhere(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A stranger's run folder may have links where results go."""
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "mine.html").write_text("mine")
    (run / "report.html").symlink_to(outside / "mine.html")
    (run / "trials.csv").symlink_to(outside / "mine.html")
    assert main([str(run)]) == 0
    assert not (run / "report.html").is_symlink()
    assert (outside / "mine.html").read_text() == "mine"
    asked = {"plots": ["--plot=success"], "tables": ["--export=markdown"], "selected": ["--planners=pd"]}
    for folder, options in asked.items():
        (run / folder).symlink_to(outside)
        assert main([str(run), *options]) == EXIT_USAGE
        assert f"{run / folder} is a link" in capsys.readouterr().err
        (run / folder).unlink()
    assert [path.name for path in outside.iterdir()] == ["mine.html"]
    assert np.isfinite(read_trial(trial_path(run, SCENARIO, PLANNER, 0)).t).all()
