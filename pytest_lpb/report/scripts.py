"""The page's own script and style: files in templates/, joined. A report carries only what it needs."""

from __future__ import annotations

from importlib.resources.abc import Traversable

from pytest_lpb.report.view import Page

# In the order in which they need each other; main.js starts.
SCRIPTS = (
    "base.js",
    "tables.js",
    "kpis.js",
    "heat.js",
    "comparisons.js",
    "scenarios.js",
    "charts.js",
    "motion.js",
    "gestures.js",
    "planar.js",
    "raster.js",
    "spatial.js",
    "player.js",
    "trials.js",
    "router.js",
    "main.js",
)
STYLES = ("style.css", "spatial.css", "replay.css")
SPATIAL = ("raster.js", "spatial.js", "spatial.css")  # of reports with problems in space


def script_of(folder: Traversable, page: Page) -> str:
    """One script, closed in itself."""
    names = [name for name in SCRIPTS if _needed(name, page)]
    parts = [(folder / "script" / name).read_text("utf-8") for name in names]
    return '"use strict";\n(() => {\n' + "".join(parts) + "})();\n"


def style_of(folder: Traversable, page: Page) -> str:
    """One style sheet."""
    return "".join((folder / name).read_text("utf-8") for name in STYLES if _needed(name, page))


def _needed(name: str, page: Page) -> bool:
    if name not in SPATIAL:
        return True
    scenes, trials = page.model("scenarios"), page.model("trial")
    return any(len(scene.panels) > 1 for scene in (scenes.scenes if scenes else ())) or bool(trials and trials.spatial)
