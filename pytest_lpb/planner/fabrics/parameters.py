"""Parameters of the fabrics planner; the defaults are the published ones of the reference release 0.10.0."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from pytest_lpb.names import listed, suggestion
from pytest_lpb.planner.base import Planner
from pytest_lpb.symbolic.expressions import casadi_expression, check_expression

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]

PROBE = 0.5  # x, and minus xdot, at which energies are looked at

# Leaves by name, for configuration files that would rather not repeat them; x, xdot as in docs/fabrics.md.
NAMED: dict[str, str] = {
    "none": "0",
    "kinetic": "0.1 * xdot**2",
    "barrier_energy": "0.1 * xdot**2 / x",
    "approaching_energy": "0.05 * (1 - sign(xdot)) * xdot**2 / x",
    "barrier": "-0.25 * (1 - sign(xdot)) * xdot**2 / x**5",
    "soft_barrier": "-0.25 * (1 - sign(xdot)) * xdot**2 / x",
    "limit_barrier": "-0.1 * xdot**2 / x",
    "soft_norm": "5 * (x + 0.1 * log(1 + exp(-20 * x)))",
    "near_goal_energy": "(1.7 * exp(-(0.75 * x)**2) + 0.3) * xdot**2",
}


def named(text: str) -> str:
    """The expression that a name of `NAMED` stands for, or the text itself."""
    return NAMED.get(text, text)


def _checked(text: str, *variables: str) -> str:
    """The text, if it is a name of `NAMED` or an expression. Raises ValueError."""
    if text.isidentifier() and text not in (*NAMED, *variables):
        raise ValueError(
            f"unknown name {text!r}{suggestion(text, NAMED)}; "
            f"allowed are {listed(NAMED)}, and expressions in {' and '.join(variables)}"
        )
    check_expression(named(text), variables)
    return text


def _value(text: str, of: Callable[[Any, Any, Any], Any]) -> float:
    """What is made of an expression in x and xdot, where something approaches at `PROBE`."""
    import casadi  # late: only planners that are chosen are checked

    x, xdot = casadi.SX.sym("x"), casadi.SX.sym("xdot")
    made = of(casadi_expression(named(text), {"x": x, "xdot": xdot}), x, xdot)
    return float(casadi.Function("value", [x, xdot], [made])(PROBE, -PROBE))


def _finite(text: str, value: float, what: str) -> None:
    if not isfinite(value):
        raise ValueError(f"{text!r} has {what} of {value} at x = {PROBE}, xdot = {-PROBE}")


def _energy(text: str) -> str:
    """An energy: none, or one that weighs what moves. Raises ValueError."""
    import casadi

    _checked(text, "x", "xdot")
    metric = _value(text, lambda energy, x, xdot: casadi.hessian(energy, xdot)[0])  # noqa: ARG005
    _finite(text, metric, "a metric")
    if named(text) != "0" and not metric > 0.0:
        raise ValueError(f"the energy {text!r} gives what approaches no weight: d2L/dxdot2 must be above 0")
    return text


def _geometry(text: str) -> str:
    """A geometry that is a number where it counts. Raises ValueError."""
    _checked(text, "x", "xdot")
    _finite(text, _value(text, lambda geometry, x, xdot: geometry), "a value")  # noqa: ARG005
    return text


def _potential(text: str) -> str:
    """A potential that pulls towards the target. Raises ValueError."""
    import casadi

    _checked(text, "x")
    slope = _value(text, lambda potential, x, xdot: casadi.gradient(potential, x))  # noqa: ARG005
    _finite(text, slope, "a slope")
    if slope < 0.0:
        raise ValueError(f"the potential {text!r} falls with the distance x: it would drive away from the target")
    return text


def _pull(text: str) -> str:
    """The energy of an attractor, without which it would not pull. Raises ValueError."""
    if named(_energy(text)) == "0":
        raise ValueError("without an energy no sub-goal would count; for one that is not to count give it no weight")
    return text


def _plane(numbers: tuple[float, ...]) -> tuple[float, ...]:
    *normal, _ = numbers
    if not all(map(isfinite, numbers)) or not any(normal):
        raise ValueError("a plane is its outward normal, not all zero, and an offset [m]: 3 or 4 finite numbers")
    return numbers


Plane = Annotated[tuple[float, ...], Field(min_length=3, max_length=4), AfterValidator(_plane)]
Geometry = Annotated[str, AfterValidator(_geometry)]
Energy = Annotated[str, AfterValidator(_energy)]
Potential = Annotated[str, AfterValidator(_potential)]
Pull = Annotated[str, AfterValidator(_pull)]


@dataclass(frozen=True)
class FabricsParameters(Planner.Parameters):
    """Leaves, speed control, and what the robot is taken for. Expressions in x and xdot, or names of `NAMED`."""

    base_energy: Energy = NAMED["kinetic"]  # of each input's velocity xdot
    obstacle_energy: Energy = NAMED["barrier_energy"]
    obstacle_geometry: Geometry = NAMED["barrier"]
    plane_energy: Energy = NAMED["barrier_energy"]
    plane_geometry: Geometry = NAMED["barrier"]
    self_collision_energy: Energy = NAMED["barrier_energy"]
    self_collision_geometry: Geometry = NAMED["soft_barrier"]
    limit_energy: Energy = NAMED["approaching_energy"]
    limit_geometry: Geometry = NAMED["limit_barrier"]
    attractor_energy: Pull = NAMED["near_goal_energy"]
    attractor_potential: Potential = NAMED["soft_norm"]
    damping_near: NotNegative = 6.5  # [1/s] at the goal
    damping_far: NotNegative = 0.01  # [1/s] everywhere
    damping_slope: NotNegative = 0.5  # [1/m] how sharply the first becomes the second
    damping_radius: NotNegative = 0.02  # [m or rad] distance to the goal at which half of the first is left
    speed_weight: NotNegative = 0.45  # [s^2/m^2] how fast the forcing takes over the speed as the robot gets faster
    speed_offset: Finite = 0.5  # how much it has the speed of a robot at rest
    regularisation: Positive = 1e-6  # epsilon of inverse metrics
    closest: Positive = 1e-3  # coordinates of barriers count as this where they are less
    brake: NotNegative = 0.0  # [s] distances shrink by at most x / brake; 0: as they like
    margin: NotNegative = 0.0  # [m or rad] that the brake leaves of distances
    distance: Literal["relative", "metric"] = "relative"  # x of obstacles: per sum of radii, or in m
    curvature_term: Literal["theory", "reference"] = "theory"  # sign of J' qd in geometries: +1, or -1 as the reference
    obstacle_motion: bool = True  # whether velocities and accelerations of obstacles are seen: dynamic fabrics
    planes: tuple[Plane, ...] = ()  # half-spaces that are free: n p >= offset, outward normal n and offset [m]
    links: Literal["spheres", "exact"] = "spheres"  # all links by spheres; or as they are where that is known
    sphere_excess: Positive = 0.03  # [m] that fitted spheres may reach beyond a link
    spheres_per_shape: Annotated[int, Field(ge=1, le=64)] = 4
    self_collision_reach: NotNegative = 0.3  # [m] pairs of bodies that never come nearer have no leaf
    lookahead: Positive = 0.3  # [m] a non-holonomic base is steered by the point this far ahead of it
    respect_limits: bool = False  # actions beyond the robot's acceleration limits are shortened, not clipped by entry
    largest_acceleration: Positive | None = None  # [m/s^2 or rad/s^2] longer actions are shortened; null: no limit
    compile: bool = False  # with the C compiler, cached on disk
