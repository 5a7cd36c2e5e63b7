"""The Logs page: reading, sides, map, proposal, use of thresholds, one log; recordings shown, exported, deleted."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from shutil import copyfile

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.flights.flight_log import FlightLog
from app.flights.judge import TriggerLimits
from app.flights.judging import FlightGroup, FlightSummary
from app.flights.read_log import SummarisedLog
from app.recordings.library import RecordingEntry, RecordingLibrary
from tests.files.recordings.test_damage import chunks_in
from tests.support.flights.made_flights import crash, made_flight, ordinary_flight, write_csv, write_logs
from tests.support.records.recordings_made import NOON, batch, recorder_in, report, talk, write_session
from tests.support.window.controls import moved, places
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import connect, page_entries, simulated, window
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import choosing, find, given, let_lay_out, notice_text, press
from ui.pages.live.page import LivePage
from ui.pages.logs import rows as work_module
from ui.pages.logs.page import LogsPage
from ui.pages.logs.rows import COLUMNS, LogColumn, LogFile, LogRow
from ui.plots.lanes import Span
from ui.services.storage import Storage
from ui.style.theme import Meaning

UNSORTED, MUST_NOT, MUST = FlightGroup


@dataclass
class Desk(Rig):
    """The page, without a port."""

    @property
    def page(self) -> LogsPage:
        return self.find(LogsPage)

    @property
    def storage(self) -> Storage:
        return self.assembly.storage

    def add(self, *logs: FlightLog, group: FlightGroup = MUST_NOT) -> None:
        """Adds flights as if they had been read."""
        self.page.work.logs |= {log.name: LogFile(log.name, flight=FlightSummary(log)) for log in logs}
        self.page.work.move([one.name for one in logs], group)
        self.wait_read()

    def open(self, *paths: Path) -> None:
        self.page.open_files(paths)
        self.wait_read()

    def wait_read(self) -> None:
        page = self.page
        self.until(lambda: not page.result.is_busy and not page.work.proposing.is_running)

    def list_again(self, count: int) -> None:
        """Refresh the list of recordings; wait until there are `count` rows and nothing reads it any more."""
        self.page.work.list_again()
        self.until(lambda: self.page.table.filter.rowCount() == count and not self.page.work.listing.is_running)

    def rows(self) -> tuple[LogRow, ...]:
        return self.page.table.filter.shown()

    def on(self, group: FlightGroup) -> list[str]:
        return sorted(row.name for row in self.rows() if row.log.group is group)

    def choose(self, *names: str) -> None:
        self.page.table.choose(lambda row: row.name in names)
        self.page.table.setFocus()

    def key(self, key: Qt.Key) -> None:
        self.qtbot.keyClick(self.page.table, key)

    def texts(self, column: LogColumn) -> dict[str, str]:
        """By the name of the row."""
        shown = self.page.table.filter
        return {shown.row_at(row).name: str(shown.index(row, column).data()) for row in range(shown.rowCount())}

    def notice(self) -> str:
        return notice_text(self.page.strip)

    def said(self) -> str:
        return self.page.proposal.head.text()


@contextmanager
def desk_in(qtbot: QtBot, qapp: QApplication, folder: Path, *recordings: Path) -> Iterator[Desk]:
    with on_fake_time(Desk, qtbot, qapp, folder, "unused", page_entries("logs")) as desk:
        library = desk.storage.library.folder
        library.mkdir(parents=True)
        for path in recordings:
            copyfile(path, library / path.name)
        desk.window.panel.hide()
        desk.go_to("logs")
        desk.list_again(len(recordings))
        yield desk


@pytest.fixture
def desk(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    with desk_in(qtbot, qapp, tmp_path / "data") as one:
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
    assert "t1.csv: No column is known to hold the time." in desk.notice()
    desk.choose(unread.name)
    desk.key(Qt.Key.Key_Return)
    view = page.view
    assert "(columns: w, a, g, h)" in view.verdict.text()
    assert view.line.text() == "time_s=w"  # as it would be typed on the command line
    view.line.setText("time_s=w time_ms=w")
    view.read.click()
    assert view.fault.text() != ""
    view.line.setText("time_s=w")
    desk.qtbot.keyClick(view.line, Qt.Key.Key_Return)
    desk.wait_read()
    assert view.line.text().startswith("time_s=w tilt_deg=")  # what was said before stays
    view.line.setText("--column time_s=w tilt_deg=a 'acceleration_g=g'")
    view.read.click()
    desk.wait_read()
    assert page.work.unread() == []
    desk.until(lambda: view.plot is not None)  # it is shown, now that it can be
    assert page.on_escape()
    assert desk.notice() == ""


def test_each_file_that_cannot_be_read_is_named_and_nothing_is_proposed_without_it(desk: Desk, tmp_path: Path) -> None:
    single = write_csv(tmp_path / "single.csv", tilted("", 20))
    (tmp_path / "race.bbl").write_bytes(b"H Product:Blackbox flight data recorder\n")
    (tmp_path / "page.ulg").write_bytes(b"<html><body>not found</body></html>")
    desk.open(single, tmp_path / "race.bbl", tmp_path / "page.ulg")
    assert "2 of 3 not read." in desk.notice()
    assert "race.bbl: This is a Betaflight or INAV blackbox log" in desk.notice()
    assert "page.ulg: This is a web page" in desk.notice()
    desk.page.work.move([str(tmp_path / "race.bbl")], MUST)
    assert desk.said() == "No proposal: 2 of 3 not read"  # and not that logs have to be chosen
    desk.page.work.move([str(single)], MUST_NOT)
    desk.wait_read()
    assert desk.said() == "No proposal: 2 of 3 not read"
    desk.choose(str(tmp_path / "race.bbl"), str(tmp_path / "page.ulg"))
    desk.key(Qt.Key.Key_Delete)
    desk.wait_read()
    assert desk.said() == "No proposal: no log is on the side “must fire”."


def test_cancel_is_immediate_and_late_results_change_nothing(
    desk: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reading blocks in the middle of a log and ignores a cancellation."""
    may_end, has_begun, has_ended = threading.Event(), threading.Event(), threading.Event()
    paths = [write_csv(tmp_path / f"{number}.csv", tilted("", 20)) for number in range(3)]

    def slowly(path: Path, _columns: object) -> SummarisedLog:
        if path == paths[1]:
            has_begun.set()
            assert may_end.wait(30)
            has_ended.set()
        return SummarisedLog(path, FlightSummary(tilted(str(path), 20)))

    monkeypatch.setattr(work_module, "summarise_log", slowly)
    desk.page.open_files(paths)
    assert has_begun.wait(30)
    desk.until(lambda: desk.notice() == "Reading logs…: 33 %")
    press(desk.qtbot, desk.page.strip.button("cancel"))  # without waiting
    assert desk.notice() == "Cancelled."
    assert desk.on(UNSORTED) == [str(paths[0])]
    may_end.set()
    assert has_ended.wait(30)
    QApplication.processEvents()
    desk.page.work._take()
    assert desk.on(UNSORTED) == [str(paths[0])]


