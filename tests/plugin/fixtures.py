"""Fixtures of tests that run the plugin. Loaded by tests/conftest.py."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from .projects import Project, run_without_pytest


@pytest.fixture(scope="session")
def warm(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Everything imported that a run imports: pytester drops what a run inside this process imports first."""
    run_without_pytest(tmp_path_factory.mktemp("warm"))


@pytest.fixture
def project(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, warm: None) -> Iterator[Project]:
    """An empty planner repository; planners and KPIs that a run registers are forgotten afterwards."""
    from pytest_lpb.kpis.registry import default_registry as kpis
    from pytest_lpb.planner import registry as planners
    from pytest_lpb.problem import registries
    from pytest_lpb.report.plots import default_registry as plots

    monkeypatch.setattr(planners, "_classes", dict(planners._classes))
    with kpis.preserved(), plots.preserved(), registries.preserved():
        yield Project(pytester)


@pytest.fixture(scope="module")
def finished_run(tmp_path_factory: pytest.TempPathFactory, warm: None) -> Path:
    """A run folder with two planners, two scenarios and two seeds, made once per test file; only to be read."""
    run = run_without_pytest(tmp_path_factory.mktemp("finished"))
    assert json.loads((run / "run.json").read_text("utf-8"))["schema_version"] == 1
    return run
