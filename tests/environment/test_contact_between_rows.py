"""Contact between two rows: fast robots, thin obstacles, sweeping links, moving and turning obstacles."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
import pytest

from pytest_lpb.environment.engine import continuous
from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.environment.monitor import Violation, contact_since
from pytest_lpb.kpis.registry import default_registry, evaluate_kpis, load_builtin
from pytest_lpb.planner.base import Observation, Planner, PlannerProblem
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.problem.problem import Problem
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial
from tests.environment.fast_motions import KINDS, verdicts
from tests.problem.entries import ARM, CART, POINT, circle, make_problem
from tests.problem.spatial import robots
from tests.problem.spatial.problems import spatial_problem, sphere

Entry = dict[str, Any]
DT = 0.1
DISC: Entry = {**POINT, "body_radius": 0.05, "control": "velocity"}
BALL: Entry = {**robots.POINT, "body_radius": 0.05, "control": "velocity"}


def wall(x: float, **changes: Any) -> Entry:
    return {"name": "wall", "shape": "rectangle", "size": [0.05, 20.0], "position": [x, 0.0], **changes}


def slab(x: float, **changes: Any) -> Entry:
    return {"name": "wall", "shape": "box", "size": [0.05, 20.0, 20.0], "position": [x, 0.0, 0.0], **changes}


def moving(entry: Entry, *trajectory: str, **changes: Any) -> Entry:
    return {
        **{key: value for key, value in entry.items() if key != "position"},
        "trajectory": list(trajectory),
        **changes,
    }


def planar(robot: Entry, obstacles: list[Entry], q: list[float] | None = None, u: Any = None) -> Problem:
    return make_problem(robot, obstacles=obstacles, q=q, u=u, dt=DT, duration=2.0)


def spatial(robot: Entry, obstacles: list[Entry], q: list[float] | None = None, **settings: Any) -> Problem:
    return spatial_problem(robot, obstacles=obstacles, q=q, dt=DT, duration=2.0, **settings)


def first_violation(problem: Problem, action: list[float]) -> Violation | None:
    """The first violation of a trial under a constant action."""
    world = ScenarioEnvironment(problem=problem)
    try:
        while not world.ended:
            world.step(action)
        return world.monitor.violation
    finally:
        world.close()


# Problem, action, outcome, names of both bodies, and the time of contact by hand [s]. At all rows bodies are apart.
AIMED = [
    # 5 m/s through walls whose faces are at 5.175 m.
    ("point", lambda: planar(DISC, [wall(5.2)]), [5.0, 0.0], "collision", ("body", "wall"), 5.125 / 5.0),
    ("point in space", lambda: spatial(BALL, [slab(5.2)]), [5.0, 0.0, 0.0], "collision", None, 5.125 / 5.0),
    # It comes to a stop beyond the wall and is back at the next row: v = 10, a = -200, face reached at x = 0.12.
    (
        "there and back",
        lambda: planar({**DISC, "control": "acceleration"}, [wall(0.195)], u=[10.0, 0.0]),
        [-200.0, 0.0],
        "collision",
        ("body", "wall"),
        0.05 - np.sqrt(0.0025 - 0.0012),
    ),
    # A wall of 9 m/s past a robot that stands: its face is 0.05 m away at x = -0.075.
    (
        "moving wall",
        lambda: planar(DISC, [moving(wall(0.0), "-1.0 + 9.0*t", "0")]),
        [0.0, 0.0],
        "collision",
        ("body", "wall"),
        0.925 / 9.0,
    ),
    (
        "moving wall in space",
        lambda: spatial(BALL, [moving(slab(0.0), "-1.0 + 9.0*t", "0", "0")]),
        [0.0, 0.0, 0.0],
        "collision",
        None,
        0.925 / 9.0,
    ),
    # A bar that turns by 20 rad/s about its middle, over a disc 1 m away: it lies over the disc at a quarter turn.
    (
        "turning bar",
        lambda: planar(
            {**DISC, "body_radius": 0.01},
            [{"name": "bar", "shape": "rectangle", "size": [2.4, 0.02], "position": [0.0, 0.0], "orientation": "20*t"}],
            q=[0.0, 1.0],
        ),
        [0.0, 0.0],
        "collision",
        ("body", "bar"),
        (0.5 * pi - np.arcsin(0.02)) / 20.0,
    ),
    (
        "turning bar in space",
        lambda: spatial(
            {**BALL, "body_radius": 0.01},
            [
                {
                    "name": "bar",
                    "shape": "box",
                    "size": [2.4, 0.02, 0.02],
                    "position": [0.0, 0.0, 0.0],
                    "orientation": {"axis": [0.0, 0.0, 1.0], "angle": "20*t"},
                }
            ],
            q=[0.0, 1.0, 0.0],
        ),
        [0.0, 0.0, 0.0],
        "collision",
        None,
        (0.5 * pi - np.arcsin(0.02)) / 20.0,
    ),
    # A link of 1 m that turns by 15 rad/s over a post at a quarter turn.
    (
        "sweeping link",
        lambda: planar(
            {**ARM, "links": [1.0], "body_radius": 0.01, "control": "velocity"}, [circle(0.0, 0.5, 0.01, "post")]
        ),
        [15.0],
        "collision",
        ("link1", "post"),
        (0.5 * pi - np.arcsin(0.04)) / 15.0,
    ),
    (
        "cart on an arc",
        lambda: planar({**CART, "body_radius": 0.02, "control": "velocity"}, [circle(1.0, 1.0, 0.02, "post")]),
        [20.0, 20.0],
        "collision",
        ("base", "post"),
        (0.5 * pi - 2.0 * np.arcsin(0.02)) / 20.0,
    ),
]


@pytest.mark.parametrize(
    ("problem", "action", "outcome", "names", "time"), [c[1:] for c in AIMED], ids=[c[0] for c in AIMED]
)
def test_contact_between_rows_is_found_when_it_happens(
    problem: Any, action: list[float], outcome: str, names: tuple[str, str] | None, time: float
) -> None:
    made = problem()
    violation = first_violation(made, action)
    assert violation is not None
    assert violation.outcome == outcome
    assert violation.time == pytest.approx(time, abs=1e-3 * DT)
    assert violation.clearance[0] > 0.0, "it was to be free again at the next row"
    assert violation.row == int(np.ceil(time / DT))
    if names is not None:
        assert violation.clearance[1:] == names


@pytest.mark.parametrize("dimension", [2, 3])
def test_links_that_pass_through_each_other_have_collided(dimension: int) -> None:
    """The third of three links swings through the first and past its end within one step."""
    changes: Entry = {"links": [1.0, 0.5, 1.0], "body_radius": 0.01, "control": "velocity"}
    changes["self_collision_pairs"] = [["link1", "link3"]]
    q = [0.0, 0.5 * pi, 0.5 * pi]
    problem = planar({**ARM, **changes}, [], q=q) if dimension == 2 else spatial({**robots.ARM, **changes}, [], q=q)
    violation = first_violation(problem, [0.0, 0.0, 18.0])
    assert violation is not None
    assert violation.outcome == "self_collision"
    assert violation.clearance[1:] == ("link1", "link3")
    assert violation.clearance[0] > 0.0
    if dimension == 2:
        assert violation.time == pytest.approx(np.arcsin(0.48) / 18.0, abs=1e-3 * DT)


@pytest.mark.parametrize("kind", KINDS)
def test_fast_motions_past_thin_obstacles(kind: str) -> None:
    """None of many random motions passes through unseen, and none is called a contact that is none.

    `python -m tests.environment.fast_motions 1000000` judges a million.
    """
    found = verdicts(kind, 100, seed=1)
    assert found["hit between rows"] > 5
    assert found["free"] > 5


class Steady(Planner):
    """The same action at each step, as the scenario's planner parameters have it."""

    name = "steady_for_contact"

    @dataclass(frozen=True)
    class Parameters:
        action: tuple[float, ...] = ()

    def setup(self, problem: PlannerProblem) -> None:
        self.action = np.array(self.parameters.action)

    def compute_action(self, observation: Observation) -> Any:
        return self.action


