"""XML of strangers as elements that know their line: bounded, without document types and entities."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.parsers import expat

from pytest_lpb.errors import ScenarioError

UTF8_BOM = b"\xef\xbb\xbf"
MAX_ELEMENTS = 100_000
MAX_DEPTH = 100  # of elements within elements: other readers of the file go down by recursion


class Element:
    """An XML element: its name, attributes, children and text, and the line it begins in."""

    def __init__(self, tag: str, attributes: dict[str, str], line: int) -> None:
        self.tag = tag
        self.attributes = attributes
        self.line = line
        self.children: list[Element] = []
        self.texts: list[str] = []

    @property
    def text(self) -> str:
        """The text within, without that of children."""
        return "".join(self.texts)

    def find(self, tag: str) -> Element | None:
        """The first child of this name."""
        return next((child for child in self.children if child.tag == tag), None)

    def all(self, tag: str) -> list[Element]:
        """All children of this name."""
        return [child for child in self.children if child.tag == tag]

    def below(self) -> Iterator[Element]:
        """All elements below, at any depth."""
        for child in self.children:
            yield child
            yield from child.below()


def parse_xml(content: bytes, path: Path, kind: str = "URDF") -> Element:
    """The root element of an XML text. Raises ScenarioError with `path:line`; document types and entities are refused.

    Blanks and empty lines before `<?xml` are skipped.

    Args:
        content: the file's bytes.
        path: what to call it in messages.
        kind: of file, for messages.
    """
    text = content.removeprefix(UTF8_BOM).lstrip(b" \t\r\n")
    if not text:
        raise ScenarioError(f"{path}:1: is empty; a {kind} file has elements")
    above = content[: len(content) - len(text)].count(b"\n")  # lines skipped
    root = Element("", {}, 0)
    open_elements = [root]
    count = 0
    parser = expat.ParserCreate()
    parser.buffer_text = True

    def fault(what: str) -> ScenarioError:
        return ScenarioError(f"{path}:{above + parser.CurrentLineNumber}: {what}")

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if count > MAX_ELEMENTS:
            raise fault(f"more than {MAX_ELEMENTS} elements")
        if len(open_elements) > MAX_DEPTH:
            raise fault(f"elements within elements, {MAX_DEPTH + 1} deep; allowed are {MAX_DEPTH}")
        element = Element(tag, attributes, above + parser.CurrentLineNumber)
        open_elements[-1].children.append(element)
        open_elements.append(element)

    def doctype(*_: object) -> None:
        raise fault(f"found a DOCTYPE; a {kind} file has none")

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: open_elements.pop()
    parser.CharacterDataHandler = lambda text: open_elements[-1].texts.append(text)
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise ScenarioError(f"{path}:{above + error.lineno}: is no XML: {expat.ErrorString(error.code)}") from None
    except (LookupError, ValueError) as error:
        # An encoding that Python does not know, or that has several bytes for a letter.
        raise ScenarioError(f"{path}:1: is no XML that can be read: {error}") from None
    return root.children[0]
