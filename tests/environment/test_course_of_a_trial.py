"""How a trial ends: goals held, violations, outcomes, rewards."""

from math import inf, pi
from typing import Any

import numpy as np
import pytest

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.errors import DivergedError, LpbError
from tests.problem.entries import ARM, CART, POINT, Entry, circle, make_problem, position_goal

DT = 0.05
MOVER = {**POINT, "control": "velocity", "body_radius": 0.2}


def environment(robot: Entry = MOVER, **changes: Any) -> ScenarioEnvironment:
    return ScenarioEnvironment(problem=make_problem(robot, **{"duration": 10.0, **changes}))


def run(world: ScenarioEnvironment, speed: list[float], steps: int = 10_000) -> int:
    """Steps until the trial ends, or `steps`; the row it has come to."""
    while not world.ended and world.row < steps:
        world.step(speed)
    return world.row


def test_the_goal_is_held_for_the_hold_time() -> None:
    """Within tolerance from row 18 (x = 0.9) on: 10 rows later it is held, at row 28, x = 1.4 would be out again."""
    world = environment(goal=[position_goal([1.4, 0.0], tolerance=0.5 + 1e-9)], success={"hold_time": 0.5})
    assert run(world, [1.0, 0.0]) == 28
    assert (world.outcome, world.monitor.goal_row) == ("success", 18)
    assert (world.terminated, world.truncated) == (True, False)


def test_a_goal_left_too_early_is_not_held() -> None:
    # In the disc of 0.25 m at 1 m/s for 0.5 m: 10 steps between its first and last row at most.
    world = environment(goal=[position_goal([1.0, 0.0], tolerance=0.25 + 1e-9)], success={"hold_time": 0.55})
    assert run(world, [1.0, 0.0]) == 200
    assert (world.outcome, world.truncated, world.terminated) == ("timeout", True, False)
    just = environment(goal=[position_goal([1.0, 0.0], tolerance=0.25 + 1e-9)], success={"hold_time": 0.5})
    assert run(just, [1.0, 0.0]) == 25
    assert just.outcome == "success"


def test_leaving_starts_the_hold_time_anew() -> None:
    world = environment(goal=[position_goal([1.0, 0.0], tolerance=0.1001)], success={"hold_time": 0.2})
    for speed in [*[1.0] * 19, 4.0, -4.0, *[0.0] * 10]:  # in at row 18, out at row 20, back at row 21
        if not world.ended:
            world.step([speed, 0.0])
    assert (world.row, world.monitor.goal_row, world.outcome) == (25, 21, "success")


def test_no_hold_time() -> None:
    world = environment(goal=[position_goal([1.0, 0.0])], success={"hold_time": 0.0})
    assert run(world, [1.0, 0.0]) == 18
    assert world.outcome == "success"


def test_at_the_goal_from_the_start() -> None:
    world = environment(goal=[position_goal([0.0, 0.0])], success={"hold_time": 0.0})
    _, info = world.reset()
    assert (world.row, world.outcome, info["outcome"]) == (0, "success", "success")


def test_a_hold_time_to_the_end() -> None:
    goal = [position_goal([1.0, 0.0], tolerance=0.25)]
    stays = environment(goal=goal, success={"hold_time": "end"}, duration=2.0)
    for _ in range(40):
        stays.step([1.0 if stays.row < 20 else 0.0, 0.0])
    assert (stays.outcome, stays.monitor.goal_row, stays.row) == ("success", 15, 40)
    passes = environment(goal=goal, success={"hold_time": "end"}, duration=2.0)
    assert run(passes, [1.0, 0.0]) == 40
    assert passes.outcome == "timeout"


def test_every_sub_goal_with_a_tolerance_counts() -> None:
    both = [position_goal([0.0, 0.0]), position_goal([0.0, 1.0], name="other", tolerance=0.2)]
    world = environment(goal=both, success={"hold_time": 0.0})
    assert run(world, [0.0, 1.0]) == 200  # never at both
    preference = environment(goal=[both[0], {**both[1], "tolerance": None}], success={"hold_time": 0.0})
    assert preference.outcome == "success"


