"""Follows docs/internals/adding-a-command.md on a copy of the program."""

import json
import re
import shutil
import sys
from pathlib import Path

from tests.support.processes import ROOT, ran

PAGE = ROOT / "docs" / "internals" / "adding-a-command.md"
_PIECE = re.compile(
    r"(?P<where>After|Before)\s+`(?P<mark>[^`]+)` (?:in `(?P<path>[^`]+)`|there):\n\n```python\n(?P<code>.*?)```",
    re.DOTALL,
)


def put_pieces(root: Path) -> None:
    """Put the page's code after or before the line that it names; white space is ignored."""
    path = ""
    for piece in _PIECE.finditer(PAGE.read_text(encoding="utf-8")):
        path = piece["path"] or path
        text = (root / path).read_text(encoding="utf-8")
        (found,) = re.finditer(r"\s*".join(map(re.escape, piece["mark"].split())), text)
        at = text.index("\n", found.end()) + 1 if piece["where"] == "After" else text.rindex("\n", 0, found.start()) + 1
        (root / path).write_text(text[:at] + piece["code"] + text[at:], encoding="utf-8")
    assert path, "the page has no pieces"


def test_a_command_that_is_added_as_the_page_says_is_decoded_read_and_set(tmp_path: Path) -> None:
    program = tmp_path / "toy"
    for package in ("protocol", "app", "ui"):
        shutil.copytree(ROOT / package, program / package)  # with what is compiled, which takes most of the time
    put_pieces(program)

    def said(*words: str) -> str:
        done = ran(sys.executable, "-P", *words, PYTHONPATH=str(program), HOME=str(tmp_path))
        assert done.returncode == 0, done.stderr
        return done.stdout

    frames = ("42 61 26 01 00 27", "41 75 26 01 32 59", "42 61 26 02 1E 46")
    lines = [json.loads(line) for line in said("-m", "app", "decode", "--json", *frames).splitlines()]
    meanings = [{key: value for key, value in line.items() if "percent" in key} for line in lines]
    assert [line["command"] for line in lines] == ["buzzer_volume"] * 3
    assert meanings == [{}, {"value_percent": 50}, {"set_percent": 30}]
    words = ("set", "buzzer_volume_percent=30", "--port", "sim://toy", "--json")
    written = json.loads(said("-m", "app", *words))["results"]["buzzer_volume_percent"]
    assert (written["read_back"], written["verified"]) == (30, True)
