"""What `lpb-report` does: evaluates a run again, prints and writes what was asked for."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.report.build import REPORT_FILE, report_data, write_results
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.text import comparison_table, planner_table, trial_lines
from pytest_lpb.retime.result import RETIMED_FILE
from pytest_lpb.retime.text import retimed_table
from pytest_lpb.run.evaluation import Evaluation, Selection, evaluate
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.plugins import load_kpi_entry_points, load_plugin, load_user_modules

SELECTED = "selected"  # folder for the tables of some of a run's trials


def report_again(options: argparse.Namespace) -> list[str]:
    """Evaluate a run as the options of `lpb-report` say; returns warnings. Raises LpbError and OSError."""
    run = RunFolder.open(_run_path(options.run))
    if options.video is not None:
        _write_video(run, options)
        return []
    warnings = _load_kpis(run, options.plugin)
    kpis = options.kpis if options.kpis is not None else run.info().get("kpis")
    evaluation = evaluate(run, kpis)
    if options.trial:
        shown = evaluation.selected(Selection(node_id=options.trial))
        print("\n".join(trial_lines(shown)))
        folder = options.output or run.path / SELECTED
        return [*warnings, *shown.warnings, *_plot(report_data(shown), options, folder)]
    planners = options.planners or options.compare
    selection = Selection(planners=planners, scenarios=options.scenarios)
    whole = planners is None and options.scenarios is None
    folder = options.output or (run.path if whole and options.kpis is None else run.path / SELECTED)
    shown = evaluation if whole else evaluation.selected(selection)
    warnings += _retime(run, shown, options, folder)
    data = write_results(shown, folder, options.compare and tuple(options.compare))
    _print(data, compare=options.compare is not None, retimed=options.retime is not None)
    failures = _plot(data, options, folder)
    print(f"report: {folder / REPORT_FILE}")
    return [*warnings, *data.warnings, *failures]


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

    return list(retime(run, shown.trials, options.retime, folder / RETIMED_FILE).warnings)


def _print(data: ReportData, *, compare: bool, retimed: bool) -> None:
    print("\n".join(planner_table(data)))
    if retimed and data.retimed is not None:
        print("\n".join(["", *retimed_table(data.retimed)]))
    if compare:
        print("\n".join(["", *comparison_table(data)]))


def _plot(data: ReportData, options: argparse.Namespace, folder: Path) -> list[str]:
    """Write the plots asked for; what could not be drawn."""
    if options.plot is None:
        return []
    from pytest_lpb.report.plots import write_plots

    written = write_plots(folder / "plots", options.plot or None, data)
    print(f"plots: {len(written.paths)} files below {folder / 'plots'}")
    return list(written.failures)
