"""Another host, reached by ssh: the words that start something there, and what is told when that fails."""

from __future__ import annotations

import os
import shlex
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from pytest_lpb.isolation.settings import Isolation

# Never a question, and no terminal, which would change bytes.
FIRST = ("ssh", "-T", "-o", "BatchMode=yes")
# Behind the user's own, which win: a host that is not there, or no more, is noticed within seconds.
LAST = ("-o", "ConnectTimeout=10", "-o", "ServerAliveInterval=5", "-o", "ServerAliveCountMax=3")
OF_SSH = 255  # exit code of ssh for its own failures; others are those of what was started there
NOT_THERE = (126, 127)  # exit codes of `env` for what it cannot run


def ssh_words(isolation: Isolation, started: Sequence[str]) -> list[str]:
    """The command that starts something on the host."""
    # The shell over there splits what ssh sends it.
    return [*FIRST, *shlex.split(isolation.ssh or ""), *LAST, shlex.join(started)]


def reason_of_ssh(isolation: Isolation, error: subprocess.CalledProcessError, python: str) -> str:
    """Why an interpreter on the host did not start."""
    reason = last_words(error)
    if error.returncode == OF_SSH:
        return f"{isolation.place} cannot be reached by ssh ({reason})"
    if error.returncode in NOT_THERE:
        return f"{isolation.place} has no {python} that can be run ({reason}); name another with `python`"
    return f"{python} at {isolation.place} did not start as a Python interpreter ({reason})"


def last_words(error: subprocess.CalledProcessError) -> str:
    """The last line that a command wrote to its standard error, else its exit code."""
    lines = [line.strip() for line in str(error.stderr or "").splitlines() if line.strip()]
    return lines[-1] if lines else f"exit code {error.returncode}"


@contextmanager
def collected_errors() -> Iterator[tuple[str, int]]:
    """A named pipe that a process started within can write its standard error to, and its end for reading.

    Reading it comes to an end when nobody writes any more, this block included.
    """
    with tempfile.TemporaryDirectory(prefix="lpb-") as folder:
        path = Path(folder, "stderr")
        os.mkfifo(path)
        # Each end waits for the other, unless it is asked not to.
        reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        writer = os.open(path, os.O_WRONLY)
        os.set_blocking(reader, True)
        try:
            yield str(path), reader
        finally:
            os.close(writer)
