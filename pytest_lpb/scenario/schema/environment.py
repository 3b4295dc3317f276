"""The `environment` and `start` parts of a scenario file."""

from typing import Annotated, Literal

from pydantic import Field

from pytest_lpb.scenario.schema.values import Distance, Distinct, Duration, Part, Vector, Vector3

MAX_STEPS = 1_000_000

Step = Annotated[float, Field(allow_inf_nan=False, ge=1e-5, le=10.0)]
Ending = Literal["goal", "violation"]


class Environment(Part):
    """The simulated world and its clock."""

    engine: Literal["planar", "pybullet"] = Field(default="planar", description="pybullet: in space")
    dt: Step = Field(default=0.05, description="[s] time step")
    duration: Duration = Field(default=25.0, description="[s] a multiple of dt")
    end_at: Annotated[list[Ending], Distinct] = Field(
        default=["goal", "violation"], description="what ends a trial before its duration"
    )
    safety_margin: Distance = Field(default=0.05, description="[m] clearance below which near misses are counted")
    dynamics: bool = Field(default=False, description="pybullet: simulate forces")
    substeps: Annotated[int, Field(ge=1, le=1000)] | None = Field(
        default=None, description="pybullet with dynamics: steps of the physics per dt; default 20"
    )
    gravity: Vector3 = Field(default=[0.0, 0.0, -9.81], description="[m/s^2]")
    prediction: Literal["none", "constant_velocity", "exact"] = Field(
        default="constant_velocity", description="what planners know of moving obstacles' future"
    )


class Start(Part):
    """The robot's state at t = 0; zeros by default."""

    q: Vector | None = Field(default=None, description="joint positions [rad or m]; default zeros")
    qd: Vector | None = Field(default=None, description="joint velocities [rad/s or m/s]; default zeros")
    u: Vector | None = Field(
        default=None, description="in place of qd for non-holonomic bases [m/s, rad/s]; default zeros"
    )
