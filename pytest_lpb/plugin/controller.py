"""Hooks of the controlling process: run folder, progress, tables, report, summary, exit code."""

from __future__ import annotations

import json
import warnings
from collections.abc import Generator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from pytest_lpb.errors import LpbError, RecordingError, in_one_line
from pytest_lpb.plugin.items import TrialItem
from pytest_lpb.plugin.progress import Progress
from pytest_lpb.plugin.session import LpbSession
from pytest_lpb.plugin.sources import check_unchanged
from pytest_lpb.plugin.unchosen import told_studies
from pytest_lpb.plugin.worker import REPORT_ATTRIBUTE, SKIP_ATTRIBUTE
from pytest_lpb.report.fault_text import fault_lines
from pytest_lpb.report.plots import default_registry as plots
from pytest_lpb.run.crashed import forget_crashes
from pytest_lpb.run.faults import FAULTS
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.lock import RunLock
from pytest_lpb.run.plan import TrialKey, planned
from pytest_lpb.run.plugins import user_modules
from pytest_lpb.run.provenance import run_information
from pytest_lpb.run.run_file import robot_warnings
from pytest_lpb.run.skipped import skip_files

if TYPE_CHECKING:
    from pytest_lpb.plugin.rates import RateVerdict
    from pytest_lpb.plugin.termination import TerminationPlugin
    from pytest_lpb.report.data import ReportData
    from pytest_lpb.run.evaluation import Evaluation
    from pytest_lpb.run.gate import GateResult


