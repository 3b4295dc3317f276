"""Motions of targets and obstacles: fixed points, expressions in t, and splines."""

from pytest_lpb.motion.expressions import Expression, parse_expression
from pytest_lpb.motion.motion import ExpressionMotion, FixedMotion, Motion, motion_from
from pytest_lpb.motion.normalised import NormalisedMotion
from pytest_lpb.motion.rotation import angle_motion, turning_motion
from pytest_lpb.motion.spline import SplineMotion

__all__ = [
    "Expression",
    "ExpressionMotion",
    "FixedMotion",
    "Motion",
    "NormalisedMotion",
    "SplineMotion",
    "angle_motion",
    "motion_from",
    "parse_expression",
    "turning_motion",
]
