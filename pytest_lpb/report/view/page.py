"""The page as a whole: views, each of sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pytest_lpb.report.view.common import PlannerStyle


@dataclass(frozen=True)
class ShownSection:
    """A section with something to show."""

    name: str
    template: str
    model: Any


@dataclass(frozen=True)
class ShownView:
    """What is seen at once; one after the other without scripts and on paper."""

    name: str
    title: str  # in the navigation; empty: not there
    sections: Sequence[ShownSection]


@dataclass(frozen=True)
class Page:
    """Everything on the page, in reading order."""

    title: str
    subtitle: str
    styles: Sequence[PlannerStyle]
    views: Sequence[ShownView]

    def model(self, section: str) -> Any:
        """The model of a section; None where it has nothing to show."""
        found = [shown.model for view in self.views for shown in view.sections if shown.name == section]
        return found[0] if found else None
