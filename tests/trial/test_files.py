"""Trial files: exact, whole or absent, and readable by others."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from numpy.testing import assert_array_equal

from pytest_lpb.errors import RecordingError
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.files import METADATA_KEY, read_trial, trial_path, write_trial
from pytest_lpb.trial.trial import failed_trial
from tests.problem.entries import CART, circle, position_goal

from .specifications import run, specification


@dataclass(frozen=True)
class Written:
    """A trial and its file."""

    trajectory: Trajectory
    path: Path


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Written:
    goal = [
        position_goal([2.0, 0.0], "base"),
        {"name": "reach_angle", "type": "orientation", "link": "base", "target": [0.5], "tolerance": 0.1},
    ]
    moving = {"name": "cart.1", "shape": "circle", "radius": 0.2, "trajectory": ["3 - t", "1.5"]}
    trajectory = run("Clock", robot=CART, goal=goal, obstacles=[circle(0.1, 5.0, 1 / 3), moving])
    return Written(trajectory, write_trial(tmp_path_factory.mktemp("run"), trajectory))


def test_the_path(written: Written) -> None:
    assert written.path.parts[-4:] == ("trials", "family", "Clock", "seed0.parquet")
    folder = Path("/runs")
    assert trial_path(folder, "point/two", "pd", 3) == folder / "trials" / "point" / "two" / "pd" / "seed3.parquet"


def test_round_trip(written: Written) -> None:
    again = read_trial(written.path)
    assert list(again.columns) == list(written.trajectory.columns)
    for name, values in written.trajectory.columns.items():
        assert again.columns[name].dtype == values.dtype, name
        if values.dtype == np.float64:
            assert again.columns[name].tobytes() == values.tobytes(), name  # to the last bit, NaN too
        else:
            assert_array_equal(again.columns[name], values)
    assert again.metadata == json.loads(json.dumps(written.trajectory.metadata))
    assert again.problem.to_dict() == written.trajectory.problem.to_dict()
    assert again.problem.name == "family"
    assert again.outcome == written.trajectory.outcome


def test_what_is_read_can_be_written_again(written: Written, tmp_path: Path) -> None:
    assert write_trial(tmp_path, read_trial(written.path)).read_bytes() == written.path.read_bytes()


def test_the_columns_of_the_contract(written: Written) -> None:
    expected = ["t", "q0", "q1", "q2", "qd0", "qd1", "qd2", "u0", "u1", "action0", "action1", "applied0", "applied1"]
    expected += ["link_base_x", "link_base_y", "goal_reach_0", "goal_reach_1", "goal_reach_error"]
    expected += ["goal_reach_angle_0", "goal_reach_angle_error"]
    expected += [f"obstacle_{name}_{part}" for name in ("disc", "cart.1") for part in ("x", "y", "theta")]
    expected += ["clearance_m", "clearance_body", "clearance_obstacle", "self_clearance_m"]
    expected += ["clearance_step_min_m", "self_clearance_step_min_m"]
    expected += ["solver_wall_ms", "solver_cpu_ms", "planner_calls", "planner_odd"]
    assert pq.read_table(written.path).column_names == expected


def test_the_metadata(written: Written) -> None:
    content = json.loads(pq.read_schema(written.path).metadata[METADATA_KEY])
    required = {"node_id", "outcome", "message", "wall_s", "parameters", "problem_hash", "trajectory_hash", "attempt"}
    assert required <= set(content)
    assert content["problem"]["robot"]["model"] == "differential_drive"


def test_units(written: Written) -> None:
    schema = pq.read_schema(written.path)
    units = {field.name: field.metadata[b"unit"].decode() for field in schema}
    expected = {
        "t": "s",
        "q0": "m",
        "q2": "rad",
        "qd1": "m/s",
        "qd2": "rad/s",
        "u0": "m/s",
        "u1": "rad/s",
        "action0": "m/s^2",
        "applied1": "rad/s^2",
        "link_base_x": "m",
        "goal_reach_0": "m",
        "goal_reach_error": "m",
        "goal_reach_angle_0": "rad",
        "goal_reach_angle_error": "rad",
        "obstacle_cart.1_x": "m",
        "obstacle_disc_theta": "rad",
        "clearance_m": "m",
        "clearance_body": "",
        "self_clearance_m": "m",
        "solver_wall_ms": "ms",
        "planner_calls": "",
    }
    assert {name: units[name] for name in expected} == expected


def test_units_of_an_arm_under_velocity_control(tmp_path: Path) -> None:
    arm = {
        "model": "planar_arm",
        "name": "a",
        "links": [1.0],
        "base": "fixed",
        "body_radius": 0.1,
        "control": "velocity",
    }
    path = write_trial(tmp_path, run("pd", robot=arm))
    units = {field.name: field.metadata[b"unit"].decode() for field in pq.read_schema(path)}
    assert (units["q0"], units["u0"], units["action0"], units["link_end_x"]) == ("rad", "rad/s", "rad/s", "m")


def test_how_columns_are_stored(written: Written) -> None:
    """Compressed, floats as byte streams without a dictionary, names of bodies with one."""
    group = pq.ParquetFile(written.path).metadata.row_group(0)
    for index in range(group.num_columns):
        column = group.column(index)
        name = column.path_in_schema
        assert column.compression == "ZSTD", name
        if name in ("clearance_body", "clearance_obstacle"):
            assert column.physical_type == "BYTE_ARRAY"
            assert column.has_dictionary_page, name
        else:
            assert column.physical_type == "DOUBLE", name
            assert "BYTE_STREAM_SPLIT" in column.encodings, name
            assert not column.has_dictionary_page, name
            assert not {"PLAIN_DICTIONARY", "RLE_DICTIONARY"} & set(column.encodings), name


def test_the_first_attempt_counts(tmp_path: Path) -> None:
    first, second = run("Constant"), run("Constant", {"action": [0.5, 0.5]})
    path = write_trial(tmp_path, first)
    content = path.read_bytes()
    assert write_trial(tmp_path, second) == path
    assert path.read_bytes() == content


def test_nothing_is_left_over(tmp_path: Path) -> None:
    path = write_trial(tmp_path, run("Constant"))
    write_trial(tmp_path, run("Constant"))
    assert [item.name for item in path.parent.iterdir()] == ["seed0.parquet"]


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "trials").write_text("in the way", encoding="utf-8")
    with pytest.raises(RecordingError, match=r"cannot write .*seed0\.parquet"):
        write_trial(tmp_path, run("Constant"))


def foreign(path: Path, metadata: dict[bytes, bytes] | None) -> Path:
    table = pa.table({"t": [0.0]})
    pq.write_table(table.replace_schema_metadata(metadata), path)
    return path


def test_files_that_are_no_trials(tmp_path: Path, written: Written) -> None:
    path = tmp_path / "seed0.parquet"
    with pytest.raises(RecordingError, match=r"cannot read .*seed0\.parquet"):
        read_trial(path)
    path.write_bytes(b"PAR1 nothing of the kind")
    with pytest.raises(RecordingError, match=r"cannot read .*seed0\.parquet"):
        read_trial(path)
    path.write_bytes(written.path.read_bytes()[:-100])
    with pytest.raises(RecordingError, match=r"cannot read .*seed0\.parquet"):
        read_trial(path)
    with pytest.raises(RecordingError, match="is no trial file of pytest-lpb"):
        read_trial(foreign(path, None))
    with pytest.raises(RecordingError, match="its metadata are damaged"):
        read_trial(foreign(path, {METADATA_KEY: b"{"}))
    with pytest.raises(RecordingError, match="its problem is not one of this version"):
        read_trial(foreign(path, {METADATA_KEY: b'{"scenario": "x", "problem": {"robot": {}}}'}))


def test_a_trial_without_rows(tmp_path: Path) -> None:
    lost = failed_trial(specification("pd", obstacles=[circle(9.0, 9.0, 1.0)]), "worker_crash", "died")
    again = read_trial(write_trial(tmp_path, lost))
    assert (len(again), again.outcome, again.metadata["message"]) == (0, "worker_crash", "died")
    assert again.q.shape == (0, 2)
    assert again.obstacle("disc").shape == (0, 3)


def test_unknown_columns_name_the_nearest(written: Written) -> None:
    with pytest.raises(RecordingError, match="no column 'clearence_m' in this trial; did you mean 'clearance_m'"):
        written.trajectory.column("clearence_m")
    with pytest.raises(RecordingError, match="no column 'link_tip_x'"):
        written.trajectory.link("tip")
