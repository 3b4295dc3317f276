"""Which array a planner tried to write into: numpy's error does not say."""

from __future__ import annotations

import linecache
import re
from collections.abc import Iterator, Mapping
from types import FrameType, TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.planner.base import PlannerProblem, arrays_of

_READ_ONLY = "read-only"
_KEY = re.compile(r"""\[\s*["'](\w+)["']\s*\]""")


def hint(error: BaseException, observation: Mapping[str, NDArray[Any]], problem: PlannerProblem | None) -> str:
    """What was written to and what to do, for numpy's error about a read-only array; empty for any other error."""
    # Of numpy's own: one that a planner derives may raise anything when it is asked for its text.
    if type(error) is not ValueError or _READ_ONLY not in str(error):
        return ""
    frames = list(_frames(error.__traceback__))
    if not frames:
        return ""
    frame, line = frames[-1]
    names = [key for key in _KEY.findall(line) if key in observation] or list(_held(frame, observation, problem, line))
    if not names:
        return "; observations are read-only: copy what you change"
    shown = " or ".join(f"observation[{name!r}]" if name in observation else name for name in dict.fromkeys(names))
    return f"; {shown} is read-only: copy what you change"


def _frames(traceback: TracebackType | None) -> Iterator[tuple[FrameType, str]]:
    while traceback is not None:
        code = traceback.tb_frame.f_code
        yield traceback.tb_frame, linecache.getline(code.co_filename, traceback.tb_lineno)
        traceback = traceback.tb_next


def _held(
    frame: FrameType, observation: Mapping[str, NDArray[Any]], problem: PlannerProblem | None, line: str
) -> Iterator[str]:
    """Names of the arrays given to the planner whose memory a variable in the failing line is a view of."""
    arrays = {**observation, **({} if problem is None else arrays_of(problem.robot))}
    seen = {name: value for name, value in frame.f_locals.items() if re.search(rf"\b{re.escape(name)}\b", line)}
    held = [value for value in seen.values() if isinstance(value, np.ndarray)]
    for name, array in arrays.items():
        if any(np.may_share_memory(array, value) for value in held):
            yield name
    if not held:
        yield from (name for name in arrays if name not in observation and name.rpartition(".")[2] in line)
