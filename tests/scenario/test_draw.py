"""Drawing problems: streams that nothing else disturbs, feasibility, and the same problem everywhere."""

import copy
import json
import subprocess
import sys
from collections.abc import Callable
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.planar.robot import PlanarRobot
from pytest_lpb.problem.problem import Problem
from pytest_lpb.problem.robot import robot_from
from pytest_lpb.scenario.draw import check_feasible, draw_problem, obstacle_counts, parts_drawn
from pytest_lpb.scenario.feasibility import is_free
from pytest_lpb.scenario.inverse_kinematics import goal_configurations
from pytest_lpb.scenario.load import Scenario, load_scenario

Content = dict[str, Any]
ALL = ("start", "goal", "obstacles")

# Start, goal and obstacles are drawn from regions far from each other: nothing is ever redrawn.
APART: Content = {
    "version": 1,
    "robot": {"model": "point", "body_radius": 0.1},
    "environment": {"duration": 5.0},
    "start": {"q": [0.0, 0.0]},
    "goal": [{"name": "reach", "type": "position", "link": "body", "target": [4.0, 0.0], "tolerance": 0.1}],
    "obstacles": [{"name": "listed", "shape": "circle", "radius": 0.3, "position": [0.0, -9.0]}],
    "randomize": {
        "start": {"q": [[-1, 1], [-1, 1]]},
        "goal": [[4, 6], [-1, 1]],
        "obstacles": {"count": [2, 6], "shape": "circle", "position": [[-5, 5], [8, 9]], "radius": [0.1, 0.5]},
    },
}
# Everything in one small room: most draws are in each other's way.
CROWDED: Content = {
    **APART,
    "goal": [{"name": "reach", "type": "position", "link": "body", "target": [1.0, 0.0], "tolerance": 0.1}],
    "obstacles": [{"name": "listed", "shape": "circle", "radius": 0.6, "position": [0.0, 0.5]}],
    "randomize": {
        "start": {"q": [[-1, 1], [-1, 1]]},
        "goal": [[-1, 1], [-1, 1]],
        "obstacles": {"count": 5, "shape": "circle", "position": [[-1.5, 1.5], [-1.5, 1.5]], "radius": [0.1, 0.6]},
        "margin": 0.1,
    },
}
ARM: Content = {
    **APART,
    "robot": {"model": "planar_arm", "links": 3, "limits": {"position": [[-3, 3], [-2, 2], [-2, 2]]}},
    "start": {"q": [1.5, 0.0, -1.5]},
    "goal": [
        {"name": "reach", "type": "position", "link": "end", "target": [1.7, -1.0], "tolerance": 0.1},
        {"name": "turn", "type": "orientation", "link": "end", "target": 0.0, "tolerance": 0.1},
        {"name": "elbow", "type": "joint", "joints": ["joint2"], "target": [0.0]},
    ],
    "obstacles": [],
    "randomize": {
        "goal": {"q": [[-3, 3], [-2, 2], [-2, 2]]},
        "obstacles": {"count": 3, "shape": "circle", "position": [[-3, 3], [-3, 3]], "radius": [0.1, 0.4]},
        "margin": 0.05,
    },
}

# Of APART, seed 7.
GOLDEN_START = [-0.7471806623659274, 0.034178718674438446]
GOLDEN_GOAL = [5.465075996210917, -0.5550886040476137]
GOLDEN_NAMES = ["listed", "drawn0", "drawn1", "drawn2"]
GOLDEN_OBSTACLE = {
    "name": "drawn0",
    "shape": "circle",
    "position": [-1.460280360810974, 8.302487577498868],
    "radius": 0.18915396339395407,
    "orientation": 0.0,
}


@pytest.fixture
def scenario(tmp_path: Path) -> Callable[[Content], Scenario]:
    def write(content: Content) -> Scenario:
        path = tmp_path / "family.yaml"
        path.write_text(json.dumps(content, indent=1), encoding="utf-8")
        return load_scenario(path)

    return write


Write = Callable[[Content], Scenario]


def changed(content: Content, **randomize: Any) -> Content:
    copied = copy.deepcopy(content)
    copied["randomize"] |= randomize
    return copied


