"""Experiment files of localPlannerBench as scenario files."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.errors import LpbError
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.scenario.import_lpb.experiment import Imported, import_experiment
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
    assert robot.self_collision_pairs == (("panda_link0", "panda_link8"),)  # numbers 6 and 7 are both on this link
    assert scenario.concrete["goal"][0]["point"] == [0.0, 0.0, 0.02]
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
    result = imported({**ARM, "weather": "fine"})
    assert result.lost[0] == "goal.upright, which is relative to a moving link in the world's axes"
    assert result.lost[1].startswith("obstacles.odd.geometry, whose trajectory cannot be read: ")
    assert result.lost[2] == "weather, which has no meaning here"
    text = result.text("exp.yaml").splitlines()
    assert text[0] == "# Imported from exp.yaml of localPlannerBench."
    assert text[1] == f"# Not converted: {result.lost[0]}"


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
        ({"robot_type": 7}, "robot_type: found 7; can be imported: "),
        ({"initState": {}}, "initState.q0: is missing"),
        ({"goal": {}}, "goal: no sub-goal of it can be converted: it is empty"),
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


def goal_entry(**changes: Any) -> Entry:
    """The Panda's goal with other keys; None takes a key away."""
    reach = {**PANDA["goal"]["reach"], **changes}
    return {"goal": {"reach": {key: value for key, value in reach.items() if value is not None}}}


def test_numbers_of_links_are_the_frames_that_published_results_record(imported: Import, tmp_path: Path) -> None:
    # The first row of a published result of the Panda: positions of its frames 1 to 7 at this configuration [m].
    q = [1.0, 0.0, 0.0, -1.5, 0.0, 1.8675, 0.0]
    recorded = [
        [0.0, 0.0, 0.649],
        [0.0446, 0.0694, 0.649],
        [0.2484, 0.3868, 0.7585],
        [0.2484, 0.3868, 0.7585],
        [0.2928, 0.4559, 0.7901],
        [0.3135, 0.4883, 0.6902],
        [0.3174, 0.4943, 0.6716],
    ]
    for number, position in enumerate(recorded, 1):
        result = imported({**PANDA, **goal_entry(child_link=number)})
        path = tmp_path / f"{number}.yaml"
        path.write_text(result.text("exp.yaml"), encoding="utf-8")
        problem = draw_problem(load_scenario(path), 0)
        goal = result.content["goal"][0]
        frame = problem.robot.forward_kinematics(q, goal["link"])
        reached = frame @ [*goal.get("point", [0.0, 0.0, 0.0]), 1.0]
        assert reached[:3] == pytest.approx(position, abs=1e-3)


@pytest.mark.parametrize("kind", [{"type": "staticJointSpaceSubGoal"}, {"type": "static", "jointSpace": True}])
def test_goals_in_joint_space_are_joint_goals(imported: Import, kind: Entry) -> None:
    goal = {"prime": True, "indices": [0, 2], "desired_position": [0.4, -0.9], "epsilon": 0.05, **kind}
    result = imported({**ARM, "goal": {"rest": goal}})
    assert result.content["goal"][0] == {
        "name": "rest",
        "type": "joint",
        "joints": ["joint1", "joint3"],
        "target": [0.4, -0.9],
        "weight": 1.0,
        "primary": True,
        "tolerance": 0.05,
    }
    assert result.notes[0] == ("goal.rest: epsilon bounds the largest joint error here, the norm of all errors there")


@pytest.mark.parametrize("prefix", ["ca.", "np.", "sp.", ""])
def test_functions_may_be_those_of_a_library(imported: Import, prefix: str) -> None:
    moving = {
        "prime": True,
        "indices": [0, 1],
        "child_link": 3,
        "trajectory": [f"1.5 * {prefix}cos(0.3 * t)", f"{prefix}sin(t)"],
        "epsilon": 0.1,
    }
    result = imported({**ARM, "goal": {"follow": moving}})
    assert result.content["goal"][0]["trajectory"] == ["1.5 * cos(0.3 * t)", "sin(t)"]


def test_the_reason_is_given_where_no_goal_is_left(imported: Import) -> None:
    goal = {"prime": True, "indices": [0, 1], "child_link": 3, "trajectory": ["ca.tanh(t)", "0"], "epsilon": 0.1}
    with pytest.raises(
        LpbError, match=r"goal: no sub-goal of it can be converted: goal\.g, .* unknown function 'tanh'"
    ):
        imported({**ARM, "goal": {"g": goal}})


