"""The Logs page: reading, sides, map, proposal, use of thresholds, one log."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.flights.flight_log import FlightLog
from app.flights.judge import TriggerLimits
from app.flights.judging import FlightGroup, summarise
from app.flights.read_log import SummarisedLog
from tests.support.flights.made_flights import crash, made_flight, ordinary_flight, write_csv, write_logs
from tests.support.window.fakes_ui import page_entries, window
from tests.support.window.steps import await_child, drop, given, let_lay_out, notice_text, press
from ui.main import Assembly
from ui.pages.logs import work as work_module
from ui.pages.logs.page import LogsPage
from ui.pages.logs.rows import LogColumn
from ui.pages.logs.work import LogFile, LogRow

UNSORTED, MUST_NOT, MUST = FlightGroup


@dataclass
class Desk:
    qtbot: QtBot
    assembly: Assembly
    page: LogsPage

    def add(self, *logs: FlightLog, group: FlightGroup = MUST_NOT) -> None:
        """Adds flights as if they had been read."""
        self.page.work.logs |= {log.name: LogFile(log.name, flight=summarise(log)) for log in logs}
        self.page.work.move([one.name for one in logs], group)
        self.wait_proposal()

    def open(self, *paths: Path) -> None:
        self.page.open_files(paths)
        self.wait_read()

    def wait_proposal(self) -> None:
        self.qtbot.waitUntil(lambda: not self.page.work.proposing.is_running)

    def wait_read(self) -> None:
        self.qtbot.waitUntil(lambda: not self.page.work.task.is_running)
        self.wait_proposal()

    def rows(self) -> tuple[LogRow, ...]:
        return self.page.table.filter.shown()

    def on(self, group: FlightGroup) -> list[str]:
        return sorted(row.name for row in self.rows() if row.log.group is group)

    def choose(self, *names: str) -> None:
        self.page.table.choose(lambda row: row.name in names)
        self.page.table.setFocus()

    def key(self, key: Qt.Key) -> None:
        self.qtbot.keyClick(self.page.table, key)

    def answers(self) -> dict[str, str]:
        shown = self.page.table.filter
        places = range(shown.rowCount())
        return {shown.row_at(row).name: str(shown.index(row, LogColumn.ANSWER).data()) for row in places}

    def notice(self) -> str:
        return notice_text(self.page.strip)

    def said(self) -> str:
        return self.page.proposal.head.text()


@contextmanager
def opened(qtbot: QtBot, qapp: QApplication, folder: Path) -> Iterator[Desk]:
    with window(qapp, folder, entries=page_entries("logs")) as assembly:
        page = await_child(qtbot, assembly.window, LogsPage)
        assembly.window.panel.hide()
        yield Desk(qtbot, assembly, page)


@pytest.fixture
def desk(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    with opened(qtbot, qapp, tmp_path) as one:
        yield one


def tilted(name: str, tilt_deg: float, seconds: float = 2.0) -> FlightLog:
    """Level, tilted for a while, level; an acceleration of 1 g."""
    tilt = np.concatenate([np.zeros(100), np.full(round(seconds * 50), tilt_deg), np.zeros(100)])
    return made_flight(tilt, 1.0, name=name)


# Reading


def test_a_folder_is_read_and_a_table_asks_for_its_columns_in_one_line(desk: Desk, tmp_path: Path) -> None:
    page = desk.page
    assert page.list.empty.isVisible()
    paths = write_logs(tmp_path / "logs")
    desk.open(tmp_path / "logs")
    assert desk.on(UNSORTED) == sorted(map(str, paths))
    assert page.work.proposal is None  # only a person knows which of them crashed
    (unread,) = page.work.unread()
    assert "1 of 3 not read." in desk.notice()
    assert "t1.csv: No column is known to hold the time." in desk.notice()
    desk.choose(unread.name)
    desk.key(Qt.Key.Key_Return)
    view = page.view
    assert "(columns: w, a, g, h)" in view.verdict.text()
    assert view.line.text() == "time_s=w"  # as it would be typed on the command line
    for line, fault in (
        ("speed=w", "“speed=w”: ROLE=COLUMN is needed"),
        ("time_s=w time_ms=w", "Choose one column for “time”."),
    ):
        view.line.setText(line)
        view.read.click()
        assert view.fault.text().startswith(fault)
    view.line.setText("time_s=w")
    desk.qtbot.keyClick(view.line, Qt.Key.Key_Return)
    desk.wait_read()
    assert view.line.text().startswith("time_s=w tilt_deg=")  # what was said before stays
    view.line.setText("--column time_s=w tilt_deg=a 'acceleration_g=g'")
    view.read.click()
    desk.wait_read()
    assert page.work.unread() == []
    desk.qtbot.waitUntil(lambda: view.plot is not None)  # it is shown, now that it can be
    assert page.on_escape()
    assert desk.notice() == ""


def test_each_dropped_file_that_cannot_be_read_is_named_and_nothing_is_proposed_without_it(
    desk: Desk, tmp_path: Path
) -> None:
    single = write_csv(tmp_path / "single.csv", tilted("", 20))
    (tmp_path / "race.bbl").write_bytes(b"H Product:Blackbox flight data recorder\n")
    (tmp_path / "page.ulg").write_bytes(b"<html><body>not found</body></html>")
    desk.assembly.window.panel.show()
    assert drop(desk.assembly.window, single, tmp_path / "race.bbl", tmp_path / "page.ulg")
    desk.wait_read()
    assert desk.page.isVisible()
    assert "2 of 3 not read." in desk.notice()
    assert "race.bbl: This is a Betaflight or INAV blackbox log" in desk.notice()
    assert "page.ulg: This is a web page" in desk.notice()
    desk.page.work.move([str(single)], MUST_NOT)
    desk.wait_proposal()
    assert desk.said() == "No proposal: 2 of 3 not read"
    desk.choose(str(tmp_path / "race.bbl"), str(tmp_path / "page.ulg"))
    desk.key(Qt.Key.Key_Delete)
    desk.wait_proposal()
    assert desk.said() == "The vendor's defaults hold: they fire in 0 of 1"


def test_cancel_is_immediate_and_late_results_change_nothing(
    desk: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reading blocks in the middle of a log and ignores a cancellation."""
    may_end, has_begun, has_ended = threading.Event(), threading.Event(), threading.Event()
    paths = [write_csv(tmp_path / f"{number}.csv", tilted("", 20)) for number in range(3)]

    def slowly(logs: list[Path], _order: object, **_told: object) -> Iterator[SummarisedLog]:
        yield SummarisedLog(logs[0], summarise(tilted(str(logs[0]), 20)))
        has_begun.set()
        assert may_end.wait(30)
        yield SummarisedLog(logs[1], summarise(tilted(str(logs[1]), 20)))
        has_ended.set()

    monkeypatch.setattr(work_module, "summarise_logs", slowly)
    desk.page.open_files(paths)
    assert has_begun.wait(30)
    desk.qtbot.waitUntil(lambda: desk.notice() == "Reading logs… (1 of 3)")
    desk.page.open_files([write_csv(tmp_path / "waits.csv", tilted("", 20))])
    press(desk.qtbot, desk.page.strip.button("cancel_logs"))  # without waiting
    assert desk.notice() == "Cancelled. 1 of 3 logs"
    assert desk.on(UNSORTED) == [str(paths[0])]
    may_end.set()
    assert has_ended.wait(30)
    QApplication.processEvents()
    desk.page.work.poll()
    assert desk.on(UNSORTED) == [str(paths[0])]


