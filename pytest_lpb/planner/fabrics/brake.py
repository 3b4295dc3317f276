"""The brake: what approaches slows down, so that steps of time and stiff barriers lead to no contact.

A velocity damper (Faverjon and Tournassoud, "A local based approach for path planning of manipulators with a high
number of degrees of freedom", ICRA 1987): a distance x may shrink by at most x / T. Velocities beyond are damped along
the distances that shrink too fast, relative to what moves there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi

from pytest_lpb.planner.fabrics.specs import congruent, solve

TOUCHING = 1e-6  # [m or rad, or as distances are measured] nearer than this nothing approaches any more
SLIGHT = 1e-6  # J J^T of a distance that no input changes


@dataclass(frozen=True)
class Damping:
    """Dampers along distances, summed: (I + `matrix`) w = w_wanted - `push`."""

    matrix: Any  # (n, n)
    push: Any  # (n, 1): what moves by itself is not waited for

    @classmethod
    def nothing(cls, size: int) -> Damping:
        """No dampers."""
        return cls(casadi.SX(size, size), casadi.SX.zeros(size, 1))

    @classmethod
    def along(cls, distance: Any, jacobian: Any, rate: Any, own: Any, mobility: Any, horizon: float) -> Damping:
        """The damper along one distance.

        Args:
            distance: x, in any unit.
            jacobian: J (1, n), by the velocities that the damper acts on.
            rate: x' with the velocities that are wanted.
            own: what x' is when these are zero, since what is approached moves.
            mobility: J J^T of the distance, by the robot's inputs.
            horizon: T [s].
        """
        excess = casadi.fmax(-rate * horizon / casadi.fmax(distance, TOUCHING) - 1.0, 0.0)
        share = excess / (mobility + SLIGHT)
        return cls(congruent(jacobian, share), share * jacobian.T * own)

    def pulled_back(self, jacobian: Any) -> Damping:
        """The same for velocities of which these ones are the product with a Jacobian."""
        return Damping(congruent(jacobian, self.matrix), jacobian.T @ self.push)

    def velocity(self, wanted: Any) -> Any:
        """The velocities (n, 1) that are left of those wanted."""
        return solve(self.matrix, wanted - self.push, 1.0)

    def __add__(self, other: Damping) -> Damping:
        return Damping(self.matrix + other.matrix, self.push + other.push)
