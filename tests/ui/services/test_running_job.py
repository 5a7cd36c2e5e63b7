"""A page and its one procedure on the module: progress, cancel, its end, what is said; the storage of the pages."""

import threading
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, cast
from unittest.mock import Mock

import pytest
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.procedure import Cancelled, Procedure, Report
from app.engine.snapshots import Snapshot
from app.engine.worker import Job
from app.recordings.export import Exported
from app.recordings.library import RecordingEntry
from app.store.fact_store import Store
from app.store.trouble import StoreTrouble
from tests.support.patience import PATIENCE_S
from tests.support.window.fakes_ui import WAIT_MS, page_entries, store_of, window
from tests.support.window.steps import find, given
from ui.pages.flights.page import FlightsPage
from ui.services.job_notice import JobNotice
from ui.services.recording_jobs import ExportKind, RecordingJobs
from ui.services.storage import Storage
from ui.session.ports import Ports
from ui.session.running_job import RunningJob
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


class Line(QObject):
    """In place of the connector: runs what it is given when the test says so."""

    invalidated = Signal()
    is_open = is_requested = True

    def __init__(self) -> None:
        super().__init__()
        self.current = self
        self.jobs: list[tuple[Job[Any], Callable[[Job[Any]], None]]] = []

    def run(self, procedure: Procedure[Any], then: Callable[[Job[Any]], None], **more: Any) -> Job[Any]:
        job = Job(procedure, more["on_progress"])
        self.jobs.append((job, then))
        job.run.start(0.0)
        return job

    def end(self, number: int = -1) -> None:
        job, then = self.jobs[number]
        then(job)


def reading() -> Procedure[int]:
    yield Report(1, 5, "Reading: {what}", (("what", "Deploy delay"),))
    return 7


def made() -> tuple[RunningJob, Line, list[Job[int]]]:
    line = Line()
    return RunningJob(cast("Ports", line)), line, []


def test_progress_is_said_until_it_ends(qtbot: QtBot) -> None:
    job, line, ended = made()
    job.notify(Meaning.GOOD, "before")
    with qtbot.waitSignal(job.changed):
        job.run(reading(), ended.append)
    assert not job.can_run
    notice = given(job.notice("Asking"))
    assert (notice.meaning, notice.text) == (Meaning.INFORMATION, "Reading: Deploy delay (2 of 5)")
    assert [choice.key for choice in notice.choices] == ["cancel"]
    assert (job.notice("Asking", can_cancel=False) or notice).choices == ()
    with qtbot.waitSignal(job.changed):
        line.end()
    assert [one.outcome() for one in ended] == [7]
    assert job.can_run
    assert job.notice("Asking") is None


def test_trouble_with_files_outlives_another_module(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=page_entries("recordings", "flights")) as assembly:
        qtbot.waitUntil(lambda: assembly.window._maker.is_done)
        flights = find(assembly.window, FlightsPage)
        for notice in (assembly.storage.recordings, flights.result):
            notice.notify(Meaning.ATTENTION, "Not saved")
            assembly.ports.invalidated.emit()
            assert notice.result_notice() is not None


def test_what_offers_no_choice_can_be_closed(qtbot: QtBot) -> None:
    job, _line, _ended = made()
    choice = Choice("again", "Again", job.dismiss)
    job.set_notice(Notice(Meaning.ATTENTION, "Restarted", (choice,)))
    asked = given(job.notice("Asking"))
    assert asked.dismiss is None  # a question is answered
    job.set_notice(Notice(Meaning.DANGER, "Link lost"))
    told = given(job.notice("Asking"))
    given(told.dismiss)()
    assert job.notice("Asking") is None


def test_what_is_said_at_its_end_stands_until_it_is_closed(qtbot: QtBot) -> None:
    job, line, _ended = made()
    job.run(reading(), lambda _job: job.notify(Meaning.GOOD, "done"))
    line.end()
    notice = given(job.notice("Asking"))
    assert (notice.meaning, notice.text) == (Meaning.GOOD, "done")
    given(notice.dismiss)()
    assert job.notice("Asking") is None


def test_the_end_of_one_that_was_replaced_or_forgotten_is_told_nobody(qtbot: QtBot) -> None:
    job, line, ended = made()
    job.run(reading(), ended.append)
    job.run(reading(), ended.append)
    line.end(0)
    assert ended == []
    assert job.is_running
    line.end(1)
    assert len(ended) == 1
    job.run(reading(), ended.append)
    job.drop()
    line.end()
    assert (len(ended), job.progress) == (1, None)


def test_it_can_be_cancelled(qtbot: QtBot) -> None:
    job, line, ended = made()
    job.cancel()  # nothing runs: nothing happens
    job.run(reading(), ended.append)
    notice = job.notice("Asking")
    assert isinstance(notice, Notice)
    notice.choices[0].act()
    assert line.jobs[0][0].run.is_cancelled
    line.jobs[0][0].run.error = Cancelled()
    line.end()
    assert isinstance(ended[0].run.error, Cancelled)


def test_what_a_cancelled_job_has_written_is_said(
    qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Deleting ends before the next one; an export was whole before it learned that it is cancelled."""
    begun, may_go_on, deleted = threading.Event(), threading.Event(), list[object]()
    jobs = RecordingJobs(tmp_path)

    def held(*_asked: object, **_more: object) -> Exported:
        begun.set()
        may_go_on.wait(WAIT_MS / 1000)
        return Exported(3, None)

    monkeypatch.setattr("app.recordings.export.export", held)
    monkeypatch.setattr(jobs.library, "delete", lambda entry: deleted.append((entry, held())))
    entry, path = cast("RecordingEntry", Mock()), tmp_path / "all.csv"
    for act, said in (
        (lambda: jobs.delete([entry, entry]), "Recordings deleted: 1."),
        (lambda: jobs.export(entry, path, ExportKind.CSV), f"Saved to {path}. Rows: 3."),
    ):
        act()
        assert begun.wait(WAIT_MS / 1000)
        asked = given(jobs.notice())
        asked.choices[0].act()
        may_go_on.set()
        qtbot.waitUntil(lambda: not jobs.is_busy)
        told = given(jobs.notice())
        assert told.text == said
        begun.clear()
        may_go_on.clear()
    assert len(deleted) == 1
    assert jobs._listing.wait(PATIENCE_S)  # else its thread would free the last of these objects
    jobs.stop()


SNAPSHOT = Snapshot(settings={"attitude_threshold_deg": 60})


def test_a_closed_storage_opens_no_store_again(tmp_path: Path) -> None:
    """Work that is under way while the window closes would open it, and nobody would close it."""
    storage = Storage(tmp_path)
    store_of(storage)
    kept = given(storage.store_snapshot(SNAPSHOT, "/dev/ttyUSB0"))
    storage.close()
    assert kept.result(0).kind
    assert isinstance(storage.store, StoreTrouble)
    assert storage.store_snapshot(SNAPSHOT, "/dev/ttyUSB0") is None
    assert not isinstance(storage.store, Store)
    storage.close()


def test_what_two_files_written_at_once_came_to_is_said_of_both(qtbot: QtBot) -> None:
    notice, first, second = JobNotice(), threading.Event(), threading.Event()

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
