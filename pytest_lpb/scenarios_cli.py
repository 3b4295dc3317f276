"""`lpb-scenarios`: scenario files that come with the package, and from elsewhere."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from pytest_lpb import __version__
from pytest_lpb.aligned import aligned
from pytest_lpb.commands import Parser, by_commas, ended
from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.errors import LpbError
from pytest_lpb.names import count
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
    importing.add_argument(
        "--strict",
        action="store_true",
        help="fail where something cannot be converted, or the result cannot be run",
    )
    importing.add_argument("--output", type=Path, metavar="FILE", help="scenario file to write (default: print it)")
    importing.set_defaults(command=_import)
    for name, command, text in (
        ("keys", _keys, "all keys of scenario files with type, unit and default, as Markdown"),
        ("schema", _schema, "the JSON Schema of scenario files, for editors"),
    ):
        printing = commands.add_parser(name, help=text)
        printing.add_argument("--output", type=Path, metavar="FILE", help="file to write (default: print it)")
        printing.add_argument(
            "--plugin",
            action="append",
            default=[],
            metavar="MODULE",
            help="module, or Python file such as conftest.py, that registers robots, shapes and the like",
        )
        printing.set_defaults(command=command)
    return parser


def _keys(options: argparse.Namespace) -> None:
    from pytest_lpb.scenario.key_table import keys_page

    _print(options, keys_page)


def _schema(options: argparse.Namespace) -> None:
    from pytest_lpb.scenario.json_schema import schema_text

    _print(options, schema_text)


def _print(options: argparse.Namespace, text_of: Callable[[], str]) -> None:
    """Print or write a text that is made with what users register."""
    from pytest_lpb.run.plugins import load_plugin

    for plugin in options.plugin:
        load_plugin(plugin)
    if options.output is None:
        print(text_of(), end="")
    else:
        options.output.parent.mkdir(parents=True, exist_ok=True)
        replace_file(options.output, text_of().encode())


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
    return count(scenarios, "scenario")


def _import(options: argparse.Namespace) -> None:
    # Imported here: `--help` needs none of it.
    from pytest_lpb.scenario.import_lpb.experiment import import_experiment

    experiment, output = options.experiment, options.output
    if output is not None and output.exists():
        raise LpbError(f"{output} is there already; choose another --output")
    base = Path.cwd() if output is None else output.parent
    imported = import_experiment(experiment, base)
    text = imported.text(experiment.name)
    refused = _why_refused(text, experiment, base)
    for line in imported.lost:
        print(f"lpb-scenarios: not converted: {line}", file=sys.stderr)
    for line in imported.notes:
        print(f"lpb-scenarios: differs: {line}", file=sys.stderr)
    for line in refused:
        print(f"lpb-scenarios: warning: pytest will not run this scenario: {line}", file=sys.stderr)
    problems = len(imported.lost) + len(refused)
    if options.strict and problems:
        raise LpbError(f"{experiment}: {problems} of the lines above; nothing is written under --strict")
    if output is None:
        print(text, end="")
        return
    output.parent.mkdir(parents=True, exist_ok=True)
    replace_file(output, text.encode())


def _why_refused(text: str, experiment: Path, base: Path) -> tuple[str, ...]:
    """Why no trial of the scenario can start, such as a start in self-collision; nothing where one can.

    Raises LpbError when the text is no scenario file.
    """
    from pytest_lpb.errors import MissingRobotsError, ScenarioError
    from pytest_lpb.scenario.draw import check_feasible
    from pytest_lpb.scenario.load import load_scenario

    # Meshes are found from where the scenario will lie.
    with _temporary(text, base if " file: " in text else None) as path:
        place = re.compile(rf"^.*{re.escape(path.name)}:\d+: ")  # lines of a file that the user never sees
        try:
            scenario = load_scenario(path)
        except MissingRobotsError as error:
            return (str(error),)
        except ScenarioError as error:
            faults = "; ".join(place.sub("", fault) for fault in error.faults)
            raise LpbError(f"{experiment}: what it says makes no scenario: {faults}") from None
        try:
            check_feasible(scenario)
        except ScenarioError as error:
            return tuple(place.sub("", fault) for fault in error.faults)
    return ()


@contextmanager
def _temporary(text: str, folder: Path | None) -> Iterator[Path]:
    """A scenario file that is gone afterwards, in a folder or among the system's temporary files."""
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=folder, prefix=".import-", suffix=".yaml")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        yield Path(name)
    finally:
        Path(name).unlink()


if __name__ == "__main__":
    sys.exit(main())
