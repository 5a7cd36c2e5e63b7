"""Test runs in forked processes: what takes long to import is imported once, and the program afresh in each."""

import importlib
import multiprocessing
import os
import tempfile
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing.process import BaseProcess

import pytest

from tests.mutants import ROOT

_PRELOADED = ("cryptography.x509", "mcap.reader", "numpy", "PySide6.QtWidgets", "serial")


def pool(jobs: int) -> ProcessPoolExecutor:
    """Workers that fork a process for each test run."""
    os.chdir(ROOT)
    for name in _PRELOADED:
        importlib.import_module(name)
    return ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("fork"))


def forked(target: Callable[..., object], *arguments: object) -> BaseProcess:
    """A started process."""
    process = multiprocessing.get_context("fork").Process(target=target, args=arguments)
    process.start()
    return process


def run_pytest(paths: Iterable[str], plugin: object) -> int:
    """Run the tests of these paths, print nothing, return pytest's exit code."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    with tempfile.TemporaryDirectory() as place:
        options = ["-q", "--tb=no", "-p", "no:randomly", "-p", "no:cacheprovider", "--basetemp", f"{place}/t"]
        return int(pytest.main([*options, *paths], plugins=[plugin]))
