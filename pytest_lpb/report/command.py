"""What `lpb-report` does: evaluates a run again, prints and writes what was asked for."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from pathlib import Path

from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.errors import LpbError, RecordingError
from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.names import count
from pytest_lpb.report.build import REPORT_FILE, report_data, write_results
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.fault_text import fault_lines
from pytest_lpb.report.gate_text import conclusion, gate_lines
from pytest_lpb.report.markdown import markdown_summary
from pytest_lpb.report.reproduce_text import reproduce_lines, sameness_lines
from pytest_lpb.report.text import comparison_table, planner_table, title_lines, trial_lines
from pytest_lpb.retime.result import RETIMED_FILE
from pytest_lpb.retime.text import retimed_table
from pytest_lpb.run.baseline_file import save_baseline, saved_kpis
from pytest_lpb.run.evaluation import Evaluation, Selection, evaluate
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.gate import GateResult
from pytest_lpb.run.gate_options import INCONCLUSIVE, GateOptions
from pytest_lpb.run.merge import endings, merge
from pytest_lpb.run.plugins import load_kpi_entry_points, load_plugin, load_user_modules
from pytest_lpb.run.reproduce import compare_runs, findings

STANDARD_OUTPUT = Path("-")
TABLES = "tables"  # folder of tables that were exported
WITHIN = ("plots", TABLES)  # folders below those of results
SELECTED = "selected"  # folder for the tables of some of a run's trials


def report_again(options: argparse.Namespace) -> tuple[list[str], bool]:
    """Evaluate a run as the options of `lpb-report` say. Raises LpbError and OSError.

    Returns:
        Warnings, and whether a regression gate is closed, or a run cannot be repeated.
    """
    runs = [RunFolder.open(_run_path(path)) for path in options.runs]
    run = runs[0]
    if options.reproduce:
        return [], not _reproduce(runs, options.trust_run)
    if options.video is not None:
        _write_video(run, options)
        return [], False
    warnings, evaluation = _evaluation(runs, options)
    home = run.path if len(runs) == 1 else run.path.parent / f"merged-{'-'.join(endings(runs))}"
    if options.trial:
        shown = evaluation.selected(Selection(node_id=options.trial))
        print("\n".join(trial_lines(shown)))
        folder = options.output or _own(home / SELECTED, *WITHIN)
        return [*warnings, *shown.warnings, *_plot(report_data(shown), options, folder)], False
    judged = _judge(evaluation, options) if options.baseline is not None else _judge_again(evaluation, options)
    shown = _selected(evaluation, options)
    folder = options.output or _own(home if shown is evaluation and options.kpis is None else home / SELECTED, *WITHIN)
    if options.save_baseline is not None:
        save_baseline(shown, options.save_baseline, saved_kpis(shown, options.kpis))
    # With Markdown on the standard output, everything else goes where it is no part of it.
    with redirect_stdout(sys.stderr if options.markdown == STANDARD_OUTPUT else sys.stdout):
        warnings += _retime(run, shown, options, folder)
        data = write_results(shown, folder, options.compare and tuple(options.compare), judged)
        _print(data, judged, options)
        failures = _plot(data, options, folder)
        if options.export is not None:
            _export(data, options, folder / TABLES)
        print(f"report: {folder / REPORT_FILE}")
    if options.markdown is not None:
        _write_markdown(options.markdown, markdown_summary(data))
    closed = options.baseline is not None and judged is not None and judged.closed
    return [*warnings, *data.warnings, *failures], closed


def _own(folder: Path, *below: str) -> Path:
    """A folder for results within a run folder. Raises RecordingError where a link would lead them elsewhere."""
    for place in (folder, *(folder / name for name in below)):
        if place.is_symlink():
            raise RecordingError(f"{place} is a link, so results are not written there; remove it")
    return folder


def _evaluation(runs: Sequence[RunFolder], options: argparse.Namespace) -> tuple[list[str], Evaluation]:
    """Warnings, and the trials of the runs with the KPIs asked for: by default all that any of the runs had."""
    warnings = [warning for run in runs for warning in _load_kpis(run, options.plugin)]
    if options.plot:
        # Before anything is evaluated or written: a misspelt name is told at once.
        from pytest_lpb.report.plots import load_builtin as load_plots

        load_plots().select(options.plot)
    own = [run.info().get("kpis") for run in runs]
    kpis = options.kpis
    if kpis is None and all(own):
        kpis = list(dict.fromkeys(name for names in own for name in names or ()))
    evaluations = [evaluate(run, kpis) for run in runs]
    return list(dict.fromkeys(warnings)), evaluations[0] if len(runs) == 1 else merge(evaluations)


def _reproduce(runs: Sequence[RunFolder], trusted: bool) -> bool:
    """Print how to run it again, and what has changed; of two runs, whether they agree. False for bad news."""
    found = list(findings(runs[0], trusted=trusted))
    print("\n".join(reproduce_lines(runs[0], found)))
    good = not any(finding.spoils for finding in found)
    if len(runs) == 1:
        return good
    sameness = compare_runs(*runs)
    print("\n".join(["", *sameness_lines(runs[0].name, runs[1].name, sameness)]))
    return sameness.whole


def _selected(evaluation: Evaluation, options: argparse.Namespace) -> Evaluation:
    planners = _chosen_planners(options)
    if planners is None and options.scenarios is None:
        return evaluation
    return evaluation.selected(Selection(planners=planners, scenarios=options.scenarios))


def _chosen_planners(options: argparse.Namespace) -> list[str] | None:
    """Planners to look at; None: all."""
    chosen: list[str] | None = options.planners or options.compare
    return chosen


def _judge(evaluation: Evaluation, options: argparse.Namespace) -> GateResult:
    """Verdicts of the regression gate that is asked for."""
    asked = GateOptions(options.baseline, options.fail_on, options.inconclusive or INCONCLUSIVE[0], "--")
    return _verdicts(evaluation, options, asked, Path())


def _judge_again(evaluation: Evaluation, options: argparse.Namespace) -> GateResult | None:
    """Verdicts of the gate that the run itself had; None without one, or when its baseline is gone."""
    info = evaluation.run.info()
    if "gate" not in info or "merged" in info:
        return None
    recorded = info["gate"]
    asked = GateOptions(recorded["baseline"], recorded["fail_on"], recorded["inconclusive"], "--lpb-")
    try:
        return _verdicts(evaluation, options, asked, Path(info["invocation"]))
    except LpbError as error:
        print(f"lpb-report: note: the run's gate is left out: {error}", file=sys.stderr)
        return None


def _verdicts(evaluation: Evaluation, options: argparse.Namespace, asked: GateOptions, folder: Path) -> GateResult:
    """Verdicts on the planners and scenarios that are selected; the baseline may be a planner that is not."""
    planners = sorted(evaluation.trials["planner"].unique().tolist())
    gate = asked.gate(folder, planners, evaluation.kpis).gate()
    scenarios = evaluation.selected(Selection(scenarios=options.scenarios)).trials
    result = gate.judge(scenarios, evaluation.run.info().get("machine") or {})
    return result.of(_chosen_planners(options), options.scenarios)


def _write_markdown(path: Path, text: str) -> None:
    if path == STANDARD_OUTPUT:
        print(text, end="")
        return
    replace_file(path, text.encode())
    print(f"markdown: {path}")


def _run_path(path: Path) -> Path:
    """A run folder's path; `latest` alone means reports/latest."""
    return Path("reports") / path if str(path) == "latest" and not path.exists() else path


