"""Speed control: what damping and excitation make of a fabric's forced motion.

Ratliff et al., arXiv:2008.02399, section V, as the reference release has it: docs/fabrics.md.
"""

from __future__ import annotations

from typing import Any

import casadi

from pytest_lpb.planner.fabrics.parameters import FabricsParameters
from pytest_lpb.planner.fabrics.specs import Spec, solve


def energised(metric: Any, force: Any, energy_force: Any, w: Any, regularisation: float) -> Any:
    """alpha with which -h - alpha w keeps the energy of M: -w (f - f_e) / (epsilon + w M w)."""
    power = casadi.dot(w, force - energy_force)
    return -power / (regularisation + casadi.dot(w, metric @ w))


def controlled(
    geometry: Spec, forced: Spec, w: Any, target_velocity: Any, distance: Any, parameters: FabricsParameters
) -> Any:
    """The acceleration of the inputs, (n, 1).

    Args:
        geometry: sum of the geometries, (M, f, f_e).
        forced: the same with the attractors.
        w: inputs (n, 1).
        target_velocity: velocity of the inputs that follows moving targets, times the forced metric (n, 1).
        distance: from the goal [m or rad].
        parameters: damping and speed.
    """
    epsilon = parameters.regularisation
    h = solve(geometry.metric, geometry.force, epsilon)
    solved = solve(forced.metric, casadi.horzcat(forced.force, target_velocity), epsilon)
    h_forced, follow = solved[:, 0], solved[:, 1]
    twice = 2.0 * casadi.SX.eye(w.numel())  # metric of the execution energy, the squared speed
    nothing = casadi.SX.zeros(w.numel(), 1)
    alpha_geometry = energised(geometry.metric, geometry.force, geometry.energy_force, w, epsilon)
    alpha_free = energised(twice, 2.0 * h, nothing, w, epsilon)
    alpha_forced = energised(twice, 2.0 * h_forced, nothing, w, epsilon)
    eta = 0.5 * (casadi.tanh(-parameters.speed_weight * casadi.sumsqr(w) - parameters.speed_offset) + 1.0)
    excitation = eta * alpha_free + (1.0 - eta) * alpha_forced
    near = 0.5 * (casadi.tanh(-parameters.damping_slope * (distance - parameters.damping_radius)) + 1.0)
    damping = near * parameters.damping_near + parameters.damping_far
    damping += casadi.fmax(0.0, alpha_geometry - excitation)
    return -h_forced - (excitation + damping) * (w - follow)
