"""`lpb-scenarios`: scenario files that come with the package, and from elsewhere."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from pytest_lpb import __version__
from pytest_lpb.aligned import aligned
from pytest_lpb.commands import Parser, by_commas, ended
from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.errors import LpbError
from pytest_lpb.shipped import shipped_folder


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `lpb-scenarios`. Returns 0, or 4 for wrong arguments and files that cannot be used."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if options.copy is not None and options.command is not None:
        parser.error("--copy DIR copies all scenarios; `lpb-scenarios copy DIR NAME ...` copies some")
    return ended("lpb-scenarios", lambda: _done(options))


def _done(options: argparse.Namespace) -> int:
    if options.copy is not None:
        _copy(argparse.Namespace(folder=options.copy, names=[]))
    else:
        (options.command or _list)(options)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = Parser(prog="lpb-scenarios", description=__doc__, allow_abbrev=False)
    parser.add_argument("--version", action="version", version=f"pytest-lpb {__version__}")
    parser.add_argument("--copy", type=Path, metavar="DIR", help="copy all scenarios, as `copy DIR` does")
    parser.set_defaults(command=None, tags=[], robot=None)
    commands = parser.add_subparsers(metavar="COMMAND", title="commands (default: list)")
    listing = commands.add_parser("list", help="list the scenarios that come with pytest-lpb")
    listing.add_argument("--tags", type=by_commas, default=[], metavar="A,B", help="those that have all of these tags")
    listing.add_argument("--robot", metavar="NAME", help="those of this robot")
    listing.set_defaults(command=_list)
    copying = commands.add_parser("copy", help="copy scenarios, with the meshes and paths they need")
    copying.add_argument("folder", type=Path, metavar="DIR", help="where to; made when it is missing")
    copying.add_argument("names", nargs="*", metavar="NAME", help="scenarios or folders of them (default: all)")
    copying.set_defaults(command=_copy)
    importing = commands.add_parser("import", help="make a scenario file of an experiment of localPlannerBench")
    importing.add_argument("experiment", type=Path, metavar="exp.yaml", help="the experiment file")
    importing.add_argument("--output", type=Path, metavar="FILE", help="scenario file to write (default: print it)")
    importing.set_defaults(command=_import)
    return parser


def _list(options: argparse.Namespace) -> None:
    from pytest_lpb.scenario.shelf import HEADS, scenarios_in, table, tagged

    entries = tagged(scenarios_in(shipped_folder("scenarios")), options.tags, options.robot)
    print("\n".join(aligned(table(entries), left=len(HEADS))))
    found = _count(len(entries))
    print(f"{found}; difficulty: planners of pytest-lpb that are known to fail, if only on some seeds")


def _copy(options: argparse.Namespace) -> None:
    from pytest_lpb.scenario.copying import copy_scenarios
    from pytest_lpb.scenario.shelf import named, scenarios_in, studies_in

    folder = shipped_folder("scenarios")
    studies = [] if options.names else studies_in(folder)
    copies = copy_scenarios(named(scenarios_in(folder), options.names), folder, options.folder, studies)
    print(f"{_count(len(copies))} copied to {options.folder}; run one, for example:")
    print(f"    {shlex.join(['pytest', '--lpb-planners=pd', str(copies[0])])}")


def _count(scenarios: int) -> str:
    return f"{scenarios} scenario{'' if scenarios == 1 else 's'}"


def _import(options: argparse.Namespace) -> None:
    # Imported here: `--help` needs none of it.
    from pytest_lpb.scenario.importing import import_experiment

    experiment, output = options.experiment, options.output
    if output is not None and output.exists():
        raise LpbError(f"{output} is there already; choose another --output")
    imported = import_experiment(experiment)
    text = imported.text(experiment.name)
    _check(text, experiment)
    for line in imported.left_out:
        print(f"lpb-scenarios: not carried over: {line}", file=sys.stderr)
    if output is None:
        print(text, end="")
        return
    output.parent.mkdir(parents=True, exist_ok=True)
    replace_file(output, text.encode())


def _check(text: str, experiment: Path) -> None:
    """Raise LpbError unless the text is a scenario file."""
    import tempfile

    from pytest_lpb.errors import ScenarioError
    from pytest_lpb.scenario.load import load_scenario

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "imported.yaml"
        path.write_text(text, encoding="utf-8")
        try:
            load_scenario(path)
        except ScenarioError as error:
            faults = "; ".join(fault.replace(str(path), "the scenario") for fault in error.faults)
            raise LpbError(f"{experiment}: what it says makes no scenario: {faults}") from None


if __name__ == "__main__":
    sys.exit(main())
