"""Tables as LaTeX (booktabs) and Markdown files."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.report.data import ReportData
from pytest_lpb.report.exported import Table, tables

_LATEX = {
    "\\": r"\textbackslash{}",
    **{character: f"\\{character}" for character in "&%$#_{}"},
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": "$<$",
    ">": "$>$",
    "|": "$|$",
    "−": "$-$",
    "–": "--",
    "·": r"$\cdot$",
    "\u202f": r"\,",
    "†": r"\dag{}",
}
_SUPERSCRIPTS = dict(zip("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789", strict=True))


def write_tables(folder: Path, data: ReportData, formats: Sequence[str], kpis: Sequence[str] | None) -> list[Path]:
    """Write summary and comparisons in each format; what was written.

    Args:
        folder: made when it is missing.
        data: the evaluated run.
        formats: names in `FORMATS`.
        kpis: KPIs in the tables; None: the headline ones and a user's own.

    Raises:
        RecordingError: a file cannot be written.
    """
    found = tables(data, kpis)
    return [
        replace_file(folder / f"{table.name}{suffix}", write(table).encode())
        for suffix, write in (FORMATS[name] for name in dict.fromkeys(formats))
        for table in found
    ]


def latex(table: Table) -> str:
    """A tabular with rules of the package booktabs, to be put into a table of the reader's own."""
    columns = "l" * table.texts + "r" * (len(table.heads) - table.texts)
    lines = [
        f"% {_one_line(table.caption)} Needs \\usepackage{{booktabs}}.",
        rf"\begin{{tabular}}{{{columns}}}",
        r"\toprule",
        _latex_row(table.heads),
        r"\midrule",
        *(_latex_row(row) for row in table.rows),
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(lines) + "\n"


def latex_text(text: str) -> str:
    """Any text as LaTeX that prints it."""
    parts = re.split(f"([{''.join(_SUPERSCRIPTS)}]+)", _one_line(text))
    printed = [
        "$^{" + "".join(_SUPERSCRIPTS[digit] for digit in part) + "}$"
        if place % 2
        else "".join(_LATEX.get(character, character) for character in part)
        for place, part in enumerate(parts)
    ]
    return "".join(printed)


def _latex_row(cells: Sequence[str]) -> str:
    # A row that begins with a bracket would be read as an argument of the row before it.
    return " & ".join("{}" + text if text.startswith("[") else text for text in map(latex_text, cells)) + r" \\"


def markdown(table: Table) -> str:
    """A table of GitHub's Markdown, under its caption."""
    rules = ["---"] * table.texts + ["---:"] * (len(table.heads) - table.texts)
    rows = [[*map(markdown_text, table.heads)], rules, *([*map(markdown_text, row)] for row in table.rows)]
    return "\n".join([markdown_text(table.caption), "", *(f"| {' | '.join(row)} |" for row in rows)]) + "\n"


def markdown_text(text: str) -> str:
    """Any text as Markdown that shows it."""
    return re.sub(r"([\\`*_{}\[\]<>#|~&!])", r"\\\1", _one_line(text))


def _one_line(text: str) -> str:
    return " ".join(text.split())


# Name of a format -> suffix of its files, and what writes it.
FORMATS: dict[str, tuple[str, Callable[[Table], str]]] = {"latex": (".tex", latex), "markdown": (".md", markdown)}
