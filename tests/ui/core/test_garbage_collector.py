"""Garbage is freed in the window's thread, nothing that is in sight is garbage, and PySide6 loses no references."""

import gc
import sys
import threading
import weakref
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QCoreApplication, QEvent
from PySide6.QtWidgets import QApplication, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from tests.support.garbage import living_garbage
from tests.support.processes import ran_code
from tests.support.window.controls import tab_chain
from tests.support.window.settings_bench import desk
from ui.core.garbage_collector import collect_due, garbage_freed_here


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


def test_without_it_a_worker_does(enabled: None) -> None:
    threads = freed_in()
    made_by_a_worker()
    assert threads
    assert threads != [threading.get_ident()]


def test_afterwards_all_is_as_it_was(qtbot: QtBot, enabled: None) -> None:
    with garbage_freed_here():
        assert not gc.isenabled()
    assert gc.isenabled()
    gc.disable()
    with garbage_freed_here():
        pass
    assert not gc.isenabled()


@pytest.mark.parametrize(
    ("counts", "oldest", "collected"),
    [
        ((1, 0, 0), 10, []),
        ((701, 0, 0), 10, [0]),
        ((701, 11, 0), 10, [1]),
        ((5, 11, 0), 10, [1]),
        ((701, 11, 11), 10, [2]),
        pytest.param((9000, 9000, 9000), 0, [1], id="a generation that is switched off is never due"),
    ],
)
def test_the_oldest_that_is_due(
    qtbot: QtBot, monkeypatch: pytest.MonkeyPatch, counts: tuple[int, int, int], oldest: int, collected: list[int]
) -> None:
    done: list[int] = []
    monkeypatch.setattr(gc, "get_count", lambda: counts)
    monkeypatch.setattr(gc, "get_threshold", lambda: (700, 10, oldest))
    monkeypatch.setattr(gc, "collect", done.append)
    collect_due()
    monkeypatch.undo()
    assert done == collected


def test_only_in_the_main_thread() -> None:
    refused: list[RuntimeError] = []

    def attempt() -> None:
        try:
            with garbage_freed_here():
                pass
        except RuntimeError as error:
            refused.append(error)

    worker = threading.Thread(target=attempt)
    worker.start()
    worker.join()
    assert len(refused) == 1


def rows_in(window: QWidget) -> None:
    rows = QVBoxLayout(window)
    for name in ("one", "two", "three"):
        row = QWidget()
        rows.addWidget(row)
        row.setObjectName(name)


def test_what_the_collector_would_take_out_of_a_window_is_found(qtbot: QtBot) -> None:
    window = QWidget()
    qtbot.addWidget(window)
    rows_in(window)
    assert not living_garbage(window)
    one, two, _three = window.findChildren(QWidget)
    one.nextInFocusChain()
    two.previousInFocusChain()  # each is the other's parent
    del one, two, _three
    assert living_garbage(window) == ["QWidget one", "QWidget two"]


def test_looking_at_the_order_of_tab_leaves_the_parents_alone(qtbot: QtBot) -> None:
    window = QWidget()
    qtbot.addWidget(window)
    rows_in(window)
    tab_chain(window)
    assert not living_garbage(window)
    assert len(window.findChildren(QWidget)) == 3


def test_nothing_of_a_closed_window_stays_in_memory(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "settings") as one:
        parts = (one.assembly.window, one.assembly.ports, one.assembly.storage, one.settings, one.settings.work)
        left = {type(part).__name__: weakref.ref(part) for part in parts}
    del one, parts
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    gc.collect()
    assert [name for name, part in left.items() if part() is not None] == []


REPEATS = 4000
LOSS_ALLOWED = REPEATS // 10
ARE_MORTAL = sys.version_info < (3, 12)

_PROGRAM = f"""
import sys
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QApplication, QLabel

class Source(QObject):
    changed = Signal(bool)

application = QApplication(["references"])
label, source, heard = QLabel(), Source(), []
source.changed.connect(lambda is_on: heard.append(1))

def churn():
    for number in range({REPEATS}):
        label.setText(str(number))
        label.setEnabled(True)
        label.isEnabled()
        source.changed.emit(True)
        if number % 100 == 0:
            label.grab()
            application.processEvents()

keep = [None] * {REPEATS * 40}, [True] * {REPEATS * 40}  # a loss shall be counted, not end the process
before = sys.getrefcount(None), sys.getrefcount(True)
churn()
after = sys.getrefcount(None), sys.getrefcount(True)
print(len(heard), before[0] - after[0], before[1] - after[1])
"""


def test_none_and_true_keep_their_references() -> None:
    run = ran_code(_PROGRAM, PYTHONFAULTHANDLER="1")
    assert run.returncode == 0, run.stderr
    heard, lost_none, lost_true = map(int, run.stdout.split())
    assert heard == REPEATS
    if ARE_MORTAL:
        assert lost_none < LOSS_ALLOWED, f"{lost_none} references to None were lost"
        assert lost_true < LOSS_ALLOWED, f"{lost_true} references to True were lost"


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
