"""The unit that a KPI's name ends with: `path_length_m` is in m, `jerk_rms_m_per_s3` in m/s^3."""

import re

BY_CONTROL_MODE = "by control mode"  # of actions, m/s, rad/s^2, ...: never pooled across control modes

BASE_UNITS = frozenset(
    (
        *("m", "mm", "cm", "km", "rad", "deg"),
        *("s", "ms", "us", "ns", "Hz", "hz"),
        *("kg", "N", "Nm", "J", "W", "percent"),
    )
)

_TOKEN = re.compile(r"([A-Za-z]+)([2-9]?)")
_SPELLINGS = str.maketrans({"²": "2", "³": "3", "^": None, " ": None, "*": None, "·": None, "%": "percent"})


def unit_of_name(name: str) -> str | None:
    """Unit that a KPI's name carries as its suffix, or None when the name ends with something else.

    `clearance_min_m` gives m, `curvature_max_per_m` 1/m, `jerk_rms_m_per_s3` m/s^3, `ldj` None.
    """
    words = name.split("_")
    last = _unit(words[-1])
    if last is None or len(words) < 2:
        return None
    if words[-2] != "per":
        return last
    return f"{_unit(words[-3]) or '1'}/{last}" if len(words) > 2 else None


def same_unit(first: str, second: str) -> bool:
    """Whether two spellings mean one unit: m/s^3, m/s3 and m/s³ do."""
    return _plain(first) == _plain(second)


def _unit(word: str) -> str | None:
    match = _TOKEN.fullmatch(word)
    if match is None or match[1] not in BASE_UNITS:
        return None
    return f"{match[1]}^{match[2]}" if match[2] else match[1]


def _plain(unit: str) -> str:
    return unit.translate(_SPELLINGS).replace("hz", "Hz")
