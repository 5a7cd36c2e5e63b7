"""Every text file is read and written with a stated encoding: Windows' own is another in each country."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FOLDERS = ("protocol", "app", "ui", "packaging", "docs", "tests")
_PLACE = {"read_text": 0, "write_text": 1}
"""Which argument the encoding is, when it is not named."""


def unstated(source: str) -> Iterator[tuple[int, str]]:
    """Line and name of each call that leaves the encoding to the system."""
    for node in ast.walk(ast.parse(source)) if any(name in source for name in _PLACE) else ():
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in _PLACE:
            named = {keyword.arg for keyword in node.keywords}
            if "encoding" not in named and len(node.args) <= _PLACE[node.func.attr]:
                yield node.end_lineno or node.lineno, node.func.attr


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_text_file_has_a_stated_encoding(folder: str) -> None:
    found = [
        f"{path.relative_to(ROOT)}:{line}: {name}"
        for path in sorted((ROOT / folder).rglob("*.py"))
        for line, name in unstated(path.read_text(encoding="utf-8"))
    ]
    assert found == []
