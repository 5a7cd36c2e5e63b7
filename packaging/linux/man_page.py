"""Writes the manual page dps-s(1) from the help of `dps-s` and its sub-commands."""

import json
import os
import subprocess
import sys
from collections.abc import Sequence

from environment import ROOT
from release import TITLE, Release

_SUMMARY = "configure, test and watch a DPS-S drone parachute module"


_ASK = """
import contextlib, io, json, sys
from app.__main__ import main
said = []
for words in json.load(sys.stdin):
    with contextlib.redirect_stdout(io.StringIO()) as output:
        main(words)
    said.append(output.getvalue())
print(json.dumps(said))
"""


def manual_page(release: Release) -> str:
    """The page in troff."""
    sys.path.insert(0, str(ROOT))
    from app.cli.commands import ENTRIES

    names = [entry.name for entry in ENTRIES]
    whole, *each = help_output(["--help"], *([name, "--help"] for name in names))
    lines = [
        f'.TH DPS\\-S 1 "{release.time:%Y-%m-%d}" "{TITLE} {release.version}" "User Commands"',
        ".SH NAME",
        f"dps\\-s \\- {_safe(_SUMMARY)}",
        ".SH SYNOPSIS",
        ".B dps\\-s",
        "[\\fICOMMAND\\fR] [\\fIOPTION\\fR]...",
        ".SH DESCRIPTION",
        *_preformatted(whole),
        ".SH COMMANDS",
    ]
    for name, help_text in zip(names, each, strict=True):
        lines += [f".SS {_safe(name)}", *_preformatted(help_text)]
    lines += [
        ".SH FILES",
        _safe("/usr/lib/udev/rules.d/60-dps-s.rules lets whoever sits at the computer open the usual USB adapters."),
    ]
    return "\n".join(lines) + "\n"


def help_output(*commands: Sequence[str]) -> list[str]:
    """What the program of the checkout prints, in English and 78 columns; all in one process, to save time."""
    variables = {"LC_ALL": "C.UTF-8", "LANGUAGE": "en", "COLUMNS": "78", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", _ASK],
        cwd=ROOT,
        env={**os.environ, **variables},
        input=json.dumps(commands),
        capture_output=True,
        encoding="utf-8",
        check=True,
    )
    said: list[str] = json.loads(done.stdout)
    return said


def _preformatted(text: str) -> Sequence[str]:
    """Lines that troff prints unchanged."""
    return [".nf", *(_safe(line) for line in text.strip().splitlines()), ".fi"]


def _safe(line: str) -> str:
    escaped = line.replace("\\", "\\e").replace("-", "\\-")
    return f"\\&{escaped}" if escaped.startswith((".", "'")) else escaped
