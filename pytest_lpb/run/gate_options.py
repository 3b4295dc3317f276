"""The gate as it is asked for in options, checked before anything is run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pytest_lpb.errors import ConfigurationError, LpbError
from pytest_lpb.kpis.definition import Kpi
from pytest_lpb.names import listed
from pytest_lpb.run.baseline import Baseline, open_baseline
from pytest_lpb.run.margins import DEFAULT_MARGINS, Margin, parse_margins

if TYPE_CHECKING:
    from pytest_lpb.run.gate import Gate

INCONCLUSIVE = ("pass", "fail")


@dataclass(frozen=True)
class GateOptions:
    """What the user wrote, and behind which options: `--lpb-baseline` in pytest, `--baseline` in lpb-report."""

    baseline: str
    fail_on: Sequence[str] | None  # entries KPI:MARGIN; None: the default
    inconclusive: str
    prefix: str

    def gate(self, folder: Path, planners: Sequence[str], kpis: Sequence[Kpi]) -> CheckedGate:
        """The gate, checked.

        Args:
            folder: what the baseline's path is relative to.
            planners: names of the run's planners.
            kpis: those that are evaluated.

        Raises:
            LpbError: there is no such baseline, it has none of the planners, a margin is wrong, or the baseline has
                no values of its KPI.
        """
        if self.inconclusive not in INCONCLUSIVE:
            raise ConfigurationError(
                f"{self.prefix}inconclusive: found {self.inconclusive!r}; allowed are {listed(INCONCLUSIVE)}"
            )
        margins = parse_margins(self._fail_on, kpis, f"{self.prefix}fail-on")
        try:
            baseline = open_baseline(self.baseline, folder)
            baseline.counterparts(planners)
            _check_values(baseline, margins)
        except LpbError as error:
            raise ConfigurationError(f"{self.prefix}baseline: {error}") from error
        return CheckedGate(baseline, tuple(margins), self.inconclusive == "fail")

    @property
    def recorded(self) -> dict[str, object]:
        """What run.json says of it."""
        return {"baseline": self.baseline, "fail_on": self._fail_on, "inconclusive": self.inconclusive}

    @property
    def _fail_on(self) -> list[str]:
        return [DEFAULT_MARGINS] if self.fail_on is None else list(self.fail_on)


@dataclass(frozen=True)
class CheckedGate:
    """Options that make sense; nothing heavy is imported for them."""

    baseline: Baseline
    margins: tuple[Margin, ...]
    inconclusive_fails: bool

    def gate(self) -> Gate:
        """The gate itself; imports pandas and SciPy."""
        from pytest_lpb.run.gate import Gate

        return Gate(self.baseline, self.margins, self.inconclusive_fails)


def _check_values(baseline: Baseline, margins: Sequence[Margin]) -> None:
    known = baseline.kpis
    missing = [m.name for m in margins if known is not None and m.kpi is not None and m.name not in known]
    if missing:
        raise ConfigurationError(
            f"{baseline.name} has no values of {', '.join(missing)}, but of {listed(known or ())}; save it again with "
            f"--save-baseline={baseline.name} --kpis={','.join(missing)},..."
        )