# Sides and proposal


def test_logs_change_sides_by_button_and_key(desk: Desk) -> None:
    desk.add(tilted("a", 20), tilted("b", 30))
    desk.choose("a")
    desk.page.action["to_must"].trigger()
    assert (desk.on(MUST_NOT), desk.on(MUST)) == (["b"], ["a"])
    desk.key(Qt.Key.Key_N)
    assert desk.on(MUST_NOT) == ["a", "b"]
    desk.choose("a", "b")
    assert not desk.page.action["open"].isEnabled()
    desk.key(Qt.Key.Key_M)
    assert desk.on(MUST) == ["a", "b"]
    desk.choose("b")
    desk.key(Qt.Key.Key_U)
    assert (desk.on(UNSORTED), desk.on(MUST)) == (["b"], ["a"])
    desk.key(Qt.Key.Key_Delete)
    assert [row.name for row in desk.rows()] == ["a"]
    desk.wait_read()


def test_logs_of_one_side_or_that_nothing_separates_propose_nothing(desk: Desk) -> None:
    """A crash that nobody has sorted yet must not raise the thresholds: it once proposed 89°."""
    proposal, work = desk.page.proposal, desk.page.work
    desk.add(tilted("calm", 20), tilted("crash", 88))
    assert desk.said() == "No proposal: no log is on the side “must fire”."
    assert not proposal.take.isEnabled()
    work.move(["crash"], MUST)
    desk.wait_read()
    desk.add(tilted("rolls", 120))
    assert desk.said() == "No thresholds separate the sides"
    assert proposal.lines.text().startswith("False trigger: rolls")
    assert not proposal.take.isEnabled()


