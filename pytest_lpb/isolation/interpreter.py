"""A Python interpreter, here or on another host, that execnet starts and connects to."""

from __future__ import annotations

import shlex
import socket
import subprocess
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import execnet
from execnet.gateway_io import popen_bootstrapline

from pytest_lpb.errors import PlannerError
from pytest_lpb.isolation.far.stream import ChannelStream, Stream
from pytest_lpb.isolation.host import collected_errors, ssh_words
from pytest_lpb.isolation.probe import START_S, check_interpreter, check_version, interpreter_words
from pytest_lpb.isolation.process import END_S, SPIN_S, Tail, end_of, kill_group
from pytest_lpb.isolation.settings import Isolation
from pytest_lpb.isolation.sources import boot_source, far_sources

TOLD_BY_SSH = {"ended with exit code 255": "was ended by a signal, or the connection was lost"}


def gateway_spec(isolation: Isolation, errors: str = "") -> execnet.XSpec:
    """What execnet is to start; ssh writes to the file `errors` what it and the planner there have to say."""
    words = interpreter_words(isolation)
    if isolation.ssh:
        # Execnet's own words for ssh leave no say in its standard error, nor in how it takes Ctrl-C.
        ssh = shlex.join(ssh_words(isolation, [*words, "-u", "-c", popen_bootstrapline]))
        words = ["sh", "-c", f"trap '' INT; exec {ssh} 2>{shlex.quote(errors)}"]
    spec = execnet.XSpec("popen")
    # Set as an attribute: in execnet's own notation no value could hold a double slash.
    spec.python = shlex.join(words)
    return spec


class Interpreter:
    """A started interpreter, ready for messages.

    On this host calls go through a socket, which is several times as fast as execnet's channel, and what is printed
    through another; execnet starts the process and sends it its first code.

    Raises PlannerError when it cannot be started, or lacks what it needs.
    """

    def __init__(self, isolation: Isolation) -> None:
        check_interpreter(isolation)
        self.about: dict[str, Any] = {}
        self._isolation = isolation
        self._process: subprocess.Popen[bytes] | None = None  # on this host: the interpreter, or ssh
        self._group_id = 0  # of the processes on this host
        self._tail = Tail()
        self._calls: socket.socket | None = None
        self._group = execnet.Group()
        try:
            self._start()
        except BaseException:
            self.kill()
            raise

    def _start(self) -> None:
        place = self._isolation.place
        try:
            hello = self._there() if self._isolation.ssh else self._here()
        except (EOFError, OSError, AssertionError, execnet.TimeoutError, execnet.RemoteError) as error:
            text = f"{type(error).__name__}: {error}".strip().rpartition("\n")[2]
            raise PlannerError(f"{place} did not start as a Python interpreter ({text})") from None
        self.about = {key: hello[key] for key in ("python", "numpy")}
        check_version(place, hello["python"])
        if hello["numpy"].startswith("missing"):
            raise PlannerError(f"{place} has no NumPy, which is needed there ({hello['numpy']})")

    def _there(self) -> dict[str, Any]:
        """Start on another host: all goes through execnet's channel, and what is printed through ssh's errors."""
        with collected_errors() as (path, reader):
            self._tail.read_from(reader)
            channel = self._started(gateway_spec(self._isolation, path))
            hello = _hello(channel, "")
        self._stream: Stream | ChannelStream = ChannelStream(channel)
        return hello

    def _here(self) -> dict[str, Any]:
        """Start on this host."""
        return self._connected(self._started(gateway_spec(self._isolation)))

    def _started(self, spec: execnet.XSpec) -> execnet.Channel:
        """Start the process; a channel to its first code."""
        gateway = self._group.makegateway(spec)
        self._process = gateway._io.popen  # type: ignore[attr-defined] # of the one kind that starts a process
        return gateway.remote_exec(boot_source())

    def _connected(self, channel: execnet.Channel) -> dict[str, Any]:
        """Have the process connect to two sockets: for calls, and for what it prints."""
        with tempfile.TemporaryDirectory(prefix="lpb-") as folder, socket.socket(socket.AF_UNIX) as server:
            path = str(Path(folder, "s"))
            server.bind(path)
            server.listen(2)
            hello = _hello(channel, path)
            server.settimeout(START_S)
            self._calls, output = server.accept()[0], server.accept()[0]
        self._group_id = hello["pid"]
        self._tail.read_from(output.detach())
        self._calls.setblocking(False)
        descriptor = self._calls.fileno()
        self._stream = Stream(descriptor, descriptor, self._lives, SPIN_S)
        return hello

    def _lives(self) -> bool:
        return self._process is not None and self._process.poll() is None

    def send(self, header: Mapping[str, Any], payload: bytes = b"", timeout_s: float | None = None) -> None:
        """Send a message."""
        self._stream.send(header, payload, timeout_s)

    def receive(self, timeout_s: float | None) -> tuple[dict[str, Any], bytes]:
        """The next message."""
        return self._stream.receive(timeout_s)

    def ending(self) -> str:
        """How the process ended, once its stream has."""
        how = "" if self._process is None else end_of(self._process)
        return TOLD_BY_SSH.get(how, how) if self._isolation.ssh else how

    def kill(self) -> None:
        """End the process, with whatever it has started."""
        if self._group_id:
            kill_group(self._group_id)
        elif self._process is not None:
            self._process.kill()  # ssh: the far side watches the connection
        with suppress(OSError):
            self._group.terminate(timeout=END_S)
        if self._calls is not None:
            self._calls.close()
        self._tail.join(END_S)

    def output(self) -> str:
        """The last of what was printed."""
        return self._tail.text


def _hello(channel: execnet.Channel, path: str) -> dict[str, Any]:
    channel.send({"socket": path, "sources": far_sources()})
    hello: dict[str, Any] = channel.receive(START_S)
    return hello
