"""A user's plots."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class UserFigure:
    """A user's plot as an image, or why it could not be drawn."""

    title: str
    image: str  # data URI
    error: str = ""