def test_the_proposal_separates_and_is_tried(desk: Desk, tmp_path: Path) -> None:
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
    (tmp_path / "race.bbl").write_bytes(b"H Product:Blackbox flight data recorder\n")
    desk.open(tmp_path / "race.bbl")
    page.work.move([str(tmp_path / "race.bbl")], MUST)
    desk.wait_read()
    assert desk.said() == "No proposal: 1 of 6 not read"
    assert not page.proposal.take.isEnabled(), "that of the others says nothing of it"


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
    let_lay_out(page)
    before = places(page.thresholds)
    desk.qtbot.keyClicks(page.thresholds.tilt.box, "0")  # 450°
    let_lay_out(page)
    assert moved(before, places(page.thresholds)) == []  # no slider is squeezed
    assert page.thresholds.tilt.range.isVisible()
    assert not cut_off(page.thresholds)
    assert (page.thresholds.tilt.box.text(), page.work.limits.attitude_threshold_deg) == ("450", 45)
    assert not page.proposal.use.isEnabled()
    desk.qtbot.keyClick(page.thresholds.tilt.box, Qt.Key.Key_Backspace)
    assert page.counts.text() == "Must not fire: 1 of 2 fire"
    assert desk.texts(LogColumn.ANSWER) == {"calm": "no", "turn": "2.0 s"}
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
    assert rows[0][0] > rows[0][2], "red where it fires and must not"
    page.work.move(["turn"], MUST)
    desk.wait_read()
    never = page.map.image.image[-1, -1]
    assert never[2] > never[0], "blue where it must fire and does not"


def test_the_map_is_dragged(desk: Desk) -> None:
    desk.add(tilted("turn", 50))
    page = desk.page
    place = page.map.view.mapViewToScene(QPointF(1.0, 40)).toPoint()
    desk.qtbot.mouseClick(page.map, Qt.MouseButton.LeftButton, pos=place)
    limits = page.work.limits
    assert abs(limits.attitude_threshold_deg - 40) <= 1
    assert abs(limits.freefall_time_s - 1.0) <= 0.05
    assert page.thresholds.time.value == pytest.approx(limits.freefall_time_s)
    desk.qtbot.mouseClick(page.map, Qt.MouseButton.LeftButton, pos=QPoint(-500, 5000))
    page.map.choose_at(QPointF(-500, 5000))
    assert (page.work.limits.attitude_threshold_deg, page.work.limits.freefall_time_s) == (30, 0.2)


def test_each_answer_has_its_word_and_stands_out_where_it_is_wrong(desk: Desk) -> None:
    late = tilted("late", 5)
    late.specific_force_g[100:103] = 9.0
    late.tilt_deg[150:] = 90.0
    unknown = tilted("tilt only", 20)
    unknown.specific_force_g[:] = np.nan
    desk.add(late, tilted("flies on", 20), group=MUST)
    desk.add(unknown, tilted("calm", 20), tilted("steep", 80))
    words = {"late": "too late", "flies on": "no", "tilt only": "not judged", "calm": "no", "steep": "2.0 s"}
    assert desk.texts(LogColumn.ANSWER) == words
    inks = {row.name: COLUMNS[LogColumn.ANSWER].ink(row) for row in desk.rows()}
    wrong, doubtful = Meaning.DANGER, Meaning.ATTENTION
    assert inks == {"late": wrong, "flies on": wrong, "tilt only": doubtful, "calm": None, "steep": wrong}
    assert desk.page.counts.text() == "Must not fire: 1 of 3 fire · Must fire: 0 of 2 fire in time"


