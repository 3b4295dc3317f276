"""What a planner raised, as pytest shows errors (`-l`, `--tb`), and as a debugger needs it (`--pdb`)."""

from __future__ import annotations

import io
import traceback
from dataclasses import dataclass
from types import TracebackType
from typing import Any

import pytest
from _pytest._io import TerminalWriter

from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.debugger import planner_frames
from pytest_lpb.trial.loop import shortened

PYTEST_STYLES = ("long", "short")  # of --tb, asked for by name


@dataclass(frozen=True)
class Raised:
    """An error of planner code in this process.

    Attributes:
        error: as it was raised.
        frames: its traceback, from the planner's first frame on.
    """

    error: BaseException
    frames: TracebackType
    config: pytest.Config

    @classmethod
    def by(cls, error: BaseException | None, planner: PlannerConfiguration, config: pytest.Config) -> Raised | None:
        """What a planner raised; None for one in a process of its own, whose frames are not here."""
        frames = None if error is None or planner.isolation is not None else planner_frames(error)
        return None if error is None or frames is None else cls(error, frames, config)

    def details(self, trajectory: Trajectory) -> str:
        """A trial's details; the traceback among them as pytest writes it, where options ask for that."""
        recorded: str = trajectory.metadata["details"].rstrip()
        option = self.config.option
        if not (option.showlocals or option.tbstyle in PYTEST_STYLES):
            return recorded
        own = shortened("".join(traceback.format_exception(type(self.error), self.error, self.frames))).rstrip()
        style: Any = option.tbstyle if option.tbstyle in PYTEST_STYLES else "long"
        info = pytest.ExceptionInfo.from_exc_info((type(self.error), self.error, self.frames))
        shown = info.getrepr(showlocals=option.showlocals, style=style, tbfilter=False)
        # Not `str`, which strips the first line's indentation.
        text = io.StringIO()
        shown.toterminal(TerminalWriter(text))
        return "\n".join(filter(None, [text.getvalue().rstrip(), recorded.removeprefix(own).lstrip("\n")]))


def advice(planner: PlannerConfiguration, config: pytest.Config) -> str:
    """What `--pdb` cannot do for a planner in a process of its own; empty where it can."""
    if planner.isolation is None or not config.option.usepdb:
        return ""
    return (
        f"--pdb cannot look into planner {planner.name!r}, which runs in {planner.isolation.place}: its frames are not "
        "in this process. Run it without the keys of its planner file that isolate it, or read its traceback above"
    )
