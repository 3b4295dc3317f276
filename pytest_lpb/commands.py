"""What the package's commands share: how arguments are read, and how a command ends that cannot do what was asked."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from typing import NoReturn, TextIO, cast

from pytest_lpb.errors import LpbError, StorageError
from pytest_lpb.shown import VisibleStream, visible

EXIT_INTERRUPTED = 2  # as pytest's
EXIT_USAGE = 4  # as pytest's


class Parser(argparse.ArgumentParser):
    """Ends with the exit code that pytest has for wrong arguments."""

    def error(self, message: str) -> NoReturn:
        """Print usage and message."""
        self.print_usage(sys.stderr)
        self.exit(EXIT_USAGE, f"{self.prog}: error: {message}\n")


def by_commas(text: str) -> list[str]:
    """Names between commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def _visible(stream: TextIO) -> TextIO:
    return cast(TextIO, VisibleStream(stream))


def ended(command: str, work: Callable[[], int], hint: str = "") -> int:
    """Exit code of a command's work; faults are told on stderr.

    Args:
        command: its name, with which messages begin.
        work: what it does; gives its exit code.
        hint: what to do about a file that cannot be written.
    """
    try:
        with redirect_stdout(_visible(sys.stdout)), redirect_stderr(_visible(sys.stderr)):
            return work()
    except StorageError as error:
        print(visible(f"{command}: error: {error}{hint}"), file=sys.stderr)
    except LpbError as error:
        print(visible(f"{command}: error: {error}"), file=sys.stderr)
    except KeyboardInterrupt:
        # Files appear whole or not at all: those that are not new are the old ones.
        print(f"{command}: interrupted; nothing is half written", file=sys.stderr)
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        # The reader, such as `head`, has seen enough.
        sys.stderr.close()
        return 0
    except OSError as error:
        # One without a file is of no file that we write, such as a process that cannot be started.
        what = f"cannot write {error.filename}: {error.strerror}{hint}" if error.filename else str(error)
        print(visible(f"{command}: error: {what}"), file=sys.stderr)
    return EXIT_USAGE
