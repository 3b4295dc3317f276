"""Mesh files of strangers: damaged ones end PyBullet's process, so they are refused before it sees them."""

from __future__ import annotations

import os
import re
import resource
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pytest_lpb.environment.visuals import add_body
from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.spatial import mesh_limits
from pytest_lpb.problem.spatial.client import Client
from pytest_lpb.problem.spatial.library import known_robots, library_robot
from pytest_lpb.problem.spatial.mesh_files import check_mesh
from pytest_lpb.problem.spatial.meshes import mesh_vertices
from pytest_lpb.problem.spatial.meshes_of_stl import TRIANGLE
from pytest_lpb.problem.spatial.shapes import create_body
from pytest_lpb.problem.spatial.triangles import mesh_triangles
from pytest_lpb.problem.spatial.urdf import Geometry
from pytest_lpb.problem.spatial.urdf_reader import load_urdf
from tests.scenario.urdfs import TETRAHEDRON


def stl(count: int, triangles: int = 4, number: float = 1.0) -> bytes:
    """A binary STL that says it has `count` triangles."""
    rows = np.zeros(triangles, TRIANGLE)
    rows["numbers"] = number
    return bytes(80) + (count % 2**32).to_bytes(4, "little") + rows.tobytes()


def collada(points: str = "0 0 0 1 0 0 0 1 0", indices: str = "0 1 2", count: str = "1", stride: str = "3") -> str:
    """A COLLADA file of one triangle."""
    return f"""<COLLADA><asset/><library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="f" count="9">{points}</float_array>
<technique_common><accessor source="#f" count="3" stride="{stride}"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="{count}"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="NORMAL" source="#s" offset="0"/><p>{indices}</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="c"><node><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#c"/></scene></COLLADA>"""


TEXT_STL = "solid x\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
DAMAGED: dict[str, tuple[str, str | bytes, str]] = {
    "empty": ("a.obj", "", "a.obj: has no triangles: the file is empty"),
    "empty stl": ("a.stl", "", "a.stl: has no triangles: the file is empty"),
    "no face": ("a.obj", "v 0 0 0\n", r"a.obj: has no triangles"),
    "nan": ("a.obj", "v 0 nan 0\n" + TETRAHEDRON, r"a.obj:1: cannot be read as OBJ: found 'v 0 nan 0'; a vertex has"),
    "infinite": ("a.obj", TETRAHEDRON + "v 0 1e999 0\n", r"a.obj:9: .*three numbers within ±1e\+09"),
    "two numbers": ("a.obj", TETRAHEDRON + "v 0 0\n", r"a.obj:9: .*three numbers"),
    "index beyond": ("a.obj", TETRAHEDRON + "f 1 2 900000000\n", "a.obj:9: .*names vertex 900000000 of 4 before"),
    "index before": ("a.obj", TETRAHEDRON + "f 1 2 -5\n", "a.obj:9: .*names vertex -5 of 4 before"),
    "index zero": ("a.obj", TETRAHEDRON + "f 0/1/1 2/1/1 3/1/1\n", "a.obj:9: .*names vertex 0 of 4"),
    "index too early": ("a.obj", "f 1 2 3\n" + TETRAHEDRON, "a.obj:1: .*names vertex 1 of 0 before"),
    "index too long": ("a.obj", TETRAHEDRON + "f 1 2 99999999999999999999\n", "a.obj:9: .*a face has two corners"),
    "no index": ("a.obj", TETRAHEDRON + "f 1 two 3\n", "a.obj:9: .*found 'f 1 two 3'; a face has"),
    # PyBullet reads 1023 bytes of a line, and takes what follows for a line of its own.
    "hidden face": ("a.obj", TETRAHEDRON + "#" + "x" * 1022 + "f 1 2 900000000\n", "a.obj:9: has 1038 bytes in a line"),
    "zero byte": ("a.obj", TETRAHEDRON + "f 1 2\0 3\n", "a.obj:9: found the byte 0x00; this should be a text"),
    "four billion triangles": ("a.stl", stl(-1), "a.stl: is damaged: 4294967295 triangles take 214748364834 bytes"),
    "count that overflows": ("a.stl", stl(4 + 2**31), r"a.stl: is damaged: 2147483652 triangles take"),
    "cut": ("a.stl", stl(4)[:-1], "a.stl: is damaged: 4 triangles take 284 bytes, but the file has 283"),
    "no triangle": ("a.stl", stl(0, 0), "a.stl: has 0 triangles; allowed are 1 to 1000000"),
    "not a number": ("a.STL", stl(4, number=np.nan), "a.STL: triangle 0 has the corners"),
    "text of nothing": ("a.stl", "solid x\n", "a.stl: has 0 triangles"),
    "text, not a number": ("a.stl", TEXT_STL.replace("1 0 0", "one 0 0"), "a.stl: is damaged: could not convert"),
    "index beyond numbers": ("a.dae", collada(indices="0 1 99999999"), "a.dae:6: names point 99999999 or 0 of 3"),
    "negative index": ("a.dae", collada(indices="0 1 -1"), "a.dae:6: names point 1 or -1 of 3"),
    "half an index": ("a.dae", collada(indices="0 1 1.5"), "a.dae:6: found 3 numbers; whole ones"),
    "large stride": ("a.dae", collada(stride="9"), "a.dae:6: names point 2 or 0 of 1"),
    "no stride": ("a.dae", collada(stride="0"), "a.dae:3: <accessor> stride: found '0'"),
    "count beyond": ("a.dae", collada(count="1000000"), "a.dae:5: says that it has 1000000 parts, with 3 corners"),
    "not a number in dae": ("a.dae", collada(points="nan 0 0 1 0 0 0 1 0"), "a.dae:2: <float_array> holds what is no"),
    "deep": ("a.dae", "<COLLADA>" + "<a>" * 1000, "a.dae:1: elements within elements, 101 deep"),
    "entities": ("a.dae", '<!DOCTYPE x [<!ENTITY a "b">]><COLLADA/>', "a.dae:1: found a DOCTYPE; a COLLADA file"),
    "no asset": ("a.dae", collada().replace("<asset/>", ""), "a.dae:1: <COLLADA> has no <asset>"),
    "no source": ("a.dae", collada().replace('source="#v"', ""), "a.dae:5: <input> has no source"),
    "no position": ("a.dae", collada().replace("POSITION", "X"), "a.dae:4: <vertices> has no <input> of POSITION"),
    "no name": ("a.dae", collada().replace('<source id="s">', "<source>"), "a.dae:2: <source> has no id"),
    "another xml": ("a.dae", "<robot/>", "a.dae:1: found <robot>; a COLLADA file has <COLLADA>"),
    "unknown encoding": ("a.dae", '<?xml version="1.0" encoding="x-y"?><COLLADA/>', "a.dae:1: is no XML"),
}  # fmt: skip


