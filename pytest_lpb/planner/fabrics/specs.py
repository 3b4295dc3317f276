"""Specs: second-order equations M x'' + f = 0 over a space, their sum and their pull-back.

Ratliff et al., "Optimization Fabrics", arXiv:2008.02399; Spahn, Wisse and Alonso-Mora, "Dynamic Optimization Fabrics
for Motion Generation", arXiv:2205.08454.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi

from pytest_lpb.planner.scene.maps import Mapped

SIGNS = {"theory": 1.0, "reference": -1.0}  # of the curvature term in a geometry's pull-back


@dataclass(frozen=True)
class Spec:
    """A geometry weighted by an energy, M (x'' + h) = 0 with f = M h, and the energy's own equation M x'' + f_e = 0."""

    metric: Any  # M (m, m)
    force: Any  # f (m, 1)
    energy_force: Any  # f_e (m, 1)

    @classmethod
    def nothing(cls, size: int) -> Spec:
        """The spec that adds nothing."""
        return cls(casadi.SX.zeros(size, size), casadi.SX.zeros(size, 1), casadi.SX.zeros(size, 1))

    def __add__(self, other: Spec) -> Spec:
        return Spec(self.metric + other.metric, self.force + other.force, self.energy_force + other.energy_force)

    def pulled_back(self, mapped: Mapped, sign: float) -> Spec:
        """The spec over the inputs that this one over a task space means.

        Args:
            mapped: the map to the task space.
            sign: of the curvature term of the geometry, one of `SIGNS`; energies have +1 always.
        """
        jacobian = mapped.jacobian
        force = self.force + self.metric @ (sign * mapped.curvature + mapped.drift)
        energy_force = self.energy_force + self.metric @ (mapped.curvature + mapped.drift)
        return Spec(congruent(jacobian, self.metric), jacobian.T @ force, jacobian.T @ energy_force)


def congruent(jacobian: Any, matrix: Any) -> Any:
    """J^T A J of a symmetric A; half of the result need not be computed."""
    return casadi.triu2symm(casadi.triu(jacobian.T @ (matrix @ jacobian)))


def solve(metric: Any, right: Any, regularisation: float) -> Any:
    """(M + epsilon I)^-1 times each column, by Cholesky's factorisation without roots."""
    size = metric.size1()
    diagonal, lower, order = casadi.ldl(casadi.densify(metric + regularisation * casadi.SX.eye(size)))
    return casadi.ldl_solve(casadi.densify(right), diagonal, lower, order)
