"""The report in a real browser: sorting, filtering, permalinks, and how it looks."""

import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.report import write_report

from .chromium import Chromium
from .views import open_view, wait_for

pytestmark = pytest.mark.chromium

VISIBLE = "[...document.querySelectorAll('#trial-table tbody tr')].filter(row => row.offsetParent)"
LOOKS = {
    "light": (1280, 900, "light", False),
    "dark": (1280, 900, "dark", False),
    "tablet": (800, 1000, "light", False),
    "phone": (390, 844, "light", True),
    "dark phone": (390, 844, "dark", True),
}


def _column(browser: Chromium, index: int) -> list[str]:
    return [str(text) for text in browser.run(f"{VISIBLE}.map(row => row.cells[{index}].textContent.trim())")]


def _numbers(texts: Sequence[str]) -> list[float]:
    return [float(text.rstrip("†").replace("−", "-")) for text in texts if text != "–"]


def _head(browser: Chromium, text: str) -> int:
    heads = "[...document.querySelectorAll('#trial-table thead th')].map(head => head.textContent.trim())"
    return int(browser.run(f"{heads}.indexOf('{text}')"))


def _click_head(browser: Chromium, index: int) -> str:
    head = f"document.querySelectorAll('#trial-table thead th')[{index}]"
    browser.run(f"{head}.querySelector('button').click()")
    return str(browser.run(f"{head}.getAttribute('aria-sort')"))


def test_no_errors_and_no_requests(browser: Chromium, report_address: str) -> None:
    browser.look(*LOOKS["light"][:3])
    browser.open(report_address)
    assert browser.run("document.documentElement.classList.contains('js')")
    assert browser.errors == []
    assert browser.requests == [report_address]


def test_sorting_by_click_puts_empty_cells_last(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, "#/trials")
    column = _head(browser, "time to goal if reached [s]")
    for direction in ("ascending", "descending"):
        assert _click_head(browser, column) == direction
        texts = _column(browser, column)
        empty = texts.count("–")
        assert empty > 0
        assert set(texts[-empty:]) == {"–"}
        values = _numbers(texts)
        assert values == sorted(values, reverse=direction == "descending")
    assert browser.run("document.querySelectorAll('#trial-table [aria-sort]').length") == 1
    assert "sort=-time+to+goal" in browser.run("location.hash")


def test_sorting_with_the_keyboard(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, "#/trials")
    browser.run("document.querySelector('#trial-table thead button').focus()")
    browser.key("Enter", 13)
    assert browser.run("document.querySelector('#trial-table thead th').getAttribute('aria-sort')") == "ascending"
    texts = _column(browser, 0)
    assert texts == sorted(texts)


def test_filtering_by_text_and_by_choice(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, "#/trials")
    before = len(_column(browser, 0))
    _set(browser, "[data-column=filter]", "CART pd")
    assert set(_column(browser, 1)) == {"cart/crossing"}
    assert len(_column(browser, 0)) == 4
    _set(browser, "[data-column=filter]", "")
    _set(browser, "[data-column=outcome]", "collision")
    assert set(_column(browser, 0)) == {"collision"}
    shown = browser.run("document.querySelector('[data-table=trial-table] output').textContent")
    assert shown == f"{len(_column(browser, 0))} of {before} shown"


def _set(browser: Chromium, selector: str, value: str) -> None:
    field = f"document.querySelector('[data-table=trial-table] {selector}')"
    browser.run(f"{field}.value = '{value}'; {field}.dispatchEvent(new Event('input', {{bubbles: true}}))")


def test_permalink_restores_the_view(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, "#/trials?sort=-seed&filter=arm&planner=pd")
    assert _column(browser, _head(browser, "seed")) == ["3", "2", "1", "0"]
    open_view(browser, report_address, "#/kpis?kpi=clearance_min_m")
    assert browser.run("document.querySelector('.kpi').dataset.kpi") == "clearance_min_m"
    open_view(browser, report_address, "#/trials?sort=nonsense&outcome=nonsense&filter=%3Cscript%3E")
    assert browser.errors == []
    assert _column(browser, 0) == []
    open_view(browser, report_address, "#/kpis?kpi=nonsense")
    assert browser.run("document.querySelector('.kpi').dataset.kpi") == "success"
    for route in ("#/nonsense/%E0%A4%A", "#/trial/%3Cscript%3E", "#/scenario/nonsense", "#/", "#/trial/"):
        open_view(browser, report_address, route)
        assert browser.errors == []


def test_one_kpi_is_shown_at_a_time(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, "#/kpis")
    shown = "[...document.querySelectorAll('.kpi')].filter(f => f.offsetParent).map(f => f.dataset.kpi)"
    assert browser.run(shown) == ["success"]
    select = "document.getElementById('kpi-select')"
    browser.run(f"{select}.value = 'path_length_m'; {select}.dispatchEvent(new Event('change'))")
    wait_for(browser, "document.querySelector('.kpi').dataset.kpi === 'path_length_m'")
    assert browser.run(shown) == ["path_length_m"]
    assert browser.run("location.hash") == "#/kpis?kpi=path_length_m"


