"""Names of parameters in planner files."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.names import listed, suggestion

Place = Callable[..., str]  # how messages call a part of the planner file, by its keys


def check_names(
    values: Iterable[str], allowed: Iterable[str], identity: str, loc: tuple[str, ...], place: Place
) -> None:
    """Raises ConfigurationError for a parameter that a class does not have."""
    allowed = list(allowed)
    for key in values:
        if key not in allowed:
            raise ConfigurationError(
                f"{place(*loc, key)}: unknown parameter{suggestion(key, allowed)}; "
                f"{identity.rpartition(':')[2].rpartition('.')[2]} has {listed(allowed)}"
            )