OBSTACLES: Entry = {
    "post": {"type": "cylinderObstacle", "geometry": {"position": [0.7, -0.5, 0.6], "radius": 0.08, "height": 1.2}},
    "table": {
        "type": "boxObstacle",
        "geometry": {
            "position": [0.7, 0.5, 0.1],
            "width": 0.4,
            "length": 0.5,
            "height": 0.2,
            "orientation": [0.0, 0.0, 0.0, 2.0],
        },
    },
    "drum": {"geometry": {"trajectory": ["0.1 * t", "1", "0.2"], "radius": 0.1, "height": 0.3}},
    "ring": {"type": "torusObstacle", "geometry": {"position": [9.0, 0.0, 0.0], "radius": 0.1}},
}


def test_each_shape_is_converted_or_listed(imported: Import) -> None:
    result = imported({**PANDA, "obstacles": OBSTACLES, "randomObstacles": {"number": 0}})
    assert result.content["obstacles"] == [
        {"name": "post", "shape": "cylinder", "radius": 0.08, "length": 1.2, "position": [0.7, -0.5, 0.6]},
        {
            "name": "table",
            "shape": "box",
            "size": [0.5, 0.4, 0.2],
            "position": [0.7, 0.5, 0.1],
            "orientation": [0.0, 0.0, 0.0, 1.0],
        },
        {"name": "drum", "shape": "cylinder", "radius": 0.1, "length": 0.3, "trajectory": ["0.1 * t", "1", "0.2"]},
    ]
    assert result.lost == ["obstacles.ring of type 'torusObstacle'; converted are sphere, cylinder, box, urdf"]


def test_planar_robots_meet_the_outlines_of_upright_shapes(imported: Import) -> None:
    tilted = {"type": "boxObstacle", "geometry": {**OBSTACLES["table"]["geometry"], "orientation": [1, 1, 0, 0]}}
    result = imported({**ARM, "obstacles": {**OBSTACLES, "tilted": tilted}})
    post, table, _ = result.content["obstacles"]
    assert post == {"name": "post", "shape": "circle", "radius": 0.08, "position": [0.7, -0.5]}
    assert table["size"] == [0.5, 0.4]
    assert table["orientation"] == pytest.approx(3.14159265)
    assert "obstacles.tilted, a box that is tilted out of the plane of its robot" in result.lost


CUBE = """<robot name="cube"><link name="only"><collision><geometry>
<mesh filename="cube.obj" scale="0.5 0.5 0.5"/></geometry></collision></link></robot>"""
CORNERS = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def test_a_mesh_comes_from_its_urdf_file(imported: Import, tmp_path: Path) -> None:
    (tmp_path / "cube.urdf").write_text(CUBE)
    (tmp_path / "cube.obj").write_text(CORNERS)
    thing = {"type": "urdfObstacle", "urdf": "cube.urdf", "scaling": 3, "geometry": {"position": [1.0, 0.0, 0.5]}}
    result = imported({**PANDA, "obstacles": {"thing": thing, "gone": {**thing, "urdf": "gone.urdf"}}})
    mesh = result.content["obstacles"][0]
    assert (mesh["shape"], mesh["scale"], mesh["position"]) == ("mesh", 1.5, [1.0, 0.0, 0.5])
    assert (Path.cwd() / mesh["file"]).resolve() == (tmp_path / "cube.obj").resolve()
    assert result.lost[0].startswith("obstacles.gone: its file ")


def test_release_1_1_1_says_links_and_robots_by_name(imported: Import) -> None:
    entry = {
        **{key: value for key, value in PANDA.items() if key != "robot_type"},
        **goal_entry(parent_link="panda_link0", child_link="panda_hand"),
        "urdf_file_name": "panda_with_finger.urdf",
        "base_type": "holonomic",
        "root_link": "panda_link0",
        "collision_links": ["panda_link5", "panda_hand"],
        "selfCollision": {"pairs": [["panda_link2", "panda_link7"]]},
    }
    content = imported(entry).content
    assert content["robot"]["model"] == "panda"
    assert set(content["robot"]["collision"]["spheres"]) == {"panda_link5", "panda_hand", "panda_link2", "panda_link7"}
    assert content["robot"]["self_collision_pairs"] == [["panda_link2", "panda_link7"]]
    assert content["goal"][0]["link"] == "panda_hand"
    with pytest.raises(LpbError, match=r"child_link: found the link 'panda_hnad'; did you mean 'panda_hand'"):
        imported({**entry, **goal_entry(parent_link="panda_link0", child_link="panda_hnad")})