def drawn(scenario: Scenario, seed: int = 7, flags: tuple[str, ...] = ALL) -> Content:
    return draw_problem(scenario, seed, flags).to_dict()


def test_golden_values(scenario: Write) -> None:
    """Problems of a seed never change; if this fails, every published drawn problem has."""
    entry = drawn(scenario(APART), seed=7)
    assert entry["start"]["q"] == GOLDEN_START
    assert entry["goal"][0]["target"] == GOLDEN_GOAL
    assert [item["name"] for item in entry["obstacles"]] == GOLDEN_NAMES
    assert entry["obstacles"][1] == GOLDEN_OBSTACLE


def test_what_is_drawn(scenario: Write) -> None:
    family = scenario(APART)
    assert parts_drawn(family) == ()
    assert parts_drawn(family, ["goal"]) == ("goal",)
    assert parts_drawn(scenario(changed(APART, draw=["obstacles"])), ["start"]) == ("start", "obstacles")
    without_ranges = copy.deepcopy(APART)
    del without_ranges["randomize"]["start"]
    assert parts_drawn(scenario(without_ranges), ALL) == ("goal", "obstacles")


def test_without_flags_nothing_is_drawn(scenario: Write) -> None:
    family = scenario(APART)
    entry = drawn(family, flags=())
    assert {**entry, "seed": 0} == family.concrete
    assert entry["seed"] == 7


def test_drawing_leaves_the_scenario_alone(scenario: Write) -> None:
    family = scenario(APART)
    before = copy.deepcopy(family.concrete)
    drawn(family)
    assert family.concrete == before


@pytest.mark.parametrize("part", ALL)
def test_a_flag_changes_its_own_part_only(scenario: Write, part: str) -> None:
    family = scenario(APART)
    everything, one = drawn(family), drawn(family, flags=(part,))
    for key in ALL:
        assert one[key] == (everything if key == part else family.concrete)[key]


@pytest.mark.parametrize(
    ("part", "ranges"),
    [
        ("start", {"q": [[-1, 1], [-1, 0.5]]}),
        ("goal", [[4, 6.5], [-1, 1]]),
        ("obstacles", {**APART["randomize"]["obstacles"], "radius": [0.1, 0.4]}),
    ],
)
def test_ranges_of_one_part_leave_the_others(scenario: Write, part: str, ranges: Any) -> None:
    before, after = drawn(scenario(APART)), drawn(scenario(changed(APART, **{part: ranges})))
    for key in ALL:
        assert (after[key] == before[key]) is (key != part)


def test_what_does_not_matter(scenario: Write, tmp_path: Path) -> None:
    before = drawn(scenario(APART))
    trimmings = {"tags": ["planar"], "trials": 50, "description": "x", "seed": 3, "success": {"rate": ">= 0.5"}}
    after = drawn(scenario({**APART, **trimmings}))
    for key in ("robot", "environment", *ALL):
        assert after[key] == before[key]
    path = tmp_path / "commented.yaml"
    reordered = json.dumps(dict(reversed(list(APART.items()))), indent=2)
    path.write_text(f"# a comment\n{reordered}\n# another\n", encoding="utf-8")
    assert drawn(load_scenario(path)) == before
    assert drawn(scenario(changed(APART, margin=0.01)))["goal"] == before["goal"]


def test_seeds_differ(scenario: Write) -> None:
    family = scenario(APART)
    hashes = {draw_problem(family, seed, ALL).problem_hash for seed in range(20)}
    assert len(hashes) == 20


def test_counts_take_every_value_of_their_range(scenario: Write) -> None:
    family = scenario(APART)
    counts = {len(drawn(family, seed)["obstacles"]) - 1 for seed in range(60)}
    assert counts == {2, 3, 4, 5, 6}
    assert obstacle_counts(family, ALL) == (3, 7)
    assert obstacle_counts(family) == (1, 1)


