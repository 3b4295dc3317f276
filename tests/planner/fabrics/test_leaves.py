"""Leaves: metrics and forces by hand and against finite differences; their sum, and their pull-back to the inputs."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, log

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.planner.fabrics.leaves import Attractor, ScalarLeaf
from pytest_lpb.planner.fabrics.parameters import NAMED
from pytest_lpb.planner.fabrics.specs import SIGNS, Spec
from pytest_lpb.planner.scene.maps import Mapped, State
from pytest_lpb.problem.robot import robot_from
from tests.planner import problems
from tests.planner.scene.making import Array, planar, random_states

PLACES = st.floats(0.2, 3.0)
RATES = st.one_of(st.floats(-2.0, -0.1), st.floats(0.1, 2.0))
STEP = 1e-4


def leaf(energy: str, geometry: str, closest: float = 1e-3) -> ScalarLeaf:
    return ScalarLeaf(energy, geometry, closest)


def numbers(spec: Spec) -> list[float]:
    """M, f and f_e of a spec over one coordinate."""
    return [float(part) for part in (spec.metric, spec.force, spec.energy_force)]


@pytest.mark.parametrize(
    ("energy", "geometry", "x", "xdot", "expected"),
    [
        # M = 0.2 / x, h = -0.5 x'^2 / x^5, f_e = -0.1 x'^2 / x^2
        ("barrier_energy", "barrier", 0.5, -0.4, [0.4, -1.024, -0.064]),
        ("barrier_energy", "barrier", 0.5, 0.4, [0.4, 0.0, -0.064]),
        ("barrier_energy", "soft_barrier", 0.5, -0.4, [0.4, -0.064, -0.064]),
        # M = 0.2 / x where it approaches, else 0; h = -0.1 x'^2 / x
        ("approaching_energy", "limit_barrier", 0.5, -0.4, [0.4, -0.0128, -0.064]),
        ("approaching_energy", "limit_barrier", 0.5, 0.4, [0.0, 0.0, 0.0]),
        ("kinetic", "none", 0.0, 3.0, [0.2, 0.0, 0.0]),
    ],
)
def test_default_leaves_by_hand(energy: str, geometry: str, x: float, xdot: float, expected: list[float]) -> None:
    assert numbers(leaf(energy, geometry).spec(x, xdot)) == pytest.approx(expected, abs=1e-12)


ENERGIES: dict[str, Callable[[float, float], float]] = {
    "barrier_energy": lambda x, v: 0.1 * v * v / x,
    "approaching_energy": lambda x, v: 0.1 * v * v / x if v < 0.0 else 0.0,
    "0.3 * exp(-x) * xdot**2 + 0.2 * xdot**4 * x": lambda x, v: 0.3 * exp(-x) * v * v + 0.2 * v**4 * x,
}


@pytest.mark.parametrize("energy", ENERGIES)
@given(PLACES, RATES)
def test_metrics_and_energy_forces_are_those_of_euler_and_lagrange(energy: str, x: float, xdot: float) -> None:
    lagrangian, h = ENERGIES[energy], STEP

    def momentum(at: float) -> float:
        return (lagrangian(at, xdot + h) - lagrangian(at, xdot - h)) / (2.0 * h)

    metric = (lagrangian(x, xdot + h) - 2.0 * lagrangian(x, xdot) + lagrangian(x, xdot - h)) / (h * h)
    slope = (lagrangian(x + h, xdot) - lagrangian(x - h, xdot)) / (2.0 * h)
    force = (momentum(x + h) - momentum(x - h)) / (2.0 * h) * xdot - slope
    spec = leaf(energy, "0").spec(x, xdot)
    assert float(spec.metric) == pytest.approx(metric, rel=1e-5, abs=1e-5)
    assert float(spec.energy_force) == pytest.approx(force, rel=1e-5, abs=1e-5)
    assert float(spec.force) == 0.0


@given(PLACES, RATES)
def test_a_geometry_s_force_is_its_metric_times_the_acceleration_it_asks_for(x: float, xdot: float) -> None:
    metric, force, _ = numbers(leaf("0.3 * xdot**2 / x**2", "sin(x) - 2 * xdot").spec(x, xdot))
    assert metric == pytest.approx(0.6 / x**2)
    assert force == pytest.approx(metric * (np.sin(x) - 2.0 * xdot))


@pytest.mark.parametrize("x", [0.1, 0.05, 0.0, -0.3, -5.0])
def test_coordinates_that_are_nearer_than_closest_count_as_closest(x: float) -> None:
    made = leaf("barrier_energy", "barrier", closest=0.1)
    assert numbers(made.spec(x, -0.4)) == numbers(made.spec(0.1, -0.4))
    assert numbers(made.spec(0.2, -0.4)) != numbers(made.spec(0.1, -0.4))


@pytest.mark.parametrize("name", [name for name in NAMED if name != "soft_norm"])
def test_names_stand_for_their_text(name: str) -> None:
    for xdot in (-0.7, 0.4):
        assert numbers(leaf(name, "barrier").spec(0.6, xdot)) == numbers(
            leaf(NAMED[name], NAMED["barrier"]).spec(0.6, xdot)
        )
        assert numbers(leaf("kinetic", name).spec(0.6, xdot)) == numbers(leaf("kinetic", NAMED[name]).spec(0.6, xdot))


@pytest.mark.parametrize("geometry", ["limit_barrier", "1 / (x - x)"])
def test_an_empty_slot_has_no_leaf_whatever_it_would_say(geometry: str) -> None:
    made = leaf("barrier_energy", geometry)
    assert numbers(made.spec(0.5, -0.3, 0.0)) == [0.0, 0.0, 0.0]
    assert numbers(made.spec(0.5, -0.3, 1.0)) == pytest.approx(numbers(made.spec(0.5, -0.3)), nan_ok=True)


@pytest.mark.parametrize(("geometry", "idle"), [("none", True), ("0", True), ("0 * xdot", True), ("barrier", False)])
def test_leaves_without_a_geometry_know_it(geometry: str, idle: bool) -> None:
    assert leaf("kinetic", geometry).idle is idle


# Attractors


def target(*error: float, velocity: tuple[float, ...] | None = None) -> Mapped:
    """A map of which only value and velocity matter."""
    size = len(error)
    zero = casadi.DM.zeros(size, 1)
    rate = zero if velocity is None else casadi.DM(list(velocity))
    return Mapped(casadi.DM(list(error)), rate, casadi.DM.eye(size), zero, zero)


def arrays(spec: Spec) -> tuple[Array, Array, Array]:
    metric, force, energy_force = (
        np.array(casadi.evalf(part)) for part in (spec.metric, spec.force, spec.energy_force)
    )
    return metric, force.ravel(), energy_force.ravel()


def soft_norm(x: float) -> float:
    return 5.0 * (x + 0.1 * log(1.0 + exp(-20.0 * x)))


def test_the_default_attractor_by_hand() -> None:
    # |x| = 0.5: metric 2 (1.7 exp(-0.375^2) + 0.3), slope 5 (1 - 2 / (1 + e^10)), along (0.6, -0.8)
    metric, force, energy_force = arrays(Attractor("near_goal_energy", "soft_norm").spec(target(0.3, -0.4), 2.5))
    mass = 2.0 * (1.7 * exp(-0.140625) + 0.3)
    assert metric == pytest.approx(mass * np.eye(2))
    assert force == pytest.approx(mass * 2.5 * 5.0 * (1.0 - 2.0 / (1.0 + exp(10.0))) * np.array([0.6, -0.8]))
    assert energy_force == pytest.approx(np.zeros(2), abs=0.0)


@given(st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3).filter(lambda error: np.linalg.norm(error) > 1e-2))
def test_attractors_pull_down_the_slope_of_their_potential(error: list[float]) -> None:
    at, step = np.array(error), 1e-6
    slope = [
        (soft_norm(float(np.linalg.norm(at + step * axis))) - soft_norm(float(np.linalg.norm(at - step * axis))))
        / (2.0 * step)
        for axis in np.eye(3)
    ]
    _, force, _ = arrays(Attractor("0.5 * xdot**2", "soft_norm").spec(target(*error), 1.0))
    assert force == pytest.approx(slope, rel=1e-5, abs=1e-6)


def test_attractors_pull_no_more_where_the_goal_is_met() -> None:
    metric, force, _ = arrays(Attractor("near_goal_energy", "soft_norm").spec(target(0.0, 0.0), 1.0))
    assert metric == pytest.approx(4.0 * np.eye(2))
    assert force == pytest.approx(np.zeros(2), abs=1e-9)


def test_an_attractor_s_energy_may_be_written_in_distance_and_speed() -> None:
    # L = x x'^2 / 2 has the metric x.
    spec = Attractor("0.5 * x * xdot**2", "0.5 * x**2").spec(target(0.3, -0.4, velocity=(1.0, 2.0)), 1.0)
    metric, force, _ = arrays(spec)
    assert metric == pytest.approx(0.5 * np.eye(2))
    assert force == pytest.approx(0.5 * np.array([0.3, -0.4]))


# Sum and pull-back

BENT = Mapped(casadi.DM(1.0), casadi.DM(0.0), casadi.DM([[1.0, 2.0]]), casadi.DM(0.5), casadi.DM(0.25))


@pytest.mark.parametrize(("sign", "force"), [(1.0, 4.5), (-1.0, 2.5)])
def test_pull_back_by_hand(sign: float, force: float) -> None:
    spec = Spec(casadi.DM(2.0), casadi.DM(3.0), casadi.DM(5.0)).pulled_back(BENT, sign)
    square = np.array([[1.0, 2.0], [2.0, 4.0]])
    assert np.array(spec.metric) == pytest.approx(2.0 * square)
    assert np.array(spec.force).ravel() == pytest.approx([force, 2.0 * force])
    assert np.array(spec.energy_force).ravel() == pytest.approx([6.5, 13.0])  # +1 for energies, always


def test_metrics_that_couple_coordinates_stay_symmetric() -> None:
    jacobian = casadi.DM([[1.0, 2.0, 0.5], [0.0, -1.0, 3.0]])
    metric = casadi.DM([[2.0, 0.7], [0.7, 1.0]])
    flat = Mapped(casadi.DM.zeros(2, 1), casadi.DM.zeros(2, 1), jacobian, casadi.DM.zeros(2, 1), casadi.DM.zeros(2, 1))
    spec = Spec(metric, casadi.DM.zeros(2, 1), casadi.DM.zeros(2, 1)).pulled_back(flat, 1.0)
    assert np.array(spec.metric) == pytest.approx(np.array(jacobian.T @ metric @ jacobian))


def test_specs_add_up_part_by_part() -> None:
    one = Spec(casadi.DM(1.0), casadi.DM(2.0), casadi.DM(3.0))
    other = Spec(casadi.DM(10.0), casadi.DM(20.0), casadi.DM(30.0))
    assert numbers(one + other) == [11.0, 22.0, 33.0]
    same = Spec.nothing(1) + one
    parts = [same.metric, same.force, same.energy_force]
    assert [float(casadi.DM(part)) for part in parts] == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("name", SIGNS)
def test_a_geometry_that_asks_for_nothing_keeps_the_tip_on_a_line_with_the_theory_s_sign(name: str) -> None:
    state = State(robot_from(planar(problems.arm(0.6, 0.5))))
    tip = state.mapped(state.frames.of("end")[0])
    spec = Spec(casadi.SX.eye(2), casadi.SX.zeros(2, 1), casadi.SX.zeros(2, 1))
    pulled = spec.pulled_back(tip, SIGNS[name])
    acceleration = tip.curvature - tip.jacobian @ casadi.solve(pulled.metric, pulled.force)
    function = casadi.Function("tip", [state.q, state.inputs], [acceleration, tip.curvature])
    for q, w in random_states(state.robot, 0, 5):
        found, curvature = (np.array(part).ravel() for part in function(q, w))
        assert np.linalg.norm(curvature) > 1e-3
        expected = 0.0 * curvature if name == "theory" else 2.0 * curvature
        assert found == pytest.approx(expected, abs=1e-9)
