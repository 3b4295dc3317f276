"""Files of problems in space travel with the run: it repeats and evaluates without the originals, wherever it lies."""

from __future__ import annotations

import shutil
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from pytest_lpb.report.build import write_results
from pytest_lpb.run.evaluation import evaluate
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.trial.files import METADATA_KEY, read_trial
from tests.scenario.urdfs import BOX, TETRAHEDRON, mesh, write_arm

from .projects import SCENARIO, Project, hashes_of, read_run, read_table, text_of

ARM = """\
version: 1
robot: {urdf: ../my_arm/urdf/arm.urdf}
environment: {engine: pybullet, dt: 0.05, duration: 0.3, end_at: []}
goal:
  - {name: reach, type: joint, joints: [j1, j2], target: [0.3, -0.2], tolerance: 1.0}
obstacles:
  - {name: rock, shape: mesh, file: ../rock.obj, scale: 2.0, position: [0, 1, 1], orientation: [1, 2, 0, 0]}
  - {name: ball, shape: sphere, radius: 0.1, trajectory: ["2 - t", 0, 1]}
success: {hold_time: 0.2}
certified: {seed: 0, length_m: 0.7, path: ../path.csv}
"""


@pytest.fixture
def arm(project: Project) -> Project:
    """A project with a robot of its own in a ROS package, a mesh, and a certified path."""
    write_arm(project.path / "my_arm/urdf/arm.urdf", mesh("package://my_arm/meshes/part.obj"))
    project.write("my_arm/meshes/part.obj", TETRAHEDRON)
    project.write("rock.obj", TETRAHEDRON)
    project.write("path.csv", "t,q0,q1\n0,0,0\n")
    project.scenario("scenarios/arm.yaml", ARM)
    return project


def run_once(project: Project) -> Path:
    project.run("scenarios").assert_outcomes(passed=1)
    return project.runs()[-1]


def without_originals(project: Project, run: Path) -> Path:
    """Delete the robot, the mesh and the scenario, and move the run folder."""
    for name in ("my_arm", "scenarios"):
        shutil.rmtree(project.path / name)
    for name in ("rock.obj", "path.csv"):
        (project.path / name).unlink()
    moved = project.path / "archive" / "old"
    moved.parent.mkdir()
    run.rename(moved)
    return moved


def test_a_problem_repeats_without_its_originals(arm: Project) -> None:
    moved = without_originals(arm, run_once(arm))
    (first,) = read_table(moved / "trials.csv")
    result = arm.run(moved / "trials/arm/pd/seed0.yaml")
    result.assert_outcomes(passed=1)
    again = arm.row()
    assert again["problem_hash"] == first["problem_hash"]
    assert again["trajectory_hash"] == first["trajectory_hash"] != ""


def test_a_repeated_problem_repeats_again(arm: Project) -> None:
    moved = without_originals(arm, run_once(arm))
    expected = set(hashes_of(moved).values())
    arm.run(moved / "trials/arm/pd/seed0.yaml").assert_outcomes(passed=1)
    second = arm.runs()[-1]
    shutil.rmtree(moved)
    (problem,) = second.glob("trials/**/seed0.yaml")
    arm.run(problem).assert_outcomes(passed=1)
    assert set(arm.hashes().values()) == expected


def test_a_run_evaluates_without_its_originals(arm: Project) -> None:
    run = run_once(arm)
    before = (run / "trials.csv").read_bytes()
    moved = without_originals(arm, run)
    (moved / "trials.csv").unlink()
    write_results(evaluate(RunFolder.open(moved), ["time_to_goal_s"]), moved)
    assert (moved / "trials.csv").read_bytes() == before


