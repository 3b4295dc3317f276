"""Answers the messages of one planner: start, describe, setup, observation, call, close."""

from __future__ import annotations

import gc
import os
import random
import sys
import traceback
import warnings
from time import perf_counter_ns, thread_time_ns
from typing import Any

import numpy as np

from pytest_lpb.isolation.far import importing
from pytest_lpb.isolation.far.description import described, parameters_of
from pytest_lpb.isolation.far.messages import NUMBER
from pytest_lpb.isolation.far.support import refusal

BYTES_PER_MB = 1000000
OF_OURS = "<pytest_lpb.isolation."  # files of the far side, as tracebacks call them
SHOWN = 80  # characters of a wrong value


class WrongResult(Exception):  # noqa: N818 - its text is the whole message
    """A planner returned, or left in its diagnostics, what is not allowed."""


class Server:
    """Holds the planner of the process."""

    def __init__(self) -> None:
        self.planner: Any = None
        self.cls: Any = None
        self.views: dict[str, Any] = {}
        self.numbers: Any = np.zeros(0)
        self.problem: Any = None
        self.surroundings: Any = None

    def start(self, header: dict[str, Any], payload: bytes) -> tuple[dict[str, Any], bytes]:  # noqa: ARG002
        """Where and within which limits to run."""
        if header["memory_mb"]:
            limit_memory(header["memory_mb"])
        if header["working_dir"]:
            os.chdir(header["working_dir"])
        importing.prepare(header["path"], header["whole_path"], header["sources"])
        self.surroundings = Surroundings()
        return {"type": "started"}, b""

    def describe(self, header: dict[str, Any], payload: bytes) -> tuple[dict[str, Any], bytes]:  # noqa: ARG002
        """Parameters, preview and source of the planner's class."""
        return dict(described(importing.class_of(header["planner"]), header["parameters"]), type="description"), b""

    def setup(self, header: dict[str, Any], payload: bytes) -> tuple[dict[str, Any], bytes]:  # noqa: ARG002
        """Prepare for a trial."""
        if self.cls is None:
            self.cls = importing.class_of(header["planner"])
        parameters = parameters_of(self.cls, header["parameters"])
        if self.planner is None:
            self.surroundings.put_back(0)
            self.planner = self.cls(parameters)
        self.problem = problem = importing.problem_of(header["problem"], header.get("robot"))
        if problem is None:
            return {"type": "robot"}, b""  # its description is needed
        self.planner.parameters = parameters
        self.planner.diagnostics = {}
        # As in the trial loop: no garbage collection while the planner is on the clock.
        gc.enable()
        gc.collect()
        gc.disable()
        self.surroundings.put_back(problem.seed)
        reason = refusal(self.planner, problem)
        if reason:
            return {"type": "unsupported", "message": reason}, b""
        self.planner.setup(problem)
        return {"type": "ready"}, b""

    def observation(self, header: dict[str, Any], payload: bytes) -> tuple[dict[str, Any], bytes] | None:  # noqa: ARG002
        """Where each array lies in the calls to come; not answered."""
        layout = header["arrays"]
        self.numbers = np.zeros(sum(size for _, size, _ in layout.values()))
        self.views = {}
        for name, (offset, size, shape) in layout.items():
            view = self.numbers[offset : offset + size].reshape(shape)
            self.views[name] = np.asarray(view.data.toreadonly())
        return None

    def call(self, header: dict[str, Any], payload: bytes) -> tuple[dict[str, Any], bytes]:  # noqa: ARG002
        """One call, timed here."""
        self.numbers[:] = np.frombuffer(payload, NUMBER)
        planner, seen = self.planner, dict(self.views)
        cpu_started = thread_time_ns()
        started = perf_counter_ns()
        try:
            result = planner.compute_action(seen)
        except BaseException as error:
            times = perf_counter_ns() - started, thread_time_ns() - cpu_started
            return dict(failure(error, self.views, self.problem), wall_ns=times[0], cpu_ns=times[1]), b""
        ended = perf_counter_ns()
        answer: dict[str, Any] = {"type": "action"}
        answer["wall_ns"], answer["cpu_ns"] = ended - started, thread_time_ns() - cpu_started
        try:
            if planner.diagnostics.__class__ is not dict or planner.diagnostics:
                diagnostics, planner.diagnostics = planner.diagnostics, {}
                answer["diagnostics"] = checked_diagnostics(diagnostics)
            action = checked_action(result)
        except WrongResult as wrong:
            return dict(answer, type="error", message=str(wrong), details=""), b""
        answer["shape"] = list(action.shape)
        return answer, action.tobytes()

    def close(self, header: dict[str, Any], payload: bytes) -> tuple[dict[str, Any], bytes]:  # noqa: ARG002
        """Close the planner."""
        if self.planner is not None:
            self.planner.close()
        return {"type": "closed"}, b""


