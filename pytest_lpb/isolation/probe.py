"""The words that start an interpreter, and whether one starts: asked before execnet is let at it."""

from __future__ import annotations

import re
import subprocess
import sys
from functools import cache

from pytest_lpb.errors import PlannerError
from pytest_lpb.isolation.host import last_words, reason_of_ssh, ssh_words
from pytest_lpb.isolation.settings import Isolation

OLDEST = (3, 8)  # what the far side is written for
START_S = 60.0  # [s] within which an interpreter must answer
# One thread for linear algebra, as in this process: what a planner gains by more depends on who else runs.
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM")}
OF_THIS_INTERPRETER = ("PYTHONPATH", "PYTHONHOME")
SHOWN = 80  # characters of what is no version
QUESTION = "import sys; print('%d %d' % sys.version_info[:2])"


def interpreter_words(isolation: Isolation) -> list[str]:
    """The command that starts the interpreter, here or there."""
    environment = {**ONE_THREAD, **isolation.environment}
    words = ["env", *(f"{name}={value}" for name, value in environment.items())]
    if isolation.python and not isolation.ssh:
        words[1:1] = [word for name in OF_THIS_INTERPRETER if name not in environment for word in ("-u", name)]
    return [*words, _interpreter(isolation)]


def _interpreter(isolation: Isolation) -> str:
    return isolation.python or ("python3" if isolation.ssh else sys.executable)


def check_interpreter(isolation: Isolation) -> None:
    """Raises PlannerError when no Python of the last years starts there.

    Execnet would say less, and leave behind what it has started.
    """
    if isolation.same_interpreter:
        return
    python = _interpreter(isolation)
    asked = [*interpreter_words(isolation), "-c", QUESTION]
    command = tuple(ssh_words(isolation, asked)) if isolation.ssh else tuple(asked)
    try:
        said = _said(command)
    except subprocess.CalledProcessError as error:
        if isolation.ssh:
            raise PlannerError(reason_of_ssh(isolation, error, python)) from None
        raise PlannerError(f"{isolation.place} did not start as a Python interpreter ({last_words(error)})") from None
    except subprocess.TimeoutExpired:
        raise PlannerError(f"{isolation.place} said nothing within {START_S:g} s") from None
    except OSError as error:
        raise PlannerError(f"{command[0]} cannot be run: {error.strerror}") from None
    if not re.fullmatch(r"\d+ \d+", said):
        hint = "; what a shell runs at its start must print nothing" if isolation.ssh else ""
        raise PlannerError(
            f"{isolation.place} did not start as a Python interpreter: it printed {said[:SHOWN]!r} in place of a "
            f"version{hint}"
        )
    check_version(isolation.place, said.replace(" ", "."))


@cache
def _said(command: tuple[str, ...]) -> str:
    """What a command prints; asked once, unless it fails."""
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=True, timeout=START_S, errors="replace"
    )
    return done.stdout.strip()


def check_version(place: str, version: str) -> None:
    """Raises PlannerError for a Python that is too old."""
    if tuple(map(int, version.split(".")[:2])) < OLDEST:
        raise PlannerError(f"{place} is Python {version}; 3.8 or newer is needed")
