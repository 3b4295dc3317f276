"""The errors pytest-lpb raises on purpose, and how errors of other people's code are told in one line.

All of ours derive from `LpbError`; anything else is a bug.
"""

import importlib
import traceback
from pathlib import Path

_IMPORTLIB = Path(importlib.__file__).parent
_OWN = Path(__file__).parent  # faults found by our own code say themselves where they are


class LpbError(Exception):
    """Base of every error that pytest-lpb raises on purpose."""


class ScenarioError(LpbError):
    """A scenario file, or a problem drawn from it, cannot be used: one line per fault, each with its place."""

    def __init__(self, *faults: str) -> None:
        super().__init__("\n".join(faults))
        self.faults = faults


class MissingRobotsError(ScenarioError):
    """A scenario's robot comes with an optional package that is not installed."""


class ConfigurationError(LpbError):
    """A planner configuration, an option or a name given by the user is wrong."""


class Infeasible(LpbError):  # noqa: N818 - the contract's public name, raised by planners
    """Raised by a planner's `compute_action`: it has found that its problem has no feasible action."""


class UnsupportedError(LpbError):
    """A planner does not take a problem, as it declares: there is no trial of it. The text is the reason."""


class PlannerError(LpbError):
    """A planner raised, or returned something that is not an action; `details` is what else is known."""

    def __init__(self, message: str = "", details: str = "") -> None:
        super().__init__(message)
        self.details = details


class DeadlineError(PlannerError):
    """A planner's call or setup took longer than its hard limit."""


class RecordingError(LpbError):
    """Raw data of a trial, or a run folder, cannot be read or written."""


class StorageError(RecordingError):
    """Nothing more can be recorded there: the disk is full, or can only be read."""


class KpiError(LpbError):
    """A KPI is registered wrongly, is unknown, or returned something that is not a number."""


class DivergedError(PlannerError):
    """A planner's actions drove the robot's state beyond all measure."""


def in_one_line(error: BaseException) -> str:
    """An exception in one line: type, text, and the file and line that raised it."""
    try:
        text = str(error)
    except BaseException as failure:
        # An exception of someone else's may fail to say what it is, in any way.
        text = f"(its text cannot be shown: {type(failure).__name__})"
    told = isinstance(error, ImportError | LpbError) and text
    line = (text if told else f"{type(error).__name__}: {text}" if text else type(error).__name__).replace("\n", " ")
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if _is_code(Path(frame.filename))]
    if isinstance(error, SyntaxError) or not frames or _OWN in Path(frames[-1].filename).parents:
        return line
    return f"{line} ({frames[-1].filename}:{frames[-1].lineno})"


def _is_code(path: Path) -> bool:
    """Whether a frame's file can be looked at and is not the machinery of imports."""
    return path.is_file() and path.parent != _IMPORTLIB
