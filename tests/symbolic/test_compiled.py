"""Compiled functions against interpreted ones, and the cache of libraries."""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import casadi
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from pytest_lpb.errors import ConfigurationError, LpbError
from pytest_lpb.symbolic import compiled as module
from pytest_lpb.symbolic.buffered import BufferedFunction
from pytest_lpb.symbolic.compiled import cache_folder, compiled

COMPILER = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
NEEDS_COMPILER = pytest.mark.skipif(COMPILER is None, reason="no C compiler: neither cc nor gcc nor clang")
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="shell scripts and file modes")

# One of several processes that build the same function at once.
BUILDER = """
import sys, casadi
from pytest_lpb.symbolic.compiled import compiled
x = casadi.SX.sym("x", 2)
function = compiled(casadi.Function("shared", [x], [casadi.sin(x)], ["x"], ["y"]))
print("ready", flush=True)
assert float(function([0.0, 1.0])[1]) == float(casadi.sin(1.0))
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, and a process that has loaded nothing yet."""
    chosen = tmp_path / "cache"
    monkeypatch.setenv("PYTEST_LPB_CACHE", str(chosen))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(module, "_loaded", {})
    return chosen


def simple(name: str = "f", factor: float = 2.0) -> casadi.Function:
    x = casadi.SX.sym("x", 2)
    return casadi.Function(name, [x], [factor * x], ["x"], ["y"])


def nonlinear(layers: int) -> casadi.Function:
    """About 160 operations of many kinds in each layer, and their derivatives; a matrix and an empty argument."""
    x, a, none = casadi.SX.sym("x", 4), casadi.SX.sym("A", 4, 4), casadi.SX.sym("none", 0)
    y = x
    for index in range(layers):
        y = casadi.tanh(a @ y) + casadi.sin(x * (index + 1)) * casadi.exp(-(y**2)) + casadi.sqrt(1 + y * y) / 3
        y = casadi.if_else(y > 1, casadi.fmod(y, 1.7), casadi.atan2(y, 1 + casadi.fabs(x)))
    return casadi.Function(
        "nonlinear", [x, a, none], [y, casadi.densify(casadi.jacobian(y[0] * 1e6, x))], ["x", "A", "none"], ["y", "J"]
    )


def forget(monkeypatch: pytest.MonkeyPatch) -> None:
    """What another process would know."""
    monkeypatch.setattr(module, "_loaded", {})


