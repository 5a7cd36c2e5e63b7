"""Imports the modules of packaging/ for tests as bootstrap.py does, because packaging/ is not a package."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
PACKAGING = ROOT / "packaging"


class SetupFiles(NamedTuple):
    """The modules that set up a checkout."""

    bootstrap: ModuleType
    commands: ModuleType
    environment: ModuleType
    system_libraries: ModuleType


@contextmanager
def loaded_setup_files() -> Iterator[SetupFiles]:
    """Import the modules. They stay imported: others of packaging/ hold their classes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(PACKAGING))
        yield SetupFiles(*(import_module(name) for name in SetupFiles._fields))


def registered_endings() -> set[str]:
    """The endings of files that the installer for Windows registers."""
    script = (PACKAGING / "windows" / "installer.nsi").read_text(encoding="utf-8")
    return set(re.findall(r"insertmacro \$\{DO\} \w+ (\.\w+)", script))
