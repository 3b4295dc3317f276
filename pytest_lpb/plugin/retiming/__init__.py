"""A pytest plugin of its own, which `lpb-report --retime` starts in a process of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_lpb.errors import LpbError
from pytest_lpb.plugin.retiming.hooks import RetimingPlugin
from pytest_lpb.retime.job import Job
from pytest_lpb.retime.session import RetimingSession


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that names the job."""
    parser.addoption("--lpb-job", type=Path, help="file that says what to time")


def pytest_configure(config: pytest.Config) -> None:
    """Load the planners."""
    try:
        session = RetimingSession(Job.from_json(config.getoption("--lpb-job").read_text(encoding="utf-8")))
    except LpbError as error:
        raise pytest.UsageError(str(error)) from error
    config.add_cleanup(session.close)
    config.pluginmanager.register(RetimingPlugin(session), "lpb-retiming")
