"""The planner: what is composed anew, what it remembers, what it does without a plan; every robot; a closed loop."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pytest_lpb.environment.limits import ActionLimits
from pytest_lpb.errors import ConfigurationError
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.mpc.bounds import INSET
from pytest_lpb.planner.mpc.composed import Composed, composed_for
from pytest_lpb.planner.mpc.parameters import MpcParameters
from pytest_lpb.planner.mpc.planner import Mpc
from pytest_lpb.planner.mpc.solver import PiqpSolver, Solution
from pytest_lpb.problem.preview import Preview
from pytest_lpb.problem.robot import robot_from
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.planner import problems
from tests.planner.scene.making import Array, Entry, goal, observed, obstacle, planar, problem_of, spatial
from tests.problem.entries import circle, position_goal, problem_entry
from tests.problem.spatial.robots import ENTRIES

STEPS = 8
FINE = 0.01  # [s]
POINT = planar(problems.POINT)
LIMITED = planar(problems.POINT, limits={"acceleration": [[-1.0, 1.0]] * 2})
AHEAD = [goal("position", [2.0, 0.0], link="body")]
DISC = obstacle("circle", [1.0, 0.05], radius=0.3)


def ready(robot: Entry, goals: list[Entry], obstacles: list[Entry], *, period: float = 0.1, **parameters: Any) -> Mpc:
    """A new planner, set up."""
    planner = Mpc(MpcParameters(**({"horizon": STEPS} | parameters)))
    planner.setup(problem_of(robot, goals, obstacles, period=period))
    return planner


def seen(q: list[float], u: list[float], goals: list[Entry], obstacles: list[Entry], steps: int = STEPS) -> Any:
    """An observation with where obstacles will be after steps of 0.1 s."""
    found = observed(q, u, goals, obstacles)
    times = 0.1 * np.arange(1.0, steps + 1.0)[:, None]
    places = [np.asarray(item["position"]) + times * np.asarray(item["velocity"]) for item in obstacles]
    return found | {"obstacle_position_preview": np.array(places)}


def act(
    robot: Entry, q: list[float], u: list[float], goals: list[Entry], obstacles: list[Entry], **others: Any
) -> Array:
    """The action of a new planner."""
    return ready(robot, goals, obstacles, **others).compute_action(seen(q, u, goals, obstacles))


# What is composed


def composed(**changes: Any) -> Composed:
    given: Entry = {"robot": POINT, "goals": AHEAD, "obstacles": [DISC], "steps": STEPS} | changes
    problem = problem_of(given["robot"], given["goals"], given["obstacles"])
    return composed_for(problem, MpcParameters(horizon=given["steps"]))


def test_problems_of_equal_structure_share_a_composed_horizon() -> None:
    there = [goal("position", [-1.0, 0.5], link="body", name="there", tolerance=0.01)]
    other = obstacle("circle", [0.0, 3.0], radius=0.9, name="other")
    assert composed() is composed(goals=there, obstacles=[other])


@pytest.mark.parametrize(
    "change",
    [
        {"obstacles": [DISC, {**DISC, "name": "second"}]},
        {"obstacles": []},
        {"robot": LIMITED},
        {"goals": [goal("position", [2.0, 0.0], link="body", weight=2.0)]},
        {"steps": STEPS + 1},
    ],
    ids=["room", "shape", "limits", "weight", "parameters"],
)
def test_problems_of_another_structure_do_not(change: Entry) -> None:
    assert composed() is not composed(**change)


def test_the_preview_is_the_horizon() -> None:
    assert Mpc.preview_for(MpcParameters(horizon=12, step=0.2)) == Preview(12, 0.2)


# What it remembers


def calls(planner: Mpc, obstacles: list[Entry], count: int = 3) -> Array:
    return np.array([planner.compute_action(seen([0.1 * k, 0.0], [1.0, 0.0], AHEAD, obstacles)) for k in range(count)])


def test_setup_forgets_the_last_trial() -> None:
    moving = {**DISC, "moving": True, "velocity": np.array([0.1, -0.3])}
    planner = ready(POINT, AHEAD, [DISC])
    for obstacles in ([DISC], [moving], [], [DISC]):
        planner.setup(problem_of(POINT, AHEAD, obstacles, period=0.1))
        assert np.array_equal(calls(planner, obstacles), calls(ready(POINT, AHEAD, obstacles), obstacles))


def test_actions_are_the_caller_s_own() -> None:
    planner = ready(POINT, AHEAD, [])
    first = planner.compute_action(seen([0.0, 0.0], [0.0, 0.0], AHEAD, []))
    kept = first.copy()
    planner.compute_action(seen([0.5, 0.3], [1.0, 0.0], AHEAD, []))
    assert np.array_equal(first, kept)


# Actions


def test_actions_keep_limits_of_accelerations_and_reach_them() -> None:
    action = act(LIMITED, [0.0, 0.0], [0.0, 0.0], AHEAD, [])
    assert np.all(np.abs(action) <= 1.0)
    assert action == pytest.approx([1.0, 0.0], abs=1e-3)
    assert act(POINT, [0.0, 0.0], [0.0, 0.0], AHEAD, [])[0] > 2.0


@pytest.mark.parametrize("period", [0.05, 0.1])
def test_under_velocity_control_the_robot_moves_as_planned(period: float) -> None:
    # The environment takes on the new velocity at once, not by and by.
    entry = {**POINT, "control": "velocity"}
    q, u = [0.1, 0.0], [0.4, 0.2]
    planner = ready(entry, AHEAD, [DISC], period=period, step=period)
    velocity = planner.compute_action(seen(q, u, AHEAD, [DISC]))
    after = robot_from(entry).integrate(q, u, velocity.tolist(), period)
    planned = planner._horizon.path(np.array([*q, *u]), planner._plan)[0]
    assert np.concatenate(after) == pytest.approx(planned, abs=1e-12)
    assert np.abs(velocity - u).max() > 0.01


def test_torques_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="mpc gives accelerations or velocities, not torques"):
        ready({**POINT, "control": "torque"}, AHEAD, [])


def test_periods_longer_than_a_step_are_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"must last at least a period, 0\.3 s"):
        ready(POINT, AHEAD, [], period=0.3)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_disc_ahead_is_passed_where_the_way_is_shorter(side: float) -> None:
    disc = {**DISC, "position": [0.8, -0.05 * side]}
    action = act(POINT, [0.0, 0.0], [1.0, 0.0], AHEAD, [disc])
    assert side * action[1] > 0.1
    assert act(POINT, [0.0, 0.0], [1.0, 0.0], AHEAD, [])[1] == pytest.approx(0.0, abs=1e-4)


def test_where_obstacles_will_be_counts() -> None:
    # From below it comes into the way; where it is now it stands in none.
    state: tuple[list[float], list[float]] = ([0.0, 0.0], [1.0, 0.0])
    still = obstacle("circle", [0.7, -0.6], radius=0.2)
    coming = {**still, "moving": True, "velocity": np.array([0.0, 1.0])}
    found = [act(POINT, *state, AHEAD, [disc]) for disc in (still, coming)]
    assert np.abs(found[0] - found[1]).max() > 0.05


# No plan


def failing(monkeypatch: pytest.MonkeyPatch) -> None:
    def solve(self: PiqpSolver) -> Solution:
        return Solution(np.full(self._program.sizes.variables, np.nan), False, 7, 1.0)

    monkeypatch.setattr(PiqpSolver, "solve", solve)


@pytest.mark.parametrize(("period", "share"), [(0.1, 1.0), (0.025, 0.25)])
def test_without_a_solution_the_last_plan_goes_on(monkeypatch: pytest.MonkeyPatch, period: float, share: float) -> None:
    planner = ready(POINT, AHEAD, [], period=period)
    planner.compute_action(seen([0.0, 0.0], [0.0, 0.0], AHEAD, []))
    plan = planner._plan.copy()
    assert planner.diagnostics["solved"] == 1.0
    failing(monkeypatch)
    action = planner.compute_action(seen([0.0, 0.0], [0.1, 0.0], AHEAD, []))
    assert planner.diagnostics["solved"] == 0.0
    assert action == pytest.approx((1.0 - share) * plan[0] + share * plan[1], abs=1e-12)
    assert abs(action[0]) > 0.1


def test_without_solutions_the_last_plan_goes_on_call_by_call(monkeypatch: pytest.MonkeyPatch) -> None:
    planner = ready(POINT, AHEAD, [])
    planner.compute_action(seen([0.0, 0.0], [0.0, 0.0], AHEAD, []))
    plan = planner._plan.copy()
    failing(monkeypatch)
    for expected in plan[1:4]:
        action = planner.compute_action(seen([0.0, 0.0], [0.1, 0.0], AHEAD, []))
        assert action == pytest.approx(expected, abs=1e-12)


# Every robot


@pytest.mark.parametrize("name", ENTRIES)
def test_every_robot_has_finite_actions(name: str) -> None:
    entry = spatial(ENTRIES[name])
    robot = robot_from(entry)
    joint = robot.joint_names[0]
    goals = [goal("joint", [0.4], joints=[joint])]
    ball = obstacle("sphere", [0.9, 0.3, 0.4], radius=0.1)
    state = np.full(robot.dof, 0.1).tolist(), np.full(robot.n_actions, 0.05).tolist()
    planner = ready(entry, goals, [ball])
    action = planner.compute_action(seen(*state, goals, [ball]))
    assert action.shape == (robot.n_actions,)
    assert np.isfinite(action).all()
    assert planner.diagnostics["solved"] == 1.0


# A closed loop


def trial() -> Trajectory:
    problem = problem_entry(
        q=[0.0, 0.0], goal=[position_goal([3.0, 0.0])], obstacles=[circle(1.5, 0.1, 0.4)], duration=15.0
    )
    return run_trial(TrialSpecification(problem, PlannerConfiguration("mpc", "mpc", period=0.1)))


def test_a_point_passes_a_disc_the_same_way_each_time() -> None:
    first, second = trial(), trial()
    assert first.metadata["success"], first.metadata["message"]
    gaps = np.linalg.norm(first.q - [1.5, 0.1], axis=1) - 0.6
    assert gaps.min() > 0.0
    assert first.metadata["trajectory_hash"] == second.metadata["trajectory_hash"]
    solved = first.columns["planner_solved"]
    assert np.nanmin(solved) == 1.0


def furthest(robot: Entry, q: list[float], u: list[float], *, period: float, steps: int = 600) -> float:
    """The largest of the first joint's positions at each step of 0.01 s, while the goal pulls."""
    planner, model = ready(robot, AHEAD, [], period=period), robot_from(robot)
    limits = ActionLimits(model, FINE)
    every, most = round(period / FINE), q[0]
    action: list[float] = []
    for step in range(steps):
        if step % every == 0:
            action = planner.compute_action(seen(q, u, AHEAD, [])).tolist()
        q, u = model.integrate(q, u, limits.apply(action, u), FINE)
        most = max(most, q[0])
    return most


