"""What a planner wants to see of the future."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Preview:
    """Predictions of obstacles and targets at t + step_s, t + 2 step_s, .., by the environment's `prediction`."""

    steps: int  # number of predicted times
    step_s: float  # [s] between them
