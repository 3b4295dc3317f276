"""How much worse a planner may be than its baseline: `success:2%,time_to_goal_s:10%,clearance_min_m:0.01m`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.kpis.units import BY_CONTROL_MODE, same_unit
from pytest_lpb.names import listed, suggestion

if TYPE_CHECKING:
    from pytest_lpb.run.problems import KpiColumn

SUCCESS = "success"
DEFAULT_MARGINS = "success:5%"
PERCENT = "%"
POINTS = "pp"  # percentage points: what two rates differ by
DIMENSIONLESS = "1"

_ENTRY = re.compile(r"([^:]+):\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)")


@dataclass(frozen=True)
class Margin:
    """The loss that is tolerated in one KPI, or in the success rate (`kpi` None)."""

    kpi: KpiColumn | None
    value: float  # relative: share of the baseline's mean; success: of all problems; else in the KPI's unit
    relative: bool

    @property
    def name(self) -> str:
        """The KPI's name, or `success`."""
        return SUCCESS if self.kpi is None else self.kpi.name

    @property
    def unit(self) -> str:
        """Unit of losses: `%`, the KPI's, or empty for a plain number."""
        if self.kpi is None or self.relative:
            return PERCENT
        return "" if self.kpi.unit == DIMENSIONLESS else self.kpi.unit

    @property
    def timing(self) -> bool:
        """Whether the machine's speed is in it."""
        return self.kpi is not None and self.kpi.timing

    def text(self, *losses: float) -> str:
        """A loss in words: `5 %`, `0.01 m`, of success `5 pp` (percentage points); or the range of two: `1 to 5 %`."""
        scale = 100 if self.unit == PERCENT else 1
        unit = POINTS if self.kpi is None else self.unit
        return f"{' to '.join(f'{scale * loss:.3g}' for loss in losses)} {unit}".rstrip()


def parse_margins(texts: Iterable[str], kpis: Iterable[KpiColumn], option: str) -> list[Margin]:
    """Margins as users write them, in their order.

    Args:
        texts: entries `KPI:MARGIN`; a percentage is a share of the baseline's mean (for success: percentage
            points), a number with the KPI's unit is absolute.
        kpis: all that may be named.
        option: what the user typed them behind, for messages.

    Raises:
        ConfigurationError: no margin, unknown KPI, one without direction, wrong unit, negative: one line each.
    """
    known = {kpi.name: kpi for kpi in kpis}
    margins: dict[str, Margin] = {}
    faults = []
    for text in texts:
        try:
            margin = _parse(text, known)
            if margin.name in margins:
                raise ConfigurationError(f"{margin.name} has two margins; leave one out")
            margins[margin.name] = margin
        except ConfigurationError as error:
            faults.append(f"{option}: {error}")
    if not margins and not faults:
        faults.append(f"{option}: found no margin; write KPI:MARGIN, such as {DEFAULT_MARGINS}")
    if faults:
        raise ConfigurationError("\n".join(faults))
    return list(margins.values())


def _parse(text: str, known: Mapping[str, KpiColumn]) -> Margin:
    match = _ENTRY.fullmatch(text.strip())
    if match is None:
        raise ConfigurationError(f"found {text!r}; allowed is KPI:MARGIN, such as success:2% or clearance_min_m:0.01m")
    name, value, unit = match[1].strip(), float(match[2]), match[3].strip()
    if name != SUCCESS and name not in known:
        names = [SUCCESS, *(kpi.name for kpi in known.values() if kpi.direction != "none")]
        raise ConfigurationError(f"unknown KPI {name!r}{suggestion(name, names)}; margins may have: {listed(names)}")
    if value < 0 or not math.isfinite(value):
        raise ConfigurationError(f"{name}: found {match[2]}{unit}; a margin is 0 or above: the loss that is tolerated")
    if name == SUCCESS:
        if unit != PERCENT:
            raise ConfigurationError(f"success: found {match[2]}{unit}; allowed are percentage points, such as 2%")
        return Margin(None, value / 100, relative=False)
    kpi = known[name]
    if kpi.direction == "none":
        raise ConfigurationError(f"{name} has no direction: neither more nor less of it is worse")
    if unit == PERCENT:
        return Margin(kpi, value / 100, relative=True)
    _check_unit(kpi, match[2], unit)
    return Margin(kpi, value, relative=False)


def _check_unit(kpi: KpiColumn, number: str, unit: str) -> None:
    if same_unit(kpi.unit, BY_CONTROL_MODE):
        raise ConfigurationError(
            f"{kpi.name}: found {number}{unit}; its unit depends on the control mode: write {number}%"
        )
    plain = kpi.unit == DIMENSIONLESS
    if unit == "" if plain else same_unit(unit, kpi.unit):
        return
    allowed = number if plain else f"{number}{' ' if kpi.unit[0].isdigit() else ''}{kpi.unit}"
    raise ConfigurationError(
        f"{kpi.name}: found {number}{unit}; allowed are {allowed} (its own unit) and {number}% (of the baseline's mean)"
    )
