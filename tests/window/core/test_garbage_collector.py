"""Garbage is freed in the window's thread, nothing that is in sight is garbage, and PySide6 loses no references."""

import gc
import threading
import weakref
from collections.abc import Iterator

import pytest
from pytestqt.qtbot import QtBot

from tests.support.processes import ran_code
from ui.core.bridge import garbage_freed_here


class Ring:
    """Refers to itself, so that only the collector can free it."""

    def __init__(self) -> None:
        self.itself = self


@pytest.fixture
def enabled() -> Iterator[None]:
    """Python collects by itself, as it does outside of tests."""
    gc.collect()
    gc.enable()
    yield
    gc.disable()


def made_by_a_worker() -> list[list[int]]:
    """So many objects that Python would begin to collect, several times."""
    made: list[list[int]] = []
    worker = threading.Thread(target=lambda: made.extend([number] for number in range(20 * gc.get_threshold()[0])))
    worker.start()
    worker.join()
    return made


def freed_in() -> list[int]:
    """A ring that is garbage at once; the thread that freed it comes into the list."""
    threads: list[int] = []
    weakref.finalize(Ring(), lambda: threads.append(threading.get_ident())).atexit = False
    return threads


def test_a_worker_frees_nothing(qtbot: QtBot, enabled: None) -> None:
    with garbage_freed_here():
        threads = freed_in()
        made = made_by_a_worker()
        assert not threads
        qtbot.waitUntil(lambda: bool(threads))
    assert threads == [threading.get_ident()]
    assert made


def test_afterwards_all_is_as_it_was(qtbot: QtBot, enabled: None) -> None:
    with garbage_freed_here():
        assert not gc.isenabled()
    assert gc.isenabled()
    gc.disable()
    with garbage_freed_here():
        pass
    assert not gc.isenabled()


def test_no_class_of_qt_is_made_beside_the_event_loop() -> None:
    """pyqtgraph, imported in the background, ended one start in eighty of a busy computer."""
    code = """if True:
        import sys, ui.main
        before = set(sys.modules)
        ui.main._load_libraries()
        print(*sys.modules.keys() - before)
    """
    loaded = {name.partition(".")[0] for name in ran_code(code).stdout.split()}
    assert "numpy" in loaded
    assert not loaded & {"ui", "pyqtgraph", "PySide6", "shiboken6"}
