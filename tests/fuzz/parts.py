"""Small URDF and mesh files, and scenarios that name their mutants."""

from __future__ import annotations

from pathlib import Path

from tests.problem.spatial.test_mesh_files import collada, stl
from tests.scenario.urdfs import TETRAHEDRON, joint, link, mesh, write_urdf

PARTS = "parts"
SCENARIO = """\
version: 1
robot: {{urdf: {urdf}, name: arm}}
environment: {{engine: pybullet, dt: 0.05, duration: 1.0}}
goal: [{{name: reach, type: joint, joints: [j1], target: [0.5], tolerance: 0.1}}]
"""
OBSTACLE = "obstacles: [{name: rock, shape: mesh, file: %s, position: [3, 3, 3]}]\n"
MATERIAL = "newmtl skin\nKd 1 0 0\nmap_Kd skin.png\n"


def write_parts(folder: Path, name: str) -> list[Path]:
    """Write them; those of which mutants are made. A mutant is to be called `name` with the suffix of its original.

    Beside each lies `names.SUFFIX.yaml`, a scenario that names it.
    """
    folder.mkdir(parents=True)
    meshes = {
        ".obj": f"mtllib part.mtl\nusemtl skin\n{TETRAHEDRON}".encode(),
        ".stl": stl(4),
        ".dae": collada().encode(),
    }
    (folder / "part.mtl").write_text(MATERIAL)
    for suffix, content in meshes.items():
        (folder / f"part{suffix}").write_bytes(content)
        (folder / f"{name}{suffix}").write_bytes(content)
        _arm(folder / f"arm{suffix}.urdf", f"{name}{suffix}")
        obstacle = "" if suffix == ".dae" else OBSTACLE % f"{name}{suffix}"
        (folder / f"names{suffix}.yaml").write_text(SCENARIO.format(urdf=f"arm{suffix}.urdf") + obstacle)
        (folder / f"{name}{suffix}").unlink()
    _arm(folder / "arm.urdf", "part.obj")
    (folder / "names.urdf.yaml").write_text(SCENARIO.format(urdf=f"{name}.urdf"))
    return [folder / "arm.urdf", *(folder / f"part{suffix}" for suffix in meshes)]


def _arm(path: Path, file: str) -> None:
    parts = (link("base"), link("upper", f"\n{mesh(file)}\n"), joint("j1", "base", "upper"))
    write_urdf(path, parts)
