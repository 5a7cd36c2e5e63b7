"""The manual page dps-s(1), made from what `dps-s --help` and the sub-commands' help say."""

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from environment import ROOT
from release import TITLE, Release

_SUMMARY = "configure, test and watch a DPS-S drone parachute module"


def manual_page(release: Release) -> str:
    """The page in troff."""
    sys.path.insert(0, str(ROOT))
    from app.__main__ import ENTRIES

    lines = [
        f'.TH DPS\\-S 1 "{release.time:%Y-%m-%d}" "{TITLE} {release.version}" "User Commands"',
        ".SH NAME",
        f"dps\\-s \\- {_safe(_SUMMARY)}",
        ".SH SYNOPSIS",
        ".B dps\\-s",
        "[\\fICOMMAND\\fR] [\\fIOPTION\\fR]...",
        ".SH DESCRIPTION",
        *_as_it_stands(_help()),
        ".SH COMMANDS",
    ]
    for entry in ENTRIES:
        lines += [f".SS {_safe(entry.name)}", *_as_it_stands(_help(entry.name))]
    lines += [
        ".SH FILES",
        _safe("/usr/lib/udev/rules.d/60-dps-s.rules lets whoever sits at the computer open the usual USB adapters."),
    ]
    return "\n".join(lines) + "\n"


def write_manual_page(path: Path, release: Release) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(manual_page(release), encoding="utf-8")


def _help(*words: str) -> str:
    """What the program of the checkout says, in English and 78 columns."""
    variables = {"LC_ALL": "C.UTF-8", "LANGUAGE": "en", "COLUMNS": "78", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "app", *words, "--help"]
    done = subprocess.run(
        command, cwd=ROOT, env={**os.environ, **variables}, capture_output=True, encoding="utf-8", check=True
    )
    return done.stdout


def _as_it_stands(text: str) -> Sequence[str]:
    """Lines that troff neither fills nor takes for orders."""
    return [".nf", *(_safe(line) for line in text.strip().splitlines()), ".fi"]


def _safe(line: str) -> str:
    escaped = line.replace("\\", "\\e").replace("-", "\\-")
    return f"\\&{escaped}" if escaped.startswith((".", "'")) else escaped
