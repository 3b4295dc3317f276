"""Scenario and trial pages in a real browser: motion, one slider, two planners, permalinks, Back."""

from __future__ import annotations

import base64
import io
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

import matplotlib.image
import numpy as np
import pytest

from pytest_lpb.report.data import ReportData
from pytest_lpb.report.report import write_report

from .chromium import Chromium
from .runs import make_run
from .spatial_runs import spatial_run
from .test_report import EVIL, recorded
from .views import open_view, wait_for

pytestmark = pytest.mark.chromium

ARM = "scenarios/arm/reach.yaml::pd::seed1"
OTHER = "scenarios/arm/reach.yaml::fabrics::seed1"
WALL = "scenarios/panda/wall.yaml::pd::seed0"
SLIDER = "document.querySelector('input[type=range]')"
CLOCK = "document.querySelector('.bar output').textContent"
DRAWN = "[...document.querySelectorAll('canvas')].every(c => c.width !== 300)"  # else it has its first size
HEADING = "document.getElementById('trial-title').textContent"


def route(node_id: str, query: str = "") -> str:
    return "#/trial/" + quote(node_id, safe="") + query


def pictures(browser: Chromium) -> list[Any]:
    """Pixels of each canvas as it is drawn."""
    data = browser.run("[...document.querySelectorAll('canvas')].map(c => c.toDataURL('image/png'))")
    pngs = [io.BytesIO(base64.b64decode(address.partition(",")[2])) for address in data]
    return [matplotlib.image.imread(png)[..., :3] for png in pngs]


def move_to(browser: Chromium, t: float) -> None:
    browser.run(f"{SLIDER}.value = {t}; {SLIDER}.dispatchEvent(new Event('input', {{bubbles: true}}))")
    browser.run(f"{SLIDER}.dispatchEvent(new Event('change', {{bubbles: true}}))")


