"""`lpb-scenarios`, as users type it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pytest_lpb.commands import EXIT_USAGE
from pytest_lpb.documents.recognition import is_study
from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.scenario.copying import copy_scenarios
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.scenario.shelf import scenarios_in
from pytest_lpb.scenarios_cli import main
from pytest_lpb.shipped import shipped_folder
from tests.scenario.test_import_lpb import ARM, PANDA


@pytest.fixture
def experiment(tmp_path: Path) -> Path:
    """An experiment file of the Panda."""
    path = tmp_path / "exp.yaml"
    path.write_text(dump_yaml(PANDA), encoding="utf-8")
    return path


def test_a_scenario_is_printed(experiment: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(experiment)]) == 0
    printed = capsys.readouterr()
    path = tmp_path / "printed.yaml"
    path.write_text(printed.out, encoding="utf-8")
    assert load_scenario(path).concrete["robot"]["model"] == "panda"
    assert "lpb-scenarios: differs: random obstacles of radius 0; the least is 0.001 m\n" in printed.err


def test_a_scenario_is_written_once(experiment: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "new folder" / "panda.yaml"
    assert main(["import", str(experiment), "--output", str(output)]) == 0
    assert load_scenario(output).concrete["robot"]["model"] == "panda"
    capsys.readouterr()
    assert main(["import", str(experiment), "--output", str(output)]) == EXIT_USAGE
    assert capsys.readouterr().err == f"lpb-scenarios: error: {output} is there already; choose another --output\n"


def test_a_file_that_is_not_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(tmp_path / "no.yaml")]) == EXIT_USAGE
    assert "no.yaml: cannot be read: No such file or directory" in capsys.readouterr().err


def test_an_experiment_that_makes_no_scenario(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "exp.yaml"
    path.write_text(dump_yaml({**ARM, "initState": {"q0": [9.0, 0.0, 0.0], "q0dot": [0.0] * 3}}), encoding="utf-8")
    assert main(["import", str(path)]) == EXIT_USAGE
    assert "what it says makes no scenario: start.q[0]: joint 1: 9 is outside [-3.14, 3.14]" in capsys.readouterr().err


def test_a_start_in_collision_is_reported_at_import(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "exp.yaml"
    path.write_text(dump_yaml({**PANDA, "r_body": 0.3, "selfCollision": {"pairs": [[5, 7]]}}), encoding="utf-8")
    assert main(["import", str(path)]) == 0
    assert "warning: pytest will not run this scenario: start: the start is in " in capsys.readouterr().err
    assert main(["import", str(path), "--strict"]) == EXIT_USAGE
    printed = capsys.readouterr()
    assert "nothing is written under --strict" in printed.err
    assert not printed.out


def test_wrong_arguments_print_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["export"])
    assert caught.value.code == EXIT_USAGE
    assert "usage: lpb-scenarios" in capsys.readouterr().err


SHIPPED = shipped_folder("scenarios")
PATHS = [path for path in SHIPPED.rglob("*.yaml") if not is_study(path)]
NAMES = sorted(path.relative_to(SHIPPED).with_suffix("").as_posix() for path in PATHS)


def listed(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, str]:
    """Lines of the list by scenario."""
    assert main([*arguments]) == 0
    head, *lines, note = capsys.readouterr().out.splitlines()
    assert head.split() == ["scenario", "robot", "control", "trials", "obstacles", "difficulty", "tags"]
    assert note.startswith(f"{len(lines)} scenarios; difficulty: ")
    return {line.split()[0]: line for line in lines}


@pytest.mark.parametrize("arguments", [["list"], []])
def test_all_are_listed(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert list(listed(capsys, *arguments)) == NAMES


def test_what_is_said_of_one(capsys: pytest.CaptureFixture[str]) -> None:
    lines = {name: re.split(r"  +", line) for name, line in listed(capsys, "list").items()}
    assert lines["panda/ring"][1:] == [
        "panda",
        "acceleration",
        "1",
        "1",
        "1 (potential_field)",
        "spatial, arm, static, narrow",
    ]
    assert lines["point/clutter"][3:5] == ["10", "7 to 8 drawn"]
    assert lines["mobile_manipulator/panda_holonomic"][1:5] == ["panda (holonomic)", "velocity", "1", "1 + 1 moving"]
    assert lines["panda/pendulum"][4] == "2 moving"
    assert lines["point/u_trap"][5].startswith("5 (")
    assert lines["differential_drive/parking"][4] == "none"


def test_difficulty_counts_planners_of_the_package() -> None:
    shipped = {path.stem for path in shipped_folder("planners").glob("*.yaml")}
    assert {planner for entry in scenarios_in(SHIPPED) for planner in entry.known_failures} <= shipped


def test_an_obstacle_that_turns_moves(tmp_path: Path) -> None:
    text = """\
version: 1
robot: {model: point}
goal: [{type: position, link: body, target: [1, 1], tolerance: 0.1}]
obstacles:
  - {shape: rectangle, size: [1, 1], position: [5, 5], orientation: "0.1*t"}
  - {shape: rectangle, size: [1, 1], position: [9, 9], orientation: 0.1}