def test_a_trial_file_names_files_relative_to_the_run(arm: Project) -> None:
    run = run_once(arm)
    path = run / "trials/arm/pd/seed0.parquet"
    metadata = pq.read_schema(path).metadata[METADATA_KEY].decode()
    assert str(arm.path / "my_arm") not in metadata
    problem = read_trial(path).problem
    assert Path(problem.robot.entry["urdf"]).is_relative_to(run)
    assert problem.obstacles[0].file is not None
    assert Path(problem.obstacles[0].file).is_relative_to(run)
    assert problem.entry["certified"] == {"seed": 0, "length_m": 0.7}
    assert len(list((run / "assets").iterdir())) == 2


def test_workers_share_the_copies(arm: Project) -> None:
    result = arm.run_workers("--lpb-trials=6", "scenarios", planners="pd,potential_field")
    result.assert_outcomes(passed=12)
    run = arm.runs()[-1]
    assert len(list((run / "assets").iterdir())) == 2
    assert len({row["problem_hash"] for row in arm.rows()}) == 1


def test_a_trial_file_without_its_run_folder(arm: Project) -> None:
    run = run_once(arm)
    shutil.rmtree(run / "assets")
    evaluation = evaluate(RunFolder.open(run), ["time_to_goal_s"])
    (warning,) = evaluation.warnings
    assert "arm.urdf of its problem is missing; a run folder keeps them in assets/" in warning


OVERLAP = ARM.replace("../my_arm/urdf/arm.urdf", "../overlap.urdf")


def write_overlapping(project: Project) -> None:
    """An arm whose links are all at one place."""
    text = write_arm(project.path / "overlap.urdf").read_text("utf-8")
    project.write("overlap.urdf", text.replace('xyz="0.5 0 0"', 'xyz="0 0 0"'))


def test_run_json_lists_pairs_left_out_of_self_collision_checks(arm: Project) -> None:
    write_overlapping(arm)
    arm.scenario("scenarios/overlap.yaml", OVERLAP)
    given = OVERLAP.replace("overlap.urdf}", "overlap.urdf, self_collision_pairs: []}")
    arm.scenario("scenarios/given.yaml", given)
    arm.scenario("scenarios/point.yaml", SCENARIO)
    arm.run("scenarios")
    left_out = read_run(arm.runs()[-1])["self_collision_left_out"]
    assert left_out == {"arm": [], "given": [], "overlap": [["base", "lower"]]}


def test_a_planar_run_leaves_out_nothing_and_loads_no_physics(project: Project) -> None:
    project.scenario()
    project.write(
        "conftest.py",
        "import sys\ndef pytest_unconfigure():\n    print('physics:', 'pybullet' in sys.modules)\n",
    )
    result = project.pytester.runpytest_subprocess("--lpb-planners=pd", "--lpb-kpis=time_to_goal_s", "scenarios")
    assert "physics: False" in text_of(result)
    run = project.runs()[-1]
    assert read_run(run)["self_collision_left_out"] == {}
    assert not (run / "assets").exists()


def test_robots_that_never_collide_are_a_warning_and_what_is_not_needed_a_note(arm: Project) -> None:
    seen = write_arm(arm.path / "seen.urdf", '<visual><geometry><mesh filename="none.glb"/></geometry></visual>')
    seen.write_text(seen.read_text("utf-8").replace(BOX, ""), "utf-8")
    arm.scenario("scenarios/seen.yaml", ARM.replace("../my_arm/urdf/arm.urdf", "../seen.urdf"))
    result = arm.run("scenarios/seen.yaml")
    run = arm.runs()[-1]
    told = "warning: seen: the robot 'seen' has no collision geometry, so it never collides; give it some in its URDF"
    assert told in text_of(result)
    assert result.ret == pytest.ExitCode.OK  # a warning fails no run
    assert told in text_of(arm.run("--lpb-report=none", "scenarios/seen.yaml"))
    assert "so it never collides" in (run / "report.html").read_text("utf-8")
    assert list(read_run(run)["robot_warnings"]) == ["seen"]
    notes = read_run(run)["robot_notes"]["seen"]
    assert notes[0] == "seen.urdf:1: the visual mesh 'none.glb' is not there; it is not shown"
