"""The schema of scenario files with what users have registered: one more model per shape and type of sub-goal."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Annotated, Any, Literal, TypeVar, Union

from pydantic import BeforeValidator, Discriminator, Field, Tag, create_model

from pytest_lpb.problem.registries import default_of, engines, goals, robots, shapes, version
from pytest_lpb.scenario.schema import goal, obstacle, randomize
from pytest_lpb.scenario.schema.available import engine_names
from pytest_lpb.scenario.schema.environment import Environment
from pytest_lpb.scenario.schema.file import ScenarioFile
from pytest_lpb.scenario.schema.robot import Robot
from pytest_lpb.scenario.schema.values import Coordinate, Part, Range, Text

_PLAIN = {float: Coordinate, str: Text}  # bounded, as all values of scenario files
_RANGES = {float: Range}


def scenario_model() -> type[ScenarioFile]:
    """The schema of scenario files now. Raises ConfigurationError for entry points that cannot be loaded."""
    return _model(version())


@lru_cache(maxsize=4)
def _model(_version: int) -> type[ScenarioFile]:
    if not any(registry.all() for registry in (engines, robots, shapes, goals)):
        return ScenarioFile
    parts: dict[str, Any] = {
        "robot": (_robot(), ...),
        "environment": (environment := _environment(), environment()),
        "goal": (Annotated[list[_goals()], Field(min_length=1, max_length=goal.MAX_GOALS)], ...),  # type: ignore[misc] # made here
        "obstacles": (Annotated[list[_obstacles()], Field(max_length=obstacle.MAX_OBSTACLES)], Field(default=[])),  # type: ignore[misc] # as above
        "randomize": (_randomize() | None, None),
    }
    return _extended(ScenarioFile, **parts)


M = TypeVar("M", bound=Part)


def _extended(base: type[M], name: str = "", text: str | None = None, /, **fields: Any) -> type[M]:
    """A model with further fields, or with others of the same names."""
    made: type[M] = create_model(name or base.__name__, __base__=base, __doc__=text or base.__doc__, **fields)
    return made


def _fields(keys: Mapping[str, Any], types: Mapping[Any, Any] = _PLAIN) -> dict[str, Any]:
    """Fields of a model from keys as they were registered."""
    found = {name: default_of(key) for name, key in keys.items()}
    return {name: (types.get(kind, _PLAIN.get(kind, kind)), default) for name, (kind, default) in found.items()}


def _tagged(models: Mapping[str, type[Part]], discriminator: Any) -> Any:
    members = tuple(Annotated[model, Tag(tag)] for tag, model in models.items())
    return Annotated[Union[members], Discriminator(discriminator)]  # noqa: UP007 - of as many as there are


def _environment() -> type[Environment]:
    return _extended(
        Environment, engine=(Literal[engine_names()], Field(default="planar", description="the simulator"))
    )


def _robot() -> type[Robot]:
    own: dict[str, Any] = {}
    for robot in robots.all():
        own |= {key: (kind | None, None) for key, (kind, _) in _fields(robot.keys).items()}
    new = {key: field for key, field in own.items() if key not in Robot.model_fields}
    return _extended(Robot, **new)


def _goals() -> Any:
    models: dict[str, type[Part]] = dict(goal.TYPES)
    for entry in goals.all():
        named = {"type": (Literal[entry.name], Field(description="registered")), **_fields(entry.keys)}
        models[f"({entry.name})"] = _extended(goal.MovingGoal, f"Goal_{entry.name}", _text(entry), **named)
    return _tagged(models, goal.type_tag)


def _obstacles() -> Any:
    models: dict[str, type[Part]] = dict(obstacle.SHAPES)
    for entry in shapes.all():
        named = {"shape": (Literal[entry.name], Field(description="registered")), **_fields(entry.keys)}
        models[f"({entry.name})"] = _extended(obstacle.Placed, f"Shape_{entry.name}", _text(entry), **named)
    return _tagged(models, obstacle.shape_tag)


def _randomize() -> type[randomize.Randomize]:
    models: dict[str, type[Part]] = dict(randomize.GROUPS)
    for entry in shapes.all():
        named = {"shape": (Literal[entry.name], Field(description="registered")), **_fields(entry.keys, _RANGES)}
        models[f"({entry.name})"] = _extended(randomize.Group, f"Group_{entry.name}", _text(entry), **named)
    group = _tagged(models, randomize.group_tag)
    groups = Annotated[
        list[group],  # type: ignore[valid-type] # made here
        Field(min_length=1, max_length=obstacle.MAX_OBSTACLES),
        BeforeValidator(randomize.as_list, json_schema_input_type=group | list[group]),  # type: ignore[valid-type] # as above
    ]
    field = Field(default=None, description="one group, or a list")
    return _extended(randomize.Randomize, obstacles=(groups | None, field))


def _text(entry: Any) -> str:
    return str(getattr(entry.create, "__doc__", None) or f"Registered by {entry.origin.module}.")