def test_values_stay_in_their_ranges_and_fill_them(scenario: Write) -> None:
    family = scenario(APART)
    entries = [drawn(family, seed) for seed in range(200)]
    starts = np.array([entry["start"]["q"] for entry in entries])
    goals = np.array([entry["goal"][0]["target"] for entry in entries])
    radii = np.array([item["radius"] for entry in entries for item in entry["obstacles"][1:]])
    for values, lower, upper in ((starts, [-1, -1], [1, 1]), (goals, [4, -1], [6, 1])):
        assert (values >= lower).all()
        assert (values <= upper).all()
        assert (np.ptp(values, axis=0) > 0.95 * (np.array(upper) - lower)).all()
        assert_allclose(values.mean(axis=0), 0.5 * (np.array(lower) + upper), atol=0.2)
    assert 0.1 <= radii.min() < 0.12 < 0.48 < radii.max() <= 0.5


def test_several_groups_and_shapes(scenario: Write) -> None:
    boxes = {
        "count": 2,
        "shape": "rectangle",
        "position": [[-5, 5], [8, 9]],
        "size": [[0.1, 0.2], [0.3, 0.4]],
        "orientation": [-1, 1],
    }
    groups = [{**APART["randomize"]["obstacles"], "count": 3}, boxes]
    entry = drawn(scenario(changed(APART, obstacles=groups, keep_obstacles=False)))
    assert [item["name"] for item in entry["obstacles"]] == [f"drawn{i}" for i in range(5)]
    box = entry["obstacles"][4]
    assert 0.1 <= box["size"][0] <= 0.2
    assert 0.3 <= box["size"][1] <= 0.4
    assert -1.0 <= box["orientation"] <= 1.0
    assert box["orientation"] != 0.0
    assert entry["obstacles"][3] != {**box, "name": "drawn3"}


def test_listed_obstacles_stay_unless_replaced(scenario: Write) -> None:
    kept = drawn(scenario(APART))
    replaced = drawn(scenario(changed(APART, keep_obstacles=False)))
    assert kept["obstacles"][0]["name"] == "listed"
    assert kept["obstacles"][1:] == replaced["obstacles"]


def test_crowded_problems_are_feasible_with_margin(scenario: Write) -> None:
    family = scenario(CROWDED)
    redrawn = 0
    for seed in range(30):
        problem = draw_problem(family, seed, ALL)
        space = problem.robot.collision_space(problem.obstacles)
        start, target = problem.start_q.tolist(), problem.to_dict()["goal"][0]["target"]
        assert space.clearance(start)[0] >= 0.1
        reachable = goal_configurations(problem.robot, problem.goal, problem.start_q)
        assert any(space.clearance(q.tolist())[0] >= 0.1 for q in reachable), target
        lonely = drawn(scenario(changed(CROWDED, margin=0.0)), seed)
        redrawn += lonely["start"]["q"] != start
    assert redrawn  # the margin had something to refuse


def test_a_redraw_leaves_the_other_obstacles(scenario: Write) -> None:
    """An item takes its own column of every round: what one needs moves no other."""
    near = {"count": 4, "shape": "circle", "position": [[-3, 3], [-3, 3]], "radius": [0.1, 0.5]}
    free, blocked = changed(APART, obstacles=near, margin=0.0), changed(APART, obstacles=near, margin=0.0)
    blocked["start"] = {"q": [2.0, 2.0]}
    pairs = [
        (drawn(scenario(free), seed, ("obstacles",)), drawn(scenario(blocked), seed, ("obstacles",)))
        for seed in range(30)
    ]
    same = [[a == b for a, b in zip(one["obstacles"][1:], other["obstacles"][1:], strict=True)] for one, other in pairs]
    mixed = [flags for flags in same if not all(flags)]
    assert mixed, "no seed made a redraw necessary"
    assert all(sum(flags) >= 1 for flags in mixed)
    later = [flags for flags in mixed if not flags[0]]
    assert all(any(flags[1:]) for flags in later)


