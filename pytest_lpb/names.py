"""Names of planners, scenarios, KPIs and bodies: what is allowed, and the nearest one to a misspelt one."""

import difflib
import re
from collections.abc import Iterable

MAX_NAME_LENGTH = 100
NAME_PATTERN = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]*")


def is_name(text: str) -> bool:
    """Whether `text` may name a planner, goal, obstacle or scenario file stem."""
    return len(text) <= MAX_NAME_LENGTH and NAME_PATTERN.fullmatch(text) is not None


def suggestion(found: str, allowed: Iterable[str]) -> str:
    """`; did you mean 'x'?` for the nearest allowed name, or an empty string when none is near."""
    nearest = difflib.get_close_matches(found, sorted(allowed), n=3, cutoff=0.6)
    if not nearest:
        return ""
    return "; did you mean " + " or ".join(repr(name) for name in nearest) + "?"


def listed(names: Iterable[str]) -> str:
    """Names as a sorted, comma-separated list; `(none)` when there are none."""
    return ", ".join(sorted(names)) or "(none)"


def count(number: int, noun: str, plural: str = "") -> str:
    """`1 trial`, `3 trials`; `plural` where it is not the noun with an s."""
    return f"{number} {noun if number == 1 else plural or noun + 's'}"
