"""A page and its one procedure on the module: progress, cancel, its end, what is said; the storage of the pages."""

import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.procedure import Job, Pause, Procedure, Report
from tests.support.patience import PATIENCE_S
from tests.support.window.fake_ports import ports_alone
from tests.support.window.fakes_ui import page_entries, window
from tests.support.window.steps import find, given
from ui.pages.logs.page import LogsPage
from ui.session.page_job import PageJob
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Notice


class Line:
    """A job on a module that answers; `end` says what came of what it began, the last one by default."""

    def __init__(self) -> None:
        self.ports = ports_alone()
        self.port, self.worker = self.ports.plug_in("/dev/one")
        QApplication.processEvents()
        self.job = PageJob(module=self.port.module)

    @property
    def jobs(self) -> list[Job[Any]]:
        return [job for job in self.worker.wanted(is_urgent=False) if job.conversation is not None]

    def begin(self, then: Callable[[Job[int]], None]) -> None:
        self.job.run(reading(), then)
        self.jobs[-1].start(0.0)

    def end(self, number: int = -1) -> None:
        self.worker.finish(self.jobs[number], 7)
        QApplication.processEvents()


@pytest.fixture
def line(qapp: QApplication) -> Iterator[Line]:
    made = Line()
    yield made
    made.ports.stop()


def reading() -> Procedure[int]:
    yield Report(1, 5, "Reading: {what}", (("what", "Deploy delay"),))
    yield Pause(1.0)
    return 7


def test_progress_is_said_until_it_ends(qtbot: QtBot, line: Line) -> None:
    job, ended = line.job, list[Job[int]]()
    job.notify(Meaning.GOOD, "before")
    with qtbot.waitSignal(job.changed):
        line.begin(ended.append)
    assert not job.can_run
    notice = given(job.notice("Asking"))
    assert (notice.meaning, notice.text) == (Meaning.INFORMATION, "Reading: Deploy delay (2 of 5)")
    assert [choice.key for choice in notice.choices] == ["cancel"]
    assert (job.notice("Asking", can_cancel=False) or notice).choices == ()
    line.end()
    assert [one.outcome() for one in ended] == [7]
    assert job.can_run
    assert job.notice("Asking") is None


def test_trouble_with_files_outlives_another_module(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=page_entries("logs")) as assembly:
        qtbot.waitUntil(lambda: assembly.window.has_pages)
        page = find(assembly.window, LogsPage)
        page.result.notify(Meaning.ATTENTION, "Not saved")
        assembly.ports.shown.emit(assembly.ports.module)
        assert page.result.result_notice() is not None


def test_what_a_person_has_to_act_on_outlives_the_page(line: Line) -> None:
    job = line.job
    for meaning, stays in ((Meaning.GOOD, False), (Meaning.INFORMATION, False), (Meaning.ATTENTION, True)):
        job.notify(meaning, "said")
        job.end(is_page_left=True)
        assert (job.result_notice() is not None) is stays, meaning
    job.end(is_page_left=False)  # another module
    assert job.result_notice() is None


def test_the_end_of_one_that_was_replaced_or_forgotten_is_told_nobody(line: Line) -> None:
    ended = list[Job[int]]()
    line.begin(ended.append)
    line.begin(ended.append)
    line.end(0)
    assert ended == []
    assert line.job.is_running
    line.end(1)
    assert len(ended) == 1
    line.begin(ended.append)
    line.job.drop()
    line.end()
    assert (len(ended), line.job.progress) == (1, None)


def test_what_two_files_written_at_once_came_to_is_said_of_both(qtbot: QtBot) -> None:
    notice, first, second = PageJob(), threading.Event(), threading.Event()

    def fail() -> None:
        first.wait(PATIENCE_S)
        raise OSError(28, "No space left on device")

    def shown() -> Notice:
        return given(notice.result_notice())

    notice.write_file(Path("M-07.pdf"), fail, lambda _none: "")
    notice.write_file(Path("M-12.pdf"), partial(second.wait, PATIENCE_S), lambda _true: "Saved to M-12.pdf.")
    first.set()
    qtbot.wait_until(lambda: bool(notice._outcomes))
    assert (notice.is_writing, shown().text) == (True, "Saving…")
    second.set()
    qtbot.wait_until(lambda: not notice.is_writing)
    assert shown().meaning is Meaning.DANGER
    assert shown().text == "M-07.pdf cannot be written: No space left on device. Saved to M-12.pdf."
    notice.write_file(Path("M-12.pdf"), lambda: None, lambda _none: "Saved once more.")
    qtbot.wait_until(lambda: not notice.is_writing)
    assert (shown().meaning, shown().text) == (Meaning.GOOD, "Saved once more.")
