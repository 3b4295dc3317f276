"""What is drawn into a rendered picture: ground, translucent balls, lines that shine through what hides them."""

from __future__ import annotations

from math import ceil

import numpy as np

from pytest_lpb.environment.camera import Camera, Image
from pytest_lpb.problem.robot import FloatArray

Rgb = tuple[int, int, int]

SKY_TOP, SKY_LOW = np.array([203.0, 214.0, 226.0]), np.array([238.0, 241.0, 244.0])
GROUND, GRID = np.array([226.0, 229.0, 232.0]), np.array([186.0, 191.0, 197.0])
GRID_WIDTH_PX = 1.2
LINE_PX = 3  # width of lines
BALL_OPACITY = 0.45
HIDDEN_OPACITY = 0.3  # of lines behind something
SAMPLE_PX = 1.0  # between the samples of a line


def backdrop(camera: Camera, cell_m: float) -> Image:
    """Sky, and the ground z = 0 with a grid of cells of this size [m] that fades with distance."""
    rays = camera.rays
    share = np.linspace(0.0, 1.0, camera.height)[:, None, None]
    picture = np.broadcast_to((1.0 - share) * SKY_TOP + share * SKY_LOW, rays.shape).copy()
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = -camera.eye[2] / rays[..., 2]
        seen = (depth > 0.0) & (depth < 30.0 * camera.distance)
        place = camera.eye[:2] + depth[..., None] * rays[..., :2]
        # A line is as wide as some pixels, and lines closer than that would flicker: they fade.
        tall = depth / camera.focal_length / np.abs(rays[..., 2:3]).clip(0.05)[..., 0]
        away = np.abs(place / cell_m - np.round(place / cell_m)) * cell_m
        line = np.clip(1.0 - away / (GRID_WIDTH_PX * tall[..., None]), 0.0, 1.0).max(axis=-1)
        near = np.clip(1.5 * camera.distance / depth - 0.25, 0.0, 1.0)
    color = GROUND + (line * near)[..., None] * (GRID - GROUND)
    horizon = np.clip(3.0 * camera.distance / np.where(seen, depth, np.inf), 0.0, 1.0)[..., None]
    picture = np.where(seen[..., None], horizon * color + (1.0 - horizon) * picture, picture)
    return picture.astype(np.uint8)


def add_ball(picture: Image, depth: FloatArray, camera: Camera, centre: FloatArray, radius: float, color: Rgb) -> None:
    """Draw a translucent ball into a picture, in front of what lies behind it.

    Args:
        picture: (height, width, 3), changed.
        depth: of the picture, (height, width) [m].
        camera: what took it.
        centre: (3,) [m].
        radius: [m].
        color: of the ball.
    """
    (place,), (away,) = camera.project(centre[None])
    if not away > radius:  # around the camera or behind it
        return
    reach = ceil(camera.focal_length * radius / (away - radius)) + 1
    columns = slice(*np.clip([int(place[0]) - reach, int(place[0]) + reach + 1], 0, camera.width))
    rows = slice(*np.clip([int(place[1]) - reach, int(place[1]) + reach + 1], 0, camera.height))
    rays = camera.rays[rows, columns]
    offset = camera.eye - centre
    a, b = (rays * rays).sum(axis=-1), rays @ offset
    root = b * b - a * (offset @ offset - radius * radius)
    hit = root >= 0.0
    surface = (-b - np.sqrt(np.where(hit, root, 0.0))) / a  # depth of the near side
    seen = hit & (surface < depth[rows, columns])
    normal = (offset + surface[..., None] * rays) / radius
    bright = 0.8 + 0.2 * normal @ (-camera.axes[2] + camera.axes[1]) / 2.0**0.5
    part = picture[rows, columns]
    mixed = (1.0 - BALL_OPACITY) * part + BALL_OPACITY * bright[..., None] * np.array(color)
    part[seen] = mixed[seen].astype(np.uint8)


def sampled(camera: Camera, points: FloatArray) -> FloatArray:
    """Samples (N, 3) in the picture of a line through points (M, 3) [m]: column, row [px], depth [m].

    A stretch that comes from behind the camera is left out.
    """
    places, depth = camera.project(points)
    # Along a line in the picture, the inverse of the depth is what changes evenly.
    rows = np.column_stack([places, 1.0 / depth])
    begin, step = rows[:-1], np.diff(rows, axis=0)
    margin = LINE_PX // 2 + 1
    with np.errstate(divide="ignore", invalid="ignore"):
        edges = np.stack([margin - begin[:, :2], (camera.width, camera.height) - begin[:, :2] - margin]) / step[:, :2]
        enter = edges.min(axis=0).max(axis=1).clip(0.0)  # shares of a stretch (Liang and Barsky, 1984)
        leave = edges.max(axis=0).min(axis=1).clip(None, 1.0)
        lengths = (leave - enter) * np.hypot(step[:, 0], step[:, 1])
    counts = np.where(lengths > 0.0, np.ceil(lengths / SAMPLE_PX), 0.0).astype(int)
    which = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts) + 0.5) / counts[which]
    along = enter[which] + share * (leave - enter)[which]
    samples = begin[which] + along[:, None] * step[which]
    return np.column_stack([samples[:, :2], 1.0 / samples[:, 2]])


def add_samples(picture: Image, depth: FloatArray, samples: FloatArray, color: Rgb) -> None:
    """Draw the samples (N, 3) of a line into a picture (height, width, 3), faint where they are hidden."""
    width = depth.shape[1]
    columns, rows = samples[:, :2].astype(int).T
    visible = samples[:, 2] <= depth[rows, columns]
    half = LINE_PX // 2
    steps = np.arange(-half, half + 1)
    pixels = (rows * width + columns)[:, None] + (steps[:, None] * width + steps).ravel()
    shown = np.unique(pixels[visible])
    hidden = np.setdiff1d(pixels[~visible], shown)
    flat = picture.reshape(-1, 3)
    flat[shown] = color
    flat[hidden] = ((1.0 - HIDDEN_OPACITY) * flat[hidden] + HIDDEN_OPACITY * np.array(color)).astype(np.uint8)
