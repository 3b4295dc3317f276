"""Messages over descriptors, or over a channel of execnet; the same at both sides."""

from __future__ import annotations

import os
import select
from collections.abc import Callable, Mapping
from time import monotonic
from typing import Any

from pytest_lpb.isolation.far.messages import decode, encode

CHUNK = 1 << 16  # bytes
LONGEST = 100000000  # bytes of a message
# Not every system has it; without, the other side waits for another core.
_let_others_run = getattr(os, "sched_yield", lambda: None)
LOOK_S = 1.0  # [s] between two looks whether the other side still lives


class Stream:
    """A pair of descriptors.

    Args:
        source: read from.
        sink: written to.
        alive: says whether the other side lives: a process that it has left behind may keep its descriptors open.
        spin_s: time [s] to look for an answer again and again before sleeping: waking up takes longer than short calls.
    """

    def __init__(self, source: int, sink: int, alive: Callable[[], bool] | None = None, spin_s: float = 0.0) -> None:
        self._source, self._sink, self._alive, self._spin_s = source, sink, alive, spin_s
        self._received = bytearray()
        self._readable, self._writable = select.poll(), select.poll()
        self._readable.register(source, select.POLLIN)
        self._writable.register(sink, select.POLLOUT)

    def send(self, header: Mapping[str, Any], payload: bytes = b"", timeout_s: float | None = None) -> None:
        """Write a message. Raises EOFError when nobody reads, TimeoutError when nobody does in time."""
        left = memoryview(encode(header, payload))
        until = None if timeout_s is None else monotonic() + timeout_s
        while left:
            try:
                left = left[os.write(self._sink, left) :]
            except BlockingIOError:
                self._wait(self._writable, until)
            except (BrokenPipeError, ConnectionResetError):
                raise EOFError("nobody reads") from None

    def receive(self, timeout_s: float | None = None) -> tuple[dict[str, Any], bytes]:
        """The next message. Raises EOFError at the end, TimeoutError, and ValueError for what is no message."""
        until = None if timeout_s is None else monotonic() + timeout_s
        end = self._received.find(b"\n")
        while end < 0:
            searched = len(self._received)
            self._read(until)
            end = self._received.find(b"\n", searched)
        header, _ = decode(bytes(self._received[: end + 1]))
        size = header.get("bytes", 0)
        if not (isinstance(size, int) and 0 <= size <= LONGEST):
            raise ValueError("`bytes` is " + repr(size) + "; allowed are 0 to " + str(LONGEST))
        stop = end + 1 + size
        while len(self._received) < stop:
            self._read(until)
        payload = bytes(self._received[end + 1 : stop])
        del self._received[:stop]
        return header, payload

    def has_more(self) -> bool:
        """Whether there is something to read already."""
        return bool(self._received) or any(events & select.POLLIN for _, events in self._readable.poll(0))

    def _read(self, until: float | None) -> None:
        if len(self._received) > LONGEST:
            raise ValueError("it has more than " + str(LONGEST) + " bytes")
        self._wait(self._readable, until)
        try:
            chunk = os.read(self._source, CHUNK)
        except ConnectionResetError:
            chunk = b""
        if not chunk:
            raise EOFError("nobody writes")
        self._received += chunk

    def _wait(self, poll: Any, until: float | None) -> None:
        """Until a descriptor is ready. Raises TimeoutError at that time, though more and more may come."""
        spun = monotonic() + self._spin_s
        while self._spin_s and monotonic() < spun:
            if poll.poll(0):
                return
            _let_others_run()
        while True:
            left_s = LOOK_S if until is None else min(LOOK_S, max(0.0, until - monotonic()))
            ready = poll.poll(left_s * 1000.0)
            if until is not None and monotonic() >= until:
                raise TimeoutError
            if ready:
                return
            if self._alive is not None and not self._alive():
                raise EOFError("the process has ended")


class ChannelStream:
    """A channel of execnet, one item per message."""

    def __init__(self, channel: Any) -> None:
        self._channel = channel

    def send(self, header: Mapping[str, Any], payload: bytes = b"", timeout_s: float | None = None) -> None:  # noqa: ARG002
        """Send a message; the other side's thread takes it at any time."""
        try:
            self._channel.send(encode(header, payload))
        except OSError as error:
            raise EOFError(str(error)) from None

    def receive(self, timeout_s: float | None = None) -> tuple[dict[str, Any], bytes]:
        """The next message."""
        try:
            message = self._channel.receive(timeout_s)
        except self._channel.TimeoutError:
            raise TimeoutError from None
        except self._channel.RemoteError as error:
            raise EOFError(str(error)) from None
        return decode(message)
