"""The errors pytest-lpb raises on purpose. All derive from `LpbError`; anything else is a bug."""


class LpbError(Exception):
    """Base of every error that pytest-lpb raises on purpose."""


class ScenarioError(LpbError):
    """A scenario file, or a problem drawn from it, cannot be used: one line per fault, each with its place."""

    def __init__(self, *faults: str) -> None:
        super().__init__("\n".join(faults))
        self.faults = faults


class ConfigurationError(LpbError):
    """A planner configuration, an option or a name given by the user is wrong."""


class Infeasible(LpbError):  # noqa: N818 - the contract's public name, raised by planners
    """Raised by a planner's `compute_action`: it has found that its problem has no feasible action."""


class PlannerError(LpbError):
    """A planner raised, or returned something that is not an action."""


class RecordingError(LpbError):
    """Raw data of a trial, or a run folder, cannot be read or written."""


class KpiError(LpbError):
    """A KPI is registered wrongly, is unknown, or returned something that is not a number."""
