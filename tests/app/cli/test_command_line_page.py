"""docs/command-line.md: every example is run, and says what the page says.

`python -m tests.app.cli.test_command_line_page` writes what the commands say now into the page; put `...` where it
differs from run to run, and read what has changed.
"""

import doctest
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.support.processes import ENVIRONMENT, PROGRAM, ROOT, run_module

PAGE = ROOT / "docs" / "command-line.md"
SHOWN_PORT = "/tmp/dps-s"
_BLOCK = re.compile(r"```console\n(.*?)```", re.DOTALL)


class Example(NamedTuple):
    words: list[str]
    said: str


def examples(text: str) -> Iterator[Example]:
    for block in _BLOCK.findall(text):
        for piece in re.split(r"^\$ dps-s ", block, flags=re.MULTILINE)[1:]:
            command, _, said = piece.partition("\n")
            yield Example(shlex.split(command), said)


def say(words: list[str], home: Path, port: str) -> str:
    """What a terminal shows: both outputs, and the exit code where it is not 0."""
    environment = {**ENVIRONMENT, "LC_ALL": "C.UTF-8", "COLUMNS": "120", "XDG_DATA_HOME": str(home)}
    done = subprocess.run(
        [*PROGRAM, *(port if word == SHOWN_PORT else word for word in words)],
        cwd=ROOT, env=environment, text=True, timeout=60, check=False,
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    code = f"(exit code {done.returncode})\n" if done.returncode else ""
    return (done.stdout + code).replace(port, SHOWN_PORT)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no pseudo-terminals")
def test_every_example_says_what_the_page_says(tmp_path: Path) -> None:
    found = list(examples(PAGE.read_text(encoding="utf-8")))
    assert len(found) > 15
    judge = doctest.OutputChecker()
    with run_module("--link", str(tmp_path / "dps-s"), "--history", "2"):
        for words, said in found:
            says = say(words, tmp_path, str(tmp_path / "dps-s"))
            assert judge.check_output(said, says, doctest.ELLIPSIS), f"dps-s {shlex.join(words)} says now:\n{says}"


def _rewrite(folder: Path) -> None:
    text = PAGE.read_text(encoding="utf-8")
    with run_module("--link", str(folder / "dps-s"), "--history", "2"):
        for block in _BLOCK.findall(text):
            shown = [line for line in block.splitlines() if line.startswith("$ ")]
            lines = [f"{line}\n{say(shlex.split(line)[2:], folder, str(folder / 'dps-s'))}" for line in shown]
            text = text.replace(block, "".join(lines))
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    import tempfile

    with tempfile.TemporaryDirectory() as home:
        _rewrite(Path(home))
    sys.exit()
