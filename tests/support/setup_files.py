"""The scripts of packaging/ and docs/generate/, which are no packages."""

import re
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
PACKAGING = ROOT / "packaging"


def tool(folder: str, name: str) -> ModuleType:
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / folder))
        return import_module(name)


def registered_endings() -> set[str]:
    """The endings of files that the installer for Windows registers."""
    script = (PACKAGING / "windows" / "installer.nsi").read_text(encoding="utf-8")
    return set(re.findall(r"insertmacro \$\{DO\} \w+ (\.\w+)", script))
