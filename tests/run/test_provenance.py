"""What run.json says of scenarios in space."""

from pathlib import Path

from pytest_lpb.run.provenance import run_information
from pytest_lpb.study.family import FileFamily
from tests.scenario.urdfs import write_arm

SPATIAL = """\
version: 1
robot: {urdf: arm.urdf}
environment: {engine: pybullet}
goal: [{type: joint, joints: [j1], target: [0.3], tolerance: 1.0}]
"""


def test_scenarios_that_do_not_load_are_errors_elsewhere(tmp_path: Path) -> None:
    write_arm(tmp_path / "arm.urdf")
    files = {"right": SPATIAL, "wrong": SPATIAL.replace("j1", "j9"), "no_file": SPATIAL.replace("arm.urdf", "no.urdf")}
    for name, content in files.items():
        (tmp_path / f"{name}.yaml").write_text(content)
    scenarios = {name: FileFamily(name, tmp_path / f"{name}.yaml") for name in files}
    information = run_information(["pytest"], [], scenarios, {}, tmp_path)
    assert information["self_collision_left_out"] == {"right": []}
    assert sorted(information["scenarios"]) == sorted(files)
