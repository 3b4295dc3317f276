"""Runs one trial and gives back its raw data."""

from __future__ import annotations

import os
from time import perf_counter_ns
from typing import Any

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.environment.monitor import Violation
from pytest_lpb.errors import Infeasible, UnsupportedError
from pytest_lpb.isolation.far.support import refusal
from pytest_lpb.planner.base import Planner, PlannerProblem
from pytest_lpb.planner.configuration import recorded
from pytest_lpb.planner.elsewhere import IsolatedPlanner
from pytest_lpb.problem.hashing import hash_of_arrays
from pytest_lpb.problem.problem import Problem
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial import read_only
from pytest_lpb.trial.columns import NS_PER_MS, columns_of
from pytest_lpb.trial.criteria import failed_criteria
from pytest_lpb.trial.debugger import DebuggerQuitError, pass_on_quit
from pytest_lpb.trial.guard import EVERYTHING, UserInterruptError, end_if_forked, guarded
from pytest_lpb.trial.holder import PlannerHolder
from pytest_lpb.trial.loop import Log, ended, log_between_rows, log_row, outcome_of, run_loop, undisturbed
from pytest_lpb.trial.message import outcome_message
from pytest_lpb.trial.outcome import INFEASIBLE, SUCCESS
from pytest_lpb.trial.specification import TrialSpecification, usable_cores

SCHEMA_VERSION = 1
NS_PER_S = 1e9


def run_trial(
    specification: TrialSpecification, holder: PlannerHolder | None = None, render_mode: str | None = None
) -> Trajectory:
    """Run one trial. Same specification, same raw data to the last bit (but for times measured).

    Raises UnsupportedError when the planner does not take the problem, as it declares: there is no trial then.
    What a debugger raises when it is left within the planner passes through, and there is no trial then.

    Args:
        specification: the concrete problem and the planner's configuration.
        holder: has the planner instance to use again; default a new one, closed at the end. What the planner raised
            is left in its `error`.
        render_mode: `human` shows the trial in real time.
    """
    problem = Problem.from_dict(specification.problem, specification.scenario)
    identity = problem.problem_hash  # before the planner has seen anything
    configuration = specification.planner
    own = PlannerHolder(configuration) if holder is None else None
    if reason := configuration.unsupported(problem.robot.entry):
        raise UnsupportedError(reason)
    parameters = configuration.parameters_for(problem.robot.name, problem.control)
    every, delay = configuration.steps_per_call(problem.dt), configuration.steps_of_delay(problem.dt)
    environment = ScenarioEnvironment(
        problem=problem,
        render_mode=render_mode,
        preview=configuration.preview_for(parameters),
        reuse_observations=True,
    )
    try:
        started = perf_counter_ns()
        planner = _built(holder or own)
        # One elsewhere cannot change this process, in which threads serve it.
        with guarded(problem.seed, keep=EVERYTHING if isinstance(planner, IsolatedPlanner) else ()) as changes:
            told = PlannerProblem.of(problem, every * problem.dt)
            ready = planner if isinstance(planner, Log) else _set_up(planner, parameters, told)
            setup_ms = (perf_counter_ns() - started) / NS_PER_MS
            log = ready if isinstance(ready, Log) else run_loop(environment, ready, every, delay, told)
        log.details = "\n".join(filter(None, [log.details.rstrip(), *changes]))
        if not log.q:
            log_row(log, environment)
        log_between_rows(log, environment)
        violation = environment.monitor.violation
        if holder is not None:
            holder.error = log.error
    except UserInterruptError:
        raise KeyboardInterrupt from None
    except DebuggerQuitError as quit_:
        raise quit_.__cause__ or quit_ from None
    finally:
        environment.close()
        if own is not None:
            own.close()
    metadata = _metadata(specification, identity, log)
    metadata |= {
        "setup_ms": setup_ms,
        "period_s": every * problem.dt,
        "parameters": recorded(parameters),
    }
    return _judged(Trajectory(columns_of(problem, log), metadata, problem), metadata, violation, log)


def failed_trial(specification: TrialSpecification, outcome: str, message: str) -> Trajectory:
    """A trial without rows: its problem could not be drawn, or its process died."""
    problem = Problem.from_dict(specification.problem, specification.scenario)
    log = Log(outcome=outcome)
    metadata = _metadata(specification, problem.problem_hash, log)
    metadata |= {"setup_ms": None, "period_s": None, "parameters": {}, "message": message}
    metadata |= {"success": False, "failed_criteria": [], "trajectory_hash": ""}
    return Trajectory(columns_of(problem, log), metadata, problem)


def _built(holder: PlannerHolder | None) -> Planner | Log:
    """The planner; or the log of a trial that ends there, since its constructor raised."""
    assert holder is not None
    try:
        return holder.get()
    except UserInterruptError:
        raise
    except BaseException as error:
        pass_on_quit(error)
        # Whatever a planner raises is that trial's outcome, not the end of a study.
        return ended(Log(), outcome_of(error), error)


def _set_up(planner: Planner, parameters: Any, problem: PlannerProblem) -> Planner | Log:
    """The planner, set up; or the log of a trial that ends there, since its setup raised."""
    process = os.getpid()
    try:
        planner.parameters = parameters
        planner.diagnostics = {}
        with undisturbed():
            if reason := refusal(planner, problem):
                raise UnsupportedError(reason)
            planner.setup(problem)
    except Infeasible as error:
        return ended(Log(), INFEASIBLE, error)
    except (UserInterruptError, UnsupportedError):
        raise
    except BaseException as error:
        pass_on_quit(error)
        log = ended(Log(), outcome_of(error), error)
        log.fault += read_only.hint(error, {}, problem)
        return log
    finally:
        end_if_forked(process)
    return planner


def _metadata(specification: TrialSpecification, problem_hash: str, log: Log) -> dict[str, Any]:
    configuration = specification.planner
    return {
        "schema_version": SCHEMA_VERSION,
        "node_id": specification.node_id,
        "scenario": specification.scenario,
        "planner": configuration.name,
        "seed": specification.seed,
        "attempt": specification.attempt,
        "command": specification.command,
        "outcome": log.outcome,
        "details": log.details,
        "wall_s": log.loop_ns / NS_PER_S if log.loop_ns else None,
        "workers": specification.workers,
        "cores": usable_cores(),
        "parameters_hash": configuration.parameters_hash,
        "problem_hash": problem_hash,
    }


def _judged(trajectory: Trajectory, metadata: dict[str, Any], violation: Violation | None, log: Log) -> Trajectory:
    """Add what follows from the raw data: the hash, the message, the criteria of success."""
    arrays = (trajectory.t, trajectory.q, trajectory.qd, trajectory.action)
    if violation is not None and violation.time is not None:
        metadata["contact_time_s"] = violation.time
    metadata["trajectory_hash"] = hash_of_arrays(arrays)
    message = outcome_message(trajectory, violation, log.fault)
    failed = failed_criteria(trajectory) if log.outcome == SUCCESS else []
    metadata["message"] = f"{message}; but not {', '.join(failed)}" if failed else message
    metadata["failed_criteria"] = failed
    metadata["success"] = log.outcome == SUCCESS and not failed
    return trajectory
