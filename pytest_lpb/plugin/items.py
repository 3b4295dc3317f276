"""The collector of a planner, which owns its instance, and the item of a seed, which runs one trial."""

from __future__ import annotations

import tempfile
from bdb import BdbQuit
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, cast

import pytest
from threadpoolctl import threadpool_limits

from pytest_lpb.documents.atomic import STORAGE_FAULTS, recording_error, write_once
from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.errors import LpbError, RecordingError, ScenarioError, StorageError, UnsupportedError
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.plugin.expectation import Expectation, known_failure
from pytest_lpb.plugin.raised import Raised, advice
from pytest_lpb.plugin.session import session_of, without_group
from pytest_lpb.run.faults import cause_and_time
from pytest_lpb.run.plan import DAMAGED, TrialKey
from pytest_lpb.run.skipped import write_skip
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.study.family import Family
from pytest_lpb.trajectory import Trajectory
from pytest_lpb.trial.assets import recorded_beside
from pytest_lpb.trial.files import read_trial, trial_path, write_trial
from pytest_lpb.trial.holder import PlannerHolder
from pytest_lpb.trial.outcome import ENVIRONMENT_ERROR, SOFTWARE_FAULTS, WORKER_CRASH
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import failed_trial, run_trial

if TYPE_CHECKING:
    from pytest_lpb.plugin.scenarios import ScenarioCollector, ScenarioFile


class TrialFailure(Exception):  # noqa: N818 - a verdict on a planner, not an error of the software
    """A trial that did not meet its scenario's success criteria; its text is the whole report."""


class ExpectedTrialFailure(TrialFailure):
    """A failure that the scenario's or the planner's xfail data names."""


class PlannerCollector(pytest.Collector):
    """One scenario with one planner: builds the planner once for all its seeds."""

    def __init__(self, *, configuration: PlannerConfiguration, **keywords: Any) -> None:
        super().__init__(**keywords)
        self.configuration = configuration
        self.holder = PlannerHolder(configuration)
        self.known_failure = known_failure(self.family.scenario(), configuration, self.family.key)
        self._stack = ExitStack()

    @property
    def family(self) -> Family:
        """The scenario above."""
        return cast("ScenarioFile | ScenarioCollector", self.parent).family

    def collect(self) -> Iterator[TrialItem]:
        """One item per seed."""
        for seed in session_of(self.config).seeds(self.family):
            yield TrialItem.from_parent(self, name=f"seed{seed}", seed=seed)

    def setup(self) -> None:
        """One thread for linear algebra: what a planner gains by more depends on who else runs."""
        self._stack.enter_context(threadpool_limits(limits=1))
        self._stack.callback(self.holder.close)

    def teardown(self) -> None:
        """Close the planner."""
        self._stack.close()


