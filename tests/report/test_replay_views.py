"""Looking closer at a replay in a real browser: zoom, pan, names of obstacles, single joints; and the video command."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from .chromium import Chromium
from .test_replay_browser import ARM, OTHER, SLIDER, route
from .views import open_view

pytestmark = pytest.mark.chromium

POINT = "scenarios/point/two_obstacles.yaml::pd::seed1"
TITLE = "20261122T024921Z-74be96"  # name of the run folder
CANVAS = "document.querySelector('canvas')"
BOX = f"(box => [box.left, box.top, box.width, box.height])({CANVAS}.getBoundingClientRect())"
# Places [px] along a row at which the name of an obstacle is shown.
MET = f"""((y, name) => {{
  const canvas = {CANVAS}, box = canvas.getBoundingClientRect(), tip = document.querySelector('.name-tip'), met = [];
  for (let x = 2; x < box.width - 2; x += 4) {{
    canvas.dispatchEvent(new PointerEvent('pointermove', {{ clientX: box.left + x, clientY: box.top + y }}));
    if (!tip.hidden && tip.textContent === name) met.push(x);
  }}
  return met;
}})"""
COLOUR = "getComputedStyle(document.documentElement).getPropertyValue('--p' + n).trim()"


class Picture:
    """The canvas of an open trial page, looked at and touched at places in pixels of the window."""

    def __init__(self, browser: Chromium) -> None:
        self.browser = browser
        browser.run("document.querySelector('canvas').scrollIntoView({block: 'center'})")
        self.left, self.top, self.width, self.height = browser.run(BOX)

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        self.browser.send("Input.dispatchMouseEvent", type=kind, x=self.left + x, y=self.top + y, **more)

    def extent_of(self, name: str, y: float) -> tuple[float, float]:
        """From where to where an obstacle is met along a row of the picture [px]."""
        met = self.browser.run(f"{MET}({y}, '{name}')")
        return (met[0], met[-1]) if met else (0.0, 0.0)

    def drag(self, x: float, y: float, dx: float, dy: float) -> None:
        self.mouse("mousePressed", x, y, button="left", buttons=1, clickCount=1)
        self.mouse("mouseMoved", x + dx, y + dy, button="left", buttons=1)
        self.mouse("mouseReleased", x + dx, y + dy, button="left", clickCount=1)

    def pinch(self, x: float, y: float, before: float, after: float) -> None:
        for kind, reach in (("touchStart", before), ("touchMove", after)):
            fingers = [{"x": self.left + x + sign * reach, "y": self.top + y, "id": sign + 1} for sign in (-1, 1)]
            self.browser.send("Input.dispatchTouchEvent", type=kind, touchPoints=fingers)
        self.browser.send("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])


@pytest.fixture
def picture(browser: Chromium, report_address: str) -> Iterator[Picture]:
    browser.look(1280, 900, "light")
    open_view(browser, report_address, route(POINT))
    yield Picture(browser)
    assert browser.errors == []


def middle_of(picture: Picture, name: str) -> tuple[float, float]:
    """A place on an obstacle [px]."""
    for y in range(4, int(picture.height), 16):
        low, high = picture.extent_of(name, y)
        if high - low > 20:
            return (low + high) / 2, y
    raise AssertionError(f"{name} is nowhere")


def test_a_picture_is_zoomed_and_moved(picture: Picture) -> None:
    x, y = middle_of(picture, "left")
    low, high = picture.extent_of("left", y)
    first = high - low
    picture.mouse("mouseWheel", x, y, deltaX=0, deltaY=-200)
    low, high = picture.extent_of("left", y)
    assert high - low > 1.3 * first
    assert low < x < high  # what is under the pointer stays there
    picture.drag(x, y, 150.0, 0.0)
    moved = picture.extent_of("left", y)
    assert moved[0] == pytest.approx(low + 150.0, abs=8)
    picture.browser.run("document.querySelector('canvas').dispatchEvent(new MouseEvent('dblclick'))")
    assert picture.extent_of("left", y) == pytest.approx((x - first / 2, x + first / 2), abs=8)
    picture.browser.run("document.querySelector('canvas').focus()")
    picture.browser.key("ArrowRight", 39)
    assert picture.extent_of("left", y)[0] == pytest.approx(x - first / 2 - 40, abs=8)
    picture.browser.key("Home", 36)
    picture.pinch(x, y, 40.0, 80.0)
    low, high = picture.extent_of("left", y)
    assert high - low == pytest.approx(2 * first, abs=12)


def test_single_joints_are_chosen_and_have_colours_of_their_own(browser: Chromium, report_address: str) -> None:
    browser.look(1280, 900, "light")
    open_view(browser, report_address, route(ARM, "?t=1"))
    chart = "[...document.querySelectorAll('.below figure')].find(f => f.textContent.startsWith('position'))"
    lines = f"[...{chart}.querySelectorAll('.path[data-line]')]"
    colours = set(browser.run(f"{lines}.map(line => getComputedStyle(line).stroke)"))
    hues = browser.run(f"[...'01234567'].map(n => {COLOUR})")
    planners = {f"rgb({', '.join(str(int(hue[i : i + 2], 16)) for i in (1, 3, 5))})" for hue in hues}
    assert len(colours) == 3
    assert not colours & planners
    shown = f"[...{chart}.querySelectorAll('.path[data-line]:not(.faint)')].map(p => p.dataset.line)"
    assert browser.run(shown) == ["joint1", "joint2", "joint3"]
    for left in (["joint2"], ["joint1", "joint2", "joint3"]):  # a second click shows all again
        browser.run(f"{chart}.querySelectorAll('.legend button')[1].click()")
        assert browser.run(shown) == left
    value = f"Number({chart}.querySelector('.legend output').textContent.replace('−', '-'))"
    before = browser.run(value)
    browser.run(f"{SLIDER}.value = 3; {SLIDER}.dispatchEvent(new Event('input'))")
    assert browser.run(value) != before


@pytest.mark.parametrize("folder", ["plain", "it's a $(run) #1 50% é\\"])
def test_the_video_command_names_the_run_wherever_it_lies(
    browser: Chromium, report_address: str, tmp_path: Path, folder: str
) -> None:
    run = tmp_path / folder
    run.mkdir()
    (run / "report.html").write_bytes(Path(report_address.removeprefix("file://")).read_bytes())
    latest = tmp_path / "latest"  # leads to another run soon: the command names the run's own folder, beside it
    latest.symlink_to(run.name, target_is_directory=True)
    for opened, named in ((run, run), (latest, tmp_path / TITLE)):
        open_view(browser, (opened / "report.html").as_uri(), route(OTHER))
        command = browser.run("[...document.querySelectorAll('#trial-body .command code')].at(-1).textContent")
        assert shlex.split(command) == ["lpb-report", str(named), "--trial", OTHER, "--video", "trial.mp4"]
