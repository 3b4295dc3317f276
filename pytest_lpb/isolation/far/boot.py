"""The first code in the far process: says who it is, then serves. Executed by execnet, which gives it `channel`."""

import os
import select
import socket
import sys
import warnings

OLDEST = (3, 8)
KILLED_WITH_PARENT = 1  # PR_SET_PDEATHSIG of Linux
SIGKILL = 9
CLOSED = select.POLLHUP | getattr(select, "POLLRDHUP", 0)
LOOK_MS = 500.0  # between two looks whether the watched process lives


def own_group():
    # type: () -> None
    """Leave the terminal's process group, whose Ctrl-C is not for planners; end when the parent does."""
    if os.getsid(0) != os.getpid():  # as it is over ssh: then the group is its own already
        os.setpgid(0, 0)
    if sys.platform == "linux":
        import ctypes

        ctypes.CDLL(None).prctl(KILLED_WITH_PARENT, SIGKILL)


def watch(connection):
    # type: (int) -> None
    """Have a child end this process's group when a connection closes, or this process ends.

    Over ssh nobody else can: what runs there is told of nothing but the end of its standard input.
    """
    watched = os.getpid()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a fork beside execnet's thread: the child needs nothing of it
        if os.fork():
            return
    poll = select.poll()
    poll.register(connection, CLOSED)
    while os.getppid() == watched and not poll.poll(LOOK_MS):
        pass
    os.killpg(os.getpgid(0), SIGKILL)


def connected(path):
    # type: (str) -> socket.socket
    """A connection to the process that started this one."""
    connection = socket.socket(socket.AF_UNIX)
    connection.connect(path)
    return connection


def redirect(output):
    # type: (int) -> None
    """Send all that is printed, from C too, to a descriptor; the protocol's own are others."""
    for standard in (1, 2):
        os.dup2(output, standard)


def numpy_version():
    # type: () -> str
    """Version of NumPy, or why there is none."""
    try:
        import numpy as np
    except Exception as error:
        return "missing: " + str(error).split("\n")[0]
    return str(np.__version__)


def main(channel):
    # type: (object) -> None
    """Say hello, then serve."""
    start = channel.receive()  # type: ignore[attr-defined] # of execnet
    own_group()
    calls = None
    if start["socket"]:
        calls, output = connected(start["socket"]), connected(start["socket"])
        redirect(output.fileno())
        output.close()
    else:
        redirect(2)  # ssh brings it home
        watch(channel.gateway._io.infile.fileno())  # type: ignore[attr-defined] # of execnet
    numpy = numpy_version() if sys.version_info >= OLDEST else "not looked for"
    hello = {"pid": os.getpid(), "python": ".".join(map(str, sys.version_info[:3])), "numpy": numpy}
    channel.send(hello)  # type: ignore[attr-defined] # of execnet
    if sys.version_info < OLDEST or numpy.startswith("missing"):
        return
    importer = {"__name__": "shipped"}
    exec(start["sources"]["pytest_lpb.isolation.far.shipped"], importer)
    importer["install"](start["sources"])  # type: ignore[operator] # a function of that source
    from pytest_lpb.isolation.far.serve import serve
    from pytest_lpb.isolation.far.stream import ChannelStream, Stream

    serve(ChannelStream(channel) if calls is None else Stream(calls.fileno(), calls.fileno()))


if __name__ == "__channelexec__":
    main(channel)  # type: ignore[name-defined] # noqa: F821 - given by execnet
