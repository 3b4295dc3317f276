"""What a planner may have changed in its process is put back after its calls, so that the next trial is not touched.

Guards code that errs, not code that hides: a planner of the same process can reach everything (isolate it).
"""

from __future__ import annotations

import contextlib
import locale
import os
import random
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Collection, Iterator
from functools import lru_cache
from types import FrameType
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import ThreadpoolController

INTERRUPTS = (signal.SIGINT, signal.SIGTERM)
SIGNALS = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGALRM", "SIGUSR1", "SIGUSR2", "SIGCHLD", "SIGPIPE")
    if hasattr(signal, name)
)
MODULE_SEARCH_PATH = "sys.path"


class UserInterruptError(KeyboardInterrupt):
    """Ctrl-C or SIGTERM, as against a KeyboardInterrupt that a planner raises by itself."""


class Part(NamedTuple):
    """One thing of a process: how it is, as a value that can be compared, and how to make it so again."""

    save: Callable[[], Any]
    put_back: Callable[[Any], object]


def _cwd() -> str | None:
    try:
        return os.getcwd()  # noqa: PTH109 - text to compare, twice per trial
    except FileNotFoundError:
        return None


def _put_back_cwd(folder: str | None) -> None:
    if folder is not None:
        os.chdir(folder)


def _put_back_environment(variables: dict[str, str]) -> None:
    for name in set(os.environ) - set(variables):
        del os.environ[name]
    os.environ.update(variables)


def _put_back_handlers(handlers: dict[int, Any]) -> None:
    if threading.current_thread() is not threading.main_thread():
        return
    for number, handler in handlers.items():
        if handler is not None and signal.getsignal(number) is not handler:
            signal.signal(number, handler)


def _timer_runs() -> bool:
    return signal.getitimer(signal.ITIMER_REAL)[0] > 0.0 if hasattr(signal, "getitimer") else False


def _stop_timer(ran: bool) -> None:
    """Stop what the planner started: it would go off in the trial of another."""
    if not ran:
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def _put_back_floats(state: tuple[dict[str, Any], Any]) -> None:
    np.seterr(**state[0])
    np.seterrcall(state[1])


@lru_cache(maxsize=1)
def _thread_pools(_modules: int) -> ThreadpoolController:
    """Libraries for linear algebra; looked up again when modules were imported meanwhile."""
    return ThreadpoolController()


def _pool_sizes() -> dict[str, int]:
    return {pool.filepath: pool.num_threads for pool in _thread_pools(len(sys.modules)).lib_controllers}


def _put_back_pool_sizes(sizes: dict[str, int]) -> None:
    for pool in _thread_pools(len(sys.modules)).lib_controllers:
        if pool.filepath in sizes:
            pool.set_num_threads(sizes[pool.filepath])


def _put_back_search_path(saved: list[str]) -> None:
    sys.path[:] = saved  # the list of now: the planner may have put another in its place


def _umask() -> str:
    """As octal digits; the system tells it only to who sets another."""
    mask = os.umask(0o077)
    os.umask(mask)
    return f"{mask:03o}"


def _cores() -> set[int]:
    """The cores that this thread may run on; empty where the system does not say."""
    return os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else set()


# What is put back, under the names that details of a trial give it.
PARTS: dict[str, Part] = {
    "the working directory": Part(_cwd, _put_back_cwd),
    "environment variables": Part(lambda: dict(os.environ), _put_back_environment),
    MODULE_SEARCH_PATH: Part(lambda: list(sys.path), _put_back_search_path),
    "signal handlers": Part(lambda: {number: signal.getsignal(number) for number in SIGNALS}, _put_back_handlers),
    "a timer": Part(_timer_runs, _stop_timer),
    "numpy's handling of floating-point errors": Part(lambda: (np.geterr(), np.geterrcall()), _put_back_floats),
    "threads of linear algebra": Part(_pool_sizes, _put_back_pool_sizes),
    "the recursion limit": Part(sys.getrecursionlimit, sys.setrecursionlimit),
    "the umask": Part(_umask, lambda mask: os.umask(int(mask, 8))),
    "the locale": Part(lambda: locale.setlocale(locale.LC_ALL), lambda name: locale.setlocale(locale.LC_ALL, name)),
    "the cores to run on": Part(_cores, lambda cores: os.sched_setaffinity(0, cores)),
}

THREADS = "threads"
EVERYTHING = (*PARTS, THREADS)


@contextlib.contextmanager
def guarded(seed: int, keep: Collection[str] = ()) -> Iterator[list[str]]:
    """Run planner code; afterwards the process is as it was.

    The global random numbers of `random` and numpy begin at `seed`, so that a planner that uses them repeats itself.
    A process that the planner forked ends here: it must not go on with the run.

    Args:
        seed: of global random numbers.
        keep: names in `PARTS` that are not put back; with THREADS, those left running are not looked for.

    Yields a list that holds, at the end, what was changed, in words.
    """
    process, changes = os.getpid(), list[str]()
    parts = {name: part for name, part in PARTS.items() if name not in keep}
    with contextlib.ExitStack() as stack:
        stack.enter_context(_global_random_numbers(seed))
        stack.enter_context(warnings.catch_warnings())
        stack.enter_context(_told_interrupts())
        threads = set(threading.enumerate())
        before = {name: part.save() for name, part in parts.items()}
        try:
            yield changes
        finally:
            end_if_forked(process)
            changes += _put_back(parts, before)
            left = sorted(thread.name for thread in set(threading.enumerate()) - threads)
            if left and THREADS not in keep:
                changes.append(f"threads left running: {', '.join(left)}")


def _put_back(parts: dict[str, Part], before: dict[str, Any]) -> Iterator[str]:
    for name, part in parts.items():
        now = part.save()
        if now != before[name]:
            part.put_back(before[name])
            yield f"changed by the planner, and put back: {name}{_changed_keys(before[name], now)}"


def _changed_keys(before: Any, now: Any) -> str:
    """Which environment variables, for example."""
    if not (isinstance(before, dict) and isinstance(now, dict)):
        return f" ({now})" if isinstance(now, str) else ""
    keys = sorted(str(key) for key in before.keys() | now.keys() if before.get(key) != now.get(key))
    return f" ({', '.join(keys[:10])})"


def end_if_forked(process: int) -> None:
    """End a child that a planner forked and let return: there would be two runs otherwise."""
    if os.getpid() != process:
        os._exit(0)


@contextlib.contextmanager
def _global_random_numbers(seed: int) -> Iterator[None]:
    numpy_state, python_state = np.random.get_state(), random.getstate()  # noqa: NPY002 - a planner's business
    np.random.seed(seed % 2**32)  # noqa: NPY002
    random.seed(seed)
    try:
        yield
    finally:
        np.random.set_state(numpy_state)  # noqa: NPY002
        random.setstate(python_state)


@contextlib.contextmanager
def _told_interrupts() -> Iterator[None]:
    """Ctrl-C raises UserInterruptError within."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    usual = {number: signal.getsignal(number) for number in INTERRUPTS}
    for number, handler in usual.items():
        if callable(handler):
            signal.signal(number, _told(handler))
    try:
        yield
    finally:
        for number, handler in usual.items():
            if callable(handler):
                signal.signal(number, handler)


def _told(handler: Callable[[int, FrameType | None], Any]) -> Callable[[int, FrameType | None], Any]:
    def tell(number: int, frame: FrameType | None) -> Any:
        try:
            return handler(number, frame)
        except KeyboardInterrupt:
            raise UserInterruptError from None

    return tell
