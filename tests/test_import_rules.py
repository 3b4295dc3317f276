"""Holds the table of docs/architecture.md to the code: what each package may import from pytest_lpb."""

import ast
import itertools
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "pytest_lpb"
TABLE = ROOT / "docs" / "architecture.md"
HEAVY = ("numpy", "scipy", "pandas", "matplotlib", "pyarrow", "gymnasium", "pydantic", "jinja2", "yaml", "casadi")


def rows_of_the_table() -> list[tuple[list[str], str]]:
    """Packages and modules of each row, and the text of its column `may import`."""
    lines = TABLE.read_text(encoding="utf-8").splitlines()
    head = next(index for index, line in enumerate(lines) if "may import from pytest_lpb" in line)
    rows = []
    for line in itertools.takewhile(lambda text: text.startswith("|"), lines[head + 2 :]):
        names, _, allowed = (cell.strip() for cell in line.strip("|").split("|"))
        rows.append(([name.strip(" `/") for name in names.split(",")], allowed))
    return rows


def allowed_imports() -> dict[str, set[str]]:
    """What each package or module may import besides itself; reasons in brackets are left out."""
    allowed: dict[str, set[str]] = {}
    for names, text in rows_of_the_table():
        items = {item.partition("(")[0].strip() for item in text.split(",")}
        above = set(allowed)
        allowed |= dict.fromkeys(names, {"all above": above, "nothing": set()}.get(text, items))
    return allowed


UNITS = sorted(allowed_imports())
# All but what is run by its path, or executed by another interpreter.
MODULES = [
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for path in sorted(PACKAGE.rglob("*.py"))
    if path.name not in ("supervisor.py", "__main__.py")
]


def unit_of(path: Path) -> str:
    """The package or module of a file, as the table names it."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def source_files() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def imports_of(path: Path) -> Iterator[tuple[str, int]]:
    """Modules that a file imports anywhere, with the line; those for type checkers only included."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: imports are absolute"
            module = node.module or ""
            yield module, node.lineno
            if module == "pytest_lpb":
                yield from ((f"pytest_lpb.{alias.name}", node.lineno) for alias in node.names)
    yield from strings_that_name_modules(path)


def strings_that_name_modules(path: Path) -> Iterator[tuple[str, int]]:
    """Modules in tables such as `"point": "pytest_lpb.problem.planar.point:Point"`, which are imported late."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith("pytest_lpb."):
            module = node.value.partition(":")[0]
            if (PACKAGE.parent / Path(*module.split("."))).with_suffix(".py").is_file():
                yield module, node.lineno


def test_the_table_names_every_package_and_module() -> None:
    assert sorted({unit_of(path) for path in source_files()} - {"__init__"}) == UNITS


@pytest.mark.parametrize("unit", UNITS)
def test_imports_follow_the_table(unit: str) -> None:
    allowed = {unit, *allowed_imports()[unit]}
    faults = [
        f"{path.relative_to(ROOT)}:{line} imports {module}"
        for path in source_files()
        if unit_of(path) == unit
        for module, line in imports_of(path)
        if module.startswith("pytest_lpb.") and module.split(".")[1] in UNITS and module.split(".")[1] not in allowed
    ]
    assert not faults, f"docs/architecture.md lets {unit} import {sorted(allowed)} only:\n" + "\n".join(faults)


def test_each_row_imports_rows_above_only() -> None:
    above: set[str] = set()
    for names, _ in rows_of_the_table():
        above |= set(names)
        for name in names:
            assert allowed_imports()[name] <= above, f"{name} imports what comes after it"


@pytest.mark.parametrize(
    ("package", "others"), [("scene", ("fabrics", "mpc")), ("fabrics", ("mpc",)), ("mpc", ("fabrics",))]
)
def test_planners_share_what_is_below_them_only(package: str, others: tuple[str, ...]) -> None:
    files = sorted((PACKAGE / "planner" / package).glob("*.py"))
    modules = {module for path in files for module, _ in imports_of(path)}
    assert modules
    assert not {module for module in modules for other in others if module.startswith(f"pytest_lpb.planner.{other}")}


def test_only_the_plugin_imports_pytest() -> None:
    importers = {
        unit_of(path)
        for path in source_files()
        for module, _ in imports_of(path)
        if module.split(".")[0] in ("pytest", "_pytest", "xdist", "pluggy")
    }
    assert importers == {"plugin"}


@pytest.mark.parametrize("module", ["pytest_lpb", "pytest_lpb.plugin", "pytest_lpb.errors", "pytest_lpb.names"])
def test_importing_it_loads_nothing_heavy(module: str) -> None:
    program = f"import {module}, sys; print(*[name for name in {HEAVY!r} if name in sys.modules])"
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == ""


def test_where_posix_is_missing_all_can_be_imported() -> None:
    """Processes of their own need it, trials in this process do not."""
    program = (
        "import sys, os, importlib, multiprocessing, signal, subprocess, socket, select\n"
        "import numpy, pandas, scipy.stats, matplotlib.pyplot, gymnasium, pyarrow.parquet, pydantic, execnet, pytest\n"
        "import xdist, asyncio, threadpoolctl, casadi, jinja2, PIL.Image\n"
        "for name in ('fcntl', 'resource', 'pwd', 'grp', 'termios'): sys.modules[name] = None\n"
        "for name in ('waitid', 'WEXITED', 'WNOHANG', 'WNOWAIT', 'CLD_EXITED', 'killpg', 'setpgid', 'mkfifo'):\n"
        "    delattr(os, name)\n"
        "for name in ('SIGKILL', 'SIGALRM', 'SIGHUP', 'SIGUSR1', 'SIGUSR2', 'SIGCHLD', 'SIGPIPE', 'setitimer'):\n"
        "    delattr(signal, name)\n"
        "del socket.AF_UNIX, select.poll\n"
        f"for name in {MODULES!r}: importlib.import_module(name)\n"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr


def test_public_names_are_there() -> None:
    program = (
        "import pytest_lpb; names = [n for n in pytest_lpb.__all__ if n != '__version__'];"
        "assert [n for n in names if getattr(pytest_lpb, n).__name__ != n] == [], names;"
        "assert set(pytest_lpb.__all__) <= set(dir(pytest_lpb))"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_planning_without_scenario_files_loads_no_yaml() -> None:
    """A worker that runs a trial of a concrete problem needs neither YAML nor tables nor pictures."""
    program = (
        "import sys, pytest_lpb.problem.problem;"
        "print(*[n for n in ('yaml', 'pydantic', 'pandas', 'matplotlib', 'gymnasium', 'casadi') if n in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == ""
