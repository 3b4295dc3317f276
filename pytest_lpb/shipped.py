"""Where the files that ship with the package lie: inside it in a wheel, in the top-level folders of a checkout."""

from pathlib import Path

from pytest_lpb.errors import LpbError


def shipped_folder(name: str) -> Path:
    """The folder of shipped `planners` or `scenarios`.

    Raises LpbError when the installation lacks it.
    """
    package = Path(__file__).resolve().parent
    for folder in (package / "shipped_files" / name, package.parent / name):
        if folder.is_dir():
            return folder
    raise LpbError(f"this installation of pytest-lpb has no {name} folder; install it again (pip install pytest-lpb)")
