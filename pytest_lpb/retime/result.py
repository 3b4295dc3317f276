"""retimed.json: what pytest-benchmark wrote of calls timed again, as tables and reports read it."""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pytest_lpb.bounded import read_bounded
from pytest_lpb.errors import RecordingError
from pytest_lpb.retime.figures import NOISE_OF, RetimedRow, noise_floor

RETIMED_FILE = "retimed.json"
MAX_BYTES = 100_000_000
OWN_KEY = "pytest_lpb"  # of the JSON, beside what is pytest-benchmark's


@dataclass(frozen=True)
class Retimed:
    """Timing of planners by scenario, measured apart from any trial."""

    rows: Sequence[RetimedRow]
    moment: str = ""  # when it was measured, ISO 8601
    machine: str = ""  # the processor
    warnings: Sequence[str] = field(default_factory=tuple)

    def floor(self, figure: str) -> float:
        """The A/A noise floor of a figure, `p50` or `p95`: relative; NaN where it was not measured."""
        return noise_floor(self.rows, figure)

    def selected(self, keys: Collection[tuple[str, str]]) -> Retimed:
        """The same for some scenarios and planners."""
        return replace(self, rows=[row for row in self.rows if (row.scenario, row.planner) in keys])


def own_part(rows: Sequence[RetimedRow], warnings: Sequence[str]) -> dict[str, Any]:
    """What stands in the JSON beside the benchmarks."""
    floors = {f"noise_floor_{figure}": noise_floor(rows, figure) for figure in NOISE_OF}
    return {key: None if value != value else value for key, value in floors.items()} | {"warnings": list(warnings)}


def read_retimed(path: Path) -> Retimed | None:
    """What a file holds; None when there is none. Raises RecordingError for another kind of file."""
    if not path.exists():
        return None
    text = read_bounded(path, MAX_BYTES, RecordingError)
    try:
        content = json.loads(text)
        return Retimed(
            rows=[RetimedRow.from_dict(benchmark["extra_info"]) for benchmark in content["benchmarks"]],
            moment=content["datetime"],
            machine=str(content["machine_info"]["cpu"].get("brand_raw", "")),
            warnings=content[OWN_KEY]["warnings"],
        )
    except (ValueError, RecursionError, KeyError, TypeError, AttributeError) as error:
        raise RecordingError(f"cannot read {path}: {error!r}; measure again with --retime, or remove it") from error