MOBILE: Entry = {
    **PANDA,
    "n": 10,
    **goal_entry(child_link=10),
    "initState": {"q0": [0.0] * 3 + PANDA["initState"]["q0"], "q0dot": [0.0] * 10},
    "obstacles": None,
    "selfCollision": {"pairs": [[2, 10]]},
}


@pytest.mark.parametrize(
    ("change", "height", "speeds"),
    [
        ({"robot_type": "mobilePanda"}, 0.25, {"qd": [0.0] * 10}),
        ({"robot_type": "albert", "initState": {**MOBILE["initState"], "q0dot": [0.0] * 9}}, 0.5995, {"u": [0.0] * 9}),
    ],
)
def test_pandas_on_bases(imported: Import, tmp_path: Path, change: Entry, height: float, speeds: Entry) -> None:
    result = imported({**MOBILE, **change})
    path = tmp_path / "mobile.yaml"
    path.write_text(result.text("exp.yaml"), encoding="utf-8")
    problem = draw_problem(load_scenario(path), 0)
    assert problem.robot.dof == 10
    frame = problem.robot.forward_kinematics(problem.start_q, "panda_link0")
    assert frame[2, 3] == pytest.approx(height)
    assert speeds.items() <= result.content["start"].items()
    assert problem.robot.self_collision_pairs == (("panda_link0", "panda_link8"),)


def test_the_point_of_a_urdf_has_a_third_joint(imported: Import) -> None:
    goal = {"is_primary_goal": True, "indices": [0, 1], "child_link": 1, "desired_position": [3, 2], "epsilon": 0.1}
    entry = {
        **ARM,
        "robot_type": "pointRobotUrdf",
        "goal": {"reach": goal},
        "initState": {"q0": [1, 2, 0], "q0dot": [0, 0, 0]},
    }
    result = imported({**entry, "selfCollision": None, "obstacles": {}})
    assert result.content["start"] == {"q": [1.0, 2.0], "qd": [0.0, 0.0]}
    assert result.content["robot"]["limits"]["position"] == [[-3.14, 3.14], [-2.0, 2.0]]
    assert result.notes == ["initState: theta, the third joint of this disc, which turns nothing that counts"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"T": "soon"}, "T: found the text 'soon'; a number within "),
        ({"n": 7.5}, "n: found 7.5; a whole number is required"),
        ({"r_body": -0.1}, "r_body: found -0.1; a number above 0 is required"),
        ({"initState": [1]}, "initState: found a list of 1; a mapping is required"),
        ({"selfCollision": {"pairs": [[0]]}}, "selfCollision.pairs.0: found [0]; two links are required"),
        (goal_entry(child_link=12), "goal.reach.child_link: found 12; a link is a number of 0 to 7, or one of "),
        (goal_entry(child_link=True), "goal.reach.child_link: found the boolean true; a number"),
        (goal_entry(indices=[0, 0, 1]), "goal.reach.indices: found [0, 0, 1]; allowed: different numbers of 0 to 2"),
        (goal_entry(epsilon="wide"), "goal.reach.epsilon: found the text 'wide'"),
        ({"obstacles": {"o": 7}}, "obstacles.o: found 7; a mapping is required"),
        ({"limits": {"low": [0.0], "high": [1.0, 2.0]}}, "limits.high: found 2 numbers; 1 are required"),
    ],
)
def test_wrong_values_are_reported_with_what_is_allowed(imported: Import, change: Entry, message: str) -> None:
    with pytest.raises(LpbError) as caught:
        imported({**PANDA, **change})
    assert message in str(caught.value)


def test_splines_run_as_they_did(imported: Import) -> None:
    # On [0, 1] by (1 - cos(pi t / T)) / 2: after a quarter of the time 14.6 % of the way, not 25 %.
    line = {"controlPoints": [[0.0, 0.0], [1.0, 0.0]], "degree": 1, "duration": 4.0}
    goal = {"prime": True, "indices": [0, 1], "child_link": 3, "trajectory": line, "epsilon": 0.1}
    rows = imported({**ARM, "goal": {"follow": goal}}).content["goal"][0]["spline"]
    quarter = next(row for row in rows if row[0] >= 1.0)
    assert quarter[1] == pytest.approx(0.5 * (1.0 - math.cos(math.pi * quarter[0] / 4.0)), abs=1e-6)