def written(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@pytest.mark.parametrize("case", DAMAGED)
def test_damaged_meshes_are_refused_before_pybullet_reads_them(tmp_path: Path, case: str) -> None:
    name, content, message = DAMAGED[case]
    path = written(tmp_path, name, content)
    with pytest.raises(ScenarioError, match=message):
        check_mesh(path)
    with pytest.raises(ScenarioError, match=message):  # as a robot's link
        mesh_vertices(path, (1.0, 1.0, 1.0))
    client = Client()
    with pytest.raises(ScenarioError, match=message):  # as an obstacle
        create_body(client, {"name": "a", "shape": "mesh", "file": str(path)})
    client.close()


def test_sound_meshes_are_read_by_pybullet(tmp_path: Path) -> None:
    for name, content in (
        ("a.obj", TETRAHEDRON.replace("f 1 3 2", "f 1/7/8 3//5 2/9 -1").replace("\n", "\r\n")),
        ("b.stl", stl(2, 2)),
        ("c.dae", collada()),
    ):
        path = written(tmp_path, name, content)
        check_mesh(path)
        assert len(mesh_vertices(path, (1.0, 1.0, 1.0)))


def test_an_stl_of_text_is_a_link_an_obstacle_and_a_picture(tmp_path: Path) -> None:
    """PyBullet takes it for a binary one: it gets a copy of the triangles."""
    path = written(tmp_path, "a.stl", TEXT_STL.replace("vertex 1", "VERTEX 2"))
    assert mesh_triangles(path).max() == 2.0
    assert mesh_vertices(path, (2.0, 1.0, 1.0)).max() == pytest.approx(4.0)
    client = Client()
    _, _, radius = create_body(client, {"name": "a", "shape": "mesh", "file": str(path)})
    assert radius == pytest.approx(2.0)
    assert add_body(client, Geometry("mesh", (1.0, 1.0, 1.0), file=path), None) >= 0
    client.close()


def test_what_is_no_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.obj")
    (tmp_path / "folder.obj").mkdir()
    (tmp_path / "loop.obj").symlink_to("loop.obj")
    (tmp_path / "zero.obj").symlink_to("/dev/zero")
    for name, message in (
        ("pipe", "is no regular file"),
        ("folder", "is no regular file"),
        ("zero", "is no regular file"),
        ("loop", "cannot be read: Too many levels of symbolic links"),
        ("none", "cannot be read: No such file or directory"),
    ):
        with pytest.raises(ScenarioError, match=rf"{name}\.obj: {message}"):
            check_mesh(tmp_path / f"{name}.obj")


def test_large_meshes(tmp_path: Path) -> None:
    """Sizes are looked at first; counts before anything is computed with them."""
    huge = tmp_path / "huge.obj"
    with huge.open("wb") as file:
        file.truncate(mesh_limits.MAX_MESH_BYTES + 1)  # takes no space
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(ScenarioError, match=r"huge\.obj: has 100000001 bytes; allowed are 100000000"):
        check_mesh(huge)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000  # [KiB]
    fan = "f " + "1 " * 400 + "\n"
    for content, message in (
        ("\n" * 3_000_001, "has 3000001 lines; allowed are 3000000"),
        (TETRAHEDRON + fan * 2520, "has 1002964 triangles; allowed are 1000000"),
    ):
        with pytest.raises(ScenarioError, match=message):
            check_mesh(written(tmp_path, "many.obj", content))


def textured(folder: Path, material: str, texture: str) -> Path:
    (folder / "meshes").mkdir(parents=True)
    (folder / "pytest.ini").write_text("[pytest]\n")
    Image.new("RGB", (4, 4)).save(folder / "skin.png")
    written(folder, "a.mtl", f"newmtl skin\nKd 1 1 1\nmap_Kd {texture}\n")
    return written(folder / "meshes", "a.obj", f"mtllib {material}\nusemtl skin\n{TETRAHEDRON}")


def test_materials_and_textures_of_the_project_are_read(tmp_path: Path) -> None:
    check_mesh(textured(tmp_path / "here", "../a.mtl", "skin.png"))
    check_mesh(textured(tmp_path / "gone", "../none.mtl", "skin.png"))
    check_mesh(textured(tmp_path / "elsewhere", "../a.mtl", "C:\\pictures\\skin.png"))


@pytest.mark.parametrize(
    ("material", "texture", "message"),
    [
        (
            "../../secret.mtl",
            "skin.png",
            r"a\.obj:1: '\.\./\.\./secret\.mtl' lies outside of .*/mine; allowed are",
        ),
        ("../link.mtl", "skin.png", r"a\.obj:1: '\.\./link\.mtl' lies outside of"),
        ("../loop.mtl", "skin.png", r"a\.obj:1: '\.\./loop\.mtl' is a link that leads to itself"),
        ("../pipe", "skin.png", r"pipe: is no regular file"),
        ("../a.mtl", "../secret.mtl", r"a\.mtl:3: '\.\./secret\.mtl' lies outside of"),
        ("../a.mtl", "-s 1 1 1 ../secret.mtl", r"a\.mtl:3: '\.\./secret\.mtl' lies outside of"),
        ("../a.mtl", "pipe", r"pipe: is no regular file"),
        ("../a.mtl", "zero.png", r"a\.mtl:3: 'zero\.png' lies outside of"),
        ("../a.mtl", "a.mtl", r"a\.mtl: is no picture"),
        ("../a.mtl", "bomb.png", r"bomb\.png: has 9000 x 9000 pixels; a texture may have 67108864"),
        ("../large.mtl", "skin.png", r"large\.mtl: has 1000001 bytes; allowed are 1000000"),
    ],
)
def test_materials_and_textures_that_are_refused(tmp_path: Path, material: str, texture: str, message: str) -> None:
    mine = tmp_path / "mine"
    mesh = textured(mine, material, texture)
    (tmp_path / "secret.mtl").write_text("newmtl secret\n")
    (mine / "link.mtl").symlink_to(tmp_path / "secret.mtl")
    (mine / "loop.mtl").symlink_to("loop.mtl")
    (mine / "zero.png").symlink_to("/dev/zero")
    (mine / "large.mtl").write_bytes(b"\n" * 1_000_001)
    os.mkfifo(mine / "pipe")
    if "bomb" in texture:
        Image.new("1", (9000, 9000)).save(mine / "bomb.png")
    with pytest.raises(ScenarioError, match=message):
        check_mesh(mesh)


def test_what_pybullet_would_find_around_the_working_directory_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mesh = textured(tmp_path / "mine", "../a.mtl", "../../secret.png")
    (tmp_path / "mine" / "deeper").mkdir()
    Image.new("RGB", (4, 4)).save(tmp_path / "secret.png")
    monkeypatch.chdir(tmp_path / "mine")
    check_mesh(mesh)  # neither beside the material nor there
    monkeypatch.chdir(tmp_path / "mine" / "deeper")
    with pytest.raises(ScenarioError, match=r"a\.mtl:3: '\.\./\.\./secret\.png' lies outside of .*/mine"):
        check_mesh(mesh)


def test_allowed_folders_hold_for_materials(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = textured(tmp_path / "mine", "../../secret.mtl", "skin.png")
    (tmp_path / "secret.mtl").write_text("newmtl secret\n")
    monkeypatch.setenv("LPB_ALLOW_PATHS", str(tmp_path))
    check_mesh(mesh)


def test_meshes_of_known_robots_are_sound(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are not checked when they are used; copies of them in a project are."""
    monkeypatch.setattr("pytest_lpb.problem.spatial.mesh_files.is_installed", lambda _: False)
    for name in ("husky", "racecar", "xarm6", *({"kinova"} & set(known_robots()))):
        try:
            meshes = load_urdf(library_robot(name).path).meshes
        except ScenarioError as error:
            assert re.search("not installed", str(error))  # noqa: PT017 - optional
            continue
        assert meshes
        for mesh in meshes:
            check_mesh(mesh)