@pytest.mark.parametrize("control", ["acceleration", "velocity"])
@pytest.mark.parametrize("period", [0.02, 0.05, 0.1])
@pytest.mark.parametrize("acceleration", [1.0, 4.0, None])
def test_positions_stay_within_their_limits_however_long_the_goal_pulls(
    acceleration: float | None, period: float, control: str
) -> None:
    # However often it is planned anew, and though the horizon is too short to stop in.
    limits: Entry = {"position": [[-1.0, 1.0]] * 2}
    if acceleration is not None:
        limits["acceleration"] = [[-acceleration, acceleration]] * 2
    robot = {**planar(problems.POINT, limits=limits), "control": control}
    assert 0.9 < furthest(robot, [0.0, 0.0], [0.0, 0.0], period=period) <= 1.0 - INSET


def test_a_robot_too_fast_for_its_limit_passes_it_by_no_more_than_it_must_and_comes_back() -> None:
    limits = {"position": [[-1.0, 1.0]] * 2, "acceleration": [[-1.0, 1.0]] * 2}
    robot = planar(problems.POINT, limits=limits)
    least = 0.9 + 0.5 * 1.0**2 / 1.0  # 1 m/s takes 0.5 m to stop
    assert least - 1e-9 <= furthest(robot, [0.9, 0.0], [1.0, 0.0], period=0.1) < least + 0.01
    planner, (q, u) = ready(robot, AHEAD, []), ([0.9, 0.0], [1.0, 0.0])
    for _ in range(60):
        action = planner.compute_action(seen(q, u, AHEAD, []))
        q, u = robot_from(robot).integrate(q, u, action.tolist(), 0.1)
    assert q[0] <= 1.0


