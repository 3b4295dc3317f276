"""Reading YAML: its meaning, its bounds, and the line of every fault."""

import json
import math
import time
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_lpb.documents import reader
from pytest_lpb.documents.reader import read_yaml
from pytest_lpb.documents.resolver import resolve
from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.errors import ScenarioError


@pytest.fixture(params=["CSafeLoader", "SafeLoader"], autouse=True)
def parser(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both of PyYAML's parsers: libyaml is not everywhere."""
    if not hasattr(yaml, request.param):
        pytest.skip("PyYAML was built without libyaml")
    monkeypatch.setattr(reader, "_PARSER", getattr(yaml, request.param))


def fault(text: str | bytes) -> str:
    """The one message that reading the text gives."""
    content = text if isinstance(text, bytes) else text.encode()
    with pytest.raises(ScenarioError) as caught:
        read_yaml(content, "x.yaml")
    (message,) = caught.value.faults
    return message


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001),
        ("1e5", 100000.0),
        (".5", 0.5),
        ("5.", 5.0),
        ("-0", 0),
        ("+1", 1),
        ("0x1F", 31),
        ("0o17", 15),
        ("on", "on"),
        ("yes", "yes"),
        ("No", "No"),
        ("012", "012"),
        ("00.5", "00.5"),
        ("1:30", "1:30"),
        ("1_000", "1_000"),
        ("2024-01-01", "2024-01-01"),
        ("0b1", "0b1"),
        ("-", "-"),
        (".", "."),
        ("true", True),
        ("FALSE", False),
        ("null", None),
        ("~", None),
        ("-.inf", -math.inf),
    ],
)
def test_plain_scalars_follow_yaml_1_2(text: str, value: object) -> None:
    assert resolve(text) == value
    assert type(resolve(text)) is type(value)


def test_nan_is_read() -> None:
    assert math.isnan(read_yaml(b"a: .nan\n", "x").data["a"])


def test_quoted_text_stays_text() -> None:
    assert read_yaml(b"{a: '1e-3', b: \"true\", c: 'null'}", "x").data == {
        "a": "1e-3",
        "b": "true",
        "c": "null",
    }


def test_lines_of_key_paths() -> None:
    text = b"a: 1\ngoal:\n  - name: x\n    target:\n      - 1\n      - 2\n  - {name: y,\n     link: z}\n"
    document = read_yaml(text, "x")
    lines = {
        ("a",): 1,
        ("goal",): 2,
        ("goal", 0): 3,
        ("goal", 0, "target"): 4,
        ("goal", 0, "target", 1): 6,
        ("goal", 1, "link"): 8,
        ("goal", 1, "absent"): 7,
        ("absent", 0): 1,
    }
    assert {loc: document.line_of(loc) for loc in lines} == lines


def test_alias_repeats_its_anchor_under_its_own_line() -> None:
    document = read_yaml(b"a: &p [1, 2]\nb: *p\n", "x")
    assert document.data == {"a": [1, 2], "b": [1, 2]}
    assert document.line_of(("b",)) == 2


