"""From world coordinates to an SVG picture with equal axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pytest_lpb.report.projection import Disc, Outline
from pytest_lpb.report.scale import drawable, round_values, tick_labels
from pytest_lpb.report.view import Mark, Panel, Tick

FloatArray = NDArray[np.float64]

WIDTH = 420.0  # [px]
MAX_PLOT_HEIGHT = 420.0  # [px]
MIN_PLOT_HEIGHT = 110.0  # [px]
LEFT, RIGHT, TOP, BOTTOM = 56.0, 10.0, 8.0, 40.0  # [px] room for labels
MAX_PATH_POINTS = 240
FARTHEST = 5000.0  # [px] from the middle of the picture: what lies farther is drawn there


@dataclass(frozen=True)
class Canvas:
    """A rectangle of the world drawn with equal axes: x to the right, y up."""

    low: FloatArray  # (2,) [m]
    high: FloatArray  # (2,) [m]
    scale: float  # [px/m]
    height: float  # [px] of the plot without labels

    @property
    def width(self) -> float:
        """Width of the plot without labels [px]."""
        return WIDTH - LEFT - RIGHT

    def pixels(self, points: FloatArray) -> FloatArray:
        """Places of points (N, 2) [m] in the picture, (N, 2) [px]; those that ran far away are drawn well outside."""
        reach = FARTHEST / self.scale
        centre = 0.5 * (self.low + self.high)
        middle = np.array([LEFT + 0.5 * self.width, TOP + 0.5 * self.height])
        return np.asarray(middle + np.clip(points - centre, -reach, reach) * self.scale * np.array([1.0, -1.0]))

    def line(self, points: FloatArray, *, closed: bool = False) -> str:
        """SVG path through points (N, 2) [m]; empty when nothing finite is left."""
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) == 0:
            return ""
        return path_through(self.pixels(thinned(points)), closed=closed)

    def disc(self, centre: FloatArray, radius: float) -> str:
        """SVG path of a circle with centre (2,) [m] and radius [m]."""
        x, y = self.pixels(centre[None, :])[0]
        # Rounded once: two half circles whose chord is not exactly their diameter are no circle.
        r = round(max(radius * self.scale, 0.1), 1)
        half = f"a{r:.1f} {r:.1f} 0 1 0"
        return f"M{x - r:.1f} {y:.1f}{half} {2 * r:.1f} 0{half} {-2 * r:.1f} 0Z"

    def outline(self, outline: Outline) -> str:
        """SVG path of an outline."""
        if isinstance(outline, Disc):
            return self.disc(outline.centre, outline.radius)
        return self.line(outline, closed=True)

    def panel(self, title: str, letters: str, marks: list[Mark]) -> Panel:
        """The finished picture with its axes; `letters` name them, such as `xy`."""
        half = 0.5 * np.array([self.width, self.height]) / self.scale
        centre = 0.5 * (self.low + self.high)
        low, high = centre - half, centre + half
        x_values = round_values(low[0], high[0], 7)
        y_values = round_values(low[1], high[1], max(5, round(self.height / 50)))
        x_places = self.pixels(np.column_stack([x_values, np.full(len(x_values), centre[1])]))[:, 0]
        y_places = self.pixels(np.column_stack([np.full(len(y_values), centre[0]), y_values]))[:, 1]
        return Panel(
            title=title,
            width=WIDTH,
            height=TOP + self.height + BOTTOM,
            left=LEFT,
            top=TOP,
            right=LEFT + self.width,
            bottom=TOP + self.height,
            x_label=f"{letters[0]} [m]",
            y_label=f"{letters[1]} [m]",
            x_ticks=_ticks(x_places, x_values),
            y_ticks=_ticks(y_places, y_values),
            marks=[mark for mark in marks if mark.d],
        )


def canvas_for(fixed: FloatArray, paths: FloatArray) -> Canvas:
    """A canvas that holds all fixed points (N, 2) [m], and paths (M, 2) [m] unless they run far away."""
    fixed = fixed[drawable(fixed).all(axis=1)]
    paths = paths[drawable(paths).all(axis=1)]
    low, high = (fixed.min(axis=0), fixed.max(axis=0)) if len(fixed) else (np.zeros(2), np.ones(2))
    reach = max(float((high - low).max()), 0.5)
    if len(paths):
        low = np.minimum(low, np.maximum(paths.min(axis=0), low - reach))
        high = np.maximum(high, np.minimum(paths.max(axis=0), high + reach))
    room = 0.04 * max(float((high - low).max()), 0.5)
    low, high = low - room, high + room
    size = high - low
    height = float(np.clip((WIDTH - LEFT - RIGHT) * size[1] / size[0], MIN_PLOT_HEIGHT, MAX_PLOT_HEIGHT))
    return Canvas(low, high, float(min((WIDTH - LEFT - RIGHT) / size[0], height / size[1])), height)


def thinned(points: FloatArray, most: int = MAX_PATH_POINTS) -> FloatArray:
    """At most `most` of the points, evenly taken, the first and the last among them."""
    if len(points) <= most:
        return points
    return np.asarray(points[np.round(np.linspace(0, len(points) - 1, most)).astype(int)])


def path_through(points: FloatArray, *, closed: bool = False) -> str:
    """SVG path through places (N, 2); lifted where one is not finite."""
    parts: list[str] = []
    pen = "M"
    for x, y in points.tolist():
        if x == x and y == y:  # not NaN
            parts.append(f"{pen}{x:.1f} {y:.1f}")
            pen = "L"
        else:
            pen = "M"
    return "".join(parts) + ("Z" if closed and parts else "")


def _ticks(places: FloatArray, values: list[float]) -> list[Tick]:
    return [Tick(round(float(at), 1), label) for at, label in zip(places, tick_labels(values), strict=True)]
