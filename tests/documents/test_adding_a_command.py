"""Follows docs/internals/adding-a-command.md on a copy of the program."""

import json
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.support.processes import ran

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "internals" / "adding-a-command.md"
_PIECE = re.compile(
    r"(?P<where>After|Before)\s+`(?P<mark>[^`]+)` (?:in `(?P<path>[^`]+)`|there):\n\n```python\n(?P<code>.*?)```",
    re.DOTALL,
)
_SETTINGS_PAGE = """
from PySide6.QtWidgets import QApplication, QWidget
from pathlib import Path
from ui.main import WindowOptions, assemble
from ui.services.storage import Storage
from ui.core.preferences import Preferences
import sys
home = Path(sys.argv[1])
app = QApplication([])
assembly = assemble(app, WindowOptions(), preferences=Preferences(home / "window.ini"), storage=Storage(home))
assembly.window.make_pages()
for _ in range(200):
    if assembly.window.findChild(QWidget, "settings_page") is not None:
        break
    app.processEvents()
names = [one.objectName() for one in app.allWidgets()]
print(*sorted(name for name in names if "buzzer_volume" in name))
assembly.window.close()
"""


class Piece(NamedTuple):
    """Code of the page and the line of the file where it belongs."""

    is_after: bool
    mark: str
    path: str
    code: str


def pieces() -> Iterator[Piece]:
    path = ""
    for found in _PIECE.finditer(PAGE.read_text(encoding="utf-8")):
        path = found["path"] or path
        yield Piece(found["where"] == "After", found["mark"], path, found["code"])


def put(root: Path, piece: Piece) -> None:
    """`mark` may span several lines; white space is ignored."""
    file = root / piece.path
    text = file.read_text(encoding="utf-8")
    mark = re.compile(r"\s*".join(map(re.escape, piece.mark.split())))
    (found,) = list(mark.finditer(text))
    at = text.rindex("\n", 0, found.start()) + 1
    if piece.is_after:
        at = text.index("\n", found.end()) + 1
    file.write_text(text[:at] + piece.code + text[at:], encoding="utf-8")


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The three packages with the example command."""
    root = tmp_path_factory.mktemp("toy")
    for package in ("protocol", "app", "ui"):
        shutil.copytree(ROOT / package, root / package)  # with what is compiled, which takes most of the time
    for piece in pieces():
        put(root, piece)
    return root


def run(program: Path, home: Path, *words: str) -> str:
    done = ran(sys.executable, "-P", *words, PYTHONPATH=str(program), HOME=str(home))
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_page_has_all_its_pieces() -> None:
    assert [piece.path for piece in pieces()] == [
        "protocol/catalogue.py",
        "protocol/catalogue.py",
        "app/simulator/memory.py",
        "app/preflight/reading_object.py",
    ]


def test_it_is_decoded(program: Path, tmp_path: Path) -> None:
    frames = ("42 61 26 01 00 27", "41 75 26 01 32 59", "42 61 26 02 1E 46")
    lines = run(program, tmp_path, "-m", "app", "decode", "--json", *frames).splitlines()
    meanings = [{key: value for key, value in json.loads(line).items() if "percent" in key} for line in lines]
    assert [json.loads(line)["command"] for line in lines] == ["buzzer_volume"] * 3
    assert meanings == [{}, {"value_percent": 50}, {"set_percent": 30}]


def test_it_is_read_set_and_verified(program: Path, tmp_path: Path) -> None:
    read = json.loads(run(program, tmp_path, "-m", "app", "read", "--port", "sim://toy", "--json"))
    assert read["settings"]["buzzer_volume_percent"] == 50
    words = ("set", "buzzer_volume_percent=30", "--port", "sim://toy", "--json")
    written = json.loads(run(program, tmp_path, "-m", "app", *words))["results"]["buzzer_volume_percent"]
    assert (written["read_back"], written["verified"]) == (30, True)


def test_the_settings_page_has_it(program: Path, tmp_path: Path) -> None:
    names = run(program, tmp_path, "-c", _SETTINGS_PAGE, str(tmp_path)).split()
    assert "buzzer_volume_wanted" in names