def test_all_duplicate_keys_are_named_with_both_lines() -> None:
    with pytest.raises(ScenarioError) as caught:
        read_yaml(b"a: 1\nb:\n  - c: 1\n    c: 2\na: 3\n", "x.yaml")
    assert caught.value.faults == (
        "x.yaml:4: b[0].c: duplicate key; it is first given in line 3",
        "x.yaml:5: a: duplicate key; it is first given in line 1",
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "x.yaml:1: the file is empty; a scenario is a mapping that begins with `version: 1`"),
        ("# nothing\n", "x.yaml:1: the file is empty; a scenario is a mapping that begins with `version: 1`"),
        ("\n- 1\n", "x.yaml:2: found a list; a scenario is a mapping that begins with `version: 1`"),
        (
            "text",
            "x.yaml:1: found the single value 'text'; a scenario is a mapping that begins with `version: 1`",
        ),
        ("a: 1\n---\nb: 2\n", "x.yaml:2: a second document begins here; a file holds one scenario"),
        ("a: 1\nb: \x07\n", "x.yaml:2: found the control character U+0007, not text"),
        (b"a: 1\nb: \xe9\n", "x.yaml:2: found the byte 0xe9; it must be a text file in UTF-8"),
        (b"\x89PNG\r\n\x1a\n", "x.yaml:1: found the byte 0x89; it must be a text file in UTF-8"),
        (
            "a: &x {b: 1}\nc:\n  <<: *x\n",
            "x.yaml:3: c: found the merge key <<; it is no YAML 1.2: write the keys out",
        ),
        ("a:\n  1: 2\n", "x.yaml:2: a: found the key 1; keys are text"),
        ("a:\n  null: 2\n", "x.yaml:2: a: found the key nothing (null); keys are text"),
        ("? [a]\n: 1\n", "x.yaml:1: found a mapping or a list as a key; keys are text"),
        ("a: *x\n", "x.yaml:1: the alias *x has no anchor &x before it"),
        ("a: &x [*x]\n", "x.yaml:1: the alias *x stands within what it stands for"),
        ("a: 1" + "0" * 100, "x.yaml:1: found a number of 101 characters; allowed are at most 100"),
        (
            "a: !!python/name:f [ls]\n",
            "x.yaml:1: found the tag tag:yaml.org,2002:python/name:f; tags are not allowed",
        ),
    ],
)
def test_one_message_for_what_is_no_scenario(text: str | bytes, message: str) -> None:
    assert fault(text) == message


def test_syntax_error_names_its_line() -> None:
    message = fault("a: [1, 2\nb: 3\nc: 4\n")
    assert message.startswith("x.yaml:2: not YAML: ")
    assert "while parsing a flow sequence" in message


def alias_bomb(levels: int) -> str:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, levels)]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (alias_bomb(30), "more than 50000 values (aliases expanded); that is too many"),
        ("a: [" + "1," * 60_000 + "]", "more than 50000 values (aliases expanded); that is too many"),
        ("a: &x 1\nb: [" + "*x, " * 1001 + "]", "more than 1000 aliases; that is too many"),
        ("[" * 100_000, "nested more than 32 levels deep; that is too deep"),
        ("{a: " * 5_000, "nested more than 32 levels deep; that is too deep"),
        ("a: " + "x" * (1 << 20), "the file has more than 1048576 bytes; that is too large"),
    ],
)
def test_bounds_hold_quickly(text: str, message: str) -> None:
    start = time.perf_counter()
    assert fault(text).endswith(message)
    assert time.perf_counter() - start < 5.0  # [s]; a nested bomb would take hours


def test_a_thousand_aliases_are_read() -> None:
    data = read_yaml(("a: &x 1\nb: [" + "*x, " * 1000 + "]").encode(), "x").data
    assert data["b"] == [1] * 1000


keys = st.text(st.characters(codec="utf-8"), max_size=30).filter("<<".__ne__)
plain_text = st.text(st.characters(codec="utf-8"), max_size=300)
awkward_text = st.sampled_from(
    ["1e-3", "on", "012", "0x1F", "0o7", "1.", "~", ".inf", "null", "=", "<<", "- a", "a: b", "#"]
)
scalars = st.none() | st.booleans() | st.integers(-(10**20), 10**20) | st.floats(allow_nan=False, allow_infinity=False)
values = st.recursive(
    scalars | plain_text | awkward_text,
    lambda children: st.lists(children, max_size=4) | st.dictionaries(keys, children, max_size=4),
    max_leaves=10,
)


def same(a: Any, b: Any) -> bool:
    """Equal, with types and the sign of zero."""
    return repr(a) == repr(b)


@settings(deadline=None)
@given(st.dictionaries(keys, values, min_size=1, max_size=4))
def test_written_data_is_read_back_exactly(data: dict[str, Any]) -> None:
    assert same(read_yaml(dump_yaml(data).encode(), "x").data, data)


@settings(deadline=None)
@given(st.dictionaries(st.sampled_from("abc"), st.lists(st.floats(allow_nan=False, allow_infinity=False)), min_size=1))
def test_json_numbers_are_read_back_exactly(data: dict[str, list[float]]) -> None:
    assert same(read_yaml(json.dumps(data).encode(), "x").data, data)