@pytest.mark.parametrize(
    ("end_at", "row", "outcome"),
    [
        (["goal", "violation"], 18, "success"),
        (["violation"], 37, "collision"),
        (["goal"], 18, "success"),
        ([], 200, "collision"),
    ],
)
def test_what_ends_a_trial(end_at: list[str], row: int, outcome: str) -> None:
    """The goal is reached at row 18; the wall's near side touches the body's rim beyond row 36 (x = 1.8)."""
    world = environment(
        goal=[position_goal([1.0, 0.0])],
        obstacles=[circle(3.0, 0.0, 0.9999)],
        end_at=end_at,
        success={"hold_time": 0.0},
    )
    assert run(world, [1.0, 0.0]) == row
    assert world.outcome == outcome


def test_the_first_violation_counts() -> None:
    robot = {**MOVER, "limits": {"position": [[-9.0, 1.0], None]}}
    near = environment(robot, obstacles=[circle(1.0, 0.0, 0.3)], end_at=[])
    run(near, [1.0, 0.0])
    assert near.outcome == "collision"
    far = environment(robot, obstacles=[circle(3.0, 0.0, 0.3)], end_at=[])
    run(far, [1.0, 0.0])
    assert far.outcome == "joint_limit"
    assert far.monitor.violation is not None
    assert far.monitor.violation.row == 21


def test_touching_is_no_collision() -> None:
    world = environment({**MOVER, "body_radius": 0.5}, obstacles=[circle(2.0, 0.0, 0.5)])
    assert world.monitor.clearance == (1.0, "body", "disc")
    world.step([1.0 / DT, 0.0])
    assert world.monitor.clearance[0] == 0.0
    assert world.outcome is None
    world.step([1e-6 / DT, 0.0])
    assert world.outcome == "collision"


FOLDED = [0.0, 0.95 * pi, 0.95 * pi]  # link3 lies across link1


@pytest.mark.parametrize(
    ("obstacles", "limits", "outcome"),
    [
        ([circle(0.5, 0.0, 0.3)], [[-1.0, 1.0]] * 3, "collision"),
        ([circle(9.0, 0.0, 0.3)], [[-1.0, 1.0]] * 3, "self_collision"),
        ([], None, "self_collision"),
    ],
)
def test_the_worst_of_one_step(obstacles: list[Entry], limits: Any, outcome: str) -> None:
    arm = {**ARM, "links": [1.0, 1.0, 1.0], "limits": {"position": limits}}
    world = environment(arm, q=FOLDED, obstacles=obstacles)
    assert (world.outcome, world.row) == (outcome, 0)


def test_self_collision_pairs_can_be_left_out() -> None:
    arm = {**ARM, "links": [1.0, 1.0, 1.0], "self_collision_pairs": []}
    assert environment(arm, q=FOLDED).outcome is None


def test_standing_still_is_stalled() -> None:
    world = environment()
    assert run(world, [0.0, 0.0]) == 200  # waiting is legal: it never ends a trial
    assert world.outcome == "stalled"


@pytest.mark.parametrize(
    ("still", "speed", "outcome"), [(101, 1e-3, "stalled"), (98, 1e-3, "timeout"), (101, 0.9e-3, "stalled")]
)
def test_stalled_means_the_last_five_seconds(still: int, speed: float, outcome: str) -> None:
    world = environment()
    for row in range(200):
        world.step([speed if row < 200 - still else 0.5e-3, 0.0])
    assert world.outcome == outcome


def test_slow_is_not_still() -> None:
    world = environment()
    run(world, [0.0, -1e-3])
    assert world.outcome == "timeout"


