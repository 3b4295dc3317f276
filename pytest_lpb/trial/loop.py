"""The trial loop: observe, ask the planner, act. Only the planner's call is on the clock."""

from __future__ import annotations

import gc
import os
import traceback
import warnings
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from math import inf, isfinite
from time import perf_counter_ns, thread_time_ns
from typing import Any

import numpy as np

from pytest_lpb.environment.between_rows import Rows, least_on_the_way
from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.errors import DeadlineError, Infeasible, LpbError, PlannerError, in_one_line
from pytest_lpb.planner.base import Planner, PlannerProblem
from pytest_lpb.planner.elsewhere import IsolatedPlanner
from pytest_lpb.trial import read_only
from pytest_lpb.trial.debugger import pass_on_quit, planner_frames
from pytest_lpb.trial.guard import UserInterruptError, end_if_forked
from pytest_lpb.trial.outcome import DEADLINE, ENVIRONMENT_ERROR, INFEASIBLE, PLANNER_ERROR

MAX_FAULT = 1_000  # characters of a message
MAX_DETAILS = 20_000  # characters of a traceback


@dataclass
class Log:
    """What a trial leaves behind: one entry per row, one per step, one per planner call."""

    q: list[list[float]] = field(default_factory=list)
    qd: list[list[float]] = field(default_factory=list)
    u: list[list[float]] = field(default_factory=list)
    goal_errors: list[list[float]] = field(default_factory=list)
    clearance: list[tuple[float, str, str]] = field(default_factory=list)
    self_clearance: list[float] = field(default_factory=list)
    step_clearance: list[float] = field(default_factory=list)  # the least on the way to each row
    self_step_clearance: list[float] = field(default_factory=list)
    action: list[list[float]] = field(default_factory=list)
    applied: list[list[float]] = field(default_factory=list)
    call_row: list[int] = field(default_factory=list)
    call_wall_ns: list[int] = field(default_factory=list)
    call_cpu_ns: list[int] = field(default_factory=list)
    diagnostics: list[dict[str, float]] = field(default_factory=list)
    outcome: str = ""
    fault: str = ""  # what went wrong in the software, in one line
    details: str = ""  # its traceback
    error: BaseException | None = None  # what the planner raised, with its frames
    loop_ns: int = 0
    process: int = field(default_factory=os.getpid)


@contextmanager
def undisturbed() -> Iterator[None]:
    """No garbage collection while a trial runs, and no warning that ends it.

    Warnings are still shown, but filters such as `-W error` do not decide how a planner fares.
    """
    enabled = gc.isenabled()
    gc.disable()
    gc.freeze()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("default")
            yield
    finally:
        gc.unfreeze()
        if enabled:
            gc.enable()


def run_loop(
    environment: ScenarioEnvironment,
    planner: Planner,
    every: int,
    delay: int,
    problem: PlannerProblem | None = None,
) -> Log:
    """Run a trial that `environment.reset` and `planner.setup` have prepared.

    Args:
        environment: at row 0, handing out its own arrays.
        planner: asked at every `every`-th row; between, its last action is held.
        every: steps per call.
        delay: steps by which actions act later; the robot is given zeros before the first.
        problem: what the planner was told, for messages.
    """
    log = Log()
    with undisturbed():
        started = perf_counter_ns()
        log_row(log, environment)
        try:
            _steps(log, environment, planner, every, delay)
        except Infeasible as error:
            ended(log, INFEASIBLE, error)
        except (_PlannerFaultError, PlannerError) as error:
            cause = error.__cause__ if isinstance(error, _PlannerFaultError) and error.__cause__ else error
            ended(log, outcome_of(cause), cause)
            log.fault += read_only.hint(cause, environment.observe(), problem)
        except Exception as error:
            # A simulator may fail in any way on any input; the trial ends, its rows so far are kept.
            ended(log, ENVIRONMENT_ERROR, error)
        log.loop_ns = perf_counter_ns() - started
    log.outcome = log.outcome or environment.outcome or ""
    return log


def shortened(text: str) -> str:
    """Beginning and end of a text that is too long to keep in every table."""
    if len(text) <= MAX_DETAILS:
        return text
    half = MAX_DETAILS // 2
    return f"{text[:half]}\n[{len(text) - MAX_DETAILS} characters left out]\n{text[-half:]}"


class _PlannerFaultError(Exception):
    """A planner raised; the cause says what."""


def _steps(log: Log, environment: ScenarioEnvironment, planner: Planner, every: int, delay: int) -> None:
    size = environment.problem.robot.n_actions
    observation = environment.observe()
    waiting: deque[list[float]] = deque([[0.0] * size] * delay)
    wanted: list[float] = []
    while not environment.ended:
        row = environment.row
        if row % every == 0:
            wanted = _call(log, planner, observation, row, size)
        waiting.append(wanted)
        action = waiting.popleft()
        environment.advance(action)
        log.action.append(action)
        log.applied.append(environment.applied)
        log_row(log, environment)


