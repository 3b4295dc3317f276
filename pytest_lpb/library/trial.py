"""One trial as a function call: the same numbers as the trial that pytest runs."""

from __future__ import annotations

import os
import shlex
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from operator import index
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from pytest_lpb.errors import LpbError, ScenarioError
from pytest_lpb.library.evaluate import registered_kpis
from pytest_lpb.library.planners import AnyPlanner, load_planner
from pytest_lpb.library.recording import Recorder
from pytest_lpb.names import listed, suggestion
from pytest_lpb.planner.base import Planner
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.draw import PARTS, check_feasible, draw_problem
from pytest_lpb.scenario.load import Scenario, load_scenario
from pytest_lpb.scenario.schema.success import MAX_SEED
from pytest_lpb.study.family import scenario_key
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial import trial
from pytest_lpb.trial.holder import PlannerHolder
from pytest_lpb.trial.specification import TrialSpecification

AnyScenario = str | Path | Scenario | Problem

# Loops over seeds with one Scenario check it once: inverse kinematics takes longer than drawing a problem.
_checked_scenarios: deque[tuple[Scenario, tuple[str, ...]]] = deque(maxlen=16)


def run_trial(
    scenario: AnyScenario | TrialSpecification,
    planner: AnyPlanner | None = None,
    seed: int | None = None,
    *,
    draw: Sequence[str] = (),
    folder: str | Path | None = None,
    render: bool = False,
) -> Trajectory:
    """Run one trial: same raw data, outcome and hashes as `pytest --lpb-planners=PLANNER --lpb-seed=SEED SCENARIO`.

    Whatever a planner does wrong is the trial's outcome (`trajectory.outcome`, `trajectory.metadata["message"]`), never
    an exception. One trial at a time per process: to run several at once, use processes.

    Args:
        scenario: path of a scenario file, a Scenario of `load_scenario`, or a concrete Problem.
        planner: a name, the path of a planner file, `module:Class`, a class, an instance (used as it is, left open),
            or what `load_planner` returned.
        seed: which problem of the scenario; None: the scenario's first. Of a concrete problem: its own.
        draw: parts to draw besides those that the scenario draws: "start", "goal", "obstacles".
        folder: a run folder to write the trial into, made if it is not there; None: nothing is written.
        render: whether to show the trial in a window, in real time.

    Returns:
        Raw data at N + 1 times t = k dt: `t` (N + 1,) [s], `q` (N + 1, dof) [rad or m], `action` (N + 1, n_actions), ..

    Raises ScenarioError for a scenario that cannot be used or drawn from, ConfigurationError for a planner,
    UnsupportedError for a problem that the planner declares not to support, RecordingError for a folder, LpbError for
    other arguments.
    """
    if isinstance(scenario, TrialSpecification):
        if planner is not None or seed is not None:
            raise LpbError("run_trial: a TrialSpecification says planner and seed itself; give it alone")
        specification, source = scenario, None
    else:
        specification, source = _specification(scenario, planner, seed, draw)
    recorder = None
    if folder is not None:
        problem_hash = Problem.from_dict(specification.problem).problem_hash
        recorder = Recorder(Path(folder), specification, problem_hash, source)
    holder = PlannerHolder(specification.planner)
    try:
        with threadpool_limits(limits=1):  # as in pytest: sums of several threads may differ in their last bits
            trajectory = trial.run_trial(specification, holder, "human" if render else None)
    finally:
        if not isinstance(planner, Planner):
            holder.close()
    if recorder is not None:
        recorder.write(trajectory)
    return trajectory


@dataclass(frozen=True)
class _Drawn:
    """A problem and where it is from."""

    problem: Problem
    key: str
    node: str  # node id of the scenario
    path: Path | None


