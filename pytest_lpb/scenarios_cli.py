"""`lpb-scenarios`: scenario files from elsewhere."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from pytest_lpb import __version__
from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.errors import LpbError

EXIT_USAGE = 4


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `lpb-scenarios`. Returns 0, or 4 for wrong arguments and files that cannot be used."""
    options = _parser().parse_args(arguments)
    try:
        _import(options.experiment, options.output)
    except LpbError as error:
        print(f"lpb-scenarios: error: {error}", file=sys.stderr)
        return EXIT_USAGE
    except OSError as error:
        print(f"lpb-scenarios: error: cannot write {error.filename}: {error.strerror}", file=sys.stderr)
        return EXIT_USAGE
    return 0


class _Parser(argparse.ArgumentParser):
    """Ends with the exit code that pytest has for wrong arguments."""

    def error(self, message: str) -> NoReturn:
        """Print usage and message."""
        self.print_usage(sys.stderr)
        self.exit(EXIT_USAGE, f"{self.prog}: error: {message}\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="lpb-scenarios", description=__doc__, allow_abbrev=False)
    parser.add_argument("--version", action="version", version=f"pytest-lpb {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    importing = commands.add_parser("import", help="make a scenario file of an experiment of localPlannerBench")
    importing.add_argument("experiment", type=Path, metavar="exp.yaml", help="the experiment file")
    importing.add_argument("--output", type=Path, metavar="FILE", help="scenario file to write (default: print it)")
    return parser


def _import(experiment: Path, output: Path | None) -> None:
    # Imported here: `--help` needs none of it.
    from pytest_lpb.scenario.importing import import_experiment

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
