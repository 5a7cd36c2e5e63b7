"""Work in the background or in turns, and who is told of it: tasks, the worker's bridge, a page's job, garbage."""

import gc
import sys
import threading
import weakref
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot
from shiboken6 import delete

from app.engine.conversation import ConversationView
from app.engine.procedure import Job, Pause, Procedure, Report
from app.engine.worker import Batch, Connection
from app.store.fact_store import Store, StoreError
from protocol.events import Ended, EndReason
from tests.support.patience import PATIENCE_S
from tests.support.processes import ran_code
from tests.support.window.rig import Rig
from tests.support.window.steps import given
from ui.core.background_task import BackgroundTask, ExportCancelled, Running
from ui.core.bridge import Bridge, garbage_freed_here
from ui.core.turns import Turns, importing
from ui.pages.logs.page import LogsPage
from ui.session.page_job import PageJob
from ui.style.theme import Meaning


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
        running.share = 0.5
        go_on.wait()
        return 3

    task.run(count, told.then, told.failed)
    qtbot.waitUntil(lambda: task.share == 0.5)
    go_on.set()
    qtbot.waitUntil(lambda: not task.is_running)
    assert (told.results, told.errors, told.threads) == ([3], [], [threading.current_thread()])
    assert task.share is None


def test_what_ends_after_its_page_was_deleted_is_told_nobody(qtbot: QtBot, qapp: QApplication) -> None:
    task, told = BackgroundTask[str]("dps-s test"), Told()
    go_on = threading.Event()
    task.run(lambda _running: str(go_on.wait()), told.then, told.failed)
    delete(task)
    go_on.set()
    assert task.wait(PATIENCE_S)
    qapp.processEvents()
    assert told.threads == []


def test_what_is_stopped_tells_its_end_and_what_is_cancelled_or_replaced_does_not(qtbot: QtBot) -> None:
    task, stopped, dropped = BackgroundTask[str]("dps-s test"), Told(), Told()
    task.run(until_wanted_no_more, stopped.then, stopped.failed)
    task.stop()
    assert task.is_running
    qtbot.waitUntil(lambda: not task.is_running)
    assert [type(error) for error in stopped.errors] == [ExportCancelled]
    task.run(until_wanted_no_more, dropped.then, dropped.failed)
    task.cancel()
    assert not task.is_running
    task.run(until_wanted_no_more, dropped.then, dropped.failed)
    task.run(lambda _running: "next", stopped.then, stopped.failed)
    qtbot.waitUntil(lambda: not task.is_running)
    assert (dropped.threads, stopped.results) == ([], ["next"])


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


def test_work_on_the_store_is_done_though_it_is_replaced_and_its_trouble_is_told(qtbot: QtBot, tmp_path: Path) -> None:
    task, told, queue, done = BackgroundTask[None]("dps-s test"), Told(), Store(tmp_path), list[int]()

    def fail(error: Exception) -> None:
        raise error

    task.run_in(queue, lambda _facts: done.append(1), told.then, told.failed)
    task.run_in(queue, lambda _facts: done.append(2), told.then, told.failed)
    qtbot.waitUntil(lambda: not task.is_running)
    assert (done, len(told.results)) == ([1, 2], 1)
    trouble = StoreError("It cannot be used.")
    task.run_in(queue, lambda _facts: fail(trouble), told.then, told.failed)
    qtbot.waitUntil(lambda: not task.is_running)
    assert told.errors == [trouble]
    with qtbot.captureExceptions() as raised:  # a fault of ours
        task.run_in(queue, lambda _facts: fail(KeyError("ours")), told.then, told.failed)
        qtbot.waitUntil(lambda: not task.is_running)
    assert [kind for kind, _error, _trace in raised] == [KeyError]
    assert told.errors == [trouble]
    queue.close(PATIENCE_S)


def test_after_a_stall_no_batch_is_lost_and_there_is_one_a_conversation(qtbot: QtBot, qapp: QApplication) -> None:
    bridge, came, count = Bridge(), list[Batch](), 5000
    bridge.batch.connect(came.append)
    ended = Ended(EndReason.SILENT, 2.0)
    first, second = ConversationView(number=1), ConversationView(number=2)

    def deliver() -> None:
        bridge.deliver(Batch(-2.0, Connection(), first, None))
        bridge.deliver(Batch(-1.0, Connection(), first._replace(ended=ended), None, events=(ended,)))
        for number in range(count):
            bridge.deliver(Batch(float(number), Connection(), second, None, (number,), (number,)))  # type: ignore[arg-type]

    thread = threading.Thread(target=deliver)
    thread.start()
    thread.join()  # the window's thread stands still all the while
    assert came == []
    qtbot.waitUntil(lambda: bool(came) and came[-1].at == count - 1)
    assert [batch.conversation.number for batch in came] == [1, 2]
    assert came[0].conversation.ended is ended
    assert [event for one in came for event in one.events] == [ended, *range(count)]
    assert [sample for one in came for sample in one.samples] == list(range(count))
    bridge.close()
    bridge.deliver(came[0])
    qapp.processEvents()
    assert len(came) == 2


@pytest.fixture
def enabled() -> Iterator[None]:
    """Python collects by itself, as it does outside of tests."""
    gc.collect()
    gc.enable()
    yield
    gc.disable()