class TrialItem(pytest.Item):
    """One trial: (scenario, planner, seed)."""

    def __init__(self, *, seed: int, **keywords: Any) -> None:
        super().__init__(**keywords)
        self.seed = seed
        self.trajectory: Trajectory | None = None
        self.unsupported = ""  # why the planner does not take the problem
        known = self.collector.known_failure
        self.expectation: Expectation | None = known if known is not None and known.concerns(seed) else None
        if self.expectation is not None:
            self.add_marker(
                pytest.mark.xfail(reason=self.expectation.reason, raises=ExpectedTrialFailure, strict=False)
            )

    @property
    def collector(self) -> PlannerCollector:
        """The planner's collector."""
        return cast(PlannerCollector, self.parent)

    @property
    def key(self) -> TrialKey:
        """Scenario, planner and seed."""
        return TrialKey(self.collector.family.key, self.collector.name, self.seed)

    def setup(self) -> None:
        """Skip a trial of what the planner declares not to support: that is decided without drawing its problem."""
        try:
            robot = self.collector.family.scenario(self.seed).concrete["robot"]
        except ScenarioError:
            return  # a recorded problem that is damaged: the trial itself reports it
        if reason := self.collector.configuration.unsupported(robot):
            self._skip(reason)

    def _skip(self, reason: str) -> NoReturn:
        """Note that the planner does not take this problem, and skip the trial."""
        self.unsupported = reason
        write_skip(session_of(self.config).run, self.key, reason)
        pytest.skip(f"{self.collector.name} does not support it: {reason}")

    def runtest(self) -> None:
        """Run the trial, write its files, then judge it."""
        options = session_of(self.config)
        self._refuse_to_crash_again()
        # A trial that is finished already is judged as it was recorded.
        finished = options.planned is not None and self._trial_path().exists()
        self.trajectory = trajectory = self._recorded() if finished else self._run_and_record()
        if trajectory.metadata["success"]:
            return
        expected, known = self._foretold(trajectory), self._is_known(trajectory)
        if not known and not self._fails(trajectory.outcome):
            return
        cause, at = cause_and_time(trajectory.metadata["message"])
        repeat = f"repeat: {trajectory.metadata['command']}"
        text = "\n".join(filter(None, [f"{verdict(trajectory)}: {cause}", at, repeat]))
        planner, holder = self.collector.configuration, self.collector.holder
        error, holder.error = holder.error, None
        raised = Raised.by(error, planner, self.config)
        details = trajectory.metadata["details"].rstrip() if raised is None else raised.details(trajectory)
        parts = filter(None, [text, details, advice(planner, self.config)])
        failure = (ExpectedTrialFailure if expected else TrialFailure)("\n\n".join(parts))
        # With the planner's own frames a debugger stops in the one that raised.
        raise failure if raised is None else failure.with_traceback(raised.frames)

    def _foretold(self, trajectory: Trajectory) -> bool:
        """Whether the scenario's or the planner's xfail data name this failure."""
        return self.expectation is not None and self.expectation.covers(trajectory.outcome)

    def _is_known(self, trajectory: Trajectory) -> bool:
        """Whether the trial failed as foretold; with --runxfail a failure is a failure."""
        failed = not trajectory.metadata["success"]
        return failed and self._foretold(trajectory) and not self.config.option.runxfail

    def _refuse_to_crash_again(self) -> None:
        """Do not run a trial that took a worker down: --dist loadscope and its kin would give it to every next one."""
        path = self._trial_path()
        if not path.exists() or getattr(self.config.option, "reruns", None):
            return
        earlier = self._recorded()
        if earlier.outcome == WORKER_CRASH:
            raise TrialFailure(f"{WORKER_CRASH}: {earlier.metadata['message']}\nrepeat: {earlier.metadata['command']}")

    def _recorded(self) -> Trajectory:
        """The trial as an earlier run of it was recorded. Raises RecordingError, with what to do."""
        try:
            return read_trial(self._trial_path())
        except RecordingError as error:
            raise RecordingError(f"{error}\n{DAMAGED}") from error

    def _run_and_record(self) -> Trajectory:
        """Run the trial and write its files. When nothing can be recorded any more, no further trial is run."""
        try:
            trajectory = self._with_reason(self._run())
            write_trial(session_of(self.config).run, trajectory)
        except StorageError as error:
            raise self._last(error) from error
        except OSError as error:
            if error.errno not in STORAGE_FAULTS:
                raise
            # PyBullet, for one, is given robots in temporary files.
            where = error.filename or f"a file in {tempfile.gettempdir()}"
            raise self._last(recording_error(f"cannot write {where}", error)) from error
        return trajectory

    def _with_reason(self, trajectory: Trajectory) -> Trajectory:
        """The trial, noting why its failure is known: reports then say so without the files that foretold it."""
        if self.expectation is None or not self._is_known(trajectory):
            return trajectory
        metadata = {**trajectory.metadata, "known_failure": self.expectation.reason}
        return Trajectory(trajectory.columns, metadata, trajectory.problem)

    def _last(self, error: RecordingError) -> StorageError:
        """The error that ends the run, with what to do then."""
        self.session.shouldstop = "trials cannot be recorded any more"
        return StorageError(f"{error}, then finish the run with: {session_of(self.config).resume_command}")

    def _trial_path(self) -> Path:
        return trial_path(session_of(self.config).run, *self.key)

    def _fails(self, outcome: str) -> bool:
        return session_of(self.config).assertion == "trial" or outcome in SOFTWARE_FAULTS

    def _run(self) -> Trajectory:
        options, key = session_of(self.config), self.key.scenario
        scenario = self.collector.family.scenario(self.seed)
        specification = TrialSpecification(
            problem=scenario.concrete | {"seed": self.seed, "trials": 1},
            planner=self.collector.configuration,
            scenario=key,
            node_id=without_group(self.nodeid),
            command=self._repeat(),
            attempt=getattr(self, "execution_count", 1),
            workers=options.workers,
        )
        try:
            problem = draw_problem(scenario, self.seed, options.flags, key)
        except ScenarioError as error:
            return failed_trial(specification, ENVIRONMENT_ERROR, str(error))
        specification = specification.with_problem(problem.to_dict())
        self._write_problem(specification)
        try:
            return run_trial(specification, self.collector.holder, "human" if options.render else None)
        except UnsupportedError as error:
            self._problem_path().unlink(missing_ok=True)
            self._skip(str(error))
        except (pytest.exit.Exception, BdbQuit):
            # Somebody has left the debugger in the middle of it: it was no trial, and the run does not know of it.
            self._problem_path().unlink(missing_ok=True)
            raise

    def _problem_path(self) -> Path:
        return self._trial_path().with_suffix(".yaml")

    def _write_problem(self, specification: TrialSpecification) -> None:
        """Write the concrete problem first: it is there even when the trial takes its process down."""
        source = f"{self.parent.parent.nodeid}, seed {self.seed}"  # type: ignore[union-attr] # a scenario file
        path = self._problem_path()
        problem = recorded_beside(specification.problem, session_of(self.config).run, path.parent)
        write_once(path, dump_yaml({**problem, "source": source}).encode())

    def _repeat(self) -> str:
        return session_of(self.config).repeat_command(self.nodeid, self.collector.name, self.seed)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """A failed trial, or a file that cannot be used, in words; anything else as pytest shows it."""
        if isinstance(excinfo.value, TrialFailure | LpbError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Any, int, str]:
        """Place and title of the trial in reports."""
        return self.path, 0, f"{self.key.scenario} :: {self.collector.name} :: {self.name}"


def verdict(trajectory: Trajectory) -> str:
    """The outcome in one word: `criteria_failed` for a success that misses further criteria."""
    return "criteria_failed" if trajectory.metadata["failed_criteria"] else trajectory.outcome
