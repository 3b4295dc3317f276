"""Numbers, names and other small values of a scenario file, with their bounds."""

from collections.abc import Callable
from math import hypot
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, StringConstraints

from pytest_lpb.errors import ScenarioError
from pytest_lpb.motion import parse_expression
from pytest_lpb.names import MAX_NAME_LENGTH, NAME_PATTERN
from pytest_lpb.problem.criterion import CRITERION, parse_criterion

MAX_COORDINATE = 1e6  # [m or rad]
MAX_LENGTH = 1e4  # [m]
MAX_TEXT = 10_000  # characters
NO_DIRECTION = 1e-9  # a vector of this length or less has none
UNIT_ERROR = 1e-12  # of the length of a quaternion that counts as one already


class Part(BaseModel):
    """A mapping of a scenario file: known keys only, and no text or boolean taken for a number."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


def refused(check: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Make a check that raises ScenarioError one that pydantic understands."""

    def checked(value: Any) -> Any:
        try:
            check(value)
        except ScenarioError as error:
            raise ValueError(str(error)) from None
        return value

    return checked


def is_number(value: object) -> bool:
    """Whether a YAML value is a number; a boolean is not."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _ordered(pair: list[float]) -> list[float]:
    if pair[0] > pair[1]:
        raise ValueError(f"found {pair}; the lower bound comes first")
    return pair


def _distinct(values: list[Any]) -> list[Any]:
    repeated = [value for index, value in enumerate(values) if value in values[:index]]
    if repeated:
        raise ValueError(f"found {repeated[0]!r} twice; each may be given once")
    return values


def _directed(vector: list[float]) -> list[float]:
    if hypot(*vector) <= NO_DIRECTION:
        what = f"a vector no longer than {NO_DIRECTION:g}" if any(vector) else "a vector of zeros"
        raise ValueError(f"found {vector}; {what} has no direction")
    return vector


def _unit(quaternion: list[float]) -> list[float]:
    length = hypot(*_directed(quaternion))
    # To normalise again must change nothing: a concrete problem repeats to the last bit.
    return quaternion if abs(length - 1.0) <= UNIT_ERROR else [value / length for value in quaternion]


def _number_as_text(value: Any) -> Any:
    return repr(float(value)) if is_number(value) else value


def _number_as_pair(value: Any) -> Any:
    return [value, value] if is_number(value) else value


Coordinate = Annotated[float, Field(allow_inf_nan=False, ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
Length = Annotated[float, Field(allow_inf_nan=False, gt=0, le=MAX_LENGTH)]
Distance = Annotated[float, Field(allow_inf_nan=False, ge=0, le=MAX_LENGTH)]
Duration = Annotated[float, Field(allow_inf_nan=False, gt=0, le=1e6)]
Weight = Annotated[float, Field(allow_inf_nan=False, ge=0, le=1e6)]

Name = Annotated[str, StringConstraints(max_length=MAX_NAME_LENGTH, pattern=f"^{NAME_PATTERN.pattern}$")]
Text = Annotated[str, StringConstraints(max_length=MAX_TEXT)]
Distinct = AfterValidator(_distinct)

Vector3 = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]
Direction3 = Annotated[list[Coordinate], Field(min_length=3, max_length=3), AfterValidator(_directed)]
Quaternion = Annotated[list[Coordinate], Field(min_length=4, max_length=4), AfterValidator(_unit)]  # wxyz, normalised
Vector = Annotated[list[Coordinate], Field(min_length=1, max_length=300)]
Range = Annotated[list[Coordinate], Field(min_length=2, max_length=2), AfterValidator(_ordered)]
LengthRange = Annotated[
    list[Length],
    Field(min_length=2, max_length=2),
    AfterValidator(_ordered),
    BeforeValidator(_number_as_pair, json_schema_input_type=float | list[Length]),
]
Box = Annotated[list[Range], Field(min_length=1, max_length=300)]
Expression = Annotated[str, AfterValidator(refused(parse_expression))]
Coordinates = Annotated[Expression, BeforeValidator(_number_as_text, json_schema_input_type=Expression | float)]
Trajectory = Annotated[list[Coordinates], Field(min_length=1, max_length=300)]
SplineRow = Annotated[list[Coordinate], Field(min_length=2, max_length=301)]
Spline = Annotated[list[SplineRow], Field(min_length=2, max_length=10_000)]


CriterionText = Annotated[
    str,
    StringConstraints(max_length=100),
    AfterValidator(refused(parse_criterion)),
    Field(json_schema_extra={"pattern": f"^\\s*{CRITERION.pattern}\\s*$"}),
]
