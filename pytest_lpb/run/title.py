"""A run's title: what it is about, in its user's words. run.json has it; reports and terminals show it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.shown import visible

MAX_TITLE = 200  # characters


def checked_title(text: str, name: str) -> str:
    """A title as it was typed, in one line. Raises ConfigurationError for one that is no heading any more.

    Args:
        text: what was typed; empty: no title.
        name: of the option, for the message.
    """
    title = in_one_line(text)
    if len(title) > MAX_TITLE:
        raise ConfigurationError(f"{name}: found {len(title)} characters; a title may have at most {MAX_TITLE}")
    return title


def title_from(description: str) -> str:
    """The title that the first paragraph of a description makes; what is too long ends with `…`."""
    first = next((part for part in description.split("\n\n") if part.strip()), "")
    title = in_one_line(first)
    return title if len(title) <= MAX_TITLE else f"{title[: MAX_TITLE - 1].rstrip()}…"


def in_one_line(text: str) -> str:
    """Text without line breaks and control characters, that every encoding of Unicode can hold."""
    return visible(" ".join(text.split())).encode("utf-8", "backslashreplace").decode()


def title_of(info: Mapping[str, Any]) -> str:
    """The title in a run.json, whoever wrote it; empty without one."""
    return title_from(str(info.get("title") or ""))


def joint_title(infos: Iterable[Mapping[str, Any]]) -> str:
    """The title of several runs in one: each title once."""
    return title_from(" + ".join(dict.fromkeys(filter(None, map(title_of, infos)))))