def test_a_worker_frees_nothing(qtbot: QtBot, enabled: None) -> None:
    freed_in, made = list[int](), list[list[int]]()
    worker = threading.Thread(target=lambda: made.extend([number] for number in range(20 * gc.get_threshold()[0])))
    with garbage_freed_here():
        ring = Told()
        vars(ring)["itself"] = ring  # only the collector can free it
        weakref.finalize(ring, lambda: freed_in.append(threading.get_ident())).atexit = False
        del ring
        worker.start()  # makes so many objects that Python would begin to collect, several times
        worker.join()
        assert not freed_in
        qtbot.waitUntil(lambda: bool(freed_in))
    assert freed_in == [threading.get_ident()]


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


def reading() -> Procedure[int]:
    yield Report(1, 5, "Reading: {what}", (("what", "Deploy delay"),))
    yield Pause(1.0)
    return 7


def test_progress_is_said_until_it_ends(one: Rig) -> None:
    job, ended = PageJob(module=one.port.module), list[Job[int]]()
    job.notify(Meaning.GOOD, "before")
    with one.qtbot.waitSignal(job.changed):
        job.run(reading(), ended.append)
    one.wait(0.5)
    assert not job.can_run
    (notice,) = job.notices
    assert (notice.meaning, notice.text) == (Meaning.INFORMATION, "Reading: Deploy delay (2 of 5)")
    assert [choice.key for choice in notice.choices] == ["cancel"]
    one.wait(1.0)
    assert [one.outcome() for one in ended] == [7]
    assert job.can_run
    assert job.notices == []


@pytest.mark.module("logs", is_connected=False)
def test_trouble_with_files_outlives_another_module(one: Rig) -> None:
    result = one.find(LogsPage).result
    result.notify(Meaning.ATTENTION, "Not saved")
    one.assembly.ports.shown.emit(one.port.module)
    assert result.notices != []


def test_what_a_person_has_to_act_on_outlives_the_page(qtbot: QtBot) -> None:
    job = PageJob()
    for meaning, stays in ((Meaning.GOOD, False), (Meaning.INFORMATION, False), (Meaning.ATTENTION, True)):
        job.notify(meaning, "said")
        job.end(is_page_left=True)
        assert (job.notices != []) is stays, meaning
    job.end(is_page_left=False)  # another module
    assert job.notices == []


def test_the_end_of_one_that_was_replaced_or_forgotten_is_told_nobody(one: Rig) -> None:
    job, ended = PageJob(module=one.port.module), list[str]()
    job.run(reading(), lambda _job: ended.append("replaced"))
    one.wait(0.5)
    job.run(reading(), lambda _job: ended.append("the next"))
    one.wait(0.8)
    assert (ended, job.is_running) == ([], True)
    one.wait(1.0)
    assert ended == ["the next"]
    job.run(reading(), lambda _job: ended.append("forgotten"))
    job.drop()
    one.wait(2.0)
    assert (ended, job.progress) == (["the next"], None)


def test_what_two_files_written_at_once_came_to_is_said_of_both(qtbot: QtBot) -> None:
    job, first, second = PageJob(), threading.Event(), threading.Event()

    def fail() -> None:
        first.wait(PATIENCE_S)
        raise OSError(28, "No space left on device")

    def shown() -> list[str]:
        return [one.text for one in job.notices]

    job.write_file(Path("M-12.pdf"), partial(second.wait, PATIENCE_S), lambda _true: "Saved to M-12.pdf.")
    job.write_file(Path("M-07.pdf"), fail, lambda _none: "")
    assert shown() == ["Saving…", "Saving…"]
    second.set()
    qtbot.wait_until(lambda: shown() == ["Saving…", "Saved to M-12.pdf."])
    first.set()
    qtbot.wait_until(lambda: not job.is_busy)
    lost = "M-07.pdf cannot be written: No space left on device."
    assert shown() == [lost, "Saved to M-12.pdf."], "the gravest first"
    given(job.notices[0].dismiss)()
    assert shown() == ["Saved to M-12.pdf."]
    job.write_file(Path("M-12.pdf"), lambda: None, lambda _none: "Saved once more.")
    qtbot.wait_until(lambda: not job.is_busy)
    assert shown() == ["Saved once more."]


def test_work_in_turns_lets_others_come_between(qtbot: QtBot, qapp: QApplication) -> None:
    """A step that fails ends nothing but itself, and other steps end those before them."""
    seen: list[str] = []
    turns = Turns(qapp)

    def long(name: str) -> None:
        seen.append(name)
        QTimer.singleShot(0, qapp, lambda: seen.append("another event"))
        threading.Event().wait(0.02)

    def fail() -> None:
        raise LookupError("of a step")

    with qtbot.capture_exceptions() as raised:
        turns.take([partial(long, "first"), fail, partial(long, "last")])
        qtbot.waitUntil(lambda: not turns.isActive())
    assert [str(error) for _kind, error, _trace in raised] == ["of a step"]
    assert seen == ["first", "another event", "last", "another event"]
    turns.take([partial(turns.take, [partial(long, "other")]), partial(long, "never")])
    qtbot.waitUntil(lambda: not turns.isActive())
    assert "other" in seen
    assert "never" not in seen


def test_a_package_is_imported_in_steps_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(tmp_path))
    for name, code in (("whole_one", "first = 1\nfrom . import part\n"), ("broken_one", "import nowhere\nlast = 1\n")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text(code, encoding="utf-8")
        (tmp_path / name / "part.py").touch()
    steps = list(importing("whole_one"))
    assert len(steps) == 2
    for step in steps:
        step()
    whole = sys.modules.pop("whole_one")
    assert (whole.first, whole.part) == (1, sys.modules.pop("whole_one.part"))
    fails, passes = importing("broken_one")
    with pytest.raises(ModuleNotFoundError, match="nowhere"):
        fails()
    passes()
    assert "broken_one" not in sys.modules