def test_impossible_ranges_end_in_an_error_with_place(scenario: Write, tmp_path: Path) -> None:
    blocking = {"count": 1, "shape": "circle", "position": [[0, 0], [0, 0]], "radius": [1, 1]}
    family = scenario(changed(APART, obstacles=blocking))
    line = next(
        number
        for number, text in enumerate((tmp_path / "family.yaml").read_text(encoding="utf-8").splitlines(), 1)
        if text.startswith('  "obstacles"')
    )
    with pytest.raises(
        ScenarioError,
        match=rf"family\.yaml:{line}: randomize\.obstacles\[0\]: seed 5: obstacle 'drawn0' always blocked",
    ) as caught:
        draw_problem(family, 5, ["obstacles"])
    assert "1000 attempts" in str(caught.value)
    assert "widen the ranges" in str(caught.value)


@pytest.mark.parametrize(
    ("part", "ranges", "message"),
    [
        ("start", {"q": [[0, 0], [-9, -9]]}, "every start drawn from these ranges was in collision"),
        ("goal", [[0, 0], [-9, -9]], "every goal drawn from these ranges was in collision or out of reach"),
    ],
)
def test_starts_and_goals_that_are_never_free(scenario: Write, part: str, ranges: Any, message: str) -> None:
    with pytest.raises(ScenarioError, match=rf"family\.yaml:\d+: randomize\.{part}: seed 0: {message}"):
        draw_problem(scenario(changed(APART, **{part: ranges})), 0, [part])


def test_goals_beyond_reach_are_redrawn(scenario: Write) -> None:
    arm = changed(ARM, goal=[[-4, 4], [-4, 4]], obstacles=None)
    arm["goal"] = arm["goal"][:1]
    del arm["randomize"]["obstacles"]
    family = scenario(arm)
    for seed in range(10):
        target = drawn(family, seed, ("goal",))["goal"][0]["target"]
        assert np.hypot(*target) <= 3.0 + 0.1


def test_goals_drawn_in_joint_space_are_reachable_by_construction(scenario: Write) -> None:
    family = scenario(ARM)
    for seed in range(10):
        problem = draw_problem(family, seed, ALL)
        robot = problem.robot
        assert isinstance(robot, PlanarRobot)
        targets = {goal["name"]: goal["target"] for goal in problem.to_dict()["goal"]}
        # The three joint values follow from the elbow, the tip's angle and the tip's position.
        solutions = goal_configurations(robot, problem.goal, problem.start_q)
        assert solutions
        angle = robot.link_angle(solutions[0].tolist(), "end")
        assert abs((angle - targets["turn"][0] + pi) % (2 * pi) - pi) <= 0.1
        space = robot.collision_space(problem.obstacles)
        assert any(is_free(space, q.tolist(), 0.0) for q in solutions)


def test_goals_drawn_in_joint_space_come_from_forward_kinematics(scenario: Write) -> None:
    fixed = changed(ARM, goal={"q": [[0.5, 0.5], [-1.0, -1.0], [0.25, 0.25]]})
    targets = [goal["target"] for goal in drawn(scenario(fixed), 0, ("goal",))["goal"]]
    robot = robot_from(scenario(fixed).concrete["robot"])
    pose = robot.forward_kinematics([0.5, -1.0, 0.25], "end")
    assert_allclose(targets[0], pose[:2, 2])
    assert_allclose(targets[1], [-0.25])
    assert_allclose(targets[2], [-1.0])


def test_alignments_are_met_where_the_goal_is_drawn(scenario: Write) -> None:
    """An alignment has no target to put where the robot is: configurations that miss it are redrawn."""
    level = {
        "name": "level",
        "type": "alignment",
        "link": "end",
        "axis": [1, 0],
        "other": "world",
        "other_axis": [0, 1],
        "tolerance": 0.3,
    }
    content = copy.deepcopy(ARM)
    content["goal"] = [content["goal"][0], content["goal"][1], level]
    family = scenario(content)
    for seed in range(10):
        turn = drawn(family, seed, ("goal",))["goal"][1]["target"][0]
        assert abs((turn - pi / 2 + pi) % (2 * pi) - pi) <= 0.3


