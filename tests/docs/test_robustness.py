"""The table of faults in docs/robustness.md says what the tests of faults test."""

import re
from pathlib import Path

import pytest

from tests.plugin.faults import FATAL, FAULTS

TEXT = Path("docs/robustness.md")


def rows() -> dict[str, list[str]]:
    """Cells of the rows that begin with a fault, by its name."""
    text = (Path(__file__).parents[2] / TEXT).read_text("utf-8")
    text = text.partition("\n## Faults of a planner\n")[2].partition("\n## ")[0]
    found = [re.split(r"(?<!\\) \| ", line.strip("| \n")) for line in text.splitlines() if line.startswith("| ")]
    return {re.split(r"\W", cells[0])[0]: cells for cells in found if cells[0] != "fault"}


def test_each_row_is_a_fault_that_is_tested() -> None:
    assert list(rows()) == [*FAULTS, *FATAL]


@pytest.mark.parametrize("name", FAULTS)
def test_row(name: str) -> None:
    _, _, outcome, *seen = rows()[name]
    fault = FAULTS[name]
    assert outcome.strip(" |") == fault.outcome
    text = fault.details if fault.outcome == "success" else fault.text.rstrip("x").rstrip()
    assert text in "".join(seen)


@pytest.mark.parametrize("name", FATAL)
def test_row_of_a_fatal_fault(name: str) -> None:
    first, with_workers, without = rows()[name]
    assert FATAL[name] in first
    assert with_workers.startswith("worker_crash")
    assert without.startswith("the run ends; finished trials are kept")