class ControllerPlugin:
    """One per run, in the process that the user started."""

    def __init__(self, session: LpbSession, config: pytest.Config, termination: TerminationPlugin) -> None:
        self._session = session
        self._termination = termination
        self._config = config
        self._folder: RunFolder | None = None
        self._data: ReportData | None = None
        self._rates: list[RateVerdict] = []
        self._gate: GateResult | None = None
        self._faults: list[str] = []
        self._progress: Progress | None = None
        self._finished: set[tuple[str, str, int]] = set()  # (scenario, planner, seed)
        self._known: set[tuple[str, str, int]] = set()  # failed as expected
        self._planned = 0  # trials of the run
        self._broken: list[dict[str, Any]] = []  # trials that ended by a fault
        self._told: list[str] = []  # faults met on the way
        self._warned: list[str] = []  # what is probably not meant about robots: it fails no run
        self._lock = RunLock()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Without xdist: make the run folder once all scenarios are collected."""
        option = self._config.option
        runs = option.continue_on_collection_errors or not session.testsfailed
        if session.items and runs and not option.collectonly and not option.setuponly:
            self._begin([item.nodeid for item in session.items if isinstance(item, TrialItem)], workers=False)

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, node: Any, ids: list[str]) -> None:  # noqa: ARG002
        """With xdist: make the run folder when the first worker has collected, before any trial is given out."""
        self._begin([node_id for node_id in ids if self._session.trial_of(node_id) is not None], workers=True)

    def tell(self, fault: str) -> None:
        """Say at the end of the run what went wrong on the way; the run fails."""
        self._told.append(fault)

    def _begin(self, node_ids: list[str], *, workers: bool) -> None:
        if self._folder is not None or not node_ids:
            return
        session = self._session
        trials = {trial for node_id in node_ids if (trial := session.trial_of(node_id)) is not None}
        self._planned = len(trials)
        options: dict[str, Any] = {
            "seeds": {"first": session.first_seed, "trials": session.trials},
            "random": list(session.flags),
            "assert": session.assertion,
            "kpis": session.kpis,
            "plugins": user_modules(session.modules, [plot.function for plot in plots if not plot.builtin]),
            "workers": session.workers,
            "rootdir": str(session.rootdir),
            "invocation": str(session.invocation),
            "pythonpath": [str(path) for path in self._config.getini("pythonpath")],
            "arguments": list(self._config.args),
            "options": dict(session.options),
            "planned": planned(trials),
            **({"swept": session.source.swept} if session.source is not None and session.source.swept else {}),
        }
        if session.title:
            options["title"] = session.title
        if session.gate is not None:
            options["gate"] = session.gate.recorded
        command = ["pytest", *map(str, self._config.invocation_params.args)]
        families = session.families(node_ids)
        information = run_information(command, session.planners, families, options, session.invocation)
        try:
            if session.planned is None:
                folder = RunFolder.create(session.run, information, session.planners)
                self._lock.take(folder.path)
            else:
                folder = RunFolder.open(session.run)
                check_unchanged(folder.info(), information)
                self._take_over(folder, workers=workers)
                folder.resume(information)
        except LpbError as error:
            raise pytest.UsageError(str(error)) from error
        self._folder = folder
        reporter = self._config.pluginmanager.get_plugin("terminalreporter")
        if reporter is not None:
            self._progress = Progress(reporter)
            self._progress.start(len(node_ids))

    def _take_over(self, folder: RunFolder, *, workers: bool) -> None:
        """Claim a run that is to be finished, and tidy up what was left in it. Raises RecordingError."""
        self._lock.take(folder.path)
        if self._lock.held:
            folder.tidy()
        if workers:
            # In this process, such a trial might end the run as it ended its worker.
            forget_crashes(folder)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count trials as they finish, each once: their first attempt counts."""
        skipped = getattr(report, SKIP_ATTRIBUTE, None)
        if skipped and self._progress is not None:
            self._finished.add(TrialKey(*json.loads(skipped)))
            self._progress.count(success=True)
        result = trial_result(report)
        if result is None or self._progress is None:
            return
        key = (result["scenario"], result["planner"], result["seed"])
        if hasattr(report, "wasxfail"):
            self._known.add(key)
        if key not in self._finished:
            self._finished.add(key)
            if result["outcome"] in FAULTS:
                self._broken.append(result)
            self._progress.count(success=result["success"])

    @pytest.hookimpl(tryfirst=True)
    def pytest_report_teststatus(self, report: pytest.TestReport) -> tuple[str, str, str] | None:
        """An unsolved trial that does not fail has a status letter of its own: u."""
        if report.outcome != "passed" or report.when != "call":
            return None
        result = trial_result(report)
        if result is None or result["success"]:
            return None
        return "unsolved", "u", f"UNSOLVED ({result['outcome']})"

    @pytest.hookimpl(wrapper=True, trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> Generator[None, object, object]:
        """Build tables before pytest prints its summary: at once, and again if workers finished trials meanwhile."""
        folder = self._folder
        if folder is None:
            return (yield)
        if self._session.checked_trials is not None:
            if self._interrupted(session):
                self.tell("isolation was not checked: the run did not come to its end")
            else:
                self._check_fairness(folder, self._session.checked_trials)
        # Who terminated the run may not wait until interrupted workers have ended.
        self._conclude(session, folder)
        files = finished_files(folder)
        result = yield
        if finished_files(folder) != files:
            self._conclude(session, folder)
        return result

    @staticmethod
    def _interrupted(session: pytest.Session) -> bool:
        return session.exitstatus not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED)

    def _check_fairness(self, folder: RunFolder, per_planner: int) -> None:
        """Run some trials again, elsewhere and in another order; what is found lies in the run folder."""
        from pytest_lpb.fairness.check import check_fairness

        reporter = self._config.pluginmanager.get_plugin("terminalreporter")
        if reporter is not None:
            reporter.write_line("")
            reporter.write_line(f"lpb: checking isolation: up to {per_planner} trials of each planner again")
        try:
            with self._termination.interruptible():
                check_fairness(folder, per_planner, self._session.workers).write(folder.path)
        except Exception as error:
            # Such as a trial file that is damaged: what it is, it costs no more than the check.
            self.tell(f"isolation could not be checked: {in_one_line(error)}")
        except KeyboardInterrupt:
            self.tell("isolation was not checked: interrupted")

    def _conclude(self, session: pytest.Session, folder: RunFolder) -> None:
        """Build tables and report from the trial files; fail the run for rates that fall short and KPIs that raise."""
        self._faults = list(self._told)
        try:
            self._warned = robot_warnings(folder.info())
        except RecordingError as error:
            self._faults += [] if self._evaluates else [str(error)]  # the evaluation says it, too
        if not self._evaluates:
            if self._faults and session.exitstatus == pytest.ExitCode.OK:
                session.exitstatus = pytest.ExitCode.TESTS_FAILED
            return
        # Imported when trials are done: pandas, SciPy and the report's templates cost a second at the start. Not
        # interruptible: what is half imported cannot be imported again, and the summary needs it.
        import pytest_lpb.plugin.rates
        import pytest_lpb.plugin.summary
        import pytest_lpb.report.build  # noqa: F401 - for `_build`

        try:
            # Filters such as `-W error` are about the tests' code; they must not cost a run its tables.
            with warnings.catch_warnings(), self._termination.interruptible():
                warnings.simplefilter("ignore")
                self._build(folder)
        except KeyboardInterrupt:
            again = self._session.report_command
            self._faults.append(f"interrupted before tables and report were done; make them with: {again}")
            session.exitstatus = pytest.ExitCode.INTERRUPTED
        except (LpbError, OSError) as error:
            self._faults.append(str(error))
        except Exception as error:
            # Trials have run for hours perhaps: what goes wrong in a picture is told, and costs no more than it.
            self._faults.append(f"the report is incomplete: {in_one_line(error)}")
        closed = self._gate is not None and self._gate.closed
        bad = self._faults or closed or any(not verdict.met for verdict in self._rates)
        if bad and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    @property
    def _evaluates(self) -> bool:
        """Whether raw data are evaluated at the end: for the report, or for a verdict that was asked for."""
        session = self._session
        return session.reported or session.checked_gate is not None or session.assertion == "rate"

    def _build(self, folder: RunFolder) -> None:
        """Everything is judged before anything is written: a full disk costs no verdict."""
        from pytest_lpb.plugin.rates import judge_rates
        from pytest_lpb.report.build import REPORT_FILE, report_data, write_tables
        from pytest_lpb.report.report import write_report
        from pytest_lpb.run.evaluation import evaluate

        evaluation = evaluate(folder, self._session.kpis)
        if self._session.assertion == "rate":
            self._rates = judge_rates(evaluation.trials, folder)
        if not self._session.reported:
            self._faults += self._besides_robots(evaluation.warnings)
            self._judge(evaluation)
            return
        self._data = report_data(evaluation, folder=folder.path)
        self._faults += self._besides_robots(self._data.warnings)
        self._judge(evaluation)
        self._data = replace(self._data, gate=self._gate)
        write_tables(self._data, evaluation.table(), folder.path)
        write_report(folder.path / REPORT_FILE, self._data)

    def _besides_robots(self, warnings: Sequence[str]) -> list[str]:
        """Warnings of an evaluation that are faults of the run: those about robots are shown, and fail nothing."""
        return [text for text in warnings if text not in self._warned]

    def _judge(self, evaluation: Evaluation) -> None:
        """Compare the run with its baseline. A gate that cannot be judged is a fault: it must not stand open."""
        if self._session.checked_gate is None:
            return
        try:
            gate = self._session.checked_gate.gate()
            self._gate = gate.judge(evaluation.trials, evaluation.run.info()["machine"])
        except Exception as error:
            # Whatever it is, it costs no more than the verdicts.
            self._faults.append(f"the gate cannot be judged: {in_one_line(error)}")

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter, exitstatus: int) -> None:
        """Print the table of planners, what failed, and where the report is."""
        if self._folder is None:
            # Where everything was deselected (-k, -m), pytest says so itself.
            if exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED and not terminalreporter.stats.get("deselected"):
                if studies := told_studies(self._config):
                    terminalreporter.write_line(studies)
                    return
                globs = ", ".join(self._config.getini("lpb_scenarios"))
                terminalreporter.write_line(
                    f"lpb: no scenario was found: name the files, or have them match ini `lpb_scenarios` ({globs})"
                )
            return
        from pytest_lpb.plugin.summary import write_summary

        write_summary(
            terminalreporter,
            self._data,
            self._rates,
            self._gate,
            [*self._faults, *self._warned],
            self._session,
            self._known,
            self._unreported(),
        )

    def _unreported(self) -> list[str]:
        """What is known of trials that were not evaluated: their faults, and how many are missing."""
        if self._data is not None:
            return []
        lines = list(fault_lines(self._broken))
        if len(self._finished) < self._planned:
            lines.append(
                f"{len(self._finished)} of {self._planned} trials were run; "
                f"run the others with: {self._session.resume_command}"
            )
        return lines

    def pytest_unconfigure(self) -> None:
        """Let others finish the run."""
        self._lock.release()


def finished_files(folder: RunFolder) -> list[Path]:
    """Files of trials that are finished, or skipped."""
    return [*folder.trial_files(), *skip_files(folder.path)]


def trial_result(report: pytest.TestReport) -> dict[str, Any] | None:
    """What a trial's report carries, or None for other reports."""
    text = getattr(report, REPORT_ATTRIBUTE, None)
    return json.loads(text) if text and report.when == "call" else None
