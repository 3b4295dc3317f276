"""Signed distances between planar convex shapes, exact: negative values are penetration depths [m].

The core of a body is a segment (a disc when its ends coincide); its radius is subtracted by the caller, which is
exact for outside and inside alike, since inflating a convex core by r moves every face outwards by r.
Penetration is the smallest translation that separates the cores: the largest separation over the face normals of
their Minkowski difference (Ericson, "Real-Time Collision Detection", 2005, sections 5.1 and 9.3).
"""

from math import hypot

from pytest_lpb.motion.directions import SHORTEST


def point_to_segment(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Distance of the point p to the segment ab [m]; never negative."""
    dx, dy = bx - ax, by - ay
    length_squared = dx * dx + dy * dy
    if length_squared == 0.0:
        return hypot(px - ax, py - ay)
    s = ((px - ax) * dx + (py - ay) * dy) / length_squared
    s = 0.0 if s < 0.0 else min(s, 1.0)
    return hypot(px - ax - s * dx, py - ay - s * dy)


def segment_to_segment(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float) -> float:
    """Signed distance between the segments ab and cd [m]: minus the penetration depth when they cross."""
    apart = min(
        point_to_segment(ax, ay, cx, cy, dx, dy),
        point_to_segment(bx, by, cx, cy, dx, dy),
        point_to_segment(cx, cy, ax, ay, bx, by),
        point_to_segment(dx, dy, ax, ay, bx, by),
    )
    crossing = _opposite(ax, ay, bx, by, cx, cy, dx, dy) and _opposite(cx, cy, dx, dy, ax, ay, bx, by)
    if not crossing:
        return apart
    # Crossing segments: an end of one leaves across the other, so the depth is the nearest end's distance to
    # the other's line; ends project inside the other segment or are farther than `apart` already.
    return -min(
        _line_distance(ax, ay, cx, cy, dx, dy),
        _line_distance(bx, by, cx, cy, dx, dy),
        _line_distance(cx, cy, ax, ay, bx, by),
        _line_distance(dx, dy, ax, ay, bx, by),
    )


def segment_to_box(ax: float, ay: float, bx: float, by: float, hx: float, hy: float) -> float:
    """Signed distance between the segment ab and a box of half lengths (hx, hy) at the origin, axes aligned [m]."""
    depth = _separation_along_axes(ax, ay, bx, by, hx, hy)
    if depth < 0.0:
        return depth
    return min(
        _point_to_box(ax, ay, hx, hy),
        _point_to_box(bx, by, hx, hy),
        point_to_segment(hx, hy, ax, ay, bx, by),
        point_to_segment(-hx, hy, ax, ay, bx, by),
        point_to_segment(hx, -hy, ax, ay, bx, by),
        point_to_segment(-hx, -hy, ax, ay, bx, by),
    )


def _separation_along_axes(ax: float, ay: float, bx: float, by: float, hx: float, hy: float) -> float:
    """Largest separation over the box's axes and the segment's normal [m]; negative when they overlap."""
    along_x = max(min(ax, bx) - hx, -max(ax, bx) - hx)
    along_y = max(min(ay, by) - hy, -max(ay, by) - hy)
    largest = max(along_x, along_y)
    dx, dy = bx - ax, by - ay
    length = hypot(dx, dy)
    if length > SHORTEST:  # shorter ones have no normal, and are points
        offset = abs(ax * dy - ay * dx) / length
        reach = (hx * abs(dy) + hy * abs(dx)) / length
        largest = max(largest, offset - reach)
    return largest


def _point_to_box(px: float, py: float, hx: float, hy: float) -> float:
    return hypot(max(abs(px) - hx, 0.0), max(abs(py) - hy, 0.0))


def _line_distance(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    dx, dy = bx - ax, by - ay
    return abs((px - ax) * dy - (py - ay) * dx) / hypot(dx, dy)


def _opposite(ax: float, ay: float, bx: float, by: float, px: float, py: float, qx: float, qy: float) -> bool:
    """Whether p and q lie strictly on opposite sides of the line through a and b."""
    dx, dy = bx - ax, by - ay
    return (dx * (py - ay) - dy * (px - ax)) * (dx * (qy - ay) - dy * (qx - ax)) < 0.0
