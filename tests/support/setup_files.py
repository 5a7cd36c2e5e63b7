"""Imports the modules of packaging/ for tests as bootstrap.py does, because packaging/ is not a package."""

import re
from importlib import import_module
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).parents[2]
PACKAGING = ROOT / "packaging"


class SetupFiles:
    """The modules of packaging/, each imported when it is asked for. They stay imported: others hold their classes."""

    def __getattr__(self, name: str) -> ModuleType:
        return import_module(name)


def registered_endings() -> set[str]:
    """The endings of files that the installer for Windows registers."""
    script = (PACKAGING / "windows" / "installer.nsi").read_text(encoding="utf-8")
    return set(re.findall(r"insertmacro \$\{DO\} \w+ (\.\w+)", script))