class TooLittle(Exception):  # noqa: N818 - its text is the whole message
    """A limit that leaves nothing to the planner."""


def limit_memory(megabytes: int) -> None:
    """Limit the address space. Raises TooLittle when more is taken already."""
    import resource

    np.random.seed(0)  # noqa: NPY002 - imports it, which takes some
    try:
        with open("/proc/self/statm") as file:  # noqa: PTH123
            taken = int(file.read().split()[0]) * resource.getpagesize() // BYTES_PER_MB
    except OSError:
        taken = 0  # no Linux
    if taken >= megabytes:
        raise TooLittle(
            "memory_mb: found %d; an interpreter with NumPy alone takes %d here" % (megabytes, taken)  # noqa: UP031
        )
    resource.setrlimit(resource.RLIMIT_AS, (megabytes * BYTES_PER_MB,) * 2)


class Surroundings:
    """What the planner found in its process: every trial finds it again."""

    def __init__(self) -> None:
        self._folder = os.getcwd()  # noqa: PTH109
        self._environment = dict(os.environ)
        self._floats = np.geterr()

    def put_back(self, seed: int) -> None:
        """Put it back; global random numbers begin at a seed."""
        os.chdir(self._folder)
        if dict(os.environ) != self._environment:
            os.environ.clear()
            os.environ.update(self._environment)
        np.seterr(**self._floats)
        np.random.seed(seed % 2**32)  # noqa: NPY002 - a planner's business
        random.seed(seed)


def checked_action(result: Any) -> Any:
    """A planner's result as a float64 array of any shape."""
    try:
        array = np.asarray(result)
        if array.dtype.kind not in "fiu":
            raise TypeError("its elements are " + str(array.dtype))
        return np.ascontiguousarray(array, dtype=NUMBER).reshape(array.shape)
    except (TypeError, ValueError) as error:
        raise WrongResult(
            "compute_action returned " + short(result) + ", which is no array of real numbers: " + str(error)
        ) from None


def checked_diagnostics(diagnostics: Any) -> dict[str, float]:
    """Diagnostics with floats for values."""
    try:
        checked = {key: float(value) for key, value in diagnostics.items()}
        if not all(isinstance(key, str) for key in checked):
            raise TypeError("its keys must be text")
    except (AttributeError, OverflowError, TypeError, ValueError) as error:
        raise WrongResult(
            "self.diagnostics is " + short(diagnostics) + ", which is no dict[str, float]: " + str(error)
        ) from None
    return checked


def short(value: Any) -> str:
    """A value as text that fits into a message."""
    text = repr(value)
    return text if len(text) <= SHOWN else text[: SHOWN - 3] + "..."


def failure(error: BaseException, observation: Any, problem: Any) -> dict[str, Any]:
    """What is told of an exception: its kind, one line, its traceback."""
    bases = {cls.__name__ for cls in type(error).__mro__}
    on_purpose = "LpbError" in bases or isinstance(error, TooLittle)
    frames = error.__traceback__
    while frames is not None and frames.tb_frame.f_code.co_filename.startswith(OF_OURS):
        frames = frames.tb_next
    return {
        "type": "infeasible" if on_purpose and "Infeasible" in bases else "error",
        "message": in_one_line(error, on_purpose) + importing.hint(error, observation, problem),
        "details": "" if on_purpose else "".join(traceback.format_exception(type(error), error, frames)),
    }


def in_one_line(error: BaseException, on_purpose: bool) -> str:
    """Type and text of an exception, and the file and line of the planner that raised it."""
    try:
        text = str(error)
    except BaseException as unshown:
        text = "(its text cannot be shown: " + type(unshown).__name__ + ")"
    name = type(error).__name__
    told = text and (on_purpose or isinstance(error, ImportError))
    line = (text if told else name + ": " + text if text else name).replace("\n", " ")
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if os.path.isfile(frame.filename)]  # noqa: PTH113
    if isinstance(error, (ImportError, SyntaxError)) or not frames or importing.is_ours(frames[-1].filename):
        return line
    return line + " (" + frames[-1].filename + ":" + str(frames[-1].lineno) + ")"


def serve(stream: Any) -> None:
    """Answer until the other side is gone."""
    sys.stdin = open(os.devnull)  # noqa: PTH123, SIM115 - a planner that asks for input gets none
    warnings.simplefilter("default")
    importing.begin()
    server, process = Server(), os.getpid()
    while True:
        try:
            header, payload = stream.receive()
        except EOFError:
            return
        try:
            reply = getattr(server, header["type"])(header, payload)
        except BaseException as error:
            reply = failure(error, {}, server.problem), b""
        if os.getpid() != process:
            os._exit(0)  # a planner has forked, and this is not the process that was asked
        if reply is not None:
            stream.send(*reply)
