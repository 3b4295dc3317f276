"""`lpb-report`: evaluates the raw data of a run again, without running anything."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from pytest_lpb import __version__
from pytest_lpb.errors import LpbError
from pytest_lpb.kpis.registry import load_builtin
from pytest_lpb.report.build import report_data, write_results
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.text import comparison_table, planner_table, trial_lines
from pytest_lpb.run.evaluation import Selection, evaluate
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.plugins import load_kpi_entry_points, load_plugin, load_user_modules

SELECTED = "selected"  # folder for the tables of some of a run's trials
EXIT_WARNINGS = 1
EXIT_USAGE = 4


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `lpb-report`. Returns 0; 1 when a KPI raised or a trial file is unreadable; 4 for wrong arguments."""
    options = _parser().parse_args(arguments)
    try:
        warnings = _report(options)
    except LpbError as error:
        print(f"lpb-report: error: {error}", file=sys.stderr)
        return EXIT_USAGE
    except BrokenPipeError:
        # The reader, such as `head`, has seen enough.
        sys.stderr.close()
        return 0
    except OSError as error:
        print(f"lpb-report: error: cannot write {error.filename}: {error.strerror}; see --output", file=sys.stderr)
        return EXIT_USAGE
    for warning in warnings:
        print(f"lpb-report: warning: {warning}", file=sys.stderr)
    return EXIT_WARNINGS if warnings else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="lpb-report", description=__doc__, allow_abbrev=False)
    parser.add_argument("run", type=Path, help="run folder, such as reports/latest, or `latest`")
    parser.add_argument("--kpis", type=_names, metavar="A,B", help="KPIs to evaluate (default: the run's own)")
    parser.add_argument("--planners", type=_names, metavar="A,B", help="planners to look at")
    parser.add_argument("--scenarios", type=_names, metavar="A,B", help="scenarios to look at, by their keys")
    parser.add_argument("--trial", metavar="NODEID", help="print one trial with all its KPIs")
    parser.add_argument("--compare", type=_names, metavar="A,B", help="compare these two planners")
    parser.add_argument("--plot", type=_names, metavar="A,B", nargs="?", const=[], help="write plots (default: all)")
    parser.add_argument("--output", type=Path, metavar="DIR", help="where to write (default: the run folder)")
    parser.add_argument("--plugin", action="append", default=[], metavar="MODULE", help="module or file with KPIs")
    parser.add_argument("--version", action="version", version=f"pytest-lpb {__version__}")
    return parser


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",") if name.strip()]


def _report(options: argparse.Namespace) -> list[str]:
    run = RunFolder.open(_run_path(options.run))
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
    data = write_results(shown, folder, _pair(options.compare))
    _print(data, compare=options.compare is not None)
    failures = _plot(data, options, folder)
    print(f"report: {folder / 'report.html'}")
    return [*warnings, *shown.warnings, *failures]


def _run_path(path: Path) -> Path:
    """A run folder's path; `latest` alone means reports/latest."""
    return Path("reports") / path if str(path) == "latest" and not path.exists() else path


def _load_kpis(run: RunFolder, plugins: Sequence[str]) -> list[str]:
    load_builtin()
    load_kpi_entry_points()
    for plugin in plugins:
        load_plugin(plugin)
    return load_user_modules(run.info().get("plugins", []))


def _pair(names: Sequence[str] | None) -> tuple[str, str] | None:
    if names is None:
        return None
    if len(names) != 2 or names[0] == names[1]:
        raise LpbError(f"--compare takes two planners, found {', '.join(names) or 'none'}; write --compare=A,B")
    return names[0], names[1]


def _print(data: ReportData, *, compare: bool) -> None:
    print("\n".join(planner_table(data)))
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
