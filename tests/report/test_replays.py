"""What replays are drawn from: numbers, meshes, poses, and which trials have one."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.spatial.rotations import matrix_of
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.packing import packed, unpacked
from pytest_lpb.report.palette import planner_styles
from pytest_lpb.report.replay.blocks import replays
from pytest_lpb.report.replay.charts import charts, diagnostics_left_out
from pytest_lpb.report.replay.choice import MAX_REPLAYS, in_order_of_interest
from pytest_lpb.report.replay.motion import motion_for
from pytest_lpb.report.replay.numbers import changed_rows, fine_step, listed, needed_rows, thinned_rows
from pytest_lpb.report.replay.shapes import MAX_TRIANGLES, mesh_block, simplified
from pytest_lpb.report.replay.spatial import continuous
from pytest_lpb.report.replay.trial import bounds, robot_block, scene_block, trial_block
from pytest_lpb.report.trial_pages import trial_pages
from pytest_lpb.trajectory import Trajectory
from tests.problem.spatial.entries import write_torus

from .runs import make_run
from .spatial_runs import spatial_problems, spatial_run

Array = NDArray[np.float64]
NUMBERS = st.floats(-1e6, 1e6) | st.just(float("nan"))


def read(listed_numbers: dict[str, Any]) -> Array:
    """Columns as the page's script reads them, (N, M)."""
    count = listed_numbers["n"]
    columns = []
    for begin in range(0, len(listed_numbers["d"]), count):
        total, column = 0, []
        for change in listed_numbers["d"][begin : begin + count]:
            total += change or 0
            column.append(np.nan if change is None else total * listed_numbers["s"])
        columns.append(column)
    return np.array(columns).T


@pytest.fixture(scope="module")
def spatial(tmp_path_factory: pytest.TempPathFactory) -> ReportData:
    return spatial_run(tmp_path_factory.mktemp("spatial"))


@given(arrays(float, (7, 3), elements=NUMBERS))
def test_numbers_are_read_back_to_half_a_step(values: Array) -> None:
    step = fine_step(values, 1000)
    back = read(listed(values, step))
    assert (np.isnan(back) == np.isnan(values)).all()
    # The step is told with six digits.
    known = ~np.isnan(values)
    assert (np.abs(back - values)[known] <= 0.501 * step + 1e-5 * np.abs(values[known])).all()


@given(arrays(float, st.integers(1, 400), elements=NUMBERS), st.integers(10, 60))
def test_thinning_keeps_the_smallest_and_the_largest(values: Array, most: int) -> None:
    rows = thinned_rows(values, most)
    assert len(rows) <= most + 2
    assert {rows[0], rows[-1]} == {0, len(values) - 1}
    if not np.isnan(values).all():
        assert np.nanmin(values[rows]) == np.nanmin(values)
        assert np.nanmax(values[rows]) == np.nanmax(values)


def test_packed_text_cannot_end_a_script() -> None:
    value = {"</script><script>alert(1)</script>": ["<!--", "é", None, 0.5]}
    text = packed(value)
    assert re.fullmatch("[A-Za-z0-9+/=]+", text)
    assert unpacked(text) == value
    with pytest.raises(ValueError, match="not JSON compliant"):
        packed([float("nan")])


def test_a_large_mesh_has_few_triangles_and_keeps_its_size(tmp_path: Path) -> None:
    path = write_torus(tmp_path / "ring.obj", 0.5, 0.1, 60, 30)
    block = mesh_block(path)
    vertices, faces = read(block["vertices"]), read(block["faces"]).astype(int)
    assert 100 < len(faces) <= MAX_TRIANGLES
    assert faces.max() < len(vertices)
    assert np.ptp(vertices, axis=0) == pytest.approx([1.2, 1.2, 0.2], rel=0.1)
    distance = np.hypot(np.hypot(vertices[:, 0], vertices[:, 1]) - 0.5, vertices[:, 2])
    assert (np.abs(distance - 0.1) < 0.03).all()


