"""The table of faults in docs/robustness.md says what the tests of faults test."""

import re
from pathlib import Path

import pytest

from tests.plugin.faults import FATAL, FAULTS, ISOLATED

TEXT = Path("docs/robustness.md")
APART = "Faults of a planner in a process of its own"


def rows(section: str = "Faults of a planner") -> dict[str, list[str]]:
    """Cells of the rows of a section that begin with a fault, by its name."""
    text = (Path(__file__).parents[2] / TEXT).read_text("utf-8")
    text = text.partition(f"\n## {section}\n")[2].partition("\n## ")[0]
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


def test_each_row_of_an_isolated_fault_is_tested() -> None:
    assert list(rows(APART)) == list(ISOLATED)


@pytest.mark.parametrize("name", ISOLATED)
def test_row_of_an_isolated_fault(name: str) -> None:
    _, code, keys, outcome, *seen = rows(APART)[name]
    fault = ISOLATED[name]
    assert code.strip("`").removeprefix("setup: ") in fault.code
    assert keys == f"`{fault.keys}`"
    assert outcome.strip(" |") == fault.outcome
    assert fault.outcome == "success" or fault.text in "".join(seen)
