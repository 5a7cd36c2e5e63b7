"""Work in the background: who is told what came of it, and who is not."""

import threading
from pathlib import Path

import pytest
from PySide6.QtCore import QObject
from pytestqt.qtbot import QtBot

from app.store.fact_store import Store, StoreFault, StoreTrouble
from tests.support.patience import PATIENCE_S
from ui.core.background_task import BackgroundTask, ExportCancelled, Running


class Told:
    """What came of it, and in which thread it was told."""

    def __init__(self) -> None:
        self.results: list[object] = []
        self.errors: list[Exception] = []
        self.threads: list[threading.Thread] = []

    def then(self, result: object) -> None:
        self.results.append(result)
        self.threads.append(threading.current_thread())

    def failed(self, error: Exception) -> None:
        self.errors.append(error)
        self.threads.append(threading.current_thread())


def until_wanted_no_more(running: Running) -> str:
    while not running.is_cancelled():
        threading.Event().wait(0.001)
    raise ExportCancelled


def test_the_result_is_told_in_the_window_s_thread(qtbot: QtBot) -> None:
    task, told = BackgroundTask[int]("dps-s test"), Told()
    go_on = threading.Event()

    def count(running: Running) -> int:
        running.set_progress(0.5)
        go_on.wait()
        return 3

    task.run(count, told.then, told.failed)
    qtbot.waitUntil(lambda: task.share == 0.5)
    go_on.set()
    qtbot.waitUntil(lambda: not task.is_running)
    assert (told.results, told.errors, told.threads) == ([3], [], [threading.current_thread()])
    assert task.share is None


def test_a_second_run_replaces_the_first(qtbot: QtBot) -> None:
    task, first, second = BackgroundTask[str]("dps-s test"), Told(), Told()
    task.run(until_wanted_no_more, first.then, first.failed)
    task.run(lambda _running: "second", second.then, second.failed)
    qtbot.waitUntil(lambda: not task.is_running)
    assert (first.threads, second.results) == ([], ["second"])


def test_what_is_stopped_tells_its_end_and_what_is_cancelled_does_not(qtbot: QtBot) -> None:
    task, stopped, cancelled = BackgroundTask[str]("dps-s test"), Told(), Told()
    task.run(until_wanted_no_more, stopped.then, stopped.failed)
    task.stop()
    assert task.is_running
    qtbot.waitUntil(lambda: not task.is_running)
    assert [type(error) for error in stopped.errors] == [ExportCancelled]
    task.run(until_wanted_no_more, cancelled.then, cancelled.failed)
    task.cancel()
    assert not task.is_running
    task.run(lambda _running: "next", stopped.then, stopped.failed)
    qtbot.waitUntil(lambda: not task.is_running)
    assert (cancelled.threads, stopped.results) == ([], ["next"])


@pytest.mark.parametrize("finished_at_close", [False, True])
def test_a_file_is_finished_when_the_window_closes(qtbot: QtBot, *, finished_at_close: bool) -> None:
    task = BackgroundTask[None]("dps-s test", finished_at_close=finished_at_close)
    go_on, found = threading.Event(), list[tuple[bool, bool]]()

    def write(running: Running) -> None:
        go_on.wait()
        found.append((running.is_requested, threading.current_thread().daemon))

    task.run(write, lambda _none: None, lambda _error: None)
    task.close()
    go_on.set()
    qtbot.waitUntil(lambda: bool(found))
    assert found == [(finished_at_close, not finished_at_close)]
    assert not task.is_running


def test_what_was_for_once_is_freed_when_its_result_is_there(qtbot: QtBot, tmp_path: Path) -> None:
    window, told, queue = QObject(), Told(), Store(tmp_path)

    def fail(_running: Running) -> int:
        raise OSError

    BackgroundTask[int]("dps-s test", window, for_once=True).run(lambda _running: 1, told.then, told.failed)
    BackgroundTask[int]("dps-s test", window, for_once=True).run(fail, told.then, told.failed)
    BackgroundTask[int]("dps-s test", window, for_once=True).run_in(queue, lambda _facts: 2, told.then, told.failed)
    kept = BackgroundTask[int]("dps-s test", window)
    kept.run(lambda _running: 3, told.then, told.failed)
    qtbot.waitUntil(lambda: len(told.results) + len(told.errors) == 4)
    qtbot.waitUntil(lambda: window.findChildren(BackgroundTask) == [kept])
    queue.close(PATIENCE_S)


def test_work_on_the_store_is_done_though_it_is_replaced(qtbot: QtBot, tmp_path: Path) -> None:
    task, told, done = BackgroundTask[int]("dps-s test"), Told(), list[int]()
    queue = Store(tmp_path)

    def work(number: int) -> int:
        done.append(number)
        return number

    task.run_in(queue, lambda _facts: work(1), told.then, told.failed)
    task.run_in(queue, lambda _facts: work(2), told.then, told.failed)
    qtbot.waitUntil(lambda: not task.is_running)
    assert (done, told.results) == ([1, 2], [2])
    queue.close(PATIENCE_S)


def test_a_trouble_of_the_store_is_told_and_a_fault_of_ours_is_raised(qtbot: QtBot, tmp_path: Path) -> None:
    task, told, queue = BackgroundTask[None]("dps-s test"), Told(), Store(tmp_path)

    def fail(error: Exception) -> None:
        raise error

    trouble = StoreTrouble(StoreFault.FAILED, Path())
    task.run_in(queue, lambda _facts: fail(trouble), told.then, told.failed)
    qtbot.waitUntil(lambda: not task.is_running)
    assert told.errors == [trouble]
    with qtbot.captureExceptions() as raised:
        task.run_in(queue, lambda _facts: fail(KeyError("ours")), told.then, told.failed)
        qtbot.waitUntil(lambda: not task.is_running)
    assert [kind for kind, _error, _trace in raised] == [KeyError]
    assert told.errors == [trouble]
    queue.close(PATIENCE_S)
