"""What a debugger needs of a trial: that it may end the run, and the frames of the planner that raised."""

from __future__ import annotations

import bdb
from collections.abc import Iterator
from types import FrameType, TracebackType

# Modules whose functions stand between the trial and the planner's code.
_BETWEEN = (
    "pytest_lpb.trial.",
    "pytest_lpb.planner.configuration",
    "pytest_lpb.planner.class_here",
    "pytest_lpb.isolation.far.support",
)


class DebuggerQuitError(BaseException):
    """Somebody has left a debugger within planner code; the cause is what the debugger raised."""


def pass_on_quit(error: BaseException) -> None:
    """Raise DebuggerQuitError for what a debugger raised to end the run."""
    if is_quit(error):
        raise DebuggerQuitError from error


def is_quit(error: BaseException) -> bool:
    """Whether a debugger raised it, when it was left: that is no fault of the planner."""
    return isinstance(error, bdb.BdbQuit) or any(_name(frame) == "bdb" for frame in _frames(error.__traceback__))


def planner_frames(error: BaseException) -> TracebackType | None:
    """The traceback of an error from the planner's first frame on.

    Where the planner has returned something wrong its frame is gone: then from the frame that has called it.
    """
    traceback = error.__traceback__
    while traceback is not None and _name(traceback.tb_frame).startswith(_BETWEEN):
        if traceback.tb_next is None or traceback.tb_next.tb_frame.f_locals.get("__tracebackhide__"):
            break
        traceback = traceback.tb_next
    return traceback


def _frames(traceback: TracebackType | None) -> Iterator[FrameType]:
    while traceback is not None:
        yield traceback.tb_frame
        traceback = traceback.tb_next


def _name(frame: FrameType) -> str:
    return str(frame.f_globals.get("__name__", ""))
