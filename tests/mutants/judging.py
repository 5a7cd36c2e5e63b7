"""Runs tests on mutants."""

import gc
import resource
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from importlib.machinery import SourceFileLoader
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from types import CodeType, FunctionType
from typing import NamedTuple

import pytest

from tests.mutants import ROOT
from tests.mutants.changes import Mutant, functions_in
from tests.mutants.executed import Batches, TestMap
from tests.mutants.processes import forked, run_pytest, side_by_side

HANGS_S = 30
"""A test that says nothing for this long hangs, which CI notices, too."""
MOST_MEMORY = 3 << 30
"""Bytes; a mutant that collects without end takes no more."""
Run = Callable[[Sequence[str], Mutant | None, Connection], None]
"""Runs tests on a mutant, or on the program as it is; says which test runs and whether it failed."""


class Verdict(NamedTuple):
    mutant: Mutant
    tests: int
    """How many tests could have failed."""
    caught_by: str | None
    seconds: float

    def __str__(self) -> str:
        word = f"SURVIVED {self.tests} tests" if self.caught_by is None else "caught"
        return f"{word:8} {self.seconds:5.0f} s  {self.mutant}  [{self.caught_by}]"


def verdicts(jobs: int, folders: Sequence[str], executed: TestMap, mutants: Iterable[Mutant]) -> Iterator[Verdict]:
    """Judge each mutant with those tests in these folders that execute it.

    Tests are collected once; a mutant then changes the imported functions in a process of its own. What takes effect
    while a file is imported (a constant, a default) is judged in processes that import the program afresh.
    """
    functions, others = list[tuple[Mutant, Batches]](), list[tuple[Mutant, Batches]]()
    for one in mutants:
        in_functions = one.changes_functions_only() and not executed.is_executed_by_import(one)
        (functions if in_functions else others).append((one, executed.batches(one)))
    yield from _verdicts_of_collected(jobs, folders, functions)
    yield from side_by_side(jobs, partial(judged, run_imported), others)


def judged(run: Run, mutant: Mutant, batches: Batches) -> Verdict:
    """Run the tests on the mutant until one fails on it again, alone, and passes without it.

    A busy machine makes tests fail, too: they take too long.
    """
    began = time.monotonic()
    count = sum(map(len, batches))
    for batch in batches:
        tests = batch
        while tests:
            failed = _first_failure(run, tests, mutant)
            if failed is None:
                break
            alone = [failed] if failed in tests else tests
            is_steady = _first_failure(run, alone, mutant) is not None
            if is_steady and _first_failure(run, alone, None) is None:
                return Verdict(mutant, count, failed, time.monotonic() - began)
            tests = [test for test in tests if test != failed]
    return Verdict(mutant, count, None, time.monotonic() - began)


def _first_failure(run: Run, tests: Sequence[str], mutant: Mutant | None) -> str | None:
    """The first test that fails, crashes or hangs in a process of its own."""
    receiver, sender = Pipe(duplex=False)
    process = forked(run, tests, mutant, sender)
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


def run_imported(tests: Sequence[str], mutant: Mutant | None, sender: Connection) -> None:
    """In a process that has not imported the program."""
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_MEMORY, MOST_MEMORY))
    if mutant is not None:
        _import_mutated(mutant)
    files = dict.fromkeys(test.split("::")[0] for test in tests)
    sys.exit(run_pytest(files, _Chooser(tests, sender)))


def _import_mutated(mutant: Mutant) -> None:
    target, plain = str(ROOT / mutant.path), SourceFileLoader.get_code

    def get_code(loader: SourceFileLoader, name: str) -> CodeType | None:
        return mutant.code() if loader.path == target else plain(loader, name)

    SourceFileLoader.get_code = get_code  # type: ignore[assignment, method-assign]


class _Reporter:
    """Says which test runs and whether it failed."""

    def __init__(self, sender: Connection) -> None:
        self._sender = sender

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        self._sender.send((f"import of {report.nodeid}", report.failed))

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self._sender.send((nodeid, False))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._sender.send((report.nodeid, report.failed))


class _Chooser(_Reporter):
    """Runs the chosen tests only, in their order."""

    def __init__(self, tests: Sequence[str], sender: Connection) -> None:
        super().__init__(sender)
        self._order = {test: number for number, test in enumerate(tests)}

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        chosen = [item for item in items if item.nodeid in self._order]
        items[:] = sorted(chosen, key=lambda item: self._order[item.nodeid])


def _verdicts_of_collected(
    jobs: int, folders: Sequence[str], cases: Iterable[tuple[Mutant, Batches]]
) -> Iterator[Verdict]:
    receiver, sender = Pipe(duplex=False)
    process = forked(_collect, folders, _Judge(jobs, cases, sender))
    sender.close()
    try:
        while True:
            yield receiver.recv()
    except EOFError:
        process.join()
    finally:
        process.terminate()
        process.join()
        receiver.close()
    if process.exitcode:
        raise RuntimeError(f"the tests of {' '.join(folders)} ended with {process.exitcode}")


def _collect(folders: Sequence[str], plugin: object) -> None:
    sys.exit(run_pytest(folders, plugin))


class _Judge:
    """Where pytest would run the tests that it collected, judges mutants with them."""

    def __init__(self, jobs: int, cases: Iterable[tuple[Mutant, Batches]], sender: Connection) -> None:
        self._jobs, self._cases, self._sender = jobs, cases, sender

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        if session.testsfailed:
            raise session.Interrupted("collection failed")
        run = partial(_run_collected, {item.nodeid: item for item in session.items})
        for verdict in side_by_side(self._jobs, partial(judged, run), self._cases):
            self._sender.send(verdict)
        return True


def _run_collected(
    items: dict[str, pytest.Item], tests: Sequence[str], mutant: Mutant | None, sender: Connection
) -> None:
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_MEMORY, MOST_MEMORY))
    if mutant is not None:
        _change_functions(mutant)
    chosen = [items[test] for test in tests]
    for item, following in zip(chosen, [*chosen[1:], None], strict=True):
        if item is chosen[0]:
            item.config.pluginmanager.register(_Reporter(sender))
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)


def _change_functions(mutant: Mutant) -> None:
    """In place, wherever they are held: as methods, in tables, wrapped by decorators."""
    target, mutated = str(ROOT / mutant.path), functions_in(mutant.code())
    for held in gc.get_objects():
        if isinstance(held, FunctionType) and held.__code__.co_filename == target:
            code = mutated.get((held.__code__.co_qualname, held.__code__.co_firstlineno))
            if code is not None:
                held.__code__ = code
