"""Stands between us and a planner's program: run as a script, with the standard library only.

    python -I -S supervisor.py MEGABYTES PROGRAM ARGUMENT ..

It limits the program's memory, ends as the program does, and ends the whole process group when its standard input is
closed at the other end: a program in the middle of a computation does not read that nobody listens any more.
"""

import os
import resource
import select
import signal
import sys
from contextlib import suppress

BYTES_PER_MB = 10**6
NOT_STARTED = 126
LOOK_MS = 200  # between two looks at the program, where the system does not tell of its end


def main() -> None:
    """Start the program, and wait for its end or ours."""
    megabytes, program = int(sys.argv[1]), sys.argv[2:]
    pid = os.fork()
    if pid == 0:
        become(program, megabytes)
    leave_output()
    status = end_of(pid)
    if status is None:
        os.killpg(0, signal.SIGKILL)  # this process too
    elif os.WIFSIGNALED(status):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # one core file is enough
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        os.kill(os.getpid(), os.WTERMSIG(status))
    else:
        os._exit(os.waitstatus_to_exitcode(status))


def become(program: list[str], megabytes: int) -> None:
    """Be the program from now on."""
    for number in (signal.SIGPIPE, signal.SIGXFSZ):
        signal.signal(number, signal.SIG_DFL)  # Python ignores them, which programs inherit
    try:
        if megabytes:
            resource.setrlimit(resource.RLIMIT_AS, (megabytes * BYTES_PER_MB,) * 2)
        os.execvp(program[0], program)
    except (OSError, ValueError) as error:
        os.write(2, f"cannot run {program[0]}: {error}\n".encode())
    os._exit(NOT_STARTED)


def leave_output() -> None:
    """Leave standard output and error to the program: they end with it."""
    nothing = os.open(os.devnull, os.O_WRONLY)
    for standard in (1, 2):
        os.dup2(nothing, standard)


def end_of(pid: int) -> "int | None":
    """The status with which a process ended; None when standard input was closed before."""
    poll = select.poll()
    poll.register(0, 0)  # its closing is told in any case
    told = LOOK_MS
    with suppress(AttributeError, OSError):  # Linux alone has it
        poll.register(os.pidfd_open(pid), select.POLLIN)
        told = None  # type: ignore[assignment] # no limit
    while True:
        events = dict(poll.poll(told))
        ended, status = os.waitpid(pid, os.WNOHANG)
        if ended:
            return status
        if 0 in events:
            return None


if __name__ == "__main__":
    main()