def test_ranges_narrower_than_the_insets_are_planned_within() -> None:
    robot = planar(problems.POINT, limits={"position": [[-1.0, 1.0], [-INSET, INSET]]})
    planner = ready(robot, AHEAD, [])
    planner.compute_action(seen([0.0, 0.0], [0.0, 0.0], AHEAD, []))
    assert planner.diagnostics["solved"] == 1.0
    assert np.all(planner._program.lower < planner._program.upper)


def test_without_a_solution_limits_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    planner = ready(planar(problems.POINT, limits={"position": [[-1.0, 1.0]] * 2}), AHEAD, [])
    q, u = [0.5, 0.0], [2.0, 0.0]
    planner.compute_action(seen(q, u, AHEAD, []))
    failing(monkeypatch)
    planner._plan[:] = 10.0
    for _ in range(5):
        action = planner.compute_action(seen(q, u, AHEAD, []))
        q, u = robot_from(POINT).integrate(q, u, action.tolist(), 0.1)
        assert q[0] <= 1.0


def test_a_plan_of_the_first_call_counts_though_a_later_iteration_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    planner = ready(POINT, AHEAD, [])
    solve, calls = PiqpSolver.solve, []

    def once(self: PiqpSolver) -> Solution:
        calls.append(1)
        return solve(self) if len(calls) == 1 else Solution(np.zeros(0), False, 7, 1.0)

    monkeypatch.setattr(PiqpSolver, "solve", once)
    action = planner.compute_action(seen([0.0, 0.0], [1.0, 0.0], AHEAD, []))
    assert planner.diagnostics["solved"] == 0.0
    assert len(calls) == 2
    # Not braking, which would be -10.
    assert action[0] > -5.0
