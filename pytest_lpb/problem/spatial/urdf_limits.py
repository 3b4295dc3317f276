"""What limits of joints say beyond one joint: ranges that followers narrow, and joints that their limits hold.

A joint that mimics another is at q = multiplier * q_master + offset; its own limits l <= q <= u bound the master by
(l - offset) / multiplier and (u - offset) / multiplier, in the order of their size.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import isclose

from pytest_lpb.problem.spatial.urdf import Joint, joint_motion

ROUNDING = 1e-9  # [rad or m, and relative] by which ends of a range that leave no motion may differ
Range = tuple[float, float]


def with_ranges(joints: Mapping[str, Joint]) -> tuple[dict[str, Joint], list[str], list[str]]:
    """The joints with the ranges that they and their followers allow; notes, and warnings.

    A joint whose range is a single position is fixed there, with its followers: a note. A follower whose own range
    would leave its master no motion (pr2's grippers have a multiplier of the wrong sign) does not narrow it: a warning.
    """
    changed = dict(joints)
    notes: list[str] = []
    warnings: list[str] = []
    for name, joint in joints.items():
        if joint.kind == "fixed" or joint.mimic is not None:
            continue
        followers = [other for other in joints.values() if other.mimic is not None and other.mimic[0] == name]
        lower, upper = joint.lower, joint.upper
        for other in followers:
            narrowed = _narrowed((lower, upper), other)
            if narrowed is None:
                warnings.append(
                    f"joint {other.name!r} mimics {name!r}, whose range [{lower:g}, {upper:g}] is no motion within its "
                    f"own, [{other.lower:g}, {other.upper:g}]; the limits of {other.name!r} are not applied"
                )
            else:
                lower, upper = narrowed
        changed[name] = replace(joint, lower=lower, upper=upper)
        if _is_point(lower, upper):
            position = 0.5 * (lower + upper)
            notes.append(f"joint {name!r} is held at {position:g}: its limits leave no motion")
            changed |= {one.name: _held(one, position) for one in (joint, *followers)}
    return changed, notes, warnings


def fixed_at(joint: Joint, position: float) -> Joint:
    """A fixed joint in place of one that stays at a position [rad or m]."""
    return replace(joint, kind="fixed", origin=joint.origin @ joint_motion(joint, position), mimic=None)


def _held(joint: Joint, master: float) -> Joint:
    _, multiplier, offset = joint.mimic or (joint.name, 1.0, 0.0)
    return fixed_at(joint, multiplier * master + offset)


def _narrowed(master: Range, follower: Joint) -> Range | None:
    """The master's range within its follower's; None where that leaves no motion, unless the follower has none."""
    _, multiplier, offset = follower.mimic or (follower.name, 1.0, 0.0)
    if multiplier == 0.0:
        return master
    ends = sorted(((follower.lower - offset) / multiplier, (follower.upper - offset) / multiplier))
    lower, upper = max(master[0], ends[0]), min(master[1], ends[1])
    if _is_point(*master) or (_is_point(*ends) and lower <= upper):
        return lower, upper
    return (lower, upper) if lower < upper and not _is_point(lower, upper) else None


def _is_point(lower: float, upper: float) -> bool:
    return isclose(lower, upper, rel_tol=ROUNDING, abs_tol=ROUNDING)