# One log


@pytest.mark.promise("g")
def test_a_single_file_is_read_again_where_it_has_changed_and_shown_at_its_moment(desk: Desk, tmp_path: Path) -> None:
    path = tmp_path / "flight.csv"
    page, view = desk.page, desk.page.view
    desk.open(write_csv(path, tilted("", 20)))
    assert desk.texts(LogColumn.ANSWER) == {str(path): "no"}
    assert page.on_escape()
    desk.open(write_csv(path, crash("", np.random.default_rng(2), seconds=30)))
    desk.until(lambda: view.plot is not None)
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
    desk.until(lambda: "No such file" in view.verdict.text())


# Use of thresholds


@pytest.mark.promise("i")
def test_thresholds_go_to_settings_as_edits(desk: Desk) -> None:
    exchange, page = desk.page.proposal._exchange, desk.page
    desk.add(tilted("turn", 50))
    for can_use in (False, True, False, True):  # there is a module to write to, or it is gone
        exchange.can_use = lambda can_use=can_use: can_use  # type: ignore[misc]
        page.module.changed.emit()
        assert page.proposal.use.isEnabled() is can_use
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


# Recordings


SECONDS = 120


def record(folder: Path, *, module: str = "Left wing", seconds: int = SECONDS) -> Path:
    """Record ten reports a second, tipped over for one second in the middle while active; return the folder."""
    with recorder_in(folder) as bench:
        bench.begin()
        bench.name(module)
        for second in range(seconds):
            start_s = 1000.0 + second
            is_tipped = second == seconds // 2
            samples = [
                report(start_s + n / 10, 75 if is_tipped else 10, triggered=is_tipped, active=second >= 30)
                for n in range(10)
            ]
            view = talk(start_s, cell_voltage_v=3.9, light_v=0.4, attitude_threshold_deg=60, light_threshold_v=1.8)
            bench.recorder.on_batch(batch(start_s + 0.95, *samples, view=view))
        bench.settle()  # it reads the clock, which moves on next
        bench.clock.now_s += seconds
        bench.finish()
        return bench.path


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recorded once."""
    return record(tmp_path_factory.mktemp("template"))


@pytest.fixture
def one(qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path) -> Iterator[Desk]:
    """With a single recording."""
    with desk_in(qtbot, qapp, tmp_path / "data", template) as desk:
        yield desk


def test_it_is_listed_and_searched_and_judged_on_a_side(one: Desk) -> None:
    record(one.storage.library.folder, module="", seconds=20)
    one.list_again(2)
    assert sorted(one.texts(LogColumn.NAME).values()) == ["Left wing", "ttyUSB0"]
    assert all(f"{NOON.astimezone():%m-%d %H:%M}" in text for text in one.texts(LogColumn.WHEN).values())
    one.choose(*(row.name for row in one.rows()))
    one.key(Qt.Key.Key_M)
    one.until(lambda: one.page.counts.text() == "Must fire: 2 of 2 fire in time")
    assert sorted(one.texts(LogColumn.ANSWER).values()) == ["10.0 s", "1:00.0"]
    one.wait_read()
    assert one.notice() == ""
    one.page.list.search.setText("left WING")
    assert [*one.texts(LogColumn.NAME).values()] == ["Left wing"]
    one.page.list.search.setText("nothing like it")
    assert one.page.list.no_match.isVisible()


@pytest.mark.promise("g")
def test_a_verdict_is_of_all_that_was_recorded(desk: Desk) -> None:
    """A recording that went on after it was read is read again once it has ended."""
    with recorder_in(desk.storage.library.folder) as bench:
        bench.record(*(batch(1000.0 + n / 10, report(1000.0 + n / 10, 5)) for n in range(30)))
        desk.list_again(1)
        desk.choose(*(row.name for row in desk.rows()))
        desk.key(Qt.Key.Key_N)
        desk.until(lambda: desk.page.counts.text() == "Must not fire: 0 of 1 fire")
        desk.wait_read()
        (flight,) = desk.page.work.side(MUST_NOT)
        assert [problem.in_english() for problem in flight.problems] == ["being recorded"]
        bench.feed(*(batch(1003.0 + n / 10, report(1003.0 + n / 10, 75)) for n in range(10)))
        desk.list_again(1)
        bench.finish()
    desk.list_again(1)
    desk.until(lambda: desk.page.counts.text() == "Must not fire: 1 of 1 fire")
    desk.wait_read()


@pytest.mark.promise("g")
def test_what_a_person_chose_stays_chosen_while_logs_are_read_and_when_that_ends(one: Desk, tmp_path: Path) -> None:
    """Else the next key would put another log on a side than the one that was meant."""
    record(one.storage.library.folder, seconds=2)
    one.list_again(2)
    first, second = (row.name for row in one.rows())
    one.choose(first)
    one.key(Qt.Key.Key_M)
    one.choose(second)
    one.wait_read()
    one.key(Qt.Key.Key_N)
    one.wait_read()
    assert (one.on(MUST), one.on(MUST_NOT)) == ([first], [second])
    one.page.open_files([write_csv(tmp_path / "calm.csv", tilted("", 20))])
    one.choose(second)
    one.wait_read()
    one.key(Qt.Key.Key_M)
    assert (one.on(MUST), len(one.on(UNSORTED))) == (sorted([first, second]), 1)
    one.wait_read()


def test_one_that_cannot_be_read_is_listed_with_its_reason_and_hinders_no_proposal(one: Desk) -> None:
    broken = record(one.storage.library.folder, seconds=2)
    broken.write_bytes(bytes(8) + broken.read_bytes()[8:])
    one.list_again(2)
    row = next(row for row in one.page.work.rows() if row.name == str(broken))
    assert one.page.work.unread() == []
    one.page.open_row(row)
    one.until(lambda: f"{broken.name} cannot be read" in one.page.view.verdict.text())
    assert one.page.view.plot is None


# One recording


def test_it_is_shown_whole_with_what_the_module_had(one: Desk) -> None:
    page, view = one.page, one.page.view
    page.open_row(page.work.rows()[0])
    one.until(lambda: view.plot is not None)
    plot = given(view.plot)
    assert view.name.text() == "Left wing"
    assert view.verdict.text() == "Fires at 1:00.0: attitude"
    assert "ttyUSB0" in view.details.text()
    assert "On the module: 60°" in view.details.text()
    assert [lane.lane.title for lane in plot.canvas.lanes] == ["Tilt", "Acceleration", "Light", "Cell voltage"]
    marks = {mark.word: mark.time_s for mark in plot.canvas.marks}
    assert marks.keys() >= {"connected", "named", "activated", "triggered", "trigger ended"}
    assert marks["fires"] == pytest.approx(1060.0)
    plot.time_range.show_instant(1060.5)
    for value in ("75°", "0.4 V", "3.90 V", f"{NOON.astimezone():%H}:01:00.5"):
        assert value in plot.reading
    plot.time_range.back_to_live()
    assert plot.time_range.span == pytest.approx(Span(1000.0, 1120.0), abs=1.0)


def test_a_trigger_is_marked_however_often_the_module_restarted_afterwards(desk: Desk, tmp_path: Path) -> None:
    notes = [(1001.0, {"event": "triggered"})]
    notes += [(1002.0 + n / 100, {"event": "restarted"}) for n in range(1200)]
    path = tmp_path / "restarts.mcap"
    write_session(path, (report(1000.0 + n / 10, active=True) for n in range(150)), notes)
    desk.open(path)
    desk.until(lambda: desk.page.view.plot is not None)
    assert "triggered" in {mark.word for mark in given(desk.page.view.plot).canvas.marks}


def test_opened_with_the_program_it_is_shown_while_a_module_goes_on(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path
) -> None:
    """From a folder of somebody else's; Live stays live, and LOCK works."""
    with simulated("beside", tilt=33), window(qapp, tmp_path, entries=page_entries("live", "logs")) as assembly:
        main = assembly.window
        qtbot.waitUntil(lambda: main.has_pages)
        live, page = find(main, LivePage), find(main, LogsPage)
        connect(qtbot, assembly, "sim://beside")
        qtbot.waitUntil(lambda: live.data.has_samples)
        main.files.open(template)
        qtbot.waitUntil(lambda: page.view.plot is not None)
        count = len(live.data.tilt)
        qtbot.waitUntil(lambda: len(live.data.tilt) > count + 3)
        assert main.top_bar.lock.isEnabled()
        page.on_escape()
        qtbot.waitUntil(lambda: any(row.entry is not None and row.entry.is_running for row in page.work.rows()))
        page.table.selectAll()
        assert not page.action["remove"].isEnabled()  # one of them is being written


