"""Imports the modules of packaging/ and docs/generate/ for tests, which are not packages."""

import re
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
PACKAGING = ROOT / "packaging"


class SetupFiles:
    """The modules of packaging/, each imported when it is asked for. They stay imported: others hold their classes."""

    def __getattr__(self, name: str) -> ModuleType:
        return import_module(name)


def generator(name: str) -> ModuleType:
    """The tool of this name in docs/generate/."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "docs" / "generate"))
        return import_module(name)


def registered_endings() -> set[str]:
    """The endings of files that the installer for Windows registers."""
    script = (PACKAGING / "windows" / "installer.nsi").read_text(encoding="utf-8")
    return set(re.findall(r"insertmacro \$\{DO\} \w+ (\.\w+)", script))
