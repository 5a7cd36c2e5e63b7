"""Forked processes: what takes long to import is imported once, and each begins from there."""

import contextlib
import importlib
import multiprocessing
import os
import signal
import tempfile
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import TypeVar

import pytest

from tests.mutants import ROOT

_PRELOADED = ("cryptography.x509", "mcap.reader", "numpy", "PySide6.QtWidgets", "serial")
Result = TypeVar("Result")


def preload() -> None:
    """Import what no mutant changes."""
    os.chdir(ROOT)
    for name in _PRELOADED:
        importlib.import_module(name)


def forked(target: Callable[..., object], *arguments: object) -> BaseProcess:
    """A started process."""
    process = multiprocessing.get_context("fork").Process(target=target, args=arguments)
    process.start()
    return process


def side_by_side(
    jobs: int, function: Callable[..., Result], arguments: Iterable[tuple[object, ...]]
) -> Iterator[Result]:
    """The result of each call as it ends, so many at a time, each in a process whose own processes end with it.

    Raises ``EOFError`` where a call ends without a result.
    """
    waiting = iter(arguments)
    running: dict[Connection, BaseProcess] = {}
    try:
        while True:
            for given in islice(waiting, jobs - len(running)):
                receiver, sender = Pipe(duplex=False)
                running[receiver] = forked(_send_result, sender, function, given)
                sender.close()
            if not running:
                return
            ended = wait(list(running))
            for receiver in [one for one in running if one in ended]:
                result = receiver.recv()
                _end(running.pop(receiver))
                receiver.close()
                yield result
    finally:
        for process in running.values():
            _end(process)


def _send_result(sender: Connection, function: Callable[..., object], given: tuple[object, ...]) -> None:
    os.setpgid(0, 0)
    sender.send(function(*given))


def _end(process: BaseProcess) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid or 0, signal.SIGKILL)
    process.kill()
    process.join()


def run_pytest(paths: Iterable[str], plugin: object) -> int:
    """Run the tests of these paths, print nothing, return pytest's exit code."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    with tempfile.TemporaryDirectory() as place:
        os.environ["PYTEST_DEBUG_TEMPROOT"] = place  # in it, each process that is forked takes a folder of its own
        options = ["-q", "--tb=no", "-p", "no:randomly", "-p", "no:cacheprovider", "--capture=sys"]
        return int(pytest.main([*options, *paths], plugins=[plugin]))
