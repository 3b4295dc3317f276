"""The test that times one pass: run by `lpb-report --retime`, never collected with other tests."""

from typing import Any

import pytest

from pytest_lpb.retime.timed import Timed
from pytest_lpb.trial.loop import undisturbed


def test_pass(benchmark: Any, timed: Timed, key: tuple[str, str]) -> None:
    """Time each call of one pass alone: one round is one call."""
    made = timed.next_pass()
    if made is None:
        pytest.skip("; ".join(timed.warnings))
    benchmark.extra_info["key"] = key
    with undisturbed():
        benchmark.pedantic(timed.planner.compute_action, setup=made.next_observation, rounds=made.rounds, iterations=1)
    timed.record(made, benchmark.stats.stats.data)