def test_moving_obstacles(scenario: Write) -> None:
    ranges = {**APART["randomize"]["obstacles"], "velocity": [[-1, 1], [0.5, 0.5]], "count": 3}
    still = drawn(scenario(changed(APART, obstacles={**ranges, "velocity": [[0, 0], [0, 0]]})))
    entry = drawn(scenario(changed(APART, obstacles=ranges)))
    problem = Problem.from_dict(entry)
    for item, obstacle in zip(entry["obstacles"][1:], problem.obstacles[1:], strict=True):
        assert "position" not in item
        position, velocity, acceleration = obstacle.motion.evaluate(np.array([0.0, 2.0]))
        assert velocity[0, 1] == 0.5
        assert -1.0 <= velocity[0, 0] <= 1.0
        assert velocity[0, 0] != 0.0
        assert_allclose(position[1] - position[0], 2.0 * velocity[0])
        assert not acceleration.any()
        assert (position[0] >= [-5.0, 8.0]).all()
        assert (position[0] <= [5.0, 9.0]).all()
        assert obstacle.moving
    assert all("trajectory" not in item for item in still["obstacles"])


def test_a_drawn_problem_is_a_scenario_file(scenario: Write) -> None:
    """What is drawn, moving obstacles too, repeats exactly from its own file, drawn names included."""
    ranges = {**APART["randomize"]["obstacles"], "velocity": [[-1, 1], [-1, 1]]}
    problem = draw_problem(scenario(changed(APART, obstacles=ranges)), 3, ALL)
    again = scenario({**problem.to_dict(), "source": "family.yaml, seed 3"})
    assert (again.seed, again.trials) == (3, 1)
    assert draw_problem(again, 3).problem_hash == problem.problem_hash
    assert {key: again.concrete[key] for key in problem.to_dict()} == problem.to_dict()


def test_the_same_problem_in_another_process(scenario: Write, tmp_path: Path) -> None:
    for content in (CROWDED, ARM):
        family = scenario(content)
        program = (
            "import json, sys; from pathlib import Path;"
            "from pytest_lpb.scenario.draw import draw_problem;"
            "from pytest_lpb.scenario.load import load_scenario;"
            "family = load_scenario(Path(sys.argv[1]));"
            "print(json.dumps([draw_problem(family, s, ('obstacles', 'goal', 'start')).to_dict() for s in (4, 2)]))"
        )
        result = subprocess.run(
            [sys.executable, "-c", program, str(tmp_path / "family.yaml")], capture_output=True, text=True, check=True
        )
        assert json.loads(result.stdout) == [drawn(family, 4), drawn(family, 2)]


def test_fixed_starts_and_goals_are_checked(scenario: Write) -> None:
    check_feasible(scenario(APART))
    inside = {**APART, "start": {"q": [0.0, -9.0]}}
    with pytest.raises(
        ScenarioError, match=r"family\.yaml:\d+: start: the start is in collision: 'body' is 0\.4 m inside"
    ):
        check_feasible(scenario(inside))
    check_feasible(scenario(inside), ["start"])  # a start that is drawn is not
    goal = [{**APART["goal"][0], "target": [0.0, -9.0]}]
    with pytest.raises(ScenarioError, match=r"family\.yaml:\d+: goal: the goal is in collision"):
        check_feasible(scenario({**APART, "goal": goal}))
    check_feasible(scenario({**APART, "goal": goal}), ["goal"])


def test_out_of_reach(scenario: Write) -> None:
    reach = ARM["goal"][0]
    far = {**ARM, "goal": [{**reach, "target": [3.2, 0.0]}]}
    with pytest.raises(ScenarioError, match=r"goal: the goal is out of reach: no configuration of 'planar_arm_3'"):
        check_feasible(scenario(far))
    # At the edge: 0.08 m beyond the stretched arm, and a tolerance of 0.1 m.
    check_feasible(scenario({**ARM, "goal": [{**reach, "target": [3.08, 0.0]}]}))


def test_a_folded_start_is_a_self_collision(scenario: Write) -> None:
    folded = {**ARM, "robot": {"model": "planar_arm", "links": 3}, "start": {"q": [0.0, 3.0, 3.0]}}
    with pytest.raises(ScenarioError, match="the start is in self-collision"):
        check_feasible(scenario(folded))
