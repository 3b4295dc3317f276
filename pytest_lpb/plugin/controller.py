"""Hooks of the controlling process: run folder, progress, tables, report, summary, exit code."""

from __future__ import annotations

import json
import warnings
from collections.abc import Generator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from pytest_lpb.errors import LpbError, in_one_line
from pytest_lpb.plugin.items import TrialItem
from pytest_lpb.plugin.progress import Progress
from pytest_lpb.plugin.session import LpbSession
from pytest_lpb.plugin.sources import check_unchanged
from pytest_lpb.plugin.worker import REPORT_ATTRIBUTE
from pytest_lpb.report.plots import default_registry as plots
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.inputs import write_planner_files
from pytest_lpb.run.plan import planned
from pytest_lpb.run.plugins import user_modules
from pytest_lpb.run.provenance import run_information

if TYPE_CHECKING:
    from pytest_lpb.plugin.rates import RateVerdict
    from pytest_lpb.report.data import ReportData
    from pytest_lpb.run.evaluation import Evaluation
    from pytest_lpb.run.gate import GateResult


class ControllerPlugin:
    """One per run, in the process that the user started."""

    def __init__(self, session: LpbSession, config: pytest.Config) -> None:
        self._session = session
        self._config = config
        self._folder: RunFolder | None = None
        self._data: ReportData | None = None
        self._rates: list[RateVerdict] = []
        self._gate: GateResult | None = None
        self._faults: list[str] = []
        self._check_faults: list[str] = []  # of `--lpb-check-isolation`
        self._progress: Progress | None = None
        self._finished: set[tuple[str, str, int]] = set()  # (scenario, planner, seed)
        self._known: set[tuple[str, str, int]] = set()  # failed as expected
        self._total = 0

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> None:
        """Without xdist: make the run folder once all scenarios are collected."""
        option = self._config.option
        runs = option.continue_on_collection_errors or not session.testsfailed
        if session.items and runs and not option.collectonly and not option.setuponly:
            self._begin([item.nodeid for item in session.items if isinstance(item, TrialItem)])

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, node: Any, ids: list[str]) -> None:  # noqa: ARG002
        """With xdist: make the run folder when the first worker has collected, before any trial is given out."""
        self._begin([node_id for node_id in ids if self._session.trial_of(node_id) is not None])

    def _begin(self, node_ids: list[str]) -> None:
        if self._folder is not None or not node_ids:
            return
        session = self._session
        trials = {trial for node_id in node_ids if (trial := session.trial_of(node_id)) is not None}
        options: dict[str, Any] = {
            "seeds": {"first": session.first_seed, "trials": session.trials},
            "random": list(session.flags),
            "assert": session.assertion,
            "kpis": session.kpis,
            "plugins": user_modules(session.modules, [plot.function for plot in plots if not plot.builtin]),
            "workers": session.workers,
            "rootdir": str(session.rootdir),
            "invocation": str(session.invocation),
            "arguments": list(self._config.args),
            "options": dict(session.options),
            "planned": planned(trials),
            **({"swept": session.source.swept} if session.source is not None and session.source.swept else {}),
        }
        if session.gate is not None:
            options["gate"] = session.gate.recorded
        command = ["pytest", *map(str, self._config.invocation_params.args)]
        families = session.families(node_ids)
        information = run_information(command, session.planners, families, options, session.invocation)
        try:
            if session.planned is None:
                self._folder = RunFolder.create(session.run, information)
                write_planner_files(session.run, session.planners)
            else:
                self._folder = RunFolder.open(session.run)
                check_unchanged(self._folder.info(), information)
                self._folder.resume(information)
        except LpbError as error:
            self._folder = None
            raise pytest.UsageError(str(error)) from error
        self._total = len(trials)
        reporter = self._config.pluginmanager.get_plugin("terminalreporter")
        if reporter is not None:
            self._progress = Progress(reporter)
            self._progress.start(len(node_ids))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count trials as they finish, each once: their first attempt counts."""
        result = trial_result(report)
        if result is None or self._progress is None:
            return
        key = (result["scenario"], result["planner"], result["seed"])
        if hasattr(report, "wasxfail"):
            self._known.add(key)
        if key not in self._finished:
            self._finished.add(key)
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
        if self._session.checked_trials is not None and not self._interrupted(session):
            self._check_fairness(folder, self._session.checked_trials)
        # Who terminated the run may not wait until interrupted workers have ended.
        self._conclude(session, folder)
        files = list(folder.trial_files())
        result = yield
        if list(folder.trial_files()) != files:
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
            check_fairness(folder, per_planner, self._session.workers).write(folder.path)
        except (LpbError, OSError) as error:
            self._check_faults.append(f"isolation could not be checked: {error}")
        except KeyboardInterrupt:
            self._check_faults.append("isolation was not checked: interrupted")

    def _conclude(self, session: pytest.Session, folder: RunFolder) -> None:
        """Build tables and report from the trial files; fail the run for rates that fall short and KPIs that raise."""
        # Imported when trials are done: pandas, SciPy and the report's templates cost a second at the start.
        from pytest_lpb.plugin.rates import judge_rates
        from pytest_lpb.report.build import REPORT_FILE, write_tables
        from pytest_lpb.report.report import write_report
        from pytest_lpb.run.evaluation import evaluate

        with warnings.catch_warnings():
            # Filters such as `-W error` are about the tests' code; they must not cost a run its tables.
            warnings.simplefilter("ignore")
            try:
                evaluation = evaluate(folder, self._session.kpis)
                self._faults = list(evaluation.warnings)
                if self._session.assertion == "rate":
                    self._rates = judge_rates(evaluation.trials, folder)
                self._data = write_tables(evaluation, folder.path)
                self._faults = [*self._check_faults, *self._data.warnings]
                self._judge(evaluation)
                self._data = replace(self._data, gate=self._gate)
                write_report(folder.path / REPORT_FILE, self._data)
            except (LpbError, OSError) as error:
                self._faults.append(str(error))
            except Exception as error:
                # Trials have run for hours perhaps: what goes wrong in a picture is told, and costs no more than it.
                self._faults.append(f"the report is incomplete: {in_one_line(error)}")
        closed = self._gate is not None and self._gate.closed
        bad = self._faults or closed or any(not verdict.met for verdict in self._rates)
        if bad and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

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
            if exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
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
            self._faults,
            self._shown_folder(),
            self._known,
            self._total,
        )

    def _shown_folder(self) -> Path:
        path, here = self._session.run, self._session.invocation
        return path.relative_to(here) if path.is_relative_to(here) else path


def trial_result(report: pytest.TestReport) -> dict[str, Any] | None:
    """What a trial's report carries, or None for other reports."""
    text = getattr(report, REPORT_ATTRIBUTE, None)
    return json.loads(text) if text and report.when == "call" else None
