"""The value of a planner file's `ssh`: a host, with options as for the program ssh."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from getopt import GetoptError, gnu_getopt

# Of OpenSSH; a colon follows those with a value.
OPTIONS = "46AaCfGgKkMNnqsTtVvXxYyB:b:c:D:E:e:F:I:i:J:L:l:m:O:o:P:p:Q:R:S:W:w:"
FILES = ("-F", "-i")  # options whose values are files


def _parted(text: str) -> tuple[list[tuple[str, str]], list[str]]:
    """Options with their values, and what is left. Raises ValueError or GetoptError."""
    return gnu_getopt(shlex.split(text), OPTIONS)


def destination(text: str) -> str:
    """The host, as it is told in messages."""
    return _parted(text)[1][0]


def with_paths(text: str, change: Callable[[str], str]) -> str:
    """The same with the paths of files changed."""
    options, hosts = _parted(text)
    changed = [(name, change(value) if name in FILES else value) for name, value in options]
    return shlex.join([*(word for pair in changed for word in pair if word), *hosts])


def faults_of_ssh(text: str) -> Iterator[str]:
    """What is wrong with the text."""
    try:
        hosts = _parted(text)[1]
    except (GetoptError, ValueError) as error:
        yield f"found {text!r}: {error}; write user@host, with options as for ssh"
        return
    if len(hosts) != 1:
        yield f"found {text!r}, which names {len(hosts)} hosts; write user@host, with options as for ssh"