"""
    (tmp_path / "x.yml").write_text(text, encoding="utf-8")
    (entry,) = scenarios_in(tmp_path)
    assert (entry.name, entry.standing, entry.moving, entry.difficulty) == ("x", 1, 1, 0)


def test_some_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    narrow = listed(capsys, "list", "--tags=spatial,narrow", "--robot=panda")
    assert list(narrow) == ["panda/bin", "panda/ring", "panda/shelf", "panda/wall_with_window"]
    assert "mobile_manipulator/panda_holonomic" in listed(capsys, "list", "--robot", "panda")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["list", "--tags", "spacial"], "no scenario has the tag 'spacial'; did you mean 'spatial'?"),
        (["list", "--robot", "pandas"], "no scenario has the robot 'pandas'; did you mean 'panda'?"),
        (["copy", "here", "panda/rings"], "no scenario 'panda/rings' comes with pytest-lpb; did you mean 'panda/ring'"),
    ],
)
def test_unknown_names(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == EXIT_USAGE
    assert f"lpb-scenarios: error: {message}" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["--copy"], ["copy"]])
def test_all_are_copied_with_what_they_name(
    arguments: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "new folder"
    assert main([*arguments, str(folder)]) == 0
    copies = {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert copies == {path.relative_to(SHIPPED): path.read_bytes() for path in SHIPPED.rglob("*") if path.is_file()}
    first, command = capsys.readouterr().out.splitlines()
    assert first.startswith(f"{len(NAMES)} scenarios copied to ")
    assert command.strip() == f"pytest --lpb-planners=pd '{folder}/{NAMES[0]}.yaml'"


def test_some_are_copied(tmp_path: Path) -> None:
    assert main(["copy", str(tmp_path), "panda/ring.yaml", "racecar/"]) == 0
    copies = sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file())
    assert copies == [
        "meshes/ring.obj",
        "panda/ring.yaml",
        "paths/panda_ring.csv",
        "paths/racecar_crossing.csv",
        "racecar/crossing.yaml",
    ]
    # What several scenarios need may be there; the scenario itself may not, as it is, or changed.
    (tmp_path / "panda" / "ring.yaml").unlink()
    assert main(["copy", str(tmp_path), "panda/ring"]) == 0


@pytest.mark.parametrize("name", ["panda/ring.yaml", "meshes/ring.obj"])
def test_nothing_is_overwritten(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine = tmp_path / name
    mine.parent.mkdir()
    mine.write_text("mine", encoding="utf-8")
    assert main(["copy", str(tmp_path)]) == EXIT_USAGE
    assert f"error: {mine} is there already, and nothing was copied" in capsys.readouterr().err
    assert mine.read_text(encoding="utf-8") == "mine"
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [mine]


def test_a_robot_of_a_urdf_comes_with_its_meshes(tmp_path: Path) -> None:
    source, target = tmp_path / "source", tmp_path / "target"
    (source / "robots" / "meshes").mkdir(parents=True)
    shutil.copy(SHIPPED / "meshes" / "ring.obj", source / "robots" / "meshes" / "hand.obj")
    urdf = """\
<robot name="mine">
<link name="base"><collision><geometry><mesh filename="meshes/hand.obj"/></geometry></collision></link>
<link name="tip"/>
<joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
</robot>
"""
    (source / "robots" / "mine.urdf").write_text(urdf, encoding="utf-8")
    (source / "group").mkdir()
    text = """\
version: 1
robot: {urdf: ../robots/mine.urdf}
environment: {engine: pybullet}
goal: [{type: joint, joints: [j], target: [0.5], tolerance: 0.1}]
"""
    (source / "group" / "x.yaml").write_text(text, encoding="utf-8")
    (entry,) = scenarios_in(source)
    assert entry.robot == "mine"
    copy_scenarios([entry], source, target)
    copies = {path.relative_to(target).as_posix() for path in target.rglob("*") if path.is_file()}
    assert copies == {"group/x.yaml", "robots/mine.urdf", "robots/meshes/hand.obj"}
    load_scenario(target / "group" / "x.yaml")


def test_copies_run(tmp_path: Path) -> None:
    assert main(["copy", str(tmp_path / "my scenarios"), "point/doorway", "panda/ring", "panda/random_spheres"]) == 0
    options = ["--lpb-planners=pd", "--lpb-kpis=time_to_goal_s", "--lpb-trials=1", "-q", "-p", "no:cacheprovider"]
    command = [
        sys.executable,
        "-m",
        "pytest",
        *options,
        "my scenarios/point/doorway.yaml",
        "my scenarios/panda/ring.yaml",
    ]
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    result = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout
    assert "2 passed" in result.stdout


def test_copying_all_is_no_command_of_another(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["--copy", str(tmp_path), "list"])
    assert caught.value.code == EXIT_USAGE
    assert "`lpb-scenarios copy DIR NAME ...` copies some" in capsys.readouterr().err