# Sides and proposal


def test_logs_change_sides_by_button_and_key(desk: Desk) -> None:
    desk.add(tilted("a", 20), tilted("b", 30))
    desk.choose("a")
    desk.page.moving[1].trigger()
    assert (desk.on(MUST_NOT), desk.on(MUST)) == (["b"], ["a"])
    desk.key(Qt.Key.Key_N)
    assert desk.on(MUST_NOT) == ["a", "b"]
    desk.choose("a", "b")
    assert not desk.page.opening.isEnabled()
    desk.key(Qt.Key.Key_M)
    assert desk.on(MUST) == ["a", "b"]
    desk.choose("b")
    desk.key(Qt.Key.Key_U)
    assert (desk.on(UNSORTED), desk.on(MUST)) == (["b"], ["a"])
    desk.key(Qt.Key.Key_Delete)
    assert [row.name for row in desk.rows()] == ["a"]
    desk.wait_proposal()


def test_logs_of_one_side_propose_nothing(desk: Desk) -> None:
    """A crash that nobody has sorted yet must not raise the thresholds: it once proposed 89°."""
    proposal, work = desk.page.proposal, desk.page.work
    desk.add(tilted("calm", 20), tilted("crash", 88))
    assert desk.said() == "The vendor's defaults fire in 1 of 2"
    assert "crash: did it crash? Then it must fire." in proposal.lines.text()
    assert not proposal.take.isEnabled()
    work.move(["calm"], UNSORTED)
    work.move(["crash"], MUST)
    desk.wait_proposal()
    assert desk.said() == "The vendor's defaults fire in all 1"
    desk.add(tilted("rolls", 120))
    assert desk.said() == "No thresholds separate the sides"
    assert proposal.lines.text().startswith("False trigger: rolls")
    assert not proposal.take.isEnabled()


