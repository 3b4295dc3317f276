"""What the writer writes is the same data to every reader."""

from __future__ import annotations

from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.documents.reader import read_yaml
from pytest_lpb.documents.writer import dump_yaml

TEXT = st.text(st.characters(exclude_categories=["Cs", "Cn", "Co"]), max_size=20)
NUMBERS = st.integers(-(10**9), 10**9) | st.floats(allow_nan=False, allow_infinity=False)
VALUES = st.recursive(
    st.none() | st.booleans() | NUMBERS | TEXT,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXT, inner, max_size=4),
    max_leaves=20,
)


@given(data=st.dictionaries(TEXT.filter(bool), VALUES, min_size=1, max_size=4))
def test_both_readers_read_what_was_written(data: dict[str, Any]) -> None:
    text = dump_yaml(data)
    assert read_yaml(text.encode(), "written.yaml").data == data
    assert yaml.safe_load(text) == data


@pytest.mark.parametrize(
    "word", ["yes", "NO", "on", "y", "null", "~", "1e-3", "012", "1:30", ".inf", "a: b", "", "=", "<<"]
)
def test_words_that_readers_disagree_on_are_quoted(word: str) -> None:
    data = {"word": word, "list": [{f"{word} key": 1e16}]}
    text = dump_yaml(data)
    assert yaml.safe_load(text) == data
    assert read_yaml(text.encode(), "written.yaml").data == data


def test_layout() -> None:
    written = dump_yaml({"version": 1, "goal": [{"name": "reach", "target": [4.0, 1e-05]}], "tags": []})
    assert written == "version: 1\ngoal:\n  - {name: reach, target: [4.0, 1.0e-05]}\ntags: []\n"