def test_a_small_mesh_stays_as_it_is() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    triangles = corners[[[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]]
    vertices, faces = simplified(triangles, 10)
    assert sorted(map(tuple, vertices.tolist())) == sorted(map(tuple, corners.tolist()))
    assert {frozenset(face.tolist()) for face in faces} == {
        frozenset(f) for f in ([0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3])
    }


def test_quaternions_do_not_jump() -> None:
    angles = np.linspace(0.0, 4 * np.pi, 50)
    turns = np.column_stack([np.cos(angles / 2), 0 * angles, 0 * angles, np.sin(angles / 2)])
    flipped = turns * np.where(np.arange(50) % 3 == 0, -1.0, 1.0)[:, None]
    found = continuous(flipped)
    assert ((found[1:] * found[:-1]).sum(axis=1) > 0.9).all()
    assert np.abs(found) == pytest.approx(np.abs(turns))


def test_planar_poses_are_the_recorded_ones(run: ReportData) -> None:
    made = replays(run, run.trials)
    for place in made.places:
        block = unpacked(made.blocks[f"trial:{place}"])
        trajectory = run.trajectory_of(run.trials["node_id"].iloc[place])
        robot = trajectory.problem.robot
        rows = np.searchsorted(trajectory.t, read(block["t"])[:, 0] - 1e-6)
        at = read(block["at"]).reshape(len(rows), -1, 2)
        turn = read(block["turn"])
        links = list(dict.fromkeys(body.link for body in robot.collision_bodies))
        for body, link in enumerate(links):
            assert at[:, body] == pytest.approx(trajectory.link(link)[rows, :2], abs=0.01)
            pose = robot.forward_kinematics(trajectory.q[rows[-1]], link)
            assert np.cos(turn[-1, body]) == pytest.approx(pose[0, 0], abs=2e-3)
            assert np.sin(turn[-1, body]) == pytest.approx(pose[1, 0], abs=2e-3)


def test_poses_in_space_are_the_recorded_ones(spatial: ReportData) -> None:
    made = replays(spatial, spatial.trials)
    assert made.spatial
    place = next(p for p in made.places if spatial.trials["scenario"].iloc[p] == "panda/wall")
    block = unpacked(made.blocks[f"trial:{place}"])
    trajectory = spatial.trajectory_of(spatial.trials["node_id"].iloc[place])
    rows = np.searchsorted(trajectory.t, read(block["t"])[:, 0] - 1e-6)
    at = read(block["at"]).reshape(len(rows), -1, 3)
    turn = read(block["turn"]).reshape(len(rows), -1, 4)
    robot: Any = trajectory.problem.robot
    parts = unpacked(made.blocks[block["robot"]])["parts"]
    drawn = [name for name in robot.link_names if robot.urdf.link(name).visuals or robot.urdf.link(name).collisions]
    assert {part[1] for part in parts} == set(range(len(drawn)))
    for body, link in enumerate(drawn):
        assert at[:, body] == pytest.approx(trajectory.link(link)[rows], abs=0.005)
        pose = robot.forward_kinematics(trajectory.q[rows[3]], link)
        unit = turn[3, body] / np.linalg.norm(turn[3, body])
        assert np.asarray(matrix_of(unit.tolist())) == pytest.approx(pose[:3, :3], abs=5e-3)
    assert {f"mesh:{part[4]}" for part in parts if part[0] == "mesh"} <= set(made.blocks)


def test_robots_problems_and_meshes_are_told_once(run: ReportData, spatial: ReportData) -> None:
    made = replays(run, run.trials)
    kinds = [key.partition(":")[0] for key in made.blocks]
    assert kinds.count("robot") == 3
    assert kinds.count("scene") == run.trials["problem_hash"].replace("", None).nunique()
    assert kinds.count("trial") == len(run.trials) - 1  # one worker crashed
    names = [key for key in replays(spatial, spatial.trials).blocks if key.startswith("mesh:")]
    assert len(names) == len(set(names)) > 5


def test_what_pictures_show_comes_first_then_failures() -> None:
    data = make_run(["point/two_obstacles"], seeds=6, crashed=False)
    order = in_order_of_interest(data.trials)
    assert order["seed"].head(3).tolist() == [0, 0, 0]
    failed = set(data.trials.loc[~data.trials["success"], "seed"])
    assert failed
    rest = order.iloc[3:]["seed"].tolist()
    assert [seed in failed for seed in rest] == sorted((seed in failed for seed in rest), reverse=True)


def test_the_budget_and_the_number_are_kept() -> None:
    data = make_run(["point/two_obstacles"], seeds=6, crashed=False)
    whole = replays(data, data.trials)
    some = replays(data, data.trials, budget=sum(map(len, whole.blocks.values())) // 2)
    assert 3 <= len(some.places) < len(whole.places)
    section = trial_pages(replace(data, trials=data.trials), planner_styles(data.trials["planner"]))
    assert section is not None
    assert section.note == ""
    many = data.trials.loc[data.trials.index.repeat(40)].reset_index(drop=True)
    assert len(in_order_of_interest(many)) == MAX_REPLAYS


def test_charts_have_every_action_and_the_limits(run: ReportData) -> None:
    trajectory = run.trajectory_of("scenarios/arm/reach.yaml::pd::seed0")
    found = {chart["title"]: chart for chart in charts(trajectory)}
    task, motion = ["distance to goal [m]", "clearance [m]", "solver time [ms]"], ["position", "velocity", "action"]
    assert list(found) == [*task, *(f"{what} [{unit}]" for what, unit in zip(motion, UNITS, strict=True))]
    joints = list(trajectory.problem.robot.joint_names)
    assert [line["name"] for line in found["action [rad/s²]"]["lines"]] == joints
    assert [chart.get("below", False) for chart in found.values()] == [False] * 3 + [True] * 3
    assert found["distance to goal [m]"]["limit"] == 0.12
    line = found["distance to goal [m]"]["lines"][0]
    rows = np.searchsorted(trajectory.t, read(line["t"])[:, 0] - 1e-6)
    assert read(line["v"])[:, 0] == pytest.approx(trajectory.goal_error("reach")[rows], abs=0.01)


UNITS = ("rad", "rad/s", "rad/s²")


def changed(trajectory: Trajectory, columns: dict[str, Array], **robot: Any) -> Trajectory:
    """The trial with other columns, and a robot with other entries."""
    entry = trajectory.problem.to_dict()
    problem = Problem.from_dict({**entry, "robot": {**entry["robot"], **robot}}, trajectory.problem.name)
    kept = {name: values.copy() for name, values in trajectory.columns.items()}
    return Trajectory({**kept, **columns}, trajectory.metadata, problem)


def test_charts_show_limits_of_positions_velocities_and_actions(run: ReportData) -> None:
    limits = {
        "position": [[-2.0, 1.5], None, None],
        "velocity": [[-1.0, 1.0]] * 3,
        "acceleration": [None, None, [-4.0, 4.0]],
    }
    arm = changed(run.trajectory_of("scenarios/arm/reach.yaml::pd::seed0"), {}, limits=limits)
    found = {chart["title"].partition(" ")[0]: chart["lines"] for chart in charts(arm)}
    assert [line.get("limits") for line in found["position"]] == [[-2.0, 1.5], None, None]
    assert [line.get("limits") for line in found["velocity"]] == [[-1.0, 1.0]] * 3
    assert [line.get("limits") for line in found["action"]] == [None, None, [-4.0, 4.0]]


def test_a_cart_is_steered_by_v_and_w(run: ReportData) -> None:
    titles = [chart["title"] for chart in charts(run.trajectory_of("scenarios/cart/crossing.yaml::pd::seed0"))]
    motion = ["position [m]", "position theta [rad]", "velocity v [m/s]", "velocity w [rad/s]", "action v [m/s]"]
    assert titles[3:] == [*motion, "action w [rad/s]"]


def test_what_a_planner_records_is_charted(run: ReportData) -> None:
    plain = run.trajectory_of("scenarios/arm/reach.yaml::pd::seed0")
    rows = np.arange(len(plain), dtype=float)
    every_second = np.where(rows % 2 == 0, rows, np.nan)
    columns = {f"planner_key_{number:02}": every_second for number in range(14)} | {"planner_none": rows * np.nan}
    recorded = changed(plain, columns)
    shown = [chart for chart in charts(recorded) if chart["title"].startswith("planner: ")]
    assert [chart["title"] for chart in shown] == [f"planner: key {number:02}" for number in range(12)]
    assert read(shown[0]["lines"][0]["v"])[-1, 0] == pytest.approx(rows[-1] - rows[-1] % 2)
    assert diagnostics_left_out(recorded) == ["key_12", "key_13", "none"]


@given(arrays(float, st.integers(1, 60), elements=st.floats(-100, 100)), st.sampled_from([0.01, 1.0, 30.0]))
def test_lines_pass_all_rows_that_are_left_out(values: Array, tolerance: float) -> None:
    t = np.linspace(0.0, 1.0, len(values))
    rows = needed_rows(t, values, tolerance)
    assert np.abs(np.interp(t, t[rows], values[rows]) - values).max() <= tolerance * (1 + 1e-9)
    assert {values.min(), values.max()} <= set(values[rows].tolist())
    held = changed_rows(values, tolerance)
    assert {held[0], held[-1]} == {0, len(values) - 1}
    before = held[np.searchsorted(held, np.arange(len(values)), side="right") - 1]
    assert np.abs(values[before] - values).max() <= tolerance


def framed(run: ReportData, obstacles: list[dict[str, Any]]) -> tuple[Array, Array, dict[str, Any]]:
    """The frame of a trial on the point with these obstacles, and its scene."""
    trajectory = run.trajectory_of("scenarios/point/two_obstacles.yaml::pd::seed0")
    problem = Problem.from_dict({**trajectory.problem.to_dict(), "obstacles": obstacles}, "point/two_obstacles")
    moved, motion = Trajectory(trajectory.columns, trajectory.metadata, problem), motion_for(2)
    return *bounds(moved, motion), scene_block(moved, motion)


def test_a_replay_is_framed_by_robot_goal_and_path(run: ReportData) -> None:
    disc = {"name": "disc", "shape": "circle", "radius": 0.4}
    low, high, _ = framed(run, [])
    points = run.trajectory_of("scenarios/point/two_obstacles.yaml::pd::seed0").link("body")[:, :2]
    assert (low <= points.min(axis=0) - 0.15 + 1e-9).all()
    assert (high >= points.max(axis=0) + 0.15 - 1e-9).all()
    assert float((high - low).max()) < 6.0
    far_low, far_high, scene = framed(run, [{**disc, "position": [60.0, -40.0]}])
    assert (far_low.tolist(), far_high.tolist()) == (low.tolist(), high.tolist())
    assert scene["low"][1] == -40.4  # all obstacles can be shown
    assert scene["high"][0] == 60.4
    near_low, near_high, _ = framed(run, [{**disc, "position": [float(high[0]) + 0.5, float(low[1])]}])
    assert near_high[0] == pytest.approx(high[0] + 0.9)
    assert near_low[1] == pytest.approx(low[1] - 0.4)


def test_bases_have_a_heading_and_trials_a_time_of_contact(run: ReportData, spatial: ReportData) -> None:
    for data, scenario, moves in (
        (run, "cart/crossing", True),
        (run, "arm/reach", False),
        (spatial, "cart/drive", True),
    ):
        trajectory = data.trajectory_of(f"scenarios/{scenario}.yaml::pd::seed0")
        trajectory.metadata["contact_time_s"] = 1.2345  # type: ignore[index] # a dictionary here
        motion = motion_for(trajectory.problem.dimension)
        heading = robot_block(trajectory, motion)["heading"]
        block = trial_block(trajectory, motion)
        del trajectory.metadata["contact_time_s"]  # type: ignore[attr-defined] # as above
        assert block["contact"] == 1.2345
        assert trial_block(trajectory, motion)["contact"] is None
        assert (heading is not None) == moves
        if heading is not None:
            body, length = heading
            theta = trajectory.q[-1, 2]
            turn = read(block["turn"]).reshape(len(read(block["t"])), -1, 1 if data is run else 4)[-1, body]
            found = turn[0] if data is run else 2 * np.arctan2(turn[3], turn[0])
            assert np.cos(found - theta) == pytest.approx(1.0, abs=1e-3)
            assert 0.2 < length < 2.0


@pytest.mark.parametrize("far", [1e13, 1e300, np.inf, np.nan])
def test_trials_that_diverge_are_small_numbers(run: ReportData, far: float) -> None:
    """Warnings are errors here."""

    def diverged(node_id: str) -> Trajectory:
        made = run.trajectory_of(node_id)
        columns = {name: values.copy() for name, values in made.columns.items()}
        for name, values in columns.items():
            if name.startswith(("q", "u", "link_", "clearance_m", "goal_reach_error", "action")):
                values[len(values) // 2 :] = far
        return Trajectory(columns, made.metadata, made.problem)

    made = replays(replace(run, trajectory_of=diverged), run.trials)
    assert len(made.places) == len(run.trials) - 1
    for place in made.places:
        block = unpacked(made.blocks[f"trial:{place}"])
        assert np.nanmax(np.abs(read(block["at"]))) < 200.0
        assert all(abs(value) < 200.0 for value in (*block["low"], *block["high"]))


def test_a_mesh_that_goes_while_the_report_is_made_is_left_out(tmp_path: Path) -> None:
    data = spatial_run(tmp_path, {"point_3d/shapes": spatial_problems(tmp_path)["point_3d/shapes"]})
    read_before = {node_id: data.trajectory_of(node_id) for node_id in data.trials["node_id"]}
    for path in tmp_path.rglob("*.obj"):
        path.unlink()
    made = replays(replace(data, trajectory_of=read_before.__getitem__), data.trials)
    assert len(made.places) == len(data.trials)
    assert unpacked(made.blocks["mesh:0"]) == {"vertices": None, "faces": None}
    again = replays(data, data.trials)
    assert not again.places
    assert "ring.obj of its problem is missing" in again.faults[0]
