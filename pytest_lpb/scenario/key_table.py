"""All keys of scenario files as a page: type, unit, default and meaning, from the schema itself.

`lpb-scenarios keys` prints it, with what users have registered; a test holds docs/scenario-keys.md to it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from pytest_lpb.scenario.json_schema import scenario_json_schema

Schema = Mapping[str, Any]

HEAD = """# All keys of scenario files

Made from the schema (`lpb-scenarios keys`); [scenarios](scenarios.md) says the same with examples. A key without a
default is required; the default `-` is absent. What several keys say together, such as the number of joints, is
checked when a file is loaded.

## In an editor

`lpb-scenarios schema --output scenario.schema.json` writes the JSON Schema, and with `--plugin conftest.py` your own
shapes and robots in it. With the first line

```yaml
# yaml-language-server: $schema=../scenario.schema.json
```

editors with [yaml-language-server](https://github.com/redhat-developer/yaml-language-server) (VS Code's YAML extension,
Neovim, Emacs, ..) complete keys, show what they mean, and mark errors while you type. The path is relative to the
scenario file. Without the line, for a whole folder, in VS Code's `.vscode/settings.json`:

```json
{"yaml.schemas": {"./scenario.schema.json": "scenarios/**/*.yaml"}}
```
"""
_UNIT = re.compile(r"\[((?:m|rad|s|N)(?:[/ ][^\]]*)?)\](?: |(?=[;,.]|$))")


def keys_page() -> str:
    """The page as Markdown."""
    schema = scenario_json_schema()
    definitions: Mapping[str, Schema] = schema["$defs"]
    seen: dict[str, str] = {}
    _walk(schema, "", definitions, seen)
    blocks = [HEAD, *_section("The file", _rows(schema))]
    for path in dict.fromkeys(seen.values()):
        members = [definitions[name] for name, place in seen.items() if place == path]
        blocks += _variants(path, [member for member in members if _variant(member)])
        for member in members:
            if not _variant(member):
                blocks += _section(f"`{path}`", _rows(member), _text(member))
    return "\n".join(blocks)


def _variants(path: str, members: Sequence[Schema]) -> list[str]:
    """Sub-goals, obstacles or groups of a list: what all have, then the keys of each."""
    if not members:
        return []
    rows = [_rows(member) for member in members]
    common = [row for row in rows[0] if all(row in others for others in rows)]
    blocks = _section(f"`{path}`, each", common)
    for member, own in zip(members, rows, strict=True):
        blocks += _section(f"`{path}`{_variant(member)}", [row for row in own if row not in common], _text(member))
    return blocks


def _text(schema: Schema) -> str:
    return str(schema.get("description", "")).partition("\n")[0]


def _variant(schema: Schema) -> str:
    """What tells a sub-goal, an obstacle or a group from the others in its list."""
    for key in ("type", "shape"):
        words = schema["properties"].get(key, {})
        values = words.get("enum") or ([words["const"]] if "const" in words else [])
        if values:
            return f" with `{key}: {' | '.join(values)}`"
    return ""


def _walk(schema: Schema, path: str, definitions: Mapping[str, Schema], seen: dict[str, str]) -> None:
    """Sections in the order in which a reader meets them, each with the path that leads to it first."""
    for key, field in schema.get("properties", {}).items():
        for name in _references(field):
            if name not in seen:
                seen[name] = f"{path}{key}"
                _walk(definitions[name], f"{path}{key}.", definitions, seen)


def _references(value: Any) -> Iterator[str]:
    if isinstance(value, Mapping):
        if "$ref" in value:
            yield str(value["$ref"]).rpartition("/")[2]
        for item in value.values():
            yield from _references(item)
    elif isinstance(value, list):
        for item in value:
            yield from _references(item)


def _rows(schema: Schema) -> list[str]:
    required = set(schema.get("required", ()))
    rows = [_row(key, field, key in required) for key, field in schema.get("properties", {}).items()]
    extra = schema.get("additionalProperties")
    if isinstance(extra, Mapping):
        rows.append(f"| any other | {_escaped(_words(extra))} | | `-` | a KPI and its bound |")
    return rows


def _section(title: str, rows: list[str], text: str = "") -> list[str]:
    head = ["| key | type | unit | default | |", "|---|---|---|---|---|"]
    return [f"## {title}\n", *([f"{text}\n"] if text else []), *head, *rows, ""]


def _row(key: str, field: Schema, required: bool) -> str:
    text = str(field.get("description", ""))
    found = _UNIT.search(text)
    unit = found.group(1) if found else ""
    meaning = text[found.end() :].lstrip(", ") if found and found.start() == 0 else text
    default = "" if required else _default(field.get("default"))
    return f"| `{key}` | {_escaped(_words(field))} | {unit} | {default} | {_escaped(meaning)} |"


def _default(value: Any) -> str:
    # Of a mapping the section below tells the defaults, key by key.
    return "`-`" if value is None or (isinstance(value, Mapping) and value) else f"`{json.dumps(value)}`"


def _words(field: Schema) -> str:
    """The type of a value in words."""
    forms = [form for form in _forms(field) if form.get("type") != "null"]
    if len(forms) > 1 or forms[0] is not field:
        return " or ".join(dict.fromkeys(_words(form) for form in forms))
    if "$ref" in field:
        return "mapping, below"
    if "const" in field:
        return f"`{field['const']}`"
    if "enum" in field:
        return ", ".join(f"`{value}`" for value in field["enum"])
    describe = _WORDS.get(str(field.get("type")))
    return "anything" if describe is None else describe(field)


def _forms(field: Schema) -> list[Schema]:
    for key in ("anyOf", "oneOf"):
        if key in field:
            return [inner for form in field[key] for inner in _forms(form)]
    return [field]


def _number(field: Schema) -> str:
    word = {"integer": "whole number", "number": "number"}[field["type"]]
    low = f" > {field['exclusiveMinimum']:g}" if "exclusiveMinimum" in field else ""
    return word + (f" >= {field['minimum']:g}" if field.get("minimum", -1.0) > -1e6 and "minimum" in field else low)


def _list(field: Schema) -> str:
    item = _words(field["items"])
    least, most = field.get("minItems"), field.get("maxItems")
    count = f" of {least}" if least is not None and least == most else ""
    return f"list{count}: {item}"


def _mapping(field: Schema) -> str:
    values = next(iter(field.get("patternProperties", {}).values()), None)
    return "mapping" if values is None else f"mapping of names to: {_words(values)}"


_WORDS: dict[str, Callable[[Schema], str]] = {
    "string": lambda _: "text",
    "boolean": lambda _: "true, false",
    "integer": _number,
    "number": _number,
    "array": _list,
    "object": _mapping,
}


def _escaped(text: str) -> str:
    return text.replace("|", "\\|")
