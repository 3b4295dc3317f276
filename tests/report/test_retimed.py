"""The report's section about calls timed again."""

from __future__ import annotations

from dataclasses import replace

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.report import page, render
from pytest_lpb.retime.figures import PassTimes, row_of
from pytest_lpb.retime.result import Retimed

from .test_report import EVIL, Elements


def retimed(run: ReportData) -> Retimed:
    scenario = str(run.trials["scenario"].iloc[0])
    slow = row_of(scenario, "pd", [PassTimes((2.0, 4.0), (5.0,), 1.0)] * 2, [7.0], 3.0, 1)
    fast = row_of(
        scenario, "fabrics", [PassTimes((1.0, 1.0), (1.0,), 1.0), PassTimes((1.2, 1.2), (1.0,), 1.0)], [], 3.0, 0
    )
    return Retimed([slow, fast], "2026-11-22T02:49:21+00:00", "a processor", [f"pd: actions differ {EVIL}"])


def test_a_row_per_planner_and_the_floor(run: ReportData) -> None:
    html = render(page(replace(run, retimed=retimed(run))))
    elements = Elements(html)
    assert ("section", "retimed") in [(tag, attributes.get("id")) for tag, attributes in elements.tags]
    assert "#/retimed" in [attributes.get("href") for tag, attributes in elements.tags if tag == "a"]
    text = elements.text
    # pd: median 3, four calls of which two (and both first ones) are longer than 3 ms; 3 / 1.1 of fabrics' median.
    for expected in ("3.00", "4 of 6", "period 3 ms", "at most 7.00", "1 with other actions", "2.73 x", "fastest"):
        assert expected in text, expected
    assert any("A/A noise floor of this machine: 20 % of p50, 20 % of p95" in part for part in text)
    assert any(part.startswith("The planners' calls made again") and "a processor" in part for part in text)
    assert EVIL not in html
    assert any("actions differ" in part for part in text)


def test_no_section_without_measurement(html: str) -> None:
    assert 'id="retimed"' not in html
    assert "#/retimed" not in html
