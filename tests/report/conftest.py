"""Runs and reports that several tests read."""

import os
from collections.abc import Iterator

import pytest

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.report import page, render, write_report

from .chromium import Chromium, chromium, find_chromium
from .runs import make_run


@pytest.fixture(scope="session")
def run() -> ReportData:
    """Three planners on a point, a cart and an arm; one worker crashed, timing was contended."""
    return make_run(seeds=4, contended=True, warnings=["KPI elbow is NaN: no link 'elbow'"])


@pytest.fixture(scope="session")
def html(run: ReportData) -> str:
    """The run's report."""
    return render(page(run))


@pytest.fixture(scope="session")
def report_address(run: ReportData, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Address of the run's report in a browser."""
    return write_report(tmp_path_factory.mktemp("report") / "report.html", run).as_uri()


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    """A headless browser; the test is skipped without one, but not in CI."""
    binary = find_chromium()
    if binary is None:
        message = "no Chromium is installed"
        if os.environ.get("CI"):
            pytest.fail(f"{message}: CI must run these tests")
        pytest.skip(message)
    with chromium(binary, tmp_path_factory.mktemp("profile", numbered=True)) as page_in_browser:
        yield page_in_browser
