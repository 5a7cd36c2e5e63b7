"""Runs tests on a mutant."""

import resource
import sys
import time
from collections.abc import Sequence
from importlib.machinery import SourceFileLoader
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from types import CodeType
from typing import NamedTuple

import pytest

from tests.mutants import ROOT
from tests.mutants.changes import Mutant
from tests.mutants.processes import forked, run_pytest

HANGS_S = 90
"""A test that says nothing for this long hangs, which CI notices, too."""
MOST_MEMORY = 3 << 30
"""Bytes; a mutant that collects without end takes no more."""


class Verdict(NamedTuple):
    mutant: Mutant
    tests: int
    """How many tests could have failed."""
    caught_by: str | None
    seconds: float

    def __str__(self) -> str:
        word = f"SURVIVED {self.tests} tests" if self.caught_by is None else "caught"
        return f"{word:8} {self.seconds:5.0f} s  {self.mutant}  [{self.caught_by}]"


def judged(mutant: Mutant, batches: list[list[str]]) -> Verdict:
    """Run the tests on the mutant until one fails on it again, alone, and passes without it.

    A busy machine makes tests fail, too: they take too long.
    """
    began = time.monotonic()
    count = sum(map(len, batches))
    for batch in batches:
        tests = batch
        while tests:
            failed = _first_failure(tests, mutant)
            if failed is None:
                break
            alone = [failed] if failed in tests else tests
            is_steady = _first_failure(alone, mutant) is not None
            if is_steady and (failed not in tests or _first_failure(alone, None) is None):
                return Verdict(mutant, count, failed, time.monotonic() - began)
            tests = [test for test in tests if test != failed]
    return Verdict(mutant, count, None, time.monotonic() - began)


def _first_failure(tests: Sequence[str], mutant: Mutant | None) -> str | None:
    """The first test that fails, crashes or hangs in a process of its own."""
    receiver, sender = Pipe(duplex=False)
    process = forked(_run_chosen, tests, mutant, sender)
    sender.close()
    running, has_failed = "the start", False
    try:
        while not has_failed and receiver.poll(HANGS_S):
            running, has_failed = receiver.recv()
    except EOFError:
        process.join()
        return running if process.exitcode else None
    finally:
        process.kill()
        process.join()
        receiver.close()
    return running


def _run_chosen(tests: Sequence[str], mutant: Mutant | None, sender: Connection) -> None:
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_MEMORY, MOST_MEMORY))
    if mutant is not None:
        _import_mutated(mutant)
    files = dict.fromkeys(test.split("::")[0] for test in tests)
    sys.exit(run_pytest(files, _Chooser(tests, sender)))


def _import_mutated(mutant: Mutant) -> None:
    target, plain = str(ROOT / mutant.path), SourceFileLoader.get_code

    def get_code(loader: SourceFileLoader, name: str) -> CodeType | None:
        if loader.path == target:
            return compile(mutant.text, target, "exec", dont_inherit=True)
        return plain(loader, name)

    SourceFileLoader.get_code = get_code  # type: ignore[assignment, method-assign]


class _Chooser:
    """Runs the chosen tests in their order, and says which one runs and whether it failed."""

    def __init__(self, tests: Sequence[str], sender: Connection) -> None:
        self._order = {test: number for number, test in enumerate(tests)}
        self._sender = sender

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        self._sender.send((f"import of {report.nodeid}", report.failed))

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        chosen = [item for item in items if item.nodeid in self._order]
        items[:] = sorted(chosen, key=lambda item: self._order[item.nodeid])

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self._sender.send((nodeid, False))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._sender.send((report.nodeid, report.failed))
