"""Reading a scenario file: every file is read when tests are collected, in each worker."""

from __future__ import annotations

from pathlib import Path

from pytest_benchmark.fixture import BenchmarkFixture

from pytest_lpb.scenario.load import load_scenario
from tests.scenario.test_load import FULL, written


def test_load(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    """With every section in it; 15 ms at most."""
    scenario = benchmark(load_scenario, written(tmp_path, FULL))
    assert scenario.tags == ("planar", "static")