def test_the_reward_is_progress() -> None:
    world = environment(goal=[position_goal([3.0, 4.0])])
    _, info = world.reset()
    assert info["goal_distance"] == pytest.approx(5.0)
    total = 0.0
    for _ in range(10):
        _, reward, _, _, info = world.step([3.0, 4.0])
        total += reward
        assert reward == pytest.approx(5.0 * DT)
    assert total == pytest.approx(5.0 - info["goal_distance"])
    assert world.step([-3.0, -4.0])[1] == pytest.approx(-5.0 * DT)


def test_a_violation_costs_one_once() -> None:
    world = environment(goal=[position_goal([5.0, 0.0])], obstacles=[circle(1.0, 0.0, 0.3)], end_at=[])
    rewards = [world.step([1.0, 0.0])[1] for _ in range(20)]
    assert [reward < -0.9 for reward in rewards] == [row == 11 for row in range(1, 21)]
    assert rewards[10] == pytest.approx(DT - 1.0)


def test_the_information() -> None:
    world = environment(obstacles=[circle(2.0, 0.0, 0.5)])
    _, info = world.reset()
    assert info == {
        "goal_distance": 50.0,
        "goal_tolerance": 0.1,
        "clearance": pytest.approx(1.3),
        "contact_time": inf,
        "robot_radius": 0.2,
        "outcome": "running",
    }
    *_, info = world.step([40.0, 0.0])
    assert info["outcome"] == "collision"
    assert info["clearance"] == pytest.approx(-0.7)


def test_reset_forgets_the_last_trial() -> None:
    world = environment(obstacles=[circle(1.0, 0.0, 0.3)])
    run(world, [1.0, 0.0])
    assert world.outcome == "collision"
    observation, info = world.reset()
    assert world.outcome is None
    assert (world.row, info["outcome"]) == (0, "running")
    assert observation["t"] == 0.0
    assert not observation["q"].any()
    assert not observation["qd"].any()


def test_a_moving_goal_is_judged_where_it_is() -> None:
    goal = {"name": "runner", "type": "position", "link": "body", "trajectory": ["1 + t", "0"], "tolerance": 0.1}
    world = environment(goal=[goal], success={"hold_time": "end"}, duration=1.0)
    assert run(world, [1.0, 0.0]) == 20
    assert world.monitor.goal_errors == [pytest.approx(1.0)]
    assert world.outcome == "timeout"
    faster = environment(goal=[goal], success={"hold_time": "end"}, duration=1.0)
    run(faster, [2.0, 0.0])
    assert (faster.outcome, faster.monitor.goal_row) == ("success", 18)


def test_a_moving_obstacle_hits_a_waiting_robot() -> None:
    cart = {"name": "cart", "shape": "circle", "radius": 0.3, "trajectory": ["2 - t", "0"]}
    world = environment(obstacles=[cart])
    assert run(world, [0.0, 0.0]) == 31  # the rims meet at t = 1.5 s
    assert world.monitor.clearance[1:] == ("body", "cart")
    turning = {"name": "bar", "shape": "rectangle", "size": [4.0, 0.1], "position": [0.0, 1.0], "orientation": "t"}
    swept = environment(obstacles=[turning])
    run(swept, [0.0, 0.0])
    angle = swept.row * DT
    assert swept.outcome == "collision"
    assert np.cos(angle) - 0.05 - 0.2 < 0.0 <= np.cos(angle - DT) - 0.05 - 0.2


@pytest.mark.parametrize("robot", [POINT, ARM, CART])
def test_a_diverging_robot_is_an_error_and_never_a_hang(robot: Entry) -> None:
    world = environment({**robot, "control": "acceleration"}, duration=1.0)
    with pytest.raises(DivergedError, match="beyond 1e\\+12"):
        world.step([1e308] * world.problem.robot.n_actions)
    assert np.isfinite(world.running_engine.q).all()


def test_rendering_needs_a_mode() -> None:
    assert environment().render() is None
    with pytest.raises(LpbError):
        ScenarioEnvironment(problem=make_problem(), render_mode="windows")
