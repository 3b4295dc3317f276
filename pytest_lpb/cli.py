"""`lpb-report`: evaluates the raw data of a run again, without running anything."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from pytest_lpb import __version__
from pytest_lpb.commands import Parser, by_commas, ended
from pytest_lpb.errors import LpbError
from pytest_lpb.names import listed, suggestion

PLOT_FORMATS = ("png", "pdf", "svg")
EXPORT_FORMATS = ("latex", "markdown")
EXIT_WARNINGS = 1
DEFAULT_PASSES, MOST_PASSES = 5, 1000  # of --retime
INCONCLUSIVE = ("pass", "fail")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `lpb-report`.

    Returns:
        0; 1: the gate is closed, a KPI raised or a trial file is unreadable; 2: interrupted; 4: wrong arguments, or
        the results cannot be written.
    """
    options = _parser().parse_args(arguments)
    return ended("lpb-report", lambda: _report(options), "; see --output")


def _report(options: argparse.Namespace) -> int:
    if options.prune is not None:
        return _prune(options)
    _check(options)
    # Imported here: `--help` and wrong arguments need no pandas.
    from pytest_lpb.report.command import report_again

    warnings, closed = report_again(options)
    for warning in warnings:
        print(f"lpb-report: warning: {warning}", file=sys.stderr)
    return EXIT_WARNINGS if warnings or closed else 0


def _prune(options: argparse.Namespace) -> int:
    """Remove old runs; prints each, and each that had to stay."""
    others = [name for name, default in _defaults().items() if getattr(options, name) != default]
    others = [name for name in others if name not in ("runs", "prune", "dry_run")]
    if others:
        raise LpbError(f"--prune only removes runs; leave --{others[0].replace('_', '-')} out")
    if options.prune < 0:
        raise LpbError(f"--prune: found {options.prune}; allowed are 0 and more")
    if len(options.runs) > 1:
        raise LpbError(f"--prune is about one folder of runs, found {len(options.runs)}")
    folder: Path = options.runs[0] if options.runs else Path("reports")
    if folder.name == "latest" or (folder / "run.json").is_file():
        raise LpbError(f"--prune: {folder} is a run; name the folder that its runs lie in")
    from pytest_lpb.run.prune import prune

    count = 0
    for run in prune(folder, options.prune, dry_run=options.dry_run):
        count += not run.kept
        told = f"kept: {run.kept}" if run.kept else "would be removed" if options.dry_run else "removed"
        print(f"{folder / run.path.name} {told}")
    print(
        f"{count} run{'' if count == 1 else 's'} {'would be removed' if options.dry_run else 'removed'} from {folder}"
    )
    return 0


def _defaults() -> dict[str, object]:
    """Values of the options without any."""
    return vars(_parser().parse_args([]))


def _parser() -> argparse.ArgumentParser:
    parser = Parser(prog="lpb-report", description=__doc__, allow_abbrev=False)
    parser.add_argument(
        "runs",
        type=Path,
        nargs="*",
        metavar="RUN",
        help="run folder, such as reports/latest, or `latest`; several count as one",
    )
    parser.add_argument("--kpis", type=by_commas, metavar="A,B", help="KPIs to evaluate (default: the run's own)")
    parser.add_argument("--planners", type=by_commas, metavar="A,B", help="planners to look at")
    parser.add_argument("--scenarios", type=by_commas, metavar="A,B", help="scenarios to look at, by their keys")
    parser.add_argument("--trial", metavar="NODEID", help="print one trial with all its KPIs")
    parser.add_argument("--video", type=Path, metavar="FILE", help="draw that trial into FILE.mp4 or FILE.gif instead")
    parser.add_argument("--fps", type=float, metavar="N", help="frames per second of the video (default: 30)")
    parser.add_argument("--compare", type=by_commas, metavar="A,B", help="compare these two planners")
    parser.add_argument("--plot", type=by_commas, metavar="A,B", nargs="?", const=[], help="write plots (default: all)")
    parser.add_argument("--plot-format", type=by_commas, metavar="png,pdf", help="files of --plot (default: both)")
    parser.add_argument("--export", type=by_commas, metavar="latex,markdown", help="write tables for papers and pages")
    parser.add_argument(
        "--retime", type=int, metavar="N", nargs="?", const=DEFAULT_PASSES, help="time all calls again, in N passes"
    )
    parser.add_argument(
        "--trust-run", action="store_true", help="let --retime and --reproduce start what the run folder names"
    )
    parser.add_argument("--output", type=Path, metavar="DIR", help="where to write (default: the run folder)")
    parser.add_argument("--save-baseline", type=Path, metavar="FILE", help="write a baseline file for the gate")
    parser.add_argument("--baseline", metavar="RUN_OR_FILE", help="regression gate: this run, file or planner:NAME")
    parser.add_argument("--fail-on", type=by_commas, metavar="KPI:MARGIN,..", help="losses that close the gate")
    parser.add_argument("--inconclusive", choices=INCONCLUSIVE, help="when the gate cannot tell (default: pass)")
    parser.add_argument(
        "--markdown", type=Path, nargs="?", const=Path("-"), metavar="FILE", help="summary for a pull request"
    )
    parser.add_argument(
        "--reproduce", action="store_true", help="how to run it again, and what has changed; of two runs, if they agree"
    )
    parser.add_argument(
        "--prune",
        type=int,
        metavar="N",
        help="remove all runs but the newest N; RUN: their parent (default: reports)",
    )
    parser.add_argument("--dry-run", action="store_true", help="say what --prune would remove, and remove nothing")
    parser.add_argument("--plugin", action="append", default=[], metavar="MODULE", help="module or file with KPIs")
    parser.add_argument("--version", action="version", version=f"pytest-lpb {__version__}")
    return parser


