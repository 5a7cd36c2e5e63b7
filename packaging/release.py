"""Name, version and maintainer of what is built, and tools that its builders share."""

import os
import platform
import re
import subprocess
import sys
import tomllib
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from environment import PYPROJECT, ROOT

NAME = "dps-s-configurator"
TITLE = "DPS-S Configurator"
COMMAND = "dps-s"
DIST = ROOT / "dist"
WORK = ROOT / "build" / "package"
_PLACEHOLDER = "localhost"


def _project() -> dict[str, Any]:
    return dict(tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["project"])


VERSION: str = _project()["version"]


def bundle_name() -> str:
    """Name, version, system and machine, such as `dps-s-configurator-0.1.0-linux-x86_64`."""
    system = {"win32": "windows", "darwin": "macos"}.get(sys.platform, "linux")
    machine = platform.machine().lower().replace("amd64", "x86_64")
    return f"{NAME}-{VERSION}-{system}-{machine}"


def numbers() -> str:
    """The version as the four numbers that Windows wants: 0.1.0rc1 is 0.1.0.0."""
    return ".".join([*re.findall(r"\d+", VERSION.partition("rc")[0]), "0", "0", "0"][:4])


def epoch() -> int:
    """The time that files in packages have, in seconds since 1970: SOURCE_DATE_EPOCH, else that of the last commit."""
    if os.environ.get("SOURCE_DATE_EPOCH", "").isdigit():
        return int(os.environ["SOURCE_DATE_EPOCH"])
    command = ["git", "-c", "safe.directory=*", "log", "-1", "--format=%ct"]
    try:
        return int(subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout)
    except (OSError, subprocess.CalledProcessError, ValueError):  # no git, or no history
        return int(PYPROJECT.stat().st_mtime)


def words() -> dict[str, str]:
    """What templates have places for. Maintainer and addresses stand in pyproject.toml only."""
    project, time = _project(), datetime.fromtimestamp(epoch(), UTC)
    author, urls = project["authors"][0], project["urls"]
    return {
        "VERSION": VERSION,
        "DATE": f"{time:%Y-%m-%d}",
        "TIME": f"{time:%a, %d %b %Y %H:%M:%S +0000}",
        "MAINTAINER": f"{author['name']} <{author['email']}>",
        "HOMEPAGE": urls["Homepage"],
        "ISSUES": urls["Issues"],
        "SCREENSHOT": urls["Screenshot"],
        "MACHINE": platform.machine(),
        "GLIBC": platform.libc_ver()[1],
    }


def filled(template: Path, **more: str) -> str:
    """The text of a file with a word in the place of each @NAME@."""
    known = words() | more
    return re.sub(r"@([A-Z]+)@", lambda match: known[match[1]], template.read_text(encoding="utf-8"))


def refusals() -> list[str]:
    """Why this must not be passed on, a sentence each."""
    told = words()
    places = ("MAINTAINER", "HOMEPAGE", "ISSUES", "SCREENSHOT")
    return [f"pyproject.toml: {place.lower()} is a placeholder." for place in places if _PLACEHOLDER in told[place]]
