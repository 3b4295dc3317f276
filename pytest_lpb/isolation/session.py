"""The conversation with a far process: start, setup, calls; what goes wrong becomes one trial's error."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.errors import DeadlineError, Infeasible, LpbError, PlannerError, UnsupportedError
from pytest_lpb.isolation.far.messages import NUMBER, PROTOCOL, layout_of, packed
from pytest_lpb.isolation.far.support import NO_REASON
from pytest_lpb.isolation.interpreter import Interpreter
from pytest_lpb.isolation.process import FarProcess
from pytest_lpb.isolation.program import Program
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.isolation.sources import our_sources

CLOSING_S = 1.0  # [s] that a planner has to close itself
SHOWN = 200  # characters of its output in a message
ANSWERS = {"start": ("started",), "describe": ("description",), "setup": ("ready", "robot"), "call": ("action",)}
LONGEST_NS = 2**63 - 1  # what fits into a column of whole numbers


@dataclass(frozen=True)
class Answer:
    """What a call gave, and how long it took in the far process."""

    action: NDArray[np.float64]
    diagnostics: Mapping[str, float]


class Session:
    """One planner in a process of its own, which is started when it is needed, and again when it has ended.

    Args:
        isolation: where, and within which limits.
        planner: `module:Class` or a registered name; empty for a program.
        folder: where the planner's module lies; None where the interpreter finds it by itself.
    """

    def __init__(self, isolation: Isolation, planner: str, folder: Path | None) -> None:
        self._isolation = isolation
        self._planner = planner
        self._folder = folder
        self._process: FarProcess | None = None
        self._layout: dict[str, Any] | None = None
        self.measured_ns: tuple[int, int] | None = None  # wall and CPU time of the last call, measured there

    def describe(self, parameters: list[Mapping[str, Any]]) -> dict[str, Any]:
        """What the planner's class says of itself with each of several sets of parameters, and what runs it."""
        process, until = self._started()
        header = {"type": "describe", "planner": self._planner, "parameters": parameters}
        description, _ = self._exchange(process, header, "setup", until)
        return {**description, "about": dict(process.about)}

    def set_up(
        self, problem: Mapping[str, Any], parameters: Mapping[str, Any], robot: Callable[[], Mapping[str, Any]]
    ) -> None:
        """Prepare for a trial. `robot` describes the problem's robot, for those who cannot build it.

        Raises UnsupportedError, Infeasible, DeadlineError or PlannerError.
        """
        process, until = self._started()
        header = {"type": "setup", "planner": self._planner, "problem": problem, "parameters": parameters}
        if self._isolation.command:
            header["robot"] = robot()
        answer, _ = self._exchange(process, header, "setup", until)
        if answer["type"] == "robot":
            self._exchange(process, {**header, "robot": robot()}, "setup", until)
        self._layout = None

    def act(self, observation: Mapping[str, Any]) -> Answer:
        """The answer to an observation. Raises Infeasible, DeadlineError or PlannerError."""
        self.measured_ns = None
        process = self._process
        if process is None:
            raise PlannerError("the planner's process has ended; setup starts another")
        limit = self._isolation.deadline_s
        until = None if limit is None else monotonic() + limit
        if self._layout is None:
            self._layout = layout_of(observation)
            self._guarded(process, lambda: process.send({"type": "observation", "arrays": self._layout}, b"", limit))
        answer, payload = self._exchange(process, {"type": "call"}, "call", until, packed(observation))
        diagnostics = answer.get("diagnostics", {})
        if not isinstance(diagnostics, dict):
            raise self._broken(process, f"wrote diagnostics {diagnostics!r}; names with numbers are expected")
        shape = answer.get("shape", [len(payload) // NUMBER.itemsize])
        try:
            return Answer(np.frombuffer(payload, NUMBER).reshape(shape).astype(np.float64), diagnostics)
        except (TypeError, ValueError) as error:
            raise self._broken(process, f"wrote an action of shape {shape} in {len(payload)} bytes: {error}") from None

    def close(self) -> None:
        """Let the planner close itself, then end the process."""
        process = self._process
        if process is None:
            return
        try:
            process.send({"type": "close"}, b"", CLOSING_S)
            process.receive(CLOSING_S)
        except (EOFError, TimeoutError, ValueError):
            pass  # it is ended in any case
        finally:
            self.abandon()

    def abandon(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()

    def _started(self) -> tuple[FarProcess, float | None]:
        """The process, and until when it must be set up."""
        limit = self._isolation.setup_deadline_s
        until = None if limit is None else monotonic() + limit
        if self._process is None:
            process: FarProcess
            process = Program(self._isolation) if self._isolation.command else Interpreter(self._isolation)
            self._process = process
            try:
                self._exchange(process, self._start(), "setup", until)
            except LpbError:
                self.abandon()  # the next trial starts another, and is told the same
                raise
        return self._process, until

    def _start(self) -> dict[str, Any]:
        isolation = self._isolation
        start = {"type": "start", "protocol": PROTOCOL}
        if isolation.command:
            return start
        here = isolation.same_interpreter
        folders = [isolation.working_dir or ("." if isolation.ssh else str(Path.cwd())), *filter(None, [self._folder])]
        return {
            **start,
            "memory_mb": isolation.memory_mb,
            "working_dir": isolation.working_dir,
            "path": list(sys.path) if here else [str(folder) for folder in folders],
            "whole_path": here,
            "sources": None if here else our_sources(),
        }

    def _exchange(
        self, process: FarProcess, header: Mapping[str, Any], what: str, until: float | None, payload: bytes = b""
    ) -> tuple[dict[str, Any], bytes]:
        """Send a message and receive its answer, by a time."""

        def talk() -> tuple[dict[str, Any], bytes]:
            process.send(header, payload, _left(until))
            return process.receive(_left(until))

        answer, numbers = self._guarded(process, talk, what)
        if "wall_ns" in answer:
            times = (answer["wall_ns"], answer.get("cpu_ns", answer["wall_ns"]))
            if not all(isinstance(time, int) and 0 <= time <= LONGEST_NS for time in times):
                raise self._broken(process, f"wrote wall_ns, cpu_ns = {times}; whole nanoseconds are expected")
            self.measured_ns = times
        kind = answer.get("type")
        if kind == "infeasible":
            raise Infeasible(str(answer.get("message", "")))
        if kind == "unsupported" and header["type"] == "setup":
            raise UnsupportedError(str(answer.get("message", "")) or NO_REASON)
        if kind == "error":
            raise PlannerError(self._with_limits(str(answer.get("message", ""))), str(answer.get("details", "")))
        if not isinstance(kind, str):
            raise self._broken(process, "answered with a header without `type`")
        asked = header["type"]
        if kind not in ANSWERS[asked]:
            raise self._broken(process, f"answered a {asked} with {kind!r}; `{ANSWERS[asked][0]}` is expected")
        return answer, numbers

    def _guarded(self, process: FarProcess, talk: Callable[[], Any], what: str = "call") -> Any:
        """Talk to the process; whatever ends the talk ends the process too, and says why."""
        try:
            return talk()
        except TimeoutError:
            raise self._late(what) from None
        except EOFError:
            raise self._ended(process) from None
        except ValueError as error:
            raise self._broken(process, f"wrote what is no message: {error}") from None
        except BaseException:
            self.abandon()  # such as Ctrl-C: what it would answer next nobody knows
            raise

    def _late(self, what: str) -> DeadlineError:
        key, limit, doing = {
            "call": ("deadline_s", self._isolation.deadline_s, "compute_action"),
            "setup": ("setup_deadline_s", self._isolation.setup_deadline_s, "start and setup"),
        }[what]
        self.abandon()
        return DeadlineError(f"{doing} took longer than {key} = {limit:g} s; the planner's process was ended")

    def _ended(self, process: FarProcess) -> PlannerError:
        how = process.ending() or "ended"
        self.abandon()
        return self._told(process, self._with_limits(f"the planner's process {how}"))

    def _broken(self, process: FarProcess, what: str) -> PlannerError:
        self.abandon()
        return self._told(process, f"{self._isolation.place} {what}")

    def _told(self, process: FarProcess, text: str) -> PlannerError:
        """An error with the last words of the process."""
        output = process.output()
        last = output.rpartition("\n")[2][-SHOWN:]
        details = f"the last that the planner's process printed:\n{output}" if output != last else ""
        return PlannerError(f"{text}; its last words: {last}" if last else text, details)

    def _with_limits(self, text: str) -> str:
        memory = self._isolation.memory_mb
        hint = memory and ("MemoryError" in text or "process" in text)
        return f"{text} (memory_mb: {memory})" if hint else text


def _left(until: float | None) -> float | None:
    return None if until is None else max(0.0, until - monotonic())