def kpis(names: list[str]) -> Any:
    load_builtin()
    return default_registry.select(names)


def trial(problem: Problem, action: list[float]) -> Trajectory:
    configuration = PlannerConfiguration("steady", "steady_for_contact", {"action": action})
    return run_trial(TrialSpecification(problem.to_dict(), configuration, "family"))


@pytest.mark.parametrize("dimension", [2, 3])
def test_least_clearances_hold_between_rows(dimension: int) -> None:
    """5 m/s past a post that is nearest in the middle between two rows, by 0.04 m; then past a wide gap."""
    if dimension == 2:
        problem = planar(DISC, [circle(0.75, 0.1, 0.01, "post"), circle(3.0, 1.0, 0.1, "other")])
    else:
        obstacles = [sphere(0.75, 0.1, 0.0, 0.01, "post"), sphere(3.0, 1.0, 0.0, 0.1, "other")]
        problem = spatial(BALL, obstacles)
    trajectory = trial(problem, [5.0, 0.0, 0.0][:dimension])
    assert trajectory.outcome == "timeout"
    assert trajectory.contact_time is None
    least = np.hypot(0.25, 0.1) - 0.06  # at both rows
    assert trajectory.clearance.min() == pytest.approx(least)
    step = trajectory.step_clearance
    assert step[2] == pytest.approx(0.04, abs=1e-4)
    assert (step <= trajectory.clearance).all()
    values, faults = evaluate_kpis(trajectory, kpis(["clearance_min_m", "near_miss_time_s"]))
    assert not faults
    assert values["clearance_min_m"] == step[2]
    margin = problem.safety_margin
    assert values["near_miss_time_s"] == pytest.approx((margin - step[2]) / (least - step[2]) * DT)
    recorded_before = {name: values for name, values in trajectory.columns.items() if "step_min" not in name}
    old = Trajectory(recorded_before, trajectory.metadata, problem)
    values, faults = evaluate_kpis(old, kpis(["clearance_min_m", "near_miss_time_s"]))
    assert values == {"clearance_min_m": trajectory.clearance.min(), "near_miss_time_s": 0.0}