@pytest.fixture(scope="module")
def spatial_address(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("spatial")
    return write_report(folder / "report.html", spatial_run(folder)).as_uri()


@pytest.fixture(autouse=True)
def desktop(browser: Chromium) -> None:
    browser.look(1280, 900, "light")


def test_a_trial_is_opened_from_the_table(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, "#/trials?filter=arm+fabrics")
    browser.run(
        "[...document.querySelectorAll('#trial-table tbody tr')].find(r => r.offsetParent).querySelector('a').click()"
    )
    wait_for(browser, "document.documentElement?.dataset.route.startsWith('#/trial/')")
    heading = browser.run(HEADING)
    assert heading.startswith("fabrics on arm/reach, seed ")
    assert browser.run("document.querySelector('#trial-body code').textContent").startswith(
        "pytest --lpb-planners=fabrics"
    )
    titles = browser.run("[...document.querySelectorAll('#trial-body figcaption')].map(f => f.textContent)")
    for start in ("distance to goal [m]", "clearance [m]", "position [rad]", "action [rad/s²]", "solver time [ms]"):
        assert any(title.startswith(start) for title in titles)
    assert browser.run("document.querySelectorAll('#trial-body table tbody tr').length") > 15
    assert browser.errors == []
    assert browser.requests == [report_address]
    browser.run("history.back()")
    wait_for(browser, "document.documentElement?.dataset.route.startsWith('#/trials')")
    assert browser.run("document.querySelector('[data-column=filter]').value") == "arm fabrics"


def test_the_slider_moves_the_robot(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, route(ARM))
    (start,) = pictures(browser)
    move_to(browser, 2.0)
    (later,) = pictures(browser)
    assert (np.abs(start - later).max(axis=-1) > 0.2).mean() > 0.002
    assert browser.run(CLOCK).startswith("2.0")
    cursor = browser.run("document.querySelector('.timeline .cursor').getAttribute('d')")
    end = float(browser.run(f"{SLIDER}.max"))
    assert float(cursor[1:].split(" ")[0]) == pytest.approx(2000.0 / end, rel=0.02)
    browser.run(f"{SLIDER}.focus()")
    before = float(browser.run(f"{SLIDER}.value"))
    browser.key("ArrowRight", 39)
    assert float(browser.run(f"{SLIDER}.value")) > before
    assert browser.run(f"{SLIDER}.getAttribute('aria-valuetext')") == browser.run(CLOCK)


def test_play_runs_to_the_end_and_stops(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, route(ARM))
    browser.run("(s => { s.value = '8'; })(document.querySelector('.bar select'))")
    browser.run("document.querySelector('.play').click()")
    assert "pause" in browser.run("document.querySelector('.play').textContent")
    wait_for(browser, f"Number({SLIDER}.value) >= Number({SLIDER}.max) * 0.99")
    wait_for(browser, "document.querySelector('.play').textContent.includes('play')")
    assert browser.errors == []


def test_two_planners_side_by_side_and_in_one_picture(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, route(ARM))
    browser.run(
        f"(s => {{ s.value = '{OTHER}'; s.dispatchEvent(new Event('change')); }})(document.getElementById('with'))"
    )
    wait_for(browser, "document.querySelectorAll('canvas').length === 2")
    before = pictures(browser)
    move_to(browser, 1.5)
    after = pictures(browser)
    assert all((np.abs(a - b).max(axis=-1) > 0.2).any() for a, b in zip(before, after, strict=True))
    assert browser.run("document.querySelectorAll('input[type=range]').length") == 1
    address = browser.run("location.hash")
    assert f"with={quote(OTHER, safe='')}" in address
    assert f"t={browser.run(CLOCK).partition(' ')[0]}" in address
    clock = browser.run(CLOCK)
    assert clock.startswith("1.")
    open_view(browser, report_address, address)
    assert browser.run(CLOCK) == clock
    assert browser.run("document.querySelectorAll('canvas').length") == 2
    browser.run(
        "(s => { s.value = 'overlay'; s.dispatchEvent(new Event('change')); })(document.getElementById('layout'))"
    )
    wait_for(browser, "document.querySelectorAll('canvas').length === 1")
    assert (
        browser.run("document.querySelectorAll('#trial-body canvas ~ figcaption, #trial-body .stages .chip').length")
        == 2
    )
    legend = "[...document.querySelectorAll('.timelines .legend')]"
    names = browser.run(f"{legend}.map(node => [...node.querySelectorAll('button')].map(key => key.innerText))")
    assert names == [["joint1", "joint2", "joint3"]] * 3  # once, though two planners are drawn
    lines = "[...document.querySelectorAll('.timelines .legend path')]"
    assert len(set(browser.run(f"{lines}.map(line => line.getAttribute('stroke-dasharray'))"))) == 3
    assert browser.errors == []


def test_a_permalink_survives_reloading_and_back_works(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, "#/scenario/arm/reach")
    shown = (
        "[...document.querySelectorAll('#scenarios article')].filter(a => a.offsetParent).map(a => a.dataset.scenario)"
    )
    assert browser.run(shown) == ["arm/reach"]
    chips = "[...document.querySelectorAll('#scenarios .more a.chip')].filter(a => a.offsetParent)"
    assert browser.run(f"{chips}.length") == 12
    browser.run(f"{chips}[0].click()")
    wait_for(browser, "document.documentElement?.dataset.route.startsWith('#/trial/')")
    heading = browser.run(HEADING)
    browser.run("document.documentElement.dataset.route = 'before'; location.reload()")
    wait_for(browser, "document.documentElement?.dataset.route === location.hash")
    assert browser.run(HEADING) == heading
    browser.run("history.back()")
    wait_for(browser, "document.documentElement?.dataset.route === '#/scenario/arm/reach'")
    assert browser.run(shown) == ["arm/reach"]


def test_motion_in_space_follows_slider_and_camera(browser: Chromium, spatial_address: str) -> None:
    open_view(browser, spatial_address, route(WALL))
    wait_for(browser, DRAWN)
    (start,) = pictures(browser)
    assert len(np.unique((255 * start).astype(int).reshape(-1, 3), axis=0)) > 200  # shaded surfaces
    end = float(browser.run(f"{SLIDER}.max"))
    move_to(browser, end)
    (later,) = pictures(browser)
    assert (np.abs(start - later).max(axis=-1) > 0.1).mean() > 0.002
    browser.run("document.querySelector('canvas').focus()")
    browser.key("ArrowLeft", 37)
    (turned,) = pictures(browser)
    assert (np.abs(turned - later).max(axis=-1) > 0.1).mean() > 0.01
    browser.run("[...document.querySelectorAll('.camera button')].find(b => b.textContent === 'from above').click()")
    (above,) = pictures(browser)
    assert (np.abs(above - turned).max(axis=-1) > 0.1).mean() > 0.01
    browser.run("document.querySelector('.camera input').click()")
    (through,) = pictures(browser)
    assert (through != above).any()
    assert browser.errors == []
    assert len(browser.requests) == 1


def test_every_trial_in_space_is_drawn(browser: Chromium, spatial_address: str) -> None:
    for scenario in ("point_3d/shapes", "cart/drive"):
        other = quote(f"scenarios/{scenario}.yaml::slow::seed0", safe="")
        open_view(browser, spatial_address, route(f"scenarios/{scenario}.yaml::pd::seed0", f"?with={other}&t=1"))
        wait_for(browser, "document.querySelectorAll('canvas').length === 2")
        move_to(browser, 0.5)
        for picture in pictures(browser):
            assert len(np.unique((255 * picture).astype(int).reshape(-1, 3), axis=0)) > 15
        assert browser.errors == []


@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_looks_of_trial_pages(
    browser: Chromium, report_address: str, spatial_address: str, width: int, scheme: str
) -> None:
    browser.look(width, 844, scheme, phone=width < 500)
    for address, view in (
        (report_address, route(ARM, f"?with={quote(OTHER, safe='')}")),
        (spatial_address, route(WALL)),
        (report_address, "#/scenario/cart/crossing"),
        (report_address, "#/comparisons?a=fabrics&b=pd"),
        (report_address, "#/overview?kpi=path_length_m"),
        (report_address, "#/kpis?kpi=path_length_m"),
    ):
        open_view(browser, address, view)
        assert browser.run("document.documentElement.scrollWidth") <= width, view
        assert browser.errors == []
        small = """[...document.querySelectorAll('main *')].filter(e => e.offsetParent && !e.closest('svg, sup')
            && parseFloat(getComputedStyle(e).fontSize) < 12.5).map(e => e.outerHTML.slice(0, 80))"""
        assert browser.run(small) == []
        page = matplotlib.image.imread(io.BytesIO(browser.picture()))[..., :3]
        assert (page.mean() > 0.6) == (scheme == "light"), view
        for canvas in pictures(browser):
            assert (canvas.mean() > 0.6) == (scheme == "light"), view


def test_a_canvas_follows_the_colour_scheme(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, route(ARM))
    (light,) = pictures(browser)
    browser.look(1280, 900, "dark")
    browser.run("new Promise(done => setTimeout(done, 100))")
    (dark,) = pictures(browser)
    assert (light != dark).any()


def test_the_heat_map_shows_another_kpi_and_success_again(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address)
    cells = "[...document.querySelectorAll('#heat tbody td:not(.ahead) b')].map(b => b.textContent)"
    success = browser.run(cells)
    assert all("/" in text for text in success)
    choose = (
        "(s => {{ s.value = '{}'; s.dispatchEvent(new Event('change')); }})(document.getElementById('heat-select'))"
    )
    browser.run(choose.format("path_length_m"))
    wait_for(browser, "document.getElementById('heat-note').textContent.includes('path length [m]')")
    assert browser.run(cells) != success
    assert "kpi=path_length_m" in browser.run("location.hash")
    cell = "[parseFloat(c.querySelector('b').textContent), Number(c.style.getPropertyValue('--rate'))]"
    cells_of = "[...r.querySelectorAll('td.heat')]"
    best = f"[...document.querySelectorAll('#heat tbody tr')].map(r => {cells_of}.map(c => {cell}))"
    for row in browser.run(best):
        assert not row or min(row)[1] == max(rate for _, rate in row) == 1  # shorter is better
    browser.run(choose.format("success"))
    wait_for(browser, "document.getElementById('heat-note').textContent.includes('95 % interval')")
    assert browser.run(cells) == success


def test_comparisons_are_filtered_and_drawn(browser: Chromium, report_address: str) -> None:
    open_view(browser, report_address, "#/comparisons")
    rows = "[...document.querySelectorAll('#comparison-table tbody tr')].filter(r => r.offsetParent)"
    assert set(browser.run(f"{rows}.map(r => r.dataset.scenario)")) == {"all"}
    assert "Choose A, B" in browser.run("document.getElementById('forest').textContent")
    choose = """(field => {{ field.value = '{1}'; field.dispatchEvent(new Event('input', {{bubbles: true}})); }})(
        document.querySelector('[data-table=comparison-table] [data-column={0}]'))"""
    browser.run(choose.format("a", "fabrics"))
    browser.run(choose.format("b", "pd"))
    wait_for(browser, "document.querySelectorAll('#forest .row').length > 5")
    assert set(browser.run(f"{rows}.map(r => r.dataset.a + ' ' + r.dataset.b)")) == {"fabrics pd"}
    assert browser.run("document.getElementById('forest').textContent").startswith("pd against fabrics")
    browser.run(choose.format("scenario", ""))
    assert len(set(browser.run(f"{rows}.map(r => r.dataset.scenario)"))) == 4
    assert "scenario=any" in browser.run("location.hash")
    open_view(browser, report_address, browser.run("location.hash"))
    assert len(set(browser.run(f"{rows}.map(r => r.dataset.scenario)"))) == 4
    assert browser.errors == []


def test_names_that_are_markup_are_text_everywhere(browser: Chromium, tmp_path: Path) -> None:
    data: ReportData = make_run(
        [EVIL], planners=('"><img src=x onerror=alert(1)>', "</script>"), seeds=3, crashed=False
    )
    address = write_report(tmp_path / "report.html", replace(data, title=EVIL)).as_uri()
    node = str(data.trials["node_id"].iloc[0])
    other = str(data.trials["node_id"].iloc[1])
    views = (
        "#/overview",
        f"#/scenario/{quote(EVIL)}",
        "#/kpis",
        "#/comparisons",
        "#/trials",
        f"#/scenario/{quote(EVIL, safe='')}",
    )
    for view in (*views, route(node, f"?with={quote(other, safe='')}")):
        open_view(browser, address, view)
        assert browser.errors == [], view
        assert browser.run("document.querySelectorAll('main img, main script:not([data-block])').length") == 0
        assert len(browser.requests) == 1
    assert browser.run("document.querySelectorAll('canvas').length") == 2
    assert EVIL in browser.run(HEADING)


def test_a_trial_without_a_replay_says_how_to_see_it(browser: Chromium, report_address: str, run: ReportData) -> None:
    crashed = run.trials[run.trials["outcome"] == "worker_crash"]["node_id"].iloc[0]
    open_view(browser, report_address, route(str(crashed)))
    text = browser.run("document.getElementById('trial-body').textContent")
    assert "neither time series nor a replay" in text
    assert f"lpb-report {report_address[7:].rpartition('/')[0]} --trial {crashed} --video trial.mp4" in text


def test_recorded_text_runs_no_script(browser: Chromium, run: ReportData, tmp_path: Path) -> None:
    text = "</script><script>document.title = 'run'</script>\"><img src=x onerror=\"document.title = 'run'\">{{7*7}}"
    address = write_report(tmp_path / "report.html", recorded(run, text)).as_uri()
    for view in ("#/overview", "#/trials", "#/run"):
        open_view(browser, address, view)
        assert browser.errors == [], view  # the content security policy would tell, too
        assert browser.requests == [address]
        assert browser.run("document.querySelectorAll('main img, main script:not([data-block])').length") == 0
        assert "{{7*7}}" in browser.run("document.title")
