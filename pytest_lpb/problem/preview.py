"""What a planner wants to see of the future."""

from dataclasses import dataclass
from math import inf

from pytest_lpb.errors import ConfigurationError

MAX_STEPS = 10_000


@dataclass(frozen=True)
class Preview:
    """Predictions of obstacles and targets at t + step_s, t + 2 step_s, .., by the environment's `prediction`."""

    steps: int  # number of predicted times
    step_s: float  # [s] between them

    def __post_init__(self) -> None:
        if not (isinstance(self.steps, int) and 1 <= self.steps <= MAX_STEPS):
            raise ConfigurationError(f"Preview: steps: found {self.steps!r}; allowed are 1 to {MAX_STEPS}")
        if not 0.0 < self.step_s < inf:
            raise ConfigurationError(f"Preview: step_s: found {self.step_s!r}; a time above 0 s is required")
