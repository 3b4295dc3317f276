"""The tables of faults and crashes in the docs say what the tests of faults and crashes test."""

import inspect
import re
from importlib import import_module
from pathlib import Path

import pytest

from tests.plugin.crashes import CRASHES, TESTS
from tests.plugin.faults import FATAL, FAULTS, ISOLATED

FOLDER = Path(__file__).parents[2] / "docs"
HERE = "Faults of a planner"
APART = "Faults of a planner in a process of its own"


def rows(section: str = HERE) -> dict[str, list[str]]:
    """Cells of the rows that begin with a fault, by its name, in a section of robustness.md."""
    text = (FOLDER / "robustness.md").read_text("utf-8")
    return cells_of(text.partition(f"\n## {section}\n")[2].partition("\n## ")[0], "fault")


def cells_of(text: str, head: str) -> dict[str, list[str]]:
    """Cells of a text's rows, by the first word; without rows of headings, which begin with `head`."""
    found = [re.split(r"(?<!\\) \| ", line.strip("| \n")) for line in text.splitlines() if line.startswith("| ")]
    return {re.split(r"\W", cells[0])[0]: cells for cells in found if cells[0] != head}


def crashes() -> dict[str, list[str]]:
    return cells_of((FOLDER / "crashes.md").read_text("utf-8"), "crash")


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


def test_each_crash_is_one_that_is_tested() -> None:
    assert list(crashes()) == list(CRASHES)


@pytest.mark.parametrize("name", CRASHES)
def test_row_of_a_crash(name: str) -> None:
    seen = crashes()[name][2]
    for text in CRASHES[name]:
        assert text in seen
    module, test = TESTS[name].split(".")
    source = inspect.getsource(getattr(import_module(f"tests.plugin.{module}"), test))
    assert f'expect("{name}"' in source