@pytest.mark.parametrize("gap", [0.3, 0.94, 4.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_least_clearances_of_far_obstacles_hold_between_rows(dimension: int, gap: float) -> None:
    """A lower bound of the distance of something far is no distance."""
    if dimension == 2:
        problem = planar(DISC, [circle(0.75, gap + 0.06, 0.01, "post"), circle(20.0, 30.0, 0.1, "far")])
    else:
        obstacles = [sphere(0.75, gap + 0.06, 0.0, 0.01, "post"), sphere(20.0, 30.0, 0.0, 0.1, "far")]
        problem = spatial(BALL, obstacles)
    trajectory = trial(problem, [5.0, 0.0, 0.0][:dimension])
    assert trajectory.step_clearance.min() == pytest.approx(gap, abs=1e-4)
    assert trajectory.step_clearance[2] == trajectory.step_clearance.min()


def test_least_clearances_of_the_robot_itself_hold_between_rows() -> None:
    """The tip of a folding arm passes its first link within a step."""
    arm = {**ARM, "links": [1.0, 0.5, 0.3], "body_radius": 0.01, "control": "velocity"}
    # The third link swings to and fro through straight down, where its tip is 0.2 m above the first.
    trajectory = trial(planar(arm, [], q=[0.0, 0.5 * pi, pi - 1.0]), [0.0, 0.0, 20.0])
    assert trajectory.self_clearance[:2].min() > 0.3
    assert np.nanmin(trajectory.self_step_clearance) == pytest.approx(0.18, abs=1e-4)
    assert np.isnan(trajectory.step_clearance).all()


def test_a_trial_says_when_bodies_touched() -> None:
    trajectory = trial(planar(DISC, [wall(5.2)]), [5.0, 0.0])
    assert trajectory.outcome == "collision"
    assert trajectory.contact_time == trajectory.metadata["contact_time_s"] == pytest.approx(1.025, abs=1e-4)
    assert trajectory.metadata["message"].startswith(
        "'body' hit obstacle 'wall' at t = 1.025 s, between two rows (0.22 m apart again at t = 1.1 s), "
    )
    assert len(trajectory) == 12
    assert trajectory.q[-1, 0] == pytest.approx(5.5), "the last row is that at the end of the step"
    values, _ = evaluate_kpis(trajectory, kpis(["clearance_min_m"]))
    assert values["clearance_min_m"] < -0.05


def test_simulated_forces_are_followed_by_their_substeps() -> None:
    """A wall of 9 m/s passes a cart that stands; the physics meets it at rows only."""
    cart = {**robots.CART, "control": "velocity"}
    passing = moving(slab(0.0), "-1.0 + 9.0*t", "0", "0")
    violation = first_violation(spatial(cart, [passing], dynamics=True, substeps=20), [0.0, 0.0])
    assert violation is not None
    assert violation.outcome == "collision"
    assert violation.row == 1
    assert violation.time == pytest.approx((1.0 - 0.025 - 0.2) / 9.0, abs=1e-3)


def test_robots_that_diverge_end() -> None:
    posts = [circle(0.5 * index, 2.6, 0.01, f"post{index}") for index in range(4)]
    arm = {**ARM, "control": "velocity", "self_collision_pairs": []}
    trajectory = trial(planar(arm, posts, q=[0.1, 0.2, 0.3]), [1e6, -2e6, 5e5])
    assert trajectory.outcome in ("collision", "timeout", "environment_error")


def test_the_same_motion_has_the_same_bits_after_a_search() -> None:
    """Looking between rows leaves obstacles and robot where they were."""
    obstacles = [moving(slab(0.0), "1.2 + 0.3*sin(t)", "0", "0"), sphere(0.5, 0.09, 0.0, 0.01, "post")]
    problem = spatial({**BALL, "body_radius": 0.05}, obstacles, end_at=[])
    seen = []
    for look in (True, False):
        world = ScenarioEnvironment(problem=problem)
        rows = []
        for step in range(10):
            world.step([4.0 * (-1.0) ** step, 0.0, 0.0])
            if look:
                contact_since(world.row, continuous(world.running_engine), DT)  # type: ignore[arg-type]
            rows.append(world.running_engine.clearance())
        world.close()
        seen.append(rows)
    assert seen[0] == seen[1]
