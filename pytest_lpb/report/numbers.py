"""Numbers as people read them: three significant digits, true minus signs, an en dash where there is none."""

from __future__ import annotations

import math
from typing import Any

from pytest_lpb import names

EMPTY = "–"
THIN_SPACE = "\u202f"

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def finite(value: Any) -> float | None:
    """The value as a float; None for NaN, infinities, missing values and anything that is no number."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return None
    return number if math.isfinite(number) else None


def show(value: Any, digits: int = 3) -> str:
    """A number with `digits` significant digits; an en dash when there is none."""
    number = finite(value)
    if number is None:
        return EMPTY
    if number == 0:
        return "0"
    exponent = int(f"{number:.{digits - 1}e}".partition("e")[2])
    if exponent < -4 or exponent > 8:
        mantissa, _, power = f"{number:.{max(digits - 2, 0)}e}".partition("e")
        return minus(f"{float(mantissa):g}·10") + str(int(power)).translate(_SUPERSCRIPT)
    text = f"{number:,.{max(digits - 1 - exponent, 0)}f}".replace(",", THIN_SPACE)
    return minus(text)


def show_exact(value: Any) -> str:
    """A number somebody chose or counted, as short as it can be: 0.1, 25, 1200."""
    number = finite(value)
    if number is None:
        return EMPTY
    if number == int(number) and abs(number) < 1e9:
        return minus(f"{int(number):,}".replace(",", THIN_SPACE))
    return minus(f"{number:.6g}") if 1e-4 <= abs(number) < 1e6 else show(number)


def show_p(value: Any) -> str:
    """A p-value."""
    number = finite(value)
    if number is None:
        return EMPTY
    return "< 0.001" if number < 0.001 else f"{number:.3f}"


def percent(rate: Any) -> str:
    """A rate as a percentage, such as `93 %`."""
    return EMPTY if finite(rate) is None else f"{whole_percent(rate)}{THIN_SPACE}%"


def whole_percent(rate: Any) -> str:
    """A rate in whole percent, without the sign: 100 only when it is all of them, 0 only when it is none."""
    number = finite(rate)
    if number is None:
        return EMPTY
    if 0.995 <= number < 1:
        return "> 99"
    return "< 1" if 0 < number <= 0.005 else f"{100 * number:.0f}"


def interval(low: Any, high: Any) -> str:
    """An interval of rates in percent, such as `62–88 %`."""
    bounds = finite(low), finite(high)
    if bounds[0] is None or bounds[1] is None:
        return EMPTY
    return f"{100 * bounds[0]:.0f}–{100 * bounds[1]:.0f}{THIN_SPACE}%"


def count(number: int, noun: str) -> str:
    """`1 trial`, `3 trials`, `1 200 trials`."""
    grouped = f"{number:,}".replace(",", THIN_SPACE)
    return names.count(number, noun).replace(str(number), grouped, 1)


def minus(text: str) -> str:
    """The text with a true minus sign."""
    return text.replace("-", "−", 1) if text.startswith("-") else text


def unit_text(unit: str) -> str:
    """A unit with superscripts: `m/s^3` becomes `m/s³`; empty for counts and ratios."""
    if unit == "1":
        return ""
    head, caret, power = unit.partition("^")
    return head + power.translate(_SUPERSCRIPT) if caret else unit


def kpi_title(name: str, unit: str) -> str:
    """A KPI's name in words with its unit: `path_length_m` becomes `path length [m]`."""
    suffix = unit.replace("^", "").replace("1/", "per_").replace("/", "_per_")
    words = (name.removesuffix(f"_{suffix}") if suffix else name).replace("_", " ")
    return f"{words} [{unit_text(unit)}]" if unit_text(unit) else words
