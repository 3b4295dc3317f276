"""Known failures (xfail) are marked with their reason wherever trials are shown."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.known_failures import known_failures
from pytest_lpb.report.overview import statements
from pytest_lpb.report.palette import styles_of
from pytest_lpb.report.report import page, render

from .runs import make_run
from .test_report import EVIL, Elements


@pytest.fixture(scope="module")
def marked() -> ReportData:
    """A run in which pd's failures on the point are known."""
    run = make_run(["point/two_obstacles"], ("pd", "fabrics"), seeds=6, crashed=False)
    trials = run.trials
    known = ~trials["success"] & trials["planner"].eq("pd")
    assert known.sum() > 1
    return replace(run, trials=trials.assign(known_failure=known.map({True: EVIL, False: ""})))


def test_known_failures_are_marked_with_their_reason(marked: ReportData) -> None:
    total = int(marked.trials["known_failure"].ne("").sum())
    html = render(page(marked))
    assert EVIL not in html
    text = " ".join(Elements(html).text)
    assert text.count(f"known failure: {EVIL}") == total  # in the table of trials, which the trials' pages show
    assert f"{total} known failures among them" in text
    assert html.count('<small class="known-failure">known failure</small>') == total
    assert "Known failures" in text


def test_known_failures_are_counted_by_scenario_and_planner(marked: ReportData) -> None:
    styles = styles_of(marked)
    found = known_failures(marked, styles)
    assert found is not None
    for known in found:
        trials = marked.trials
        own = trials[trials["scenario"].eq(known.scenario) & trials["planner"].eq("pd")]
        assert (known.style.name, known.reason) == ("pd", EVIL)
        assert (known.failed, known.trials) == (int((~own["success"]).sum()), len(own))


def test_a_run_without_known_failures_says_nothing_of_them(run: ReportData, html: str) -> None:
    assert known_failures(run, styles_of(run)) is None
    assert "known failure" not in " ".join(Elements(html).text).lower()
    assert all("known" not in statement.detail for statement in statements(run, styles_of(run)))