# Exported, deleted


def test_it_is_exported_and_damage_is_said_there_and_where_it_is_shown(one: Desk, tmp_path: Path) -> None:
    one.page.table.selectRow(0)
    path, asked = tmp_path / "all.csv", list[tuple[str, Path, str]]()
    one.page.ask_path = choosing(path, asked)
    one.page.action["export"].trigger()
    one.until(lambda: one.notice().startswith(f"Saved to {path}"))
    assert asked[0][1].name.startswith("dps-s Left-wing ")
    assert path.read_bytes().startswith(b"time")
    one.page.ask_path = choosing(tmp_path / "missing" / "all.csv")
    one.page.action["export"].trigger()
    one.until(lambda: "cannot be written" in one.notice())
    damage(Path(one.rows()[0].name))
    one.page.ask_path = choosing(path)
    one.page.action["export"].trigger()
    one.until(lambda: "Damaged or altered" in one.notice())
    assert given(one.page.strip.notice).meaning is Meaning.ATTENTION
    one.page.open_row(one.rows()[0])
    one.until(lambda: one.page.view.plot is not None)
    assert "Damaged or altered" in one.page.view.details.text()


def test_it_is_deleted_once_that_is_confirmed_and_keeps_its_side_where_it_cannot_be(
    one: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = one.page
    one.choose(*one.texts(LogColumn.NAME))
    one.key(Qt.Key.Key_M)
    one.wait_read()
    let_lay_out(page)
    before = places(page)
    one.key(Qt.Key.Key_Delete)
    let_lay_out(page)
    assert moved(before, places(page)) == []
    assert one.notice().startswith("Delete for good?")
    assert given(page.strip.button("keep_recordings")).hasFocus()
    one.qtbot.keyClick(page, Qt.Key.Key_Escape)
    assert one.notice() == ""
    assert len(one.storage.library.entries()) == 1

    def refuse(_library: RecordingLibrary, _entry: RecordingEntry) -> None:
        raise PermissionError(13, "Permission denied")

    with monkeypatch.context() as patch:
        patch.setattr(RecordingLibrary, "delete", refuse)
        page.action["remove"].trigger()
        one.click(page.strip.button("delete_recordings"))
        one.until(lambda: "Permission denied" in one.notice())
    assert len(one.on(MUST)) == 1
    page.action["remove"].trigger()
    one.click(page.strip.button("delete_recordings"))
    one.until(lambda: one.notice() == "Recordings deleted: 1.")
    one.until(page.list.empty.isVisible)
    assert one.storage.library.entries() == ()


def damage(path: Path) -> None:
    """Changes one bit in a chunk in the middle."""
    data = bytearray(path.read_bytes())
    chunks = chunks_in(data)
    start, end = chunks[len(chunks) // 2]
    data[(start + end) // 2] ^= 0x10
    path.write_bytes(data)
