"""What the engines can run of what the schema can express."""

from pytest_lpb.problem.registries import GOALS, SHAPES, engines, goals, shapes

_CONTROLS = {  # per engine
    "planar": ("acceleration", "velocity"),
    "pybullet": ("acceleration", "velocity", "torque"),
}
SAME_SHAPE = {"circle": "sphere", "rectangle": "box", "sphere": "circle", "box": "rectangle"}  # in the other dimension
_DIMENSIONS = {"planar": 2, "pybullet": 3}  # of the engines
NOT_DRAWN = ("mesh",)


def engine_names() -> tuple[str, ...]:
    """Names of all engines, the built-in ones first."""
    return (*_DIMENSIONS, *(engine.name for engine in engines.all()))


def dimension_of(engine: str) -> int:
    """Dimension of an engine, 2 or 3."""
    registered = engines.get(engine)
    return _DIMENSIONS[engine] if registered is None else registered.dimension


def engines_of(dimension: int) -> list[str]:
    """Engines of a dimension, the built-in one first."""
    return [engine for engine in engine_names() if dimension_of(engine) == dimension]


def controls_of(engine: str) -> tuple[str, ...]:
    """Kinds of actions that an engine can apply."""
    registered = engines.get(engine)
    return _CONTROLS[engine] if registered is None else registered.controls


def simulates_forces(engine: str) -> bool:
    """Whether an engine can do with `dynamics: true`."""
    registered = engines.get(engine)
    return engine == "pybullet" if registered is None else registered.dynamics


def shapes_of(engine: str) -> tuple[str, ...]:
    """Shapes of obstacles that an engine has: all of its dimension."""
    dimension = dimension_of(engine)
    return (*SHAPES[dimension], *(shape.name for shape in shapes.all() if shape.dimension == dimension))


def shape_names() -> tuple[str, ...]:
    """Shapes of obstacles, in the plane and in space."""
    return (*SHAPES[2], *SHAPES[3], *(shape.name for shape in shapes.all()))


def drawn_shape_names() -> tuple[str, ...]:
    """Shapes of obstacles that can be drawn."""
    return tuple(name for name in shape_names() if name not in NOT_DRAWN)


def goal_type_names() -> tuple[str, ...]:
    """Types of sub-goals."""
    return (*GOALS, *(goal.name for goal in goals.all()))