def _specification(
    scenario: AnyScenario, planner: AnyPlanner | None, seed: int | None, draw: Sequence[str]
) -> tuple[TrialSpecification, Path | None]:
    """The trial to run, and its scenario file if it has one."""
    if planner is None:
        raise LpbError("run_trial: planner: missing; give a name, a planner file, a class or an instance")
    registered_kpis()  # a scenario's criteria of success name some
    configuration = load_planner(planner)
    drawn = _drawn(scenario, _checked_seed(seed), _checked_parts(draw))
    problem = drawn.problem
    configuration.steps_per_call(problem.dt)
    configuration.steps_of_delay(problem.dt)
    configuration.parameters_for(problem.robot.name, problem.control)
    specification = TrialSpecification(
        problem=problem.to_dict(),
        planner=configuration,
        scenario=drawn.key,
        node_id=f"{drawn.node}::{configuration.name}::seed{problem.seed}",
        command=_command(planner, configuration, drawn, draw),
    )
    return specification, drawn.path


def _drawn(scenario: AnyScenario, seed: int | None, draw: tuple[str, ...]) -> _Drawn:
    if isinstance(scenario, Problem):
        if seed not in (None, scenario.seed) or draw:
            raise LpbError(f"run_trial: this problem is that of seed {scenario.seed}; only a scenario has others")
        name = scenario.name or "problem"
        return _Drawn(scenario, name, name, None)
    if not isinstance(scenario, Scenario | str | Path):
        raise LpbError(
            f"run_trial: scenario: found {scenario!r}; allowed: the path of a scenario file, "
            "what load_scenario returned, or a pytest_lpb.Problem"
        )
    loaded = scenario if isinstance(scenario, Scenario) else load_scenario(Path(scenario))
    if not any(known is loaded and parts == draw for known, parts in _checked_scenarios):
        _check_criteria(loaded)
        check_feasible(loaded, draw)
        _checked_scenarios.append((loaded, draw))
    path = Path(os.path.normpath(Path.cwd() / loaded.path))
    key = scenario_key(path, Path.cwd())
    problem = draw_problem(loaded, loaded.seed if seed is None else seed, draw, key)
    return _Drawn(problem, key, Path(os.path.relpath(path)).as_posix(), path)


def _check_criteria(scenario: Scenario) -> None:
    for name in scenario.success.criteria:
        try:
            registered_kpis().select([name])
        except LpbError as error:
            raise ScenarioError(f"{scenario.place(('success', name))}: success: {error}") from error


def _checked_seed(seed: int | None) -> int | None:
    if seed is None:
        return None
    try:
        number = -1 if isinstance(seed, bool) else index(seed)
    except TypeError:
        number = -1
    if not 0 <= number <= MAX_SEED:
        raise LpbError(f"run_trial: seed: found {seed!r}; allowed: a whole number from 0 to {MAX_SEED}")
    return number


def _checked_parts(draw: Any) -> tuple[str, ...]:
    parts = (draw,) if isinstance(draw, str) else tuple(draw)
    for part in parts:
        if part not in PARTS:
            hint = suggestion(part, PARTS) if isinstance(part, str) else ""
            raise LpbError(f"run_trial: draw: found {part!r}{hint}; allowed: {listed(PARTS)}")
    return parts


def _command(planner: AnyPlanner, configuration: PlannerConfiguration, drawn: _Drawn, draw: Sequence[str]) -> str:
    """What runs the trial again from here; empty when only Python can."""
    named = isinstance(planner, str) and planner == configuration.name
    reference = configuration.name if named else _reference(configuration)
    if drawn.path is None or not reference:
        return ""
    flags = [f"--lpb-random-{part}" for part in draw]
    seed = f"--lpb-seed={drawn.problem.seed}"
    return shlex.join(["pytest", f"--lpb-planners={reference}", seed, "--lpb-trials=1", *flags, drawn.node])


def _reference(configuration: PlannerConfiguration) -> str:
    path = configuration.path
    if path is None:
        return ""
    shown = os.path.relpath(path)
    return shown if path.stem == configuration.name else f"{configuration.name}={shown}"
