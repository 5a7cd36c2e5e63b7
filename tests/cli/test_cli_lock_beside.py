"""`dps-s lock` waits for no disk: the module is locked whatever becomes of the store."""

import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing

import pytest

from app.store.fact_store import FILE_NAME
from app.system.files import data_folder
from tests.support.patience import in_time
from tests.support.processes import PROGRAM, RunningModule, ran, ran_code, run_module

pytestmark = [
    pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals on Windows"),
    pytest.mark.usefixtures("user_files"),
]
ENDS_WITHIN_S = 8.0
"""The contract says 5 s after the confirmation; the start of the program and a busy machine come on top."""
BLOCKED = """
import sqlite3, sys, threading
sqlite3.connect = lambda *words, **options: threading.Event().wait()
from app.__main__ import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def module() -> Iterator[RunningModule]:
    with run_module("--active", "yes") as one:
        yield one


def locked(printed: "subprocess.CompletedProcess[str]") -> str:
    """What it says beside "LOCKED"; its exit code is LOCK's."""
    assert (printed.returncode, printed.stdout) == (0, "The module reports LOCKED.\n"), printed.stderr
    return printed.stderr


def test_a_store_that_another_program_holds(module: RunningModule) -> None:
    locked(ran(*PROGRAM, "lock", "--port", module.port))
    with closing(sqlite3.connect(data_folder() / FILE_NAME, isolation_level=None)) as other:
        other.execute("PRAGMA locking_mode = EXCLUSIVE")
        other.execute("BEGIN EXCLUSIVE")
        with in_time(ENDS_WITHIN_S):
            assert "The audit log is incomplete." in locked(ran(*PROGRAM, "lock", "--port", module.port))


def test_a_disk_that_never_answers(module: RunningModule) -> None:
    with in_time(ENDS_WITHIN_S):
        assert "The audit log is incomplete." in locked(ran_code(BLOCKED, "lock", "--port", module.port))