def _check(options: argparse.Namespace) -> None:
    """Raise LpbError for options that contradict each other."""
    if not options.runs:
        raise LpbError("RUN: missing; name a run folder, such as reports/latest")
    if options.dry_run:
        raise LpbError("--dry-run says what --prune=N would remove; add that")
    for name in ("kpis", "planners", "scenarios", "plot_format", "export"):
        if getattr(options, name) == []:
            raise LpbError(f"--{name.replace('_', '-')}: found no name; leave the option out for all of them")
    compared = options.compare
    if compared is not None and (len(compared) != 2 or compared[0] == compared[1]):
        found = ", ".join(compared) or "none"
        raise LpbError(f"--compare takes two planners, found {found}; write --compare=A,B")
    if compared and options.planners and not set(compared) <= set(options.planners):
        raise LpbError("--compare names a planner that --planners leaves out")
    if options.trial and (compared or options.planners or options.scenarios):
        raise LpbError("--trial shows one trial; leave --planners, --scenarios and --compare out")
    _check_runs(options)
    _check_formats(options)
    _check_retime(options)
    _check_gate(options)
    _check_video(options)


def _check_runs(options: argparse.Namespace) -> None:
    """Raise LpbError for what is about one run, or two, but is asked of others."""
    if len(options.runs) > 1:
        single: dict[str, object] = {"video": None, "retime": None}
        asked = [f"--{name}" for name, nothing in single.items() if getattr(options, name) != nothing]
        if asked:
            raise LpbError(f"{asked[0]} is about one run, found {len(options.runs)}")
    if options.reproduce and len(options.runs) > 2:
        raise LpbError(f"--reproduce is about one run, or whether two agree; found {len(options.runs)}")


def _check_formats(options: argparse.Namespace) -> None:
    """Raise LpbError for formats of files that are not written."""
    for option, allowed in (("plot_format", PLOT_FORMATS), ("export", EXPORT_FORMATS)):
        for name in getattr(options, option) or ():
            if name not in allowed:
                hint = suggestion(name, allowed)
                raise LpbError(f"--{option.replace('_', '-')}: no format {name!r}; there are {listed(allowed)}{hint}")
    if options.plot_format and options.plot is None:
        raise LpbError("--plot-format is for plots; add --plot, or --plot=NAME")
    if options.trial and options.export:
        raise LpbError("--export writes tables of all trials of a selection; leave --trial out")


def _check_retime(options: argparse.Namespace) -> None:
    """Raise LpbError for a number of passes that measures no noise, or more than one trial can have."""
    if options.retime is None:
        return
    if not 2 <= options.retime <= MOST_PASSES:
        raise LpbError(
            f"--retime: found {options.retime} passes; allowed are 2 to {MOST_PASSES} (what two differ by is noise)"
        )
    if options.trial:
        raise LpbError("--retime times all trials of a selection; choose with --planners and --scenarios, not --trial")


def _check_gate(options: argparse.Namespace) -> None:
    """Raise LpbError for options of the gate that gate nothing."""
    for name in ("fail_on", "inconclusive"):
        if getattr(options, name) is not None and options.baseline is None:
            option = f"--{name.replace('_', '-')}"
            raise LpbError(f"{option}: nothing to compare with; add --baseline=RUN_OR_FILE, or planner:NAME")
    unasked: dict[str, object] = {"baseline": None, "save_baseline": None, "markdown": None}
    others = [f"--{name.replace('_', '-')}" for name, nothing in unasked.items() if getattr(options, name) != nothing]
    if options.trial and others:
        raise LpbError(f"--trial shows one trial; leave {' and '.join(others)} out")


def _check_video(options: argparse.Namespace) -> None:
    """Raise LpbError for options that make no sense of a video."""
    if options.video is None:
        if options.fps is not None:
            raise LpbError("--fps is for videos; add --trial=NODEID --video=FILE.mp4")
        return
    if not options.trial:
        raise LpbError("--video draws one trial; say which with --trial=NODEID")
    unasked: dict[str, object] = {"kpis": None, "plot": None, "export": None, "output": None, "plugin": []}
    others = [f"--{name}" for name, nothing in unasked.items() if getattr(options, name) != nothing]
    if others:
        raise LpbError(f"--video only draws; leave {' and '.join(others)} out")


if __name__ == "__main__":
    sys.exit(main())