def _write_video(run: RunFolder, options: argparse.Namespace) -> None:
    """Draw the one trial asked for; nothing else of the run is read."""
    from pytest_lpb.report.video import DEFAULT_FPS, format_of, write_video
    from pytest_lpb.run.lookup import find_trial
    from pytest_lpb.trial.files import read_trial

    fps = DEFAULT_FPS if options.fps is None else options.fps
    format_of(options.video, fps)  # before anything is read
    # Registered robots and shapes are needed to read the trial.
    for warning in load_user_modules(run.info().get("plugins", []), run.path):
        print(warning, file=sys.stderr)
    trajectory = read_trial(find_trial(run, options.trial))
    print(f"video: {write_video(trajectory, options.video, fps)}")


def _load_kpis(run: RunFolder, plugins: Sequence[str]) -> list[str]:
    load_builtin()
    load_kpi_entry_points()
    for plugin in plugins:
        load_plugin(plugin)
    return load_user_modules(run.info().get("plugins", []), run.path)


def _retime(run: RunFolder, shown: Evaluation, options: argparse.Namespace, folder: Path) -> list[str]:
    """Time the calls of the selected trials again, if that was asked for; what there is to warn of."""
    if options.retime is None:
        return []
    from pytest_lpb.retime.command import retime

    target = folder / RETIMED_FILE
    return list(retime(run, shown.trials, options.retime, target, trusted=options.trust_run).warnings)


def _print(data: ReportData, judged: GateResult | None, options: argparse.Namespace) -> None:
    further = [kpi.name for kpi in data.kpis] if options.compare is not None else []
    print("\n".join([*title_lines(data), *planner_table(data, further)]))
    if faults := list(fault_lines(data.trials.to_dict("records"))):
        print("\n".join(["", *faults]))
    if options.retime is not None and data.retimed is not None:
        print("\n".join(["", *retimed_table(data.retimed)]))
    if options.compare is not None:
        print("\n".join(["", *comparison_table(data)]))
    if judged is not None:
        print("\n".join(["", *gate_lines(judged), conclusion(judged)]))
    if options.save_baseline is not None:
        print(f"baseline: {options.save_baseline}")


def _export(data: ReportData, options: argparse.Namespace, folder: Path) -> None:
    """Write the tables in the formats asked for."""
    from pytest_lpb.report.export import write_tables

    written = write_tables(folder, data, options.export, options.kpis)
    print(f"tables: {', '.join(path.name for path in written)} in {folder}")


def _plot(data: ReportData, options: argparse.Namespace, folder: Path) -> list[str]:
    """Write the plots asked for; what could not be drawn."""
    if options.plot is None:
        return []
    from pytest_lpb.report.plots import write_plots

    formats = options.plot_format or ("png", "pdf")
    written = write_plots(folder / "plots", options.plot or None, data, formats)
    print(f"plots: {count(len(written.paths), 'file')} below {folder / 'plots'}")
    return list(written.failures)
