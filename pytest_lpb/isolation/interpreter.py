"""A Python interpreter, here or on another host, that execnet starts and connects to."""

from __future__ import annotations

import shlex
import socket
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from shutil import which
from typing import Any

import execnet

from pytest_lpb.errors import PlannerError
from pytest_lpb.isolation.far.stream import ChannelStream, Stream
from pytest_lpb.isolation.process import Tail, end_of, has_ended, kill_group
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.isolation.sources import boot_source, far_sources

OLDEST = (3, 8)  # what the far side is written for
START_S = 60.0  # [s] within which an interpreter must say hello
END_S = 1.0  # [s] for what is left to read of a process that has ended
# One thread for linear algebra, as in this process: what a planner gains by more depends on who else runs.
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM")}
OF_THIS_INTERPRETER = ("PYTHONPATH", "PYTHONHOME")


def gateway_spec(isolation: Isolation) -> execnet.XSpec:
    """What execnet is to start."""
    environment = {**ONE_THREAD, **isolation.environment}
    words = ["env", *(f"{name}={value}" for name, value in environment.items())]
    if isolation.python and not isolation.ssh:
        words[1:1] = [word for name in OF_THIS_INTERPRETER if name not in environment for word in ("-u", name)]
    words.append(isolation.python or ("python3" if isolation.ssh else sys.executable))
    # Set as attributes: in execnet's own notation no value could hold a double slash.
    spec = execnet.XSpec("popen" if not isolation.ssh else f"ssh=-o BatchMode=yes {isolation.ssh}")
    spec.python = shlex.join(words)
    return spec


class Interpreter:
    """A started interpreter, ready for messages.

    On this host calls go through a socket, which is several times as fast as execnet's channel, and what is printed
    through another; execnet starts the process and sends it its first code.

    Raises PlannerError when it cannot be started, or lacks what it needs.
    """

    def __init__(self, isolation: Isolation) -> None:
        program = isolation.python or sys.executable
        if not isolation.ssh and which(program) is None:
            raise PlannerError(f"python: {program} is no program that can be run")
        if isolation.python and not isolation.ssh:
            _check_python(isolation)
        self.about: dict[str, Any] = {}
        self._place = isolation.place
        self._pid = 0  # of a process on this host
        self._tail = Tail()
        self._calls: socket.socket | None = None
        self._group = execnet.Group()
        try:
            self._start(isolation)
        except BaseException:
            self.kill()
            raise

    def _start(self, isolation: Isolation) -> None:
        try:
            channel = self._group.makegateway(gateway_spec(isolation)).remote_exec(boot_source())
            if isolation.ssh:
                hello = _hello(channel, "")
                self._stream: Stream | ChannelStream = ChannelStream(channel)
            else:
                hello = self._connected(channel)
        except (EOFError, OSError, execnet.HostNotFound, execnet.TimeoutError, execnet.RemoteError) as error:
            text = f"{type(error).__name__}: {error}".strip().rpartition("\n")[2]
            raise PlannerError(f"{self._place} did not start as a Python interpreter ({text})") from None
        self.about = {key: hello[key] for key in ("python", "numpy")}
        if tuple(map(int, hello["python"].split(".")[:2])) < OLDEST:
            raise PlannerError(f"{self._place} is Python {hello['python']}; 3.8 or newer is needed")
        if hello["numpy"].startswith("missing"):
            raise PlannerError(f"{self._place} has no NumPy, which is needed there ({hello['numpy']})")

    def _connected(self, channel: execnet.Channel) -> dict[str, Any]:
        """Have the process connect to two sockets: for calls, and for what it prints."""
        with tempfile.TemporaryDirectory(prefix="lpb-") as folder, socket.socket(socket.AF_UNIX) as server:
            path = str(Path(folder, "s"))
            server.bind(path)
            server.listen(2)
            hello = _hello(channel, path)
            server.settimeout(START_S)
            self._calls, output = server.accept()[0], server.accept()[0]
        self._pid = hello["pid"]
        self._tail.read_from(output.detach())
        self._calls.setblocking(False)
        descriptor = self._calls.fileno()
        self._stream = Stream(descriptor, descriptor, lambda: not has_ended(self._pid))
        return hello

    def send(self, header: Mapping[str, Any], payload: bytes = b"", timeout_s: float | None = None) -> None:
        """Send a message."""
        self._stream.send(header, payload, timeout_s)

    def receive(self, timeout_s: float | None) -> tuple[dict[str, Any], bytes]:
        """The next message."""
        return self._stream.receive(timeout_s)

    def ending(self) -> str:
        """How the process ended, once its stream has."""
        return end_of(self._pid) if self._pid else ""

    def kill(self) -> None:
        """End the process, with whatever it has started."""
        if self._pid:
            kill_group(self._pid)
        with suppress(OSError):
            self._group.terminate(timeout=END_S)
        if self._calls is not None:
            self._calls.close()
        self._tail.join(END_S)

    def output(self) -> str:
        """The last of what was printed; of another host none."""
        return self._tail.text


def _check_python(isolation: Isolation) -> None:
    """Raises PlannerError for a program that is no Python of the last years: execnet would leave it behind."""
    words = shlex.split(str(gateway_spec(isolation).python))
    command = [*words, "-c", "import sys; print(*sys.version_info[:2])"]
    try:
        said = subprocess.run(command, capture_output=True, text=True, check=True, timeout=START_S).stdout
        version = tuple(map(int, said.split()))
    except (OSError, ValueError, subprocess.SubprocessError):
        raise PlannerError(f"{isolation.place} did not start as a Python interpreter") from None
    if version < OLDEST:
        raise PlannerError(f"{isolation.place} is Python {'.'.join(map(str, version))}; 3.8 or newer is needed")


def _hello(channel: execnet.Channel, path: str) -> dict[str, Any]:
    channel.send({"socket": path, "sources": far_sources()})
    hello: dict[str, Any] = channel.receive(START_S)
    return hello
