"""Scenarios whose robots come with an optional package, where it is missing."""

import pytest

SCENARIO = """\
version: 1
robot: {model: ur5}
environment: {engine: pybullet, dt: 0.02, duration: 1.0}
goal: [{type: joint, joints: [elbow_joint], target: [0.1], tolerance: 0.1}]
"""
WITHOUT = """\
from pytest_lpb.problem.spatial import library

library._example_robot_data_folder = lambda: None
"""


@pytest.mark.parametrize("workers", ["0", "2"])
def test_they_are_skipped_with_their_reason(pytester: pytest.Pytester, workers: str) -> None:
    pytester.makeconftest(WITHOUT)
    folder = pytester.mkdir("scenarios")
    (folder / "ur5.yaml").write_text(SCENARIO, encoding="utf-8")
    result = pytester.runpytest_subprocess("--lpb-planners=pd", "-rs", "-n", workers)
    result.assert_outcomes(skipped=1)
    result.stdout.fnmatch_lines(["SKIPPED*the robot ur5 comes with the package example-robot-data*pip install*"])


def test_unreadable_meshes_are_told_with_file_and_line(pytester: pytest.Pytester) -> None:
    folder = pytester.mkdir("scenarios")
    (folder / "bad.obj").write_text("no mesh", encoding="utf-8")
    obstacle = "obstacles: [{name: o, shape: mesh, file: bad.obj, position: [2, 0, 0]}]\n"
    goal = "goal: [{type: joint, joints: [x], target: [0.1], tolerance: 0.1}]\n"
    text = SCENARIO.replace("model: ur5", "model: point_3d").partition("goal")[0] + goal + obstacle
    (folder / "mesh.yaml").write_text(text, encoding="utf-8")
    result = pytester.runpytest_subprocess("--lpb-planners=pd", "-n", "0")
    result.stdout.fnmatch_lines(["scenarios/mesh.yaml:5: obstacles[[]0].file: bad.obj: has no triangles*"])
    result.stdout.no_fnmatch_line("*Traceback*")