def _call(log: Log, planner: Planner, observation: Any, row: int, size: int) -> list[float]:
    """One call of the planner, timed; its action as finite numbers."""
    seen = dict(observation)  # what a planner puts into or takes out of it is not there at the next call
    cpu_started = thread_time_ns()
    started = perf_counter_ns()
    try:
        result = planner.compute_action(seen)
    except (Infeasible, UserInterruptError):
        raise
    except BaseException as error:
        pass_on_quit(error)
        # Whatever else a planner raises is that trial's outcome, not the end of a study.
        raise _PlannerFaultError from error
    finally:
        end_if_forked(log.process)
        ended = perf_counter_ns()
        cpu_ended = thread_time_ns()
        log.call_row.append(row)
        # The clock of a planner elsewhere is that of its own process.
        far = planner if isinstance(planner, IsolatedPlanner) else None
        wall_ns, cpu_ns = (far and far.measured_ns) or (ended - started, cpu_ended - cpu_started)
        log.call_wall_ns.append(wall_ns)
        log.call_cpu_ns.append(cpu_ns)
        log.diagnostics.append({})
    try:
        if planner.diagnostics.__class__ is not dict or planner.diagnostics:
            log.diagnostics[-1] = checked_diagnostics(planner.diagnostics)
            planner.diagnostics = {}
        if far is not None and far.round_trip_ms is not None:
            log.diagnostics[-1]["round_trip_ms"] = far.round_trip_ms
        return checked_action(result, size)
    except (PlannerError, UserInterruptError):
        raise
    except BaseException as error:
        pass_on_quit(error)
        # Objects of a planner's own may raise whenever they are looked at.
        raise _PlannerFaultError from error


def checked_diagnostics(diagnostics: Any) -> dict[str, float]:
    """A planner's diagnostics with floats for values. Raises PlannerError for what is not a number by name."""
    __tracebackhide__ = True  # a debugger stops where the planner was called
    try:
        checked = {key: float(value) for key, value in diagnostics.items()}
        if not all(isinstance(key, str) for key in checked):
            raise TypeError("its keys must be text")
    except (AttributeError, OverflowError, TypeError, ValueError) as error:
        raise PlannerError(
            f"self.diagnostics is {_short(diagnostics)}, which is no dict[str, float]: {error}"
        ) from None
    return checked


def checked_action(result: Any, size: int) -> list[float]:
    """A planner's result as a list of finite numbers.

    Raises PlannerError when it is not an array of shape (size,) of finite real numbers.
    """
    __tracebackhide__ = True  # a debugger stops where the planner was called
    if not (isinstance(result, np.ndarray) and result.dtype == np.float64):
        given = result
        try:
            result = np.asarray(given)
            if result.dtype.kind not in "fiu":
                raise TypeError(f"its elements are {result.dtype}")
            result = result.astype(np.float64)
        except (TypeError, ValueError) as error:
            raise PlannerError(
                f"compute_action returned {_short(given)}, which is no array of real numbers: {error}"
            ) from None
    if result.shape != (size,):
        raise PlannerError(f"compute_action returned an array of shape {result.shape}; expected ({size},)")
    values: list[float] = result.tolist()
    if not all(map(isfinite, values)):
        raise PlannerError(f"compute_action returned {values}; every entry must be finite")
    return values


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def outcome_of(error: BaseException) -> str:
    """The outcome of a trial whose planner raised."""
    return DEADLINE if isinstance(error, DeadlineError) else PLANNER_ERROR


def log_row(log: Log, environment: ScenarioEnvironment) -> None:
    """Log the state of the environment's current row."""
    engine, monitor = environment.running_engine, environment.monitor
    log.q.append(engine.q)
    log.qd.append(engine.qd)
    log.u.append(engine.u)
    log.goal_errors.append(monitor.goal_errors)
    log.clearance.append(monitor.clearance)
    log.self_clearance.append(monitor.self_clearance[0])


def log_between_rows(log: Log, environment: ScenarioEnvironment) -> None:
    """Log the least clearances on the way to each row; off the clock, after the trial."""
    engine, margin = environment.running_engine, environment.problem.safety_margin
    rows = Rows(log.q, log.u, log.applied)
    log.step_clearance = least_on_the_way(engine, rows, [distance for distance, *_ in log.clearance], margin)
    log.self_step_clearance = least_on_the_way(engine, rows, log.self_clearance, -inf, own=True)


def ended(log: Log, outcome: str, error: BaseException) -> Log:
    """The log of a trial that an error ends."""
    log.outcome = outcome
    log.fault = in_one_line(error)[:MAX_FAULT]
    log.error = error
    # What is raised on purpose says itself what is wrong; of anything else the place helps.
    frames = planner_frames(error)
    raised = traceback.format_exception(type(error), error, frames)
    log.details = shortened(getattr(error, "details", "") if isinstance(error, LpbError) else "".join(raised))
    return log
