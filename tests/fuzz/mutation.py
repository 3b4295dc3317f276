"""Mutants of files: of their bytes, of YAML files' values, and of the words of other texts."""

from __future__ import annotations

import copy
import random
import re
from collections.abc import Callable
from pathlib import Path as File
from typing import Any

import yaml

Path = tuple[Any, ...]

# What files hold that somebody wrote in haste, or to do harm.
VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2, 1e-300, 1e300, -1e300, 10**30, 0.1, float("nan"), float("inf"), "", " ", "t",
    "0", "1e3", "nan", "x", "../../../../etc/passwd", "/etc/passwd", "/dev/zero", "<script>alert(1)</script>", "a:b",
    "os:system", "t**t**t", "exp(exp(exp(t)))", "1/0", "sqrt(-1)", "9**9**9**9", "(" * 100, "__import__('os')",
    ">= 0", "goal", "é\u202e", "x" * 300, [], [[]], [None], [0], [0, 0], [0, 0, 0], [1, 0, 0, 0], [1e308] * 2,
    ["t", "t"],    [[0, 1]], [[1, 0]], [[0, 0], [1, 1]], [0] * 50, {}, {"x": 1}, {"version": 1}, {"": {}}, [{}],
)  # fmt: skip


def places(value: Any, path: Path = ()) -> list[Path]:
    """Paths of all values within plain data."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(place for key, item in items for place in places(item, (*path, key)))]


def _parent(data: Any, path: Path) -> Any:
    for key in path[:-1]:
        data = data[key]
    return data


def _is_number(data: Any, path: Path) -> bool:
    value = _parent(data, path)[path[-1]]
    return isinstance(value, int | float) and not isinstance(value, bool)


def _replace(data: Any, path: Path, source: random.Random) -> None:
    _parent(data, path)[path[-1]] = copy.deepcopy(source.choice(VALUES))


def _delete(data: Any, path: Path, _source: random.Random) -> None:
    del _parent(data, path)[path[-1]]


def _rename(data: Any, path: Path, source: random.Random) -> None:
    parent = _parent(data, path)
    if isinstance(parent, dict):
        value = parent.pop(path[-1])
        parent[str(path[-1])[:-1] + source.choice("xyz_ <")] = value
    else:
        parent.append(copy.deepcopy(parent[path[-1]]))


def _scale(data: Any, path: Path, source: random.Random) -> None:
    parent, factor = _parent(data, path), source.choice((-1, 0, 0.5, 0.9, 1.1, 3, 1e6, 1e-9, 1e154))
    value = parent[path[-1]]
    parent[path[-1]] = value * factor if isinstance(value, int | float) else [value, value]


def _graft(data: Any, path: Path, source: random.Random) -> None:
    other = source.choice(places(data))
    value = data
    for key in other:
        value = value[key]
    _parent(data, path)[path[-1]] = copy.deepcopy(value)


_CHANGES: tuple[Callable[[Any, Path, random.Random], None], ...] = (_replace, _delete, _rename, _graft, *[_scale] * 4)


def mutated_tree(text: str, source: random.Random) -> bytes:
    """The file with one to three of its values changed."""
    data = yaml.safe_load(text)
    for _ in range(source.choice((1, 1, 1, 1, 2, 3))):
        candidates = [path for path in places(data) if path]
        if not candidates:
            break
        change = source.choice(_CHANGES)
        if change is _scale:
            candidates = [path for path in candidates if _is_number(data, path)] or candidates
        change(data, source.choice(candidates), source)
    return yaml.safe_dump(data, allow_unicode=True, sort_keys=False, width=1000).encode()


SNIPPETS = (
    b"&a ", b"*a", b"<<: *a\n", b"!!python/object/apply:os.system [ls]", b"\x00", b"\xff\xfe", b"---\n", b"{", b"[",
    b"}", b"]", b": ", b"- ", b"\t", b"'", b'"', b"|\n", b"#", b"[" * 60, b"9" * 200, b"%YAML 3.0\n", b"? ", b"\r",
)  # fmt: skip


def mutated_bytes(original: str | bytes, source: random.Random) -> bytes:
    """The file with one to four places overwritten, cut out, doubled, or with something put in."""
    content = bytearray(original.encode() if isinstance(original, str) else original)
    for _ in range(source.randint(1, 4)):
        start = source.randrange(len(content) + 1)
        end = min(len(content), start + source.choice((0, 1, 1, 3, 20, 200)))
        piece = bytes(content[start:end])
        content[start:end] = source.choice(
            (b"", piece + piece, source.choice(SNIPPETS), source.randbytes(2), piece[::-1])
        )
    return bytes(content)


# What stands in for a word of a URDF or a mesh.
WORDS = (
    b"", b"0", b"-1", b"1", b"2", b"5", b"99999999", b"-99999999", b"2147483648", b"1e30", b"1e999", b"nan", b"1.5",
    b"x", b"#s", b"#v", b"#", b"..", b"../../../etc/passwd", b"/dev/zero", b"mutant_.obj", b"mesh", b"box", b"f", b"v",
)  # fmt: skip
_WORD = re.compile(rb"[^\s<>\"=/]+")


def mutated_words(content: bytes, source: random.Random) -> bytes:
    """The file with one to three of its words replaced, cut out or doubled."""
    for _ in range(source.choice((1, 1, 2, 3))):
        words = list(_WORD.finditer(content))
        if not words:
            break
        word = source.choice(words)
        other = source.choice((*WORDS, source.choice(words).group(), word.group() * 2))
        content = content[: word.start()] + other + content[word.end() :]
    return content


def mutant(original: File, source: random.Random) -> bytes:
    """A mutant of one of the kinds that suit the file."""
    content = original.read_bytes()
    if source.random() < 0.25 or original.suffix == ".stl":
        return mutated_bytes(content, source)
    return mutated_tree(content.decode(), source) if original.suffix == ".yaml" else mutated_words(content, source)
