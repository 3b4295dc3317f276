"""Where a planner runs, and within which limits: the keys of a planner file."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from shutil import which
from typing import Any

from pytest_lpb.isolation.ssh_options import destination, faults_of_ssh, with_paths

ELSEWHERE = ("python", "ssh", "command")  # keys that name another interpreter or program
KEYS = (*ELSEWHERE, "preview", "environment", "working_dir", "isolate", "deadline_s", "setup_deadline_s", "memory_mb")


@dataclass(frozen=True)
class Isolation:
    """A planner's own process. Picklable."""

    python: str | None = None  # an interpreter, on the host `ssh` if there is one
    ssh: str | None = None  # user@host, with options of ssh
    command: tuple[str, ...] = ()  # a program that speaks the protocol over stdin and stdout
    preview: Mapping[str, Any] = field(default_factory=dict)  # `steps` and `step_s` [s] that the program wants to see
    environment: Mapping[str, str] = field(default_factory=dict)  # added to this process's
    working_dir: str | None = None  # None: this process's
    isolate: bool = False
    deadline_s: float | None = None  # [s] of one call
    setup_deadline_s: float | None = None  # [s] of the process's start and the planner's setup
    memory_mb: int | None = None  # [10^6 bytes] of address space

    @property
    def same_interpreter(self) -> bool:
        """Whether the process runs this interpreter, where everything of ours is installed."""
        return not (self.python or self.ssh or self.command)

    @property
    def place(self) -> str:
        """Where the planner runs, in messages."""
        host = destination(self.ssh) if self.ssh else ""
        return host or (self.command[0] if self.command else "") or self.python or "its own process"

    def to_dict(self) -> dict[str, Any]:
        """The keys of a planner file that give this; those with their defaults are left out."""
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        values["command"] = list(self.command)
        values["environment"] = dict(self.environment)
        values["preview"] = dict(self.preview)
        return {key: value for key, value in values.items() if value}

    def hashed(self) -> dict[str, Any]:
        """What of it decides what the planner does, on any machine: no paths; `isolate` changes no result."""
        values = self.to_dict()
        for key in ("isolate", "working_dir"):
            values.pop(key, None)
        for key in ("python", "ssh"):
            if key in values:
                values[key] = True
        if self.command:
            values["command"] = [Path(self.command[0]).name, *self.command[1:]]
        return values


def isolation_of(values: Mapping[str, Any], folder: Path) -> Isolation | None:
    """The isolation that the keys of a planner file ask for; None for none.

    Paths with a slash are relative to a folder, the file's; programs without one are looked up in PATH, as in a shell.
    """
    given = {key: value for key, value in values.items() if key in KEYS and value}
    if not given:
        return None
    command = given.get("command", ())
    command = tuple(shlex.split(command) if isinstance(command, str) else command)
    isolation = replace(Isolation(**{**given, "isolate": True}), command=command)
    if command:
        isolation = replace(isolation, command=(_program(command[0], folder), *command[1:]))
    if isolation.python and not isolation.ssh:
        isolation = replace(isolation, python=_program(isolation.python, folder))
    if isolation.ssh:
        isolation = replace(isolation, ssh=with_paths(isolation.ssh, lambda path: _program(path, folder)))
    if isolation.working_dir and not isolation.ssh:
        isolation = replace(isolation, working_dir=str((folder / Path(isolation.working_dir).expanduser()).absolute()))
    return isolation


def faults_here(isolation: Isolation) -> Iterator[tuple[str, str]]:
    """Keys that name what is not on this host, each with what is wrong."""
    if isolation.command and which(isolation.command[0]) is None:
        yield "command", f"{isolation.command[0]} is no program that can be run"
    if isolation.ssh:
        return
    if isolation.python and which(isolation.python) is None:
        yield "python", f"{isolation.python} is no program that can be run"
    if isolation.working_dir and not Path(isolation.working_dir).is_dir():
        yield "working_dir", f"{isolation.working_dir} is no folder"


def _program(name: str, folder: Path) -> str:
    if "/" not in name:
        return name
    # Not resolved: the interpreter of a virtual environment is a link, which says where its packages are.
    return str(Path(folder / Path(name).expanduser()).absolute())


def faults_of(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Keys that do not fit together, each with what is wrong."""
    if values.get("command") and (values.get("python") or values.get("ssh")):
        yield "command", "a program needs no `python` or `ssh`; write `command: ssh host program` for another host"
    if values.get("ssh"):
        yield from (("ssh", fault) for fault in faults_of_ssh(values["ssh"]))
    if values.get("preview") and not values.get("command"):
        yield "preview", "is for programs (`command`); a class says what it wants to see: `preview = Preview(..)`"
    if values.get("planner") and values.get("command"):
        yield "planner", "a program (`command`) has no class; leave this key out"
    if values.get("isolate") is False and any(values.get(key) for key in KEYS):
        yield "isolate", "found false, but other keys ask for a process of its own; leave this key out"
