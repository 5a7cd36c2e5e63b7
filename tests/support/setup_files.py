"""The files of packaging/ for tests: it is no package, so they are imported as bootstrap.py does it."""

import sys
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
    """The modules that set a checkout up."""

    bootstrap: ModuleType
    commands: ModuleType
    environment: ModuleType
    system_libraries: ModuleType
    tools: ModuleType


@contextmanager
def loaded_setup_files() -> Iterator[SetupFiles]:
    """Import them, and forget their plain names afterwards."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(PACKAGING))
        yield SetupFiles(*(import_module(name) for name in SetupFiles._fields))
        for name in SetupFiles._fields:
            sys.modules.pop(name)