def test_planner_can_be_hidden_in_pictures(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, "#/scenarios")
    paths = "[...document.querySelectorAll('.scene path[data-planner=pd]')]"
    assert browser.run(f"{paths}.length") > 3
    browser.run("document.querySelector('input[data-planner=pd]').click()")
    assert browser.run(f"{paths}.every(path => getComputedStyle(path).display === 'none')")


def test_copying_a_command(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, "#/trials")
    browser.run("document.querySelector('.copy').click()")
    browser.run("new Promise(done => setTimeout(done, 200))")
    assert browser.run("document.getElementById('status').textContent").startswith("Cop")
    assert browser.errors == []


@pytest.mark.parametrize("look", LOOKS)
def test_looks(browser: Chromium, report_address: str, look: str) -> None:
    width, height, scheme, phone = LOOKS[look]
    browser.look(width, height, scheme, phone=phone)
    open_view(browser, report_address, "#/scenarios")
    assert browser.run("document.documentElement.scrollWidth") <= width
    pixels = _pixels(browser.picture(whole=True))
    assert pixels.shape[1] == width
    assert (pixels.mean() > 0.7) == (scheme == "light")
    scene = browser.run(
        "(() => { const r = document.querySelector('.scene-svg').getBoundingClientRect();"
        " return [r.x + scrollX, r.y + scrollY, r.width, r.height]; })()"
    )
    picture = _pixels(browser.picture(clip=tuple(scene)))
    assert len(np.unique((255 * picture).astype(int).reshape(-1, 3), axis=0)) > 50


@pytest.mark.parametrize("look", LOOKS)
def test_text_is_large_enough_and_inside(browser: Chromium, report_address: str, look: str) -> None:
    width, height, scheme, phone = LOOKS[look]
    browser.look(width, height, scheme, phone=phone)
    open_view(browser, report_address, "#/scenarios")
    texts = """[...document.querySelectorAll('.scene-svg text')].map(text =>
        parseFloat(getComputedStyle(text).fontSize) * Math.hypot(text.getScreenCTM().a, text.getScreenCTM().b))"""
    assert min(browser.run(texts)) > 10.5
    small = """[...document.querySelectorAll('main *')].filter(e => e.offsetParent && !e.closest('svg, sup')
        && parseFloat(getComputedStyle(e).fontSize) < 12.5).map(e => e.outerHTML.slice(0, 80))"""
    assert browser.run(small) == []
    inside = """[...document.querySelectorAll('.scene-svg text')].every(text => {
        const t = text.getBoundingClientRect(), s = text.ownerSVGElement.getBoundingClientRect();
        return t.left >= s.left - 2 && t.right <= s.right + 8 && t.bottom <= s.bottom + 2; })"""
    assert browser.run(inside)


def test_labels_at_the_end_of_a_profiles_axis_stay_on_a_phone(browser: Chromium, report_address: str) -> None:
    width, height, scheme, phone = LOOKS["phone"]
    browser.look(width, height, scheme, phone=phone)
    open_view(browser, report_address, "#/profiles")
    last = "document.querySelector('.profile .axis span:last-child')"
    browser.run(f"{last}.style.left = '100%', {last}.textContent = '100 x'")
    assert browser.run(f"{last}.getBoundingClientRect().right") <= width
    assert browser.run("document.documentElement.scrollWidth") <= width


def test_intervals_in_the_heat_map_are_not_broken(browser: Chromium, report_address: str) -> None:
    for width in (390, 700, 1000, 1280):
        browser.look(width, 900, "light", phone=width < 500)
        open_view(browser, report_address, "#/overview")
        lines = "[part.textContent, part.getClientRects().length]"
        found = browser.run(f"[...document.querySelectorAll('#heat .whole')].map(part => {lines})")
        assert found
        assert all(text.endswith("%") and number == 1 for text, number in found), (width, found)


def test_views_that_a_report_lacks_lead_to_the_overview(browser: Chromium, run: ReportData, tmp_path: Path) -> None:
    nothing = {name: getattr(run, name).iloc[:0] for name in ("trials", "summary", "comparisons", "aggregates")}
    address = write_report(tmp_path / "report.html", replace(run, **nothing)).as_uri()
    for route in ("", "#/trials", "#/trial/x", "#/kpis", "#/scenario/x", "#/comparisons", "#/constructor", "#/no/such"):
        open_view(browser, address, route)
        assert browser.errors == [], route
        assert browser.run("document.querySelector('.view.shown').dataset.view") == "overview", route


def _pixels(png: bytes) -> Any:
    return matplotlib.image.imread(io.BytesIO(png))[..., :3]
