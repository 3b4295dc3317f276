"""Parameters of the MPC planner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from pytest_lpb.planner.base import Planner

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


@dataclass(frozen=True)
class MpcParameters(Planner.Parameters):
    """Horizon, cost, constraints and solver."""

    horizon: Annotated[int, Field(ge=2, le=200)] = 20  # steps
    step: Positive = 0.1  # [s] length of one
    goal: NotNegative = 1.0  # weight of the squared error of each sub-goal, times its own weight [1/m^2 or 1/rad^2]
    goal_end: NotNegative = 10.0  # in its place at the end of the horizon
    velocity: NotNegative = 0.1  # weight of u squared [s^2/m^2 or s^2/rad^2]
    velocity_end: NotNegative = 1.0  # added to it at the end
    input: Positive = 0.05  # weight of du/dt squared [s^4/m^2 or s^4/rad^2]
    input_change: NotNegative = 0.0  # weight of changes of du/dt from step to step
    input_limit: Positive | None = None  # [m/s^2 or rad/s^2] bound of du/dt besides the robot's own; null: none
    velocity_limit: Positive | None = None  # [m/s or rad/s] bound of u besides the robot's own; null: none
    proximal: NotNegative = 1e-3  # weight of moving away from the last plan: keeps redundant joints where they are
    margin: NotNegative = 0.02  # [m] that distances are to keep
    slack: Positive = 100.0  # cost of missing a distance [1/m]
    slack_squared: Positive = 1.0  # and of its square [1/m^2]
    nearest: Annotated[int, Field(ge=0, le=64)] = 2  # obstacles that each ball of the robot minds; 0: all
    own_nearest: Annotated[int, Field(ge=0, le=64)] = 2  # pairs of its own bodies that it minds; 0: none
    own_margin: NotNegative = 0.005  # [m] between its own bodies
    iterations: Annotated[int, Field(ge=1, le=100)] = 1  # of sequential quadratic programming per call
    first_iterations: Annotated[int, Field(ge=1, le=100)] = 5  # at the first call of a trial
    solver: Literal["sqp", "ipopt", "fatrop"] = "sqp"  # real-time iterations with PIQP, or the converged solution
    tolerance: Positive = 1e-5  # of the programs
    sphere_excess: Positive = 0.04  # [m] that fitted spheres may reach beyond a link
    spheres_per_shape: Annotated[int, Field(ge=1, le=64)] = 2
    self_collision_reach: NotNegative = 0.1  # [m] pairs of bodies that never come nearer are left out
    compile: bool = False  # with the C compiler, cached on disk