def test_the_proposal_separates_and_is_tried(desk: Desk) -> None:
    random = np.random.default_rng(1)
    desk.add(*(ordinary_flight(f"survey {number}", random, seconds=30) for number in range(3)))
    desk.add(*(crash(f"crash {number}", random, seconds=20) for number in range(2)), group=MUST)
    page, limits = desk.page, given(given(desk.page.work.proposal).limits)
    assert desk.said().startswith("Proposal: ")
    lines = page.proposal.lines.text()
    assert [line.partition(":")[0] for line in lines.split("\n")[:2]] == ["Must not fire", "Must fire"]
    assert "55° to 80°, 0.3 g to 0.6 g, 0.50 s to 2.00 s" in lines
    page.work.choose(TriggerLimits(attitude_threshold_deg=30))
    page.proposal.take.click()
    assert page.work.limits == limits
    assert page.counts.text() == "Must not fire: 0 of 3 fire · Must fire: 2 of 2 fire in time"
    assert not page.proposal.take.isEnabled()
    page.work.choose(TriggerLimits(attitude_threshold_deg=30))
    assert page.proposal.take.isEnabled()


# Thresholds and map


def test_map_and_list_follow_a_threshold(desk: Desk) -> None:
    desk.add(tilted("calm", 20), tilted("turn", 50))
    page = desk.page
    assert page.counts.text() == "Must not fire: 0 of 2 fire"
    page.proposal._exchange.can_use = lambda: True
    page.thresholds.tilt.box.selectAll()
    desk.qtbot.keyClicks(page.thresholds.tilt.box, "45")
    assert page.work.limits.attitude_threshold_deg == 45
    assert page.proposal.use.isEnabled()
    desk.qtbot.keyClicks(page.thresholds.tilt.box, "0")  # 450°
    assert (page.thresholds.tilt.box.text(), page.work.limits.attitude_threshold_deg) == ("450", 45)
    assert not page.proposal.use.isEnabled()
    desk.qtbot.keyClick(page.thresholds.tilt.box, Qt.Key.Key_Backspace)
    assert page.counts.text() == "Must not fire: 1 of 2 fire"
    assert desk.answers() == {"calm": "no", "turn": "2.0 s"}
    let_lay_out(page)
    assert "1 of 2" in page.map.accessibleName()
    assert "45°" in page.map.accessibleName()
    page.table.sortByColumn(LogColumn.ANSWER, Qt.SortOrder.AscendingOrder)
    assert [row.name for row in desk.rows()] == ["turn", "calm"]  # what is not as expected comes first
    page.thresholds.tilt.slider.setValue(60)
    assert [line.value() for line in page.map.cross[2:]] == [60, page.work.limits.freefall_time_s]
    rows = page.map.image.image[:, -1]  # lowest tilt first: 50° fires up to a threshold of 50°, not above it
    assert (rows[0] == rows[len(rows) // 5]).all()
    assert (rows[0] != rows[len(rows) // 2]).any()


def test_the_map_is_dragged_and_has_keys(desk: Desk) -> None:
    desk.add(tilted("turn", 50))
    page = desk.page
    place = page.map.view.mapViewToScene(QPointF(1.0, 40)).toPoint()
    desk.qtbot.mouseClick(page.map, Qt.MouseButton.LeftButton, pos=place)
    limits = page.work.limits
    assert abs(limits.attitude_threshold_deg - 40) <= 1
    assert abs(limits.freefall_time_s - 1.0) <= 0.05
    assert page.thresholds.time.value == pytest.approx(limits.freefall_time_s)
    page.work.choose(TriggerLimits())
    for key in (Qt.Key.Key_Up, Qt.Key.Key_PageDown, Qt.Key.Key_Right):
        desk.qtbot.keyClick(page.map, key)
    assert (page.work.limits.attitude_threshold_deg, page.work.limits.freefall_time_s) == (51, 1.65)
    desk.qtbot.mouseClick(page.map, Qt.MouseButton.LeftButton, pos=QPoint(-500, 5000))
    page.map.choose_at(QPointF(-500, 5000))
    assert (page.work.limits.attitude_threshold_deg, page.work.limits.freefall_time_s) == (30, 0.2)


def test_each_answer_has_its_word(desk: Desk) -> None:
    late = tilted("late", 5)
    late.specific_force_g[100:103] = 9.0
    late.tilt_deg[150:] = 90.0
    unknown = tilted("tilt only", 20)
    unknown.specific_force_g[:] = np.nan
    desk.add(late, tilted("flies on", 20), group=MUST)
    desk.add(unknown, tilted("calm", 20), tilted("steep", 80))
    words = {"late": "too late", "flies on": "no", "tilt only": "not judged", "calm": "no", "steep": "2.0 s"}
    assert desk.answers() == words
    assert desk.page.counts.text() == "Must not fire: 1 of 3 fire · Must fire: 0 of 2 fire in time"


# One log


def test_a_single_file_is_shown_at_its_moment(desk: Desk, tmp_path: Path) -> None:
    path = write_csv(tmp_path / "crash.csv", crash("", np.random.default_rng(2), seconds=30))
    page, view = desk.page, desk.page.view
    desk.open(path)
    desk.qtbot.waitUntil(lambda: view.plot is not None)
    plot, outcome = given(view.plot), given(desk.rows()[0].outcome)
    assert "after the loss of control" in view.verdict.text()
    assert plot.time_range.cursor_s == pytest.approx(outcome.at_s, abs=0.05)
    assert plot.time_range.span.start_s < outcome.at_s < plot.time_range.span.end_s
    assert {mark.word for mark in plot.canvas.marks} >= {"control lost (estimate)", "impact"}
    assert page.on_escape()
    assert view.plot is None
    assert page.map.isVisible()
    path.unlink()
    page.open_row(desk.rows()[0])
    desk.qtbot.waitUntil(lambda: "No such file" in view.verdict.text())


# Use of thresholds


@pytest.mark.promise("i")
def test_thresholds_go_to_settings_as_edits(desk: Desk) -> None:
    exchange, page = desk.page.proposal._exchange, desk.page
    desk.add(tilted("turn", 50))
    page.proposal.refresh()
    assert not page.proposal.use.isEnabled()  # there is no module to write to
    exchange.can_use = lambda: True
    page.proposal.refresh()
    used: list[object] = []
    wanted: list[str] = []
    exchange.used.connect(used.append)
    page.page_wanted.connect(wanted.append)
    page.work.choose(TriggerLimits(62, 0.4, 1.25))
    page.proposal.use.click()
    assert used == [
        {"attitude_threshold_deg": 62, "freefall_acceleration_g": 0.4, "freefall_time_s": 1.25},
    ]
    assert wanted == ["settings"]
