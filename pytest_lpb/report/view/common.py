"""What every view model is made of."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PlannerStyle:
    """How a planner looks in every figure."""

    name: str
    number: int  # place among the planners
    colour: int  # number of a CSS colour variable
    dash: str  # SVG stroke-dasharray; empty: solid
    marker: str  # SVG path around (0, 0)


@dataclass(frozen=True)
class Tick:
    """A labelled place on an axis."""

    at: float  # [%] of the axis, or [px] in a scene
    label: str


@dataclass(frozen=True)
class Cell:
    """A number in a table: as shown, as sorted, and what there is to know about it."""

    text: str
    value: float | None = None
    note: str = ""
    mark: str = ""


@dataclass(frozen=True)
class Fact:
    """A line about the run: machine, version, command."""

    name: str
    text: str
