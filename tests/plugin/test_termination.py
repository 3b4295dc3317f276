"""When a signal interrupts a session, and when it does not."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from pytest_lpb.plugin.termination import TerminationPlugin
from pytest_lpb.trial.guard import UserInterruptError, guarded


@pytest.fixture
def listening() -> Iterator[TerminationPlugin]:
    """A plugin that listens, as in a session of its own."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    plugin = TerminationPlugin()
    session: Any = SimpleNamespace()
    plugin.pytest_sessionstart(session)
    yield plugin
    plugin.pytest_unconfigure()
    signal.signal(signal.SIGINT, before)


def interrupted() -> bool:
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        return True
    return False


def test_at_the_end_of_a_session_only_its_tables_are_interrupted(listening: TerminationPlugin) -> None:
    assert interrupted()
    end = listening.pytest_sessionfinish()
    next(end)
    with listening.interruptible():
        assert interrupted()
    assert not interrupted()
    # What it came too early for is interrupted when it begins; and who insists is heard.
    with pytest.raises(KeyboardInterrupt), listening.interruptible():
        raise AssertionError("it has begun")
    assert interrupted()


def test_a_second_signal_finds_handlers_that_a_trial_has_put_back() -> None:
    """As of a trial that SIGTERM interrupts: it began with our handler, and ends with it."""
    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    plugin = TerminationPlugin()
    session: Any = SimpleNamespace()
    plugin.pytest_sessionstart(session)
    try:
        with pytest.raises(UserInterruptError), guarded(0):
            signal.raise_signal(signal.SIGTERM)
        end = plugin.pytest_sessionfinish()
        next(end)
        signal.raise_signal(signal.SIGTERM)
        with pytest.raises(KeyboardInterrupt), plugin.interruptible():
            raise AssertionError("it has begun")
    finally:
        plugin.pytest_unconfigure()
        assert signal.signal(signal.SIGTERM, before) is signal.SIG_DFL
