"""Version, time and names of a release. pyproject.toml states the version, and who stands behind it."""

import os
import platform
import re
import subprocess
import sys
import tomllib
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

import packaging.version
from environment import PYPROJECT, ROOT

NAME: Final = "dps-s-configurator"
TITLE: Final = "DPS-S Configurator"
COMMAND: Final = "dps-s"
_PLACEHOLDER: Final = "localhost"
_SYSTEMS: Final = {"win32": "windows", "darwin": "macos"}


@dataclass(frozen=True, slots=True)
class Release:
    """A version, and the time of all files in its packages: `epoch`, in seconds since 1970."""

    version: str
    epoch: int

    @property
    def system(self) -> str:
        """System and machine of the bundle, such as ``linux-x86_64``."""
        machine = platform.machine().lower().replace("amd64", "x86_64")
        return f"{_SYSTEMS.get(sys.platform, 'linux')}-{machine}"

    @property
    def bundle_name(self) -> str:
        return f"{NAME}-{self.version}-{self.system}"

    @property
    def numbers(self) -> tuple[int, ...]:
        """The version as the four numbers that Windows wants."""
        return (*packaging.version.parse(self.version).release, 0, 0, 0)[:4]

    @property
    def time(self) -> datetime:
        return datetime.fromtimestamp(self.epoch, UTC)


def read_release() -> Release:
    """The version of the checkout. Its time is SOURCE_DATE_EPOCH, or that of the last commit."""
    return Release(_stated()["project"]["version"], _epoch())


def project() -> dict[str, str]:
    """Maintainer and addresses from pyproject.toml."""
    stated = _stated()["project"]
    author, urls = stated["authors"][0], stated["urls"]
    return {
        "maintainer": author["name"], "address": author["email"],
        "home_page": urls["Homepage"], "issues": urls["Issues"], "downloads": urls["Releases"],
    }  # fmt: skip


def refusals(python: Sequence[int] = sys.version_info[:3]) -> list[str]:
    """Reasons why a build must not be released, one sentence each."""
    reasons = [f"pyproject.toml: {key} is a placeholder." for key, value in project().items() if _PLACEHOLDER in value]
    series, patch = f"{python[0]}.{python[1]}", python[2]
    oldest = _stated()["tool"]["dps-s"]["oldest-python"].get(series)
    if oldest is None:
        reasons.append(f"A release brings none of Python {series}: pyproject.toml states no version of it.")
    elif patch < oldest:
        reasons.append(f"Python {series}.{patch} is too old to be passed on: build with {series}.{oldest} or later.")
    return reasons


def _stated() -> dict[str, Any]:
    return tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))


def _epoch() -> int:
    given = os.environ.get("SOURCE_DATE_EPOCH", "")
    if re.fullmatch(r"\d+", given):
        return int(given)
    try:
        command = ["git", "-c", "safe.directory=*", "log", "-1", "--format=%ct"]
        shown = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
        return int(shown)
    except (OSError, subprocess.CalledProcessError, ValueError):  # no git, or no history
        return int(PYPROJECT.stat().st_mtime)


def filled(template: Path, **words: str) -> str:
    """The text of a file with a word in the place of each @NAME@."""
    return re.sub(r"@([A-Z]+)@", lambda match: words[match[1]], template.read_text(encoding="utf-8"))


def set_rights(folder: Path, programs: Collection[Path]) -> None:
    """Set the modes of all files, independent of the umask; only `programs` are executable."""
    for path in (folder, *folder.rglob("*")):
        if not path.is_symlink():
            path.chmod(0o755 if path.is_dir() or path in programs else 0o644)


def stamp_times(folder: Path, epoch: int) -> None:
    for path in (*folder.rglob("*"), folder):
        os.utime(path, (epoch, epoch), follow_symlinks=os.utime not in os.supports_follow_symlinks)
