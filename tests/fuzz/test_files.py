"""Files of strangers: read, or refused in words; never a traceback, nothing left behind."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_lpb.documents.reader import read_yaml
from pytest_lpb.errors import LpbError
from tests.fuzz.files import findings, kind_of, originals
from tests.fuzz.mutation import VALUES, mutated_bytes, places

MUTANTS = 400
PLAIN = st.recursive(
    st.sampled_from([value for value in VALUES if not isinstance(value, list | dict)])
    | st.text(max_size=20)
    | st.floats()
    | st.integers(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=12,
)
SCENARIO_KEYS = st.sampled_from(
    ["version", "robot", "environment", "start", "goal", "obstacles", "randomize", "success", "tags", "seed", "trials"]
)


@pytest.mark.parametrize("seed", range(3))
def test_mutants_of_shipped_files(tmp_path: Path, seed: int) -> None:
    # A time is no matter of a test: `python -m tests.fuzz.files` looks for slow ones.
    found = list(findings(MUTANTS, seed, tmp_path, slow_s=float("inf")))
    assert not found, "\n".join(f"{finding.original} #{finding.number}: {finding.what}" for finding in found)


def test_mutants_are_of_every_kind_and_some_are_read(tmp_path: Path) -> None:
    """The fuzzer can find something: a reader that raises is found, and not all mutants are refused."""
    from tests.fuzz import files

    assert {kind_of(path) for path in originals(tmp_path / "kinds")} == set(files.READERS)
    read: list[str] = []
    usual = dict(files.READERS)

    def faulty(path: Path) -> None:
        usual[kind_of(path)](path)
        read.append(kind_of(path))
        raise KeyError("a bug")

    (tmp_path / "runs").mkdir()
    files.READERS.update(dict.fromkeys(usual, faulty))
    try:
        found = list(findings(200, 3, tmp_path / "runs", slow_s=float("inf")))
    finally:
        files.READERS.update(usual)
    assert set(read) == set(usual)
    assert len(found) == len(read)
    assert "KeyError: 'a bug'" in found[0].what


@given(st.binary(max_size=400))
def test_any_bytes_are_yaml_or_refused(content: bytes) -> None:
    refused, data = "", None
    try:
        data = read_yaml(content, "x.yaml").data
    except LpbError as error:
        refused = str(error)
    assert isinstance(data, dict) or re.match(r"x\.yaml:\d+: ", refused)


@settings(max_examples=200)
@given(st.dictionaries(SCENARIO_KEYS, PLAIN, max_size=6))
def test_any_values_of_a_scenario_are_refused_with_their_line(
    tmp_path_factory: pytest.TempPathFactory, data: dict[str, object]
) -> None:
    from pytest_lpb.scenario.load import load_scenario

    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_text(yaml.safe_dump({"version": 1, **data}, allow_unicode=True), "utf-8", errors="replace")
    with pytest.raises(LpbError, match=r"any\.yaml:\d+: "):
        load_scenario(path)


def test_mutations_change_something() -> None:
    import random

    text = "robot: {model: point}\ngoal: [1, 2]\n"
    assert len({mutated_bytes(text, random.Random(seed)) for seed in range(20)}) > 10
    assert places({"a": [1, 2]}) == [(), ("a",), ("a", 0), ("a", 1)]
