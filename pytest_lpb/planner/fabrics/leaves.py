"""Leaves: what acts in a task space. Geometries, energies and potentials are expressions that a user may write.

Spahn, Wisse and Alonso-Mora, "Dynamic Optimization Fabrics for Motion Generation", arXiv:2205.08454, section IV.
"""

from __future__ import annotations

from typing import Any

import casadi

from pytest_lpb.planner.fabrics.parameters import named
from pytest_lpb.planner.fabrics.specs import Spec
from pytest_lpb.planner.scene.maps import Mapped
from pytest_lpb.planner.scene.shapes import length
from pytest_lpb.symbolic.expressions import casadi_expression


class ScalarLeaf:
    """A geometry h(x, x') weighted by an energy L(x, x'), both functions of one coordinate.

    By Euler and Lagrange M = d2L/dx'2 and f_e = d2L/dx dx' x' - dL/dx; f = M h.

    Args:
        energy: expression in x and xdot.
        geometry: expression in x and xdot.
        closest: x counts as this where it is less: barriers turn around at 0.
    """

    def __init__(self, energy: str, geometry: str, closest: float) -> None:
        x, xdot = casadi.SX.sym("x"), casadi.SX.sym("xdot")
        symbols = {"x": x, "xdot": xdot}
        lagrangian, h = casadi_expression(named(energy), symbols), casadi_expression(named(geometry), symbols)
        momentum = casadi.gradient(lagrangian, xdot)
        metric = casadi.gradient(momentum, xdot)
        energy_force = casadi.gradient(momentum, x) * xdot - casadi.gradient(lagrangian, x)
        self.idle = bool(h.is_zero())  # whether it bends nothing
        self._closest = closest
        self._function = casadi.Function("leaf", [x, xdot], [metric, metric * h, energy_force], {"cse": True})

    def spec(self, x: Any, xdot: Any, present: Any = None) -> Spec:
        """The leaf's spec where the coordinate is x and its rate x'; nothing where `present` is given and 0."""
        parts = self._function(casadi.fmax(x, self._closest), xdot)
        if present is not None:
            # Not times `present`: what the leaf says of an empty slot may be no number.
            parts = [casadi.if_else(present, part, 0.0) for part in parts]
        return Spec(*parts)


class Attractor:
    """The forcing of a sub-goal: a potential of the distance to the target, weighted by an energy.

    M = d2L/dx'2 times the identity, f = M w grad potential. The reference that moves is in the map.

    Args:
        energy: L, an expression in the distance x and the speed xdot, quadratic in xdot.
        potential: an expression in the distance x.
    """

    def __init__(self, energy: str, potential: str) -> None:
        x, xdot = casadi.SX.sym("x"), casadi.SX.sym("xdot")
        lagrangian = casadi_expression(named(energy), {"x": x, "xdot": xdot})
        slope = casadi.gradient(casadi_expression(named(potential), {"x": x}), x)
        metric = casadi.gradient(casadi.gradient(lagrangian, xdot), xdot)
        self._function = casadi.Function("attractor", [x, xdot], [metric, slope], {"cse": True})

    def spec(self, mapped: Mapped, weight: float) -> Spec:
        """The spec over the sub-goal's error; its energy takes no part in the fabric's own."""
        distance = length(mapped.value)
        metric, slope = self._function(distance, length(mapped.velocity))
        size = mapped.value.numel()
        force = metric * weight * slope * mapped.value / distance
        return Spec(metric * casadi.SX.eye(size), force, casadi.SX.zeros(size, 1))