def logging_compiler(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make a compiler that writes its arguments to a file the compiler; returns the file."""
    folder.mkdir()
    log, script = folder / "calls.txt", folder / "logging cc"
    script.write_text(f'#!/bin/sh\necho "$@" >> {shlex.quote(str(log))}\nexec {COMPILER} "$@"\n')
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    return log


def builds(log: Path) -> int:
    return sum("-shared" in line for line in log.read_text().splitlines())


@NEEDS_COMPILER
def test_compiled_is_as_interpreted() -> None:
    function = nonlinear(20)
    fast = compiled(function)
    assert (fast.name_in(), fast.name_out()) == (function.name_in(), function.name_out())
    assert fast.class_name() == "External"
    generator = np.random.Generator(np.random.PCG64(5))
    for _ in range(20):
        arguments = generator.normal(size=4), generator.normal(size=(4, 4)), casadi.DM(0, 1)
        for expected, value in zip(function(*arguments), fast(*arguments), strict=True):
            assert_allclose(np.array(value), np.array(expected), rtol=1e-12)


@NEEDS_COMPILER
def test_compiled_through_buffers() -> None:
    function = nonlinear(3)
    fast, slow = BufferedFunction(compiled(function)), BufferedFunction(function)
    for buffered in (fast, slow):
        buffered.arguments["x"][:] = [0.1, -0.4, 0.2, 0.9]
        buffered.arguments["A"][:] = np.arange(16).reshape(4, 4) / 8
        buffered()
    for name, value in slow.results.items():
        assert_allclose(fast.results[name], value, rtol=1e-12)


@NEEDS_COMPILER
def test_failures_of_compiled_code_are_raised() -> None:
    x = casadi.MX.sym("x")
    function = casadi.Function("root", [x], [x.attachAssert(x > 0, "not positive")], ["x"], ["y"])
    buffered = BufferedFunction(compiled(function))
    buffered.arguments["x"][:] = 1.0
    buffered()
    buffered.arguments["x"][:] = -1.0
    with pytest.raises(LpbError, match="evaluation of the CasADi function root failed with code 1"):
        buffered()


@NEEDS_COMPILER
def test_functions_of_one_name_are_told_apart() -> None:
    double, triple = compiled(simple(factor=2.0)), compiled(simple(factor=3.0))
    assert_array_equal(np.array(double([1.0, 2.0]))[:, 0], [2.0, 4.0])
    assert_array_equal(np.array(triple([1.0, 2.0]))[:, 0], [3.0, 6.0])


@NEEDS_COMPILER
@POSIX
def test_a_cached_library_is_not_built_again(tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = logging_compiler(tmp_path / "with spaces", monkeypatch)
    first = compiled(simple())
    assert builds(log) == 1
    assert compiled(simple()) is first
    forget(monkeypatch)
    again = compiled(simple())
    assert again is not first
    assert_array_equal(np.array(again([1.0, 2.0]))[:, 0], [2.0, 4.0])
    assert builds(log) == 1
    compiled(simple("g"))
    assert builds(log) == 2
    assert len(list(folder.iterdir())) == 2


@NEEDS_COMPILER
@POSIX
def test_arguments_of_the_compiler_count(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled(simple())
    monkeypatch.setenv("CC", f"{COMPILER} -g0")
    assert_array_equal(np.array(compiled(simple())([1.0, 2.0]))[:, 0], [2.0, 4.0])
    assert len(list(folder.iterdir())) == 2


@NEEDS_COMPILER
@POSIX
def test_only_the_user_may_write_to_the_folder(folder: Path) -> None:
    compiled(simple())
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert [path.suffix for path in folder.iterdir()] == [".so"]


@NEEDS_COMPILER
def test_nothing_is_written_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    compiled(simple())
    assert list(here.iterdir()) == []


@NEEDS_COMPILER
def test_a_folder_with_spaces_that_is_relative(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTEST_LPB_CACHE", "my own/cache of libraries")
    assert_array_equal(np.array(compiled(simple())([1.0, 2.0]))[:, 0], [2.0, 4.0])
    assert len(list((tmp_path / "my own" / "cache of libraries").glob("*.so"))) == 1


@NEEDS_COMPILER
def test_several_processes_at_once(folder: Path) -> None:
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-c", BUILDER]
    processes = [
        subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(4)
    ]
    for process in processes:
        out, complaints = process.communicate()
        assert (process.returncode, out) == (0, "ready\n"), complaints
    assert [path.suffix for path in folder.iterdir()] == [".so"]


@NEEDS_COMPILER
@pytest.mark.parametrize("kept", [0, 10, 0.3, 0.9, -1])
def test_a_truncated_library_is_built_again(folder: Path, kept: float) -> None:
    """Most of these would kill the process if they were loaded."""
    function = simple()
    library = built_elsewhere(function, folder)
    whole = library.read_bytes()
    library.write_bytes(whole[: int(kept * len(whole)) if isinstance(kept, float) else kept])
    assert_array_equal(np.array(compiled(function)([1.0, 2.0]))[:, 0], [2.0, 4.0])
    assert library.read_bytes() == whole
    assert list(folder.iterdir()) == [library]


def built_elsewhere(function: casadi.Function, folder: Path) -> Path:
    """The library of a function, not loaded into this process."""
    source, compiler = module._source(function), module._compiler()
    path = folder / f"{module._key(source, compiler)}.so"
    module._build(path, source, compiler)
    return path


@NEEDS_COMPILER
def test_a_library_of_another_system_is_built_again(folder: Path) -> None:
    function = simple()
    library = built_elsewhere(function, folder)
    whole = library.read_bytes()
    content = b"not for this system" * 100
    library.write_bytes(content + hashlib.sha256(content).digest())
    assert_array_equal(np.array(compiled(function)([1.0, 2.0]))[:, 0], [2.0, 4.0])
    assert library.read_bytes() == whole


@POSIX
def test_a_library_that_never_loads(tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = tmp_path / "cc"
    script.write_text('#!/bin/sh\nwhile [ "$1" ]; do [ "$1" = -o ] && echo nonsense > "$2"; shift; done\n')
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    with pytest.raises(ConfigurationError, match=r"cannot load the compiled function f: /.*\.so: .*PYTEST_LPB_CACHE"):
        compiled(simple())


def test_no_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ConfigurationError) as raised:
        compiled(simple())
    assert str(raised.value) == (
        "no C compiler found: looked for CC (not set), cc, gcc, clang; install one, e.g. apt install gcc, "
        "or leave `compile` off"
    )


def test_a_compiler_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler -m64")
    with pytest.raises(ConfigurationError, match="no C compiler found: CC=no-such-compiler -m64 is no program; inst"):
        compiled(simple())


@POSIX
def test_a_compiler_that_does_not_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = tmp_path / "cc"
    script.write_text("#!/no/such/shell\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    with pytest.raises(ConfigurationError, match=r"cannot run the C compiler /.*/cc: No such file or directory"):
        compiled(simple())


@POSIX
def test_a_compiler_that_fails_and_says_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "false")
    with pytest.raises(ConfigurationError, match=r"the C compiler failed \(/.*/false -O1 .*, status 1\):\nit printed"):
        compiled(simple())
    assert list(folder.iterdir()) == []


@POSIX
def test_a_compiler_that_fails_is_quoted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script = tmp_path / "cc"
    script.write_text("#!/bin/sh\nfor n in 1 2 3 4 5 6 7 8 9 10 11 12; do echo line $n >&2; done\nexit 3\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    with pytest.raises(ConfigurationError) as raised:
        compiled(simple())
    head, *lines = str(raised.value).splitlines()
    assert head.endswith("status 3):")
    assert lines == [f"line {number}" for number in range(3, 13)]


@NEEDS_COMPILER
def test_what_casadi_cannot_write_as_c(folder: Path) -> None:
    y = casadi.SX.sym("y")
    solver = casadi.rootfinder("solver", "kinsol", {"x": y, "g": y * y - 2})
    with pytest.raises(ConfigurationError, match="Code generation not supported for KinsolInterface"):
        compiled(solver)
    assert list(folder.iterdir()) == []


@NEEDS_COMPILER
def test_a_folder_that_cannot_be_written(folder: Path) -> None:
    folder.write_text("a file")
    with pytest.raises(ConfigurationError, match=r"cannot write compiled functions to /.*cache: .*PYTEST_LPB_CACHE"):
        compiled(simple())


@pytest.mark.parametrize(
    ("variables", "expected"),
    [
        ({"PYTEST_LPB_CACHE": "/chosen", "XDG_CACHE_HOME": "/caches"}, "/chosen"),
        ({"PYTEST_LPB_CACHE": "~/chosen", "HOME": "/home/me"}, "/home/me/chosen"),
        ({"PYTEST_LPB_CACHE": "", "XDG_CACHE_HOME": "/caches"}, "/caches/pytest-lpb"),
        ({"HOME": "/home/me"}, "/home/me/.cache/pytest-lpb"),
        ({"XDG_CACHE_HOME": "relative", "HOME": "/home/me"}, "/home/me/.cache/pytest-lpb"),
    ],
)
@POSIX
def test_where_the_cache_is(monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], expected: str) -> None:
    for name in ("PYTEST_LPB_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert cache_folder() == Path(expected)


def test_no_home(monkeypatch: pytest.MonkeyPatch) -> None:
    def homeless(self: Path) -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("PYTEST_LPB_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "expanduser", homeless)
    with pytest.raises(ConfigurationError, match=r"no folder for compiled functions.*PYTEST_LPB_CACHE"):
        cache_folder()
