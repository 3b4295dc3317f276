"""Read a scenario file's YAML: bounded, without surprises, and with the line of every key.

Built from the parser's events, not by PyYAML's constructor: sizes, depth and aliases are bounded while
reading, so that a file made to exhaust memory is refused within milliseconds.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from pytest_lpb.documents.faults import Key, capped, described, key_path
from pytest_lpb.documents.resolver import resolve
from pytest_lpb.errors import ScenarioError

MAX_BYTES = 1 << 20
MAX_NODES = 50_000  # aliases count as what they stand for
MAX_ALIASES = 1_000
MAX_DEPTH = 32

# libyaml's parser gives the same events with the same marks, about ten times as fast.
_PARSER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
SCENARIO = "a scenario is a mapping that begins with `version: 1`"
_NOT_PRINTABLE = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass(slots=True)
class Place:
    """Where a value stands: the line of its key (or of itself, in a list), and the places within it."""

    line: int
    children: dict[Key, Place]


@dataclass(frozen=True, slots=True)
class Document:
    """A YAML file as plain data, with the line of each part."""

    data: dict[str, Any]
    root: Place

    def line_of(self, loc: Sequence[Key]) -> int:
        """Line (1-based) of the key path `loc`, or of its nearest enclosing part that is in the file."""
        place = self.root
        for key in loc:
            if key not in place.children:
                break
            place = place.children[key]
        return place.line


def read_yaml(content: bytes, name: str, expected: str = SCENARIO) -> Document:
    """Read one YAML document whose top level is a mapping.

    Args:
        content: the file's bytes.
        name: what to call the file in messages.
        expected: what the file should be, for messages.

    Raises:
        ScenarioError: `name:line: message`, one for each duplicate key, else for the first fault found.
    """
    text = _decoded(content, name)
    builder = _Builder(expected)
    try:
        for event in yaml.parse(text, Loader=_PARSER):
            builder.handle(event)
        return builder.document()
    except _FaultError as fault:
        raise ScenarioError(*capped([f"{name}:{line}: {message}" for line, message in fault.faults])) from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark else 1
        if "nesting depth" in str(error.problem):
            # Newer parsers look ahead and have a bound of their own, far beyond ours.
            raise ScenarioError(f"{name}:{line}: {TOO_DEEP}") from None
        context = f" ({error.context})" if error.context else ""
        raise ScenarioError(f"{name}:{line}: not YAML: {error.problem}{context}") from None


def _decoded(content: bytes, name: str) -> str:
    if len(content) > MAX_BYTES:
        raise ScenarioError(f"{name}:1: the file has more than {MAX_BYTES} bytes; that is too large")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise ScenarioError(
            f"{name}:{line}: found the byte 0x{content[error.start]:02x}; it must be a text file in UTF-8"
        ) from None
    if wrong := _NOT_PRINTABLE.search(text):
        line = text.count("\n", 0, wrong.start()) + 1
        raise ScenarioError(f"{name}:{line}: found the control character U+{ord(wrong.group()):04X}, not text")
    return text


TOO_DEEP = f"nested more than {MAX_DEPTH} levels deep; that is too deep"


class _FaultError(Exception):
    def __init__(self, *faults: tuple[int, str]) -> None:
        super().__init__(faults)
        self.faults = faults


class _Open:
    """A mapping or list whose end has not been reached yet."""

    def __init__(self, data: dict[str, Any] | list[Any], line: int, anchor: str | None, first_node: int) -> None:
        self.data = data
        self.line = line
        self.anchor = anchor
        self.first_node = first_node
        self.children: dict[Key, Place] = {}
        self.key: str | None = None
        self.key_line = line


@dataclass(frozen=True, slots=True)
class _Anchored:
    value: Any
    children: dict[Key, Place]
    nodes: int


class _Builder:
    """Builds plain data from YAML events, without recursion."""

    def __init__(self, expected: str) -> None:
        self.expected = expected
        self.stack: list[_Open] = []
        self.anchors: dict[str, _Anchored | None] = {}  # None: not closed yet
        self.nodes = 0
        self.aliases = 0
        self.documents = 0
        self.root: tuple[Any, Place] | None = None
        self.duplicates: list[tuple[int, str]] = []

    def handle(self, event: yaml.Event) -> None:
        line = event.start_mark.line + 1 if event.start_mark else 1
        match event:
            case yaml.ScalarEvent():
                self._untagged(event, line)
                self._count(1, line)
                self._scalar(event, line)
            case yaml.MappingStartEvent() | yaml.SequenceStartEvent():
                self._untagged(event, line)
                self._count(1, line)
                self._open({} if isinstance(event, yaml.MappingStartEvent) else [], event.anchor, line)
            case yaml.CollectionEndEvent():
                self._close()
            case yaml.AliasEvent():
                self._alias(str(event.anchor), line)
            case yaml.DocumentStartEvent():
                self.documents += 1
                if self.documents > 1:
                    raise _FaultError((line, "a second document begins here; a file holds one scenario"))

    def document(self) -> Document:
        if self.duplicates:
            raise _FaultError(*self.duplicates)
        if self.root is None or self.root[0] is None:
            raise _FaultError((1, f"the file is empty; {self.expected}"))
        data, place = self.root
        if not isinstance(data, dict):
            found = "a list" if isinstance(data, list) else f"the single value {data!r:.60}"
            raise _FaultError((place.line, f"found {found}; {self.expected}"))
        return Document(data, place)

    def _count(self, nodes: int, line: int) -> None:
        self.nodes += nodes
        if self.nodes > MAX_NODES:
            raise _FaultError((line, f"more than {MAX_NODES} values (aliases expanded); that is too many"))

    def _untagged(self, event: yaml.ScalarEvent | yaml.CollectionStartEvent, line: int) -> None:
        if event.tag is not None:
            raise _FaultError((line, f"found the tag {event.tag}; tags are not allowed"))

    def _scalar(self, event: yaml.ScalarEvent, line: int) -> None:
        try:
            value = resolve(event.value) if event.implicit[0] else event.value
        except ValueError as error:
            raise _FaultError((line, str(error))) from None
        if event.anchor:
            self.anchors[event.anchor] = _Anchored(value, {}, 1)
        self._add(value, {}, line)

    def _open(self, data: dict[str, Any] | list[Any], anchor: str | None, line: int) -> None:
        if self.stack and isinstance(self.stack[-1].data, dict) and self.stack[-1].key is None:
            raise _FaultError((line, "found a mapping or a list as a key; keys are text"))
        if len(self.stack) >= MAX_DEPTH:
            raise _FaultError((line, TOO_DEEP))
        if anchor:
            self.anchors[anchor] = None
        self.stack.append(_Open(data, line, anchor, self.nodes))

    def _close(self) -> None:
        closed = self.stack.pop()
        if closed.anchor:
            nodes = self.nodes - closed.first_node + 1
            self.anchors[closed.anchor] = _Anchored(closed.data, closed.children, nodes)
        self._add(closed.data, closed.children, closed.line)

    def _alias(self, anchor: str, line: int) -> None:
        self.aliases += 1
        if self.aliases > MAX_ALIASES:
            raise _FaultError((line, f"more than {MAX_ALIASES} aliases; that is too many"))
        if anchor not in self.anchors:
            raise _FaultError((line, f"the alias *{anchor} has no anchor &{anchor} before it"))
        target = self.anchors[anchor]
        if target is None:
            raise _FaultError((line, f"the alias *{anchor} stands within what it stands for"))
        self._count(target.nodes, line)
        self._add(target.value, target.children, line)

    def _add(self, value: Any, children: dict[Key, Place], line: int) -> None:
        if not self.stack:
            self.root = (value, Place(line, children))
            return
        top = self.stack[-1]
        if isinstance(top.data, list):
            top.children[len(top.data)] = Place(line, children)
            top.data.append(value)
        elif top.key is None:
            self._key(top, value, line)
        else:
            top.data[top.key] = value
            top.children[top.key] = Place(top.key_line, children)
            top.key = None

    def _key(self, top: _Open, key: Any, line: int) -> None:
        if not isinstance(key, str):
            raise _FaultError((line, f"{self._path()}found the key {described(key)}; keys are text"))
        if key == "<<":
            raise _FaultError((line, f"{self._path()}found the merge key <<; it is no YAML 1.2: write the keys out"))
        if key in top.data:
            first = top.children[key].line
            self.duplicates.append((line, f"{self._path(key)}duplicate key; it is first given in line {first}"))
        top.key = key
        top.key_line = line

    def _path(self, *last: str) -> str:
        path = key_path([*self._keys(), *last])
        return f"{path}: " if path else ""

    def _keys(self) -> Iterator[Key]:
        for part in self.stack[:-1]:
            yield len(part.data) if isinstance(part.data, list) else str(part.key)
