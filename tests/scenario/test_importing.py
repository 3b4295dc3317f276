"""Experiment files of localPlannerBench as scenario files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.errors import LpbError
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.importing import Imported, import_experiment
from pytest_lpb.scenario.load import load_scenario

Entry = dict[str, Any]
Import = Callable[[Entry], Imported]

PANDA: Entry = {
    "T": 2000,
    "dt": 0.01,
    "control_mode": "acc",
    "robot_type": "panda",
    "n": 7,
    "goal": {
        "reach": {
            "is_primary_goal": True,
            "weight": 2,
            "indices": [0, 1, 2],
            "parent_link": 0,
            "child_link": 7,
            "desired_position": [0.5, -0.4, 0.3],
            "low": [-0.4, -0.4, 0.1],
            "high": [0.7, 0.0, 1.1],
            "type": "staticSubGoal",
            "epsilon": 0.05,
        }
    },
    "initState": {"q0": [1.0, 0, 0, -1.5, 0, 1.8675, 0], "q0dot": [0] * 7},
    "r_body": 0.1,
    "selfCollision": {"pairs": [[0, 6], [0, 7]]},
    "obstacles": {
        "ball": {
            "type": "sphereObstacle",
            "geometry": {"position": [0.7, 0.3, 0.6], "radius": 0.15},
            "low": {"position": [-1.0, -1.0, 0.0], "radius": 0.0},
            "high": {"position": [1.0, 0.3, 1.0], "radius": 0.2},
        }
    },
    "randomObstacles": {"number": 5},
}
ARM: Entry = {
    "T": 300,
    "dt": 0.05,
    "env": "nLink-reacher-vel-v0",
    "robot_type": "planarArm",
    "n": 3,
    "goal": {
        "tip": {
            "prime": True,
            "w": 1,
            "indices": [0, 1],
            "parent_link": 0,
            "child_link": 3,
            "desired_position": [1.7, -1.0],
            "epsilon": 0.15,
        },
        "upright": {
            "prime": False,
            "w": 1,
            "indices": [0],
            "parent_link": 1,
            "child_link": 2,
            "desired_position": [0.0],
        },
    },
    "initState": {"q0": [1.57, 0.0, -1.57], "q0dot": [0.0] * 3},
    "limits": {"low": [-3.14, -2.0, -2.0], "high": [3.14, 2.0, 2.0]},
    "r_body": 0.1,
    "obstacles": {
        "still": {"geometry": {"position": [2.3, 0.0], "radius": 0.5}},
        "passing": {"type": "analyticSphere", "geometry": {"trajectory": ["-3 + 0.2 * t", "2.5"], "radius": 0.2}},
        "odd": {"type": "analyticSphere", "geometry": {"trajectory": ["ca.tanh(t)", "2.5"], "radius": 0.2}},
    },
    "selfCollision": {"pairs": [[0, 2], [1, 3]]},
}


@pytest.fixture
def imported(tmp_path: Path) -> Import:
    """Imports an experiment of this content."""

    def read(entry: Entry) -> Imported:
        path = tmp_path / "exp.yaml"
        path.write_text(dump_yaml(entry), encoding="utf-8")
        return import_experiment(path)

    return read


def test_the_panda_s_problem_is_carried_over(imported: Import, tmp_path: Path) -> None:
    result = imported(PANDA)
    path = tmp_path / "panda.yaml"
    path.write_text(result.text("exp.yaml"), encoding="utf-8")
    scenario = load_scenario(path)
    problem = draw_problem(scenario, 0)
    robot = problem.robot
    assert robot.name == "panda"
    assert problem.duration == 20.0
    assert problem.end_at == frozenset()
    assert problem.hold_time == 0.0
    assert problem.primary.link == "panda_link8"
    assert problem.primary.tolerance == 0.05
    assert problem.primary.weight == 2.0
    assert robot.self_collision_pairs == (("panda_link0", "panda_link6"), ("panda_link0", "panda_link8"))
    assert {body.capsules[0][6] for body in robot.collision_bodies} == {0.1}
    assert [obstacle.radius for obstacle in problem.obstacles] == [0.15]
    drawn = draw_problem(scenario, 1, ("goal", "obstacles"))
    assert [obstacle.name for obstacle in drawn.obstacles] == [f"drawn{index}" for index in range(5)]


def test_an_arm_s_frames_are_numbered_from_its_base(imported: Import, tmp_path: Path) -> None:
    result = imported(ARM)
    path = tmp_path / "arm.yaml"
    path.write_text(result.text("exp.yaml"), encoding="utf-8")
    content = load_scenario(path).concrete
    assert content["robot"]["control"] == "velocity"  # by the name of its environment
    assert [goal["link"] for goal in content["goal"]] == ["end"]
    assert content["robot"]["self_collision_pairs"] == [["base", "link3"], ["link2", "end"]]
    assert content["robot"]["limits"]["position"] == [[-3.14, 3.14], [-2.0, 2.0], [-2.0, 2.0]]
    assert [obstacle["name"] for obstacle in content["obstacles"]] == ["still", "passing"]
    assert content["obstacles"][1]["trajectory"] == ["-3 + 0.2 * t", "2.5"]


def test_what_cannot_be_carried_over_is_listed_in_the_file_too(imported: Import) -> None:
    result = imported({**ARM, "root_link": "world"})
    assert result.left_out[0] == "goal.upright, which is relative to a link in the world's axes"
    assert result.left_out[1].startswith("obstacles.odd, whose trajectory cannot be read: ")
    assert result.left_out[2] == "root_link, which has no meaning here"
    text = result.text("exp.yaml").splitlines()
    assert text[0] == "# Imported from exp.yaml of localPlannerBench."
    assert text[1] == f"# Not carried over: {result.left_out[0]}"


def test_splines_of_control_points_become_points_on_them(imported: Import) -> None:
    points = [[0.0, 0.0], [1.0, 2.0], [2.0, 0.0]]
    spline = {"ctrlpts": points, "degree": 2, "duration": 10}
    goal = {"prime": True, "indices": [0, 1], "child_link": 3, "desired_position": spline, "epsilon": 0.1}
    result = imported({**ARM, "goal": {"follow": goal}})
    rows = result.content["goal"][0]["spline"]
    assert rows[0] == [0.0, 0.0, 0.0]
    assert rows[-1] == [10.0, 2.0, 0.0]
    assert rows[15] == pytest.approx([5.0, 1.0, 1.0])  # a parabola: half of the way, half of the height


def test_a_cart_starts_with_two_velocities(imported: Import) -> None:
    entry = {
        **ARM,
        "robot_type": "boxer",
        "goal": {
            "reach": {"prime": True, "indices": [0, 1], "child_link": 3, "desired_position": [1, 1], "epsilon": 0.1}
        },
        "initState": {"q0": [0.5, 0.0, 0.0], "q0dot": [0.1, 0.0]},
        "selfCollision": {"pairs": None},
    }
    content = imported(entry).content
    assert content["robot"]["model"] == "differential_drive"
    assert content["start"] == {"q": [0.5, 0.0, 0.0], "u": [0.1, 0.0]}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"robot_type": "pandas"}, "robot_type: found 'pandas', did you mean 'panda'?"),
        ({"robot_type": "tiago"}, "robot_type: found 'tiago'; can be imported: "),
        ({"initState": {}}, "is not as experiments of localPlannerBench are: KeyError('q0')"),
        ({"goal": {}}, "goal: no sub-goal of it can be carried over"),
        ({"control_mode": "tor"}, "control_mode: found 'tor'; can be imported: acc, vel"),
    ],
)
def test_wrong_experiments_are_told_with_their_line(imported: Import, change: Entry, message: str) -> None:
    with pytest.raises(LpbError) as caught:
        imported({**PANDA, **change})
    text = str(caught.value)
    assert message.replace(", did", "; did") in text.replace(", did", "; did")
    assert "exp.yaml:" in text


def test_what_every_experiment_has_is_missed(imported: Import) -> None:
    with pytest.raises(LpbError, match=r"exp.yaml:1: T: is missing; experiments of localPlannerBench have it"):
        imported({key: value for key, value in PANDA.items() if key != "T"})
