"""Pydantic's errors in the words of scenario files: what was found, what is allowed."""

from collections.abc import Callable, Iterator
from typing import Any, get_args

from pydantic import BaseModel, TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from pytest_lpb.documents.faults import Fault, Loc, described
from pytest_lpb.names import listed, suggestion
from pytest_lpb.scenario.schema.available import drawn_shape_names, goal_type_names, shape_names

Context = dict[str, Any]


def faults_of(error: ValidationError, model: type[BaseModel], data: Any) -> list[Fault]:
    """The faults that a validation found in `data`, which `model` was to be."""
    faults = []
    for details in error.errors(include_url=False):
        loc = details["loc"]
        # Union tags stand in parentheses: they are steps of the schema, not keys of the file.
        place = _present(tuple(key for key in loc if not str(key).startswith("(")), data)
        faults.append(Fault(place, _message(details, model)))
    return faults


def _present(loc: Loc, data: Any) -> Loc:
    """`loc` without steps that only a normalised form of the data has; a missing last key stays."""
    kept: list[str | int] = []
    for index, key in enumerate(loc):
        if _holds(data, key):
            data = data[key]
        elif index < len(loc) - 1 or isinstance(key, int) or key == "[key]":
            continue
        kept.append(key)
    return tuple(kept)


def _holds(data: Any, key: str | int) -> bool:
    if isinstance(data, dict):
        return key in data
    return isinstance(data, list) and isinstance(key, int) and key < len(data)


def _message(details: ErrorDetails, model: type[BaseModel]) -> str:
    found = described(details["input"])
    context = details.get("ctx", {})
    kind = details["type"]
    if kind == "value_error":
        return str(context["error"])
    if kind == "extra_forbidden":
        return unknown_key(str(details["loc"][-1]), allowed_keys(model, details["loc"][:-1]))
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _unknown_tag(details)
    if kind == "missing":
        return "is missing"
    if kind == "literal_error":
        return _unknown_word(details)
    if kind == "string_type" and details["loc"][0] == "success":
        hint = suggestion(str(details["loc"][-1]), ("hold_time", "rate"))
        return f"found {found}; a criterion such as '>= 0.02' is required{hint}"
    if kind in _PHRASES:
        return f"found {found}; {_PHRASES[kind](context)}"
    return f"found {found}; {details['msg']}"


def unknown_key(key: str, allowed: Iterator[str] | list[str]) -> str:
    """What to say of a key that is not in the schema."""
    allowed = list(allowed)
    return f"unknown key{suggestion(key, allowed)}; allowed: {listed(allowed)}"


def _bound(number: float) -> str:
    return str(number) if isinstance(number, int) else f"{number:.15g}"


def _fewest(context: Context) -> str:
    number = context["min_length"]
    return f"at least {number} {'entry is' if number == 1 else 'entries are'} required"


def _fixed(phrase: str) -> Callable[[Context], str]:
    return lambda _: phrase


_NUMBER = "a number is required"
_WHOLE = "a whole number is required"
_LIST = "a list is required"
_MAPPING = "a mapping is required"

# Pydantic's error types -> what is allowed.
_PHRASES: dict[str, Callable[[Context], str]] = {
    "float_type": _fixed(_NUMBER),
    "float_parsing": _fixed(_NUMBER),
    "finite_number": _fixed("a finite number is required"),
    "int_type": _fixed(_WHOLE),
    "int_parsing_size": _fixed("the number is too large"),
    "int_from_float": _fixed(_WHOLE),
    "string_type": _fixed("text is required"),
    "bool_type": _fixed("true or false is required"),
    "list_type": _fixed(_LIST),
    "dict_type": _fixed(_MAPPING),
    "model_type": _fixed(_MAPPING),
    "model_attributes_type": _fixed(_MAPPING),
    "greater_than": lambda context: f"allowed: greater than {_bound(context['gt'])}",
    "greater_than_equal": lambda context: f"allowed: at least {_bound(context['ge'])}",
    "less_than_equal": lambda context: f"allowed: at most {_bound(context['le'])}",
    "too_short": _fewest,
    "too_long": lambda context: f"allowed: at most {context['max_length']}",
    "string_too_long": lambda context: f"at most {context['max_length']} characters are allowed",
    "string_pattern_mismatch": _fixed(
        "a name is made of letters, digits, '_', '.' and '-', and does not begin with '.'"
    ),
}


def _unknown_word(details: ErrorDetails) -> str:
    names = str(details["ctx"]["expected"]).replace("'", "").replace(" or ", ", ").split(", ")
    found = details["input"]
    hint = suggestion(found, names) if isinstance(found, str) else ""
    key = next((key for key in reversed(details["loc"]) if not str(key).startswith("(")), "")
    return f"found {described(found)}{hint}; allowed: {', '.join(names)}{_ALSO.get(key, '')}"


# Keys that take a word or something else.
_ALSO: dict[str | int, str] = {
    "hold_time": ", or a number [s]",
    "collision": ", or a mapping with spheres or link_spheres",
}


def _unknown_tag(details: ErrorDetails) -> str:
    # Unions are told apart by the key `type` (goals) or `shape` (obstacles).
    if not isinstance(details["input"], dict):
        return f"found {described(details['input'])}; {_MAPPING}"
    key, names = _TAGGED[str(details["loc"][0])]
    allowed = names()
    if key not in details["input"]:
        return f"{key} is missing; allowed: {listed(allowed)}"
    found = details["input"][key]
    hint = suggestion(found, allowed) if isinstance(found, str) else ""
    return f"{key}: found {described(found)}{hint}; allowed: {listed(allowed)}"


_TAGGED = {
    "goal": ("type", goal_type_names),
    "obstacles": ("shape", shape_names),
    "randomize": ("shape", drawn_shape_names),
}


def allowed_keys(model: type[BaseModel], loc: tuple[str | int, ...]) -> list[str]:
    """Keys of the mapping at `loc`, found by walking the schema."""
    candidates: list[tuple[str, type[BaseModel]]] = [("", model)]
    for key in loc:
        if isinstance(key, str) and key.startswith("("):
            candidates = [pair for pair in candidates if pair[0] == key] or candidates
        elif isinstance(key, str):
            candidates = [
                pair
                for _, candidate in candidates
                if key in candidate.model_fields
                for pair in _models_in(candidate.model_fields[key].annotation, "")
            ] or candidates
    fields = [item for _, candidate in candidates for item in candidate.model_fields.items()]
    return sorted({field.alias or name for name, field in fields})


def _models_in(annotation: Any, tag: str) -> Iterator[tuple[str, type[BaseModel]]]:
    """Models within an annotation, each with its union tag."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield tag, annotation
        return
    arguments = get_args(annotation)
    tags = [getattr(argument, "tag", "") for argument in arguments]
    for argument in arguments:
        yield from _models_in(argument, next((found for found in tags if found), tag))


def valid_parts(model: type[BaseModel], data: dict[str, Any], wrong: set[str]) -> dict[str, Any]:
    """Top-level parts of `data` outside `wrong`, each validated by itself: checks can go on with them."""
    parts: dict[str, Any] = {}
    for name, field in model.model_fields.items():
        if name in data and name not in wrong:
            parts[name] = TypeAdapter(field.rebuild_annotation()).validate_python(data[name])
    return parts
