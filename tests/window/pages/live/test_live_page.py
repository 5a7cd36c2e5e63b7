"""The Live page: fresh, stale, unknown, the time line, its memory; the recording of a session."""

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import repeat
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.engine.conversation import ConversationView, StatusSample
from app.engine.worker import Batch, Connection
from app.limits.limits import LimitsInUse
from app.procedures.light import LightDirection
from app.procedures.stream import StreamSwitch
from app.recordings.excerpt import ACTIVE, TRIGGERED
from app.recordings.library import RecordingLibrary
from app.recordings.recorder import Recorder
from app.samples.samples import Series
from app.system.clock import steady_time
from protocol.events import Began, Ended, EndReason
from protocol.fields import Value
from tests.support.patience import PATIENCE_S
from tests.support.records.recordings_made import CLOSED, LOST, OPEN, batch, received, report, settle, talk
from tests.support.window.fakes_ui import connect, page_entries, simulated, window
from tests.support.window.rig import Rig, on_fake_time
from tests.support.window.steps import choosing, given, notice_text, press
from ui.files.file_dialogs import ThenPath
from ui.main import PAGES
from ui.pages.live.data import LiveData
from ui.pages.live.page import LivePage
from ui.plots.lanes import measured_lanes
from ui.session.recording import SessionRecording
from ui.style.theme import Meaning
from ui.widgets.readout import Freshness

KNOWN: dict[str, Value] = {
    "tilt_deg": 12,
    "acceleration_g": 1.0,
    "triggered": False,
    "active": False,
    "cell_voltage_v": 3.94,
    "charging": False,
    "light_v": 0.3,
    "boot_count": 37,
    "attitude_threshold_deg": 60,
    "freefall_acceleration_g": 0.5,
    "light_threshold_v": 1.8,
}


@dataclass
class Live(Rig):
    """The page, told batch by batch what the module says."""

    number: int = 1
    """Of the conversation."""

    @cached_property
    def page(self) -> LivePage:
        return self.find(LivePage)

    def say(self, *samples: StatusSample, leave_out: str = "", **values: Value) -> None:
        """A batch with these values, and a sample of them unless samples are given; the page shows it."""
        known = {key: value for key, value in (KNOWN | values).items() if key != leave_out}
        state = known["triggered"] is True, known["active"] is True
        one = StatusSample(self.clock(), int(known["tilt_deg"]), float(known["acceleration_g"]), *state)
        self.hand_over(known, *(samples or (one,)), hz=50.0)

    def hand_over(
        self, known: dict[str, Value], *samples: StatusSample, hz: float = 0.0, ended: Ended | None = None
    ) -> None:
        view = talk(self.clock(), number=self.number, **known)
        view = view._replace(is_streaming=hz > 0, ended=ended)
        self.port.bridge.batch.emit(batch(self.clock(), *samples, view=view, events=()))
        self.pass_time(0.0)

    def pass_time(self, seconds: float) -> None:
        self.clock.now_s += seconds
        self.page.refresh()
        self.page.draw()


@pytest.fixture
def live(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Live]:
    with on_fake_time(Live, qtbot, qapp, tmp_path, "unused", page_entries("live")) as made:
        made.window.panel.hide()
        made.go_to("live")
        yield made


def test_fresh_then_stale_with_its_age(live: Live) -> None:
    live.say()
    panel = live.page.panel
    assert live.page.plot.isVisible()
    assert panel.tilt.accessibleName() == "Tilt: 12°, limit 60°, trigger not known"
    assert panel.light.accessibleName() == "Light: 0.3 V, limit 1.8 V, bay closed (assumed)"
    assert panel.cell.accessibleName() == "Cell voltage: 3.94 V, not charging"
    live.pass_time(3.0)
    assert panel.tilt.accessibleName() == "Tilt: 12°, limit 60°, 3 s ago"
    assert panel.gauge.freshness is Freshness.STALE
    assert panel.cell.freshness is Freshness.FRESH  # polled once a second
    live.pass_time(5.0)
    assert panel.cell.accessibleName() == "Cell voltage: 3.94 V, 8 s ago"
    assert panel.boot_count.freshness is Freshness.FRESH  # changes only by a restart


def test_it_follows_a_clock_that_is_set(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    live.say()
    wrong_s = live.page.plot.canvas.wall_offset_s
    monkeypatch.setattr("ui.pages.live.page.wall_offset_s", lambda: wrong_s + 3600.0)
    live.say()
    assert live.page.plot.canvas.wall_offset_s == wrong_s + 3600.0
    assert len(live.page.data.tilt) == 2, "nothing is lost"


def test_what_comes_while_another_page_is_shown_is_kept(live: Live) -> None:
    live.say()
    live.page.hide()
    live.clock.now_s += 1.0
    live.say(tilt_deg=33)
    assert live.page.data.tilt.window(0, live.clock() + 1).value.tolist() == [12, 33]


@pytest.mark.promise("a")
def test_values_are_greyed_when_the_conversation_ends_and_nowhere_in_the_next(live: Live) -> None:
    live.say()
    panel = live.page.panel
    live.hand_over(KNOWN, ended=Ended(EndReason.RESTARTED, live.clock()))
    shown = (panel.tilt, panel.acceleration, panel.light, panel.cell, panel.boot_count)
    assert {readout.freshness for readout in shown} == {Freshness.STALE}
    assert panel.tilt.accessibleName().startswith("Tilt: 12°")
    live.number += 1
    live.hand_over({"cell_voltage_v": 4.1})
    assert panel.cell.accessibleName().startswith("Cell voltage: 4.10 V")
    assert {readout.freshness for readout in shown if readout is not panel.cell} == {Freshness.UNKNOWN}
    names = [readout.accessibleName() for readout in shown] + [panel.gauge.accessibleName()]
    assert not [name for name in names for old in ("12°", "0.3 V", "3.94", "60°", "1.8 V") if old in name]


@pytest.mark.promise("g")
def test_what_is_never_reported_is_unknown_and_what_is_outside_its_limit_is_marked(live: Live) -> None:
    panel = live.page.panel
    live.say(leave_out="cell_voltage_v")
    assert (panel.cell.accessibleName(), panel.cell.freshness) == ("Cell voltage: unknown", Freshness.UNKNOWN)
    live.say(leave_out="attitude_threshold_deg", tilt_deg=80)
    assert "fires" not in panel.gauge.accessibleName()
    assert panel.tilt.accessibleName() == "Tilt: 80°, trigger not known"  # 60° is only the vendor's default
    live.say(tilt_deg=80, cell_voltage_v=3.52, light_v=2.1, acceleration_g=0.1)
    assert panel.tilt.accessibleName() == "Tilt: 80°, limit 60°, over 60°"
    assert panel.cell.accessibleName() == "Cell voltage: 3.52 V, limit 3.80 V, low"
    assert panel.acceleration.accessibleName() == "Acceleration: 0.1 g, free fall"
    assert panel.cell.meaning is panel.light.meaning is Meaning.ATTENTION


def test_the_charger_and_the_triggers_are_noted(live: Live) -> None:
    panel = live.page.panel
    live.say(charging=True)
    assert panel.cell.accessibleName().endswith(", charging")
    live.say(leave_out="charging")
    assert panel.cell.accessibleName().endswith(", charger unknown")
    for flag, says in ((None, "trigger not known"), (False, "trigger off"), (True, "limit 60°")):
        live.say() if flag is None else live.say(attitude_trigger=flag, freefall_trigger=flag)
        assert panel.tilt.accessibleName().endswith(says)
        assert ("trigger not known" in panel.gauge.accessibleName()) is (flag is None)
        assert ("trigger" in panel.acceleration.accessibleName()) is (flag is not True)


def test_the_bay_is_assumed_until_it_was_measured_closed_and_open(live: Live) -> None:
    for direction, light_v, says in (
        (None, 2.5, "bay open (assumed)"),
        (LightDirection.RISES, 0.3, "bay closed"),
        (LightDirection.RISES, 2.5, "bay open"),
        (LightDirection.FALLS, 0.3, "bay open"),
        (LightDirection.FALLS, 2.5, "bay closed"),
    ):
        live.say(light_v=light_v)
        live.port.module.light_direction = direction
        live.say(light_v=light_v)
        assert live.page.panel.light.accessibleName() == f"Light: {light_v} V, limit 1.8 V, {says}"


def test_pause_holds_the_picture_until_a_person_ends_it_or_shows_another_module(live: Live) -> None:
    live.say()
    live.say(triggered=True)
    plot = live.page.plot
    live.click("time-plot-pause")
    held = plot.time_range.span
    live.clock.now_s += 5
    live.say(tilt_deg=44)
    assert plot.time_range.span == held
    assert given(live.page.data.tilt.last).value == 44
    live.qtbot.keyClick(live.page, Qt.Key.Key_P, Qt.KeyboardModifier.ControlModifier)
    assert plot.time_range.is_live
    assert plot.time_range.span.end_s == pytest.approx(live.clock(), abs=0.3)
    live.click("time-plot-pause")
    assert plot.canvas.marks
    live.assembly.ports.choose(live.assembly.ports.add())
    assert (list(plot.canvas.marks), plot.time_range.is_live) == ([], True)
    assert (live.page.is_empty, live.page.data.has_samples) == (True, False)


def test_the_values_in_sight_at_the_time_of_the_click_are_saved(live: Live, tmp_path: Path) -> None:
    live.say()
    live.clock.now_s += 100  # the first one is out of sight
    live.say(tilt_deg=20)
    live.clock.now_s += 1
    live.say(tilt_deg=61, active=True)
    path = tmp_path / "values.csv"
    suggested: list[Path] = []

    def choose_late(_parent: QWidget, _title: str, proposed: Path, _filter: str, then: ThenPath) -> None:
        suggested.append(proposed)
        live.clock.now_s += 2
        live.say(tilt_deg=99)  # acquisition goes on behind the dialog
        then(path)

    live.page.ask_path = choose_late
    live.qtbot.keyClick(live.page, Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
    live.until(lambda: not live.page.job.is_busy)
    live.page.refresh()
    assert suggested[0].match("dps-s ttyUSB0 20*.csv")
    rows = list(csv.DictReader(io.StringIO(path.read_text("utf-8-sig"), newline="")))
    assert [(row["tilt_deg"], row["active"]) for row in rows if row["tilt_deg"]] == [("20", "false"), ("61", "true")]
    assert [row["event"] for row in rows if row["event"]] == ["activated"]
    assert {row["cell_voltage_v"] for row in rows} == {"", "3.94"}
    (said,) = live.page.job.notices
    assert (said.text, said.meaning) == (f"Saved to {path}. Rows: {len(rows)}.", Meaning.GOOD)
    opened: list[str] = []
    live.page.job.open_in_system = lambda url: opened.append(url.toLocalFile())
    live.click("notice_open")
    live.click("notice_folder")
    assert opened == [str(path), str(path.parent)]


def test_a_long_saving_can_be_cancelled(live: Live, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    live.say()
    monkeypatch.setattr("ui.pages.live.page.csv_parts", lambda *_, **__: repeat(b"row"))
    path = tmp_path / "values.csv"
    live.page.ask_path = choosing(path)
    live.click("live_save_csv")
    assert live.page.job.is_busy
    assert not live.page.png.isEnabled()
    assert notice_text(live.page.strip).startswith("Saving…")
    live.click("notice_cancel")
    live.until(lambda: not live.page.job.is_busy)
    assert notice_text(live.page.strip) == "Cancelled."
    assert list(tmp_path.iterdir()) == []
    assert live.page.csv.isEnabled()


ON: dict[str, Any] = {"attitude_trigger": True, "freefall_trigger": True}
VALUES: dict[str, Any] = {"attitude_threshold_deg": 60, "freefall_acceleration_g": 0.5}


def take(data: LiveData, *batches: Batch) -> list[tuple[float, str]]:
    """When and what all these batches mark."""
    return [(mark.time_s, mark.word) for one in batches for mark in data.on_batch(one)]


def test_every_sample_is_kept_with_its_flags() -> None:
    data = LiveData()
    samples = tuple(report(n / 1440, n % 90, active=n >= 700, triggered=n % 7 == 0) for n in range(1440))
    for first in range(0, 1440, 24):
        data.on_batch(batch(1.0, *samples[first : first + 24]))
    span = data.excerpt(0.0, 1.0)
    columns = (span.tilt.time_s, span.tilt.value, span.flags & TRIGGERED != 0, span.flags & ACTIVE != 0)
    kept = list(zip(*(column.tolist() for column in columns), strict=True))
    assert kept == [(one.at, one.tilt_deg, one.triggered, one.active) for one in samples]
    assert span.is_whole


def test_another_module_starts_over() -> None:
    data = LiveData()
    view = talk(1.0, attitude_threshold_deg=60, cell_voltage_v=3.9)
    take(data, batch(1.0, report(1.0, active=True), view=view))
    data.reset()
    assert (len(data.tilt), len(data.cell), list(data.markers)) == (0, 0, [])
    assert data.unproven.fires.between(0.0, 9.0) == []
    # What was of the old one is no change of the new one.
    assert take(data, batch(0.5, report(0.5, active=False))) == []


@pytest.mark.parametrize(
    ("flags", "acting", "unproven"),
    [
        (ON, (60, 0.5), (None, None)),
        ({}, (None, None), (60, 0.5)),
        (ON | {"attitude_trigger": False}, (None, 0.5), (None, None)),
        ({"freefall_trigger": False}, (None, None), (60, None)),
    ],
)
def test_a_limit_acts_only_where_its_trigger_is_known_to_be_on(
    flags: dict[str, Any], acting: tuple[float | None, ...], unproven: tuple[float | None, ...]
) -> None:
    """ "60° fires" was drawn with unknown flags."""
    data = LiveData()
    take(data, batch(1.0, view=talk(0.0, **VALUES, **flags)))
    lanes = measured_lanes(data, LimitsInUse(), data.acting, data.unproven)[:2]
    for is_stale, expected in ((False, acting), (True, unproven)):
        drawn = [next(limit for limit in lane.limits if limit.is_stale is is_stale) for lane in lanes]
        assert tuple(limit.steps.value for limit in drawn) == expected


def test_each_change_is_marked_where_it_was_seen_and_the_first_known_state_is_none() -> None:
    data = LiveData()
    marks = take(
        data,
        batch(1.0, report(0.9, triggered=True)),
        batch(2.0, report(1.9, triggered=True), report(2.0, active=True, triggered=True)),
        batch(3.0, report(2.5, active=True), report(3.0, active=True, triggered=True)),
        batch(4.0, report(4.0, triggered=True)),
    )
    assert marks == [(2.0, "activated"), (2.5, "trigger ended"), (3.0, "triggered"), (4.0, "locked")]


@pytest.mark.parametrize(
    ("reason", "word"), [(EndReason.RESTARTED, "restarted"), (EndReason.CONTRADICTED, "two modules?")]
)
def test_the_end_of_a_conversation_is_a_mark_behind_which_nothing_of_it_holds(reason: EndReason, word: str) -> None:
    data = LiveData()
    first, second = talk(0.5, **VALUES), talk(4.0, number=2)
    marks = take(
        data,
        batch(1.0, report(1.0, 3, active=True), view=first),
        batch(2.0, view=first._replace(ended=Ended(reason, 2.0)), events=(Ended(reason, 2.0),)),
        batch(4.0, report(4.0, 40), view=second, events=(Began(8, 4.0),)),
    )
    # The next one may be another module: that it is locked is no news.
    assert marks == [(2.0, word)]
    assert (data.acting.fires.value, data.unproven.fires.value) == (None, None)


def test_a_span_with_dropped_samples_is_marked() -> None:
    data = LiveData()
    data.tilt, data.acceleration, data.flags = (Series(100) for _ in range(3))
    data.on_batch(batch(20.0, *(report(n / 10) for n in range(200))))
    assert not data.excerpt(0.0, 20.0).is_whole
    assert data.excerpt(15.0, 20.0).is_whole


NEXT = OPEN._replace(opening=7)


# From the worker to the disk, without a window


class Session:
    """A session recording whose worker is the test."""

    def __init__(self, folder: Path) -> None:
        self.handed_on: list[Batch] = []
        self.library = RecordingLibrary(folder)
        self.stream = StreamSwitch(is_wanted=False)
        self.recording = SessionRecording(self.stream, lambda: self.library)
        self.say = self.recording.recorded(self.handed_on.append)

    def name(self, name: str, *, number: int = 1) -> None:
        self.recording.name_module(name, ConversationView(number=number))

    def listed(self) -> list[tuple[str, tuple[str, ...], int]]:
        """Port, modules and number of reports of all recordings, oldest first."""
        if self.recording._recorder is not None:
            settle(self.recording._recorder)
        return [(entry.port, entry.modules, entry.sample_count) for entry in reversed(self.library.entries())]


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    one = Session(tmp_path / "recordings")
    yield one
    assert one.recording.stop(PATIENCE_S)


def some(first_s: float, *, connection: Connection = OPEN, number: int = 1, begins: bool = False) -> Batch:
    """Three reports, by the clock of the recorder: a part that began a day ago ends."""
    first_s += steady_time()
    reports = tuple(report(first_s + n / 10, n) for n in range(3))
    events = ((Began(7, first_s),) if begins else ()) + tuple(map(received, reports))
    view = ConversationView(number=number, began_at=first_s)
    return batch(first_s + 0.3, *reports, connection=connection, view=view, events=events)


@pytest.mark.parametrize(
    ("connections", "counts"),
    [
        ((OPEN, OPEN, CLOSED), [9]),
        ((OPEN, LOST, NEXT), [6, 3]),  # lost, and back
        ((OPEN, NEXT), [3, 3]),
    ],
)
def test_all_is_handed_on_and_one_opening_of_the_port_is_one_recording(
    session: Session, connections: tuple[Connection, ...], counts: list[int]
) -> None:
    batches = [some(1.0 + number, connection=one, begins=number == 0) for number, one in enumerate(connections)]
    recorders = set[Recorder]()
    for one in batches:
        session.say(one)
        session.name("Left wing")
        recorders.add(given(session.recording._recorder))
        for recorder in recorders:  # a recording does not wait for the file of the one before
            settle(recorder)
    assert session.handed_on == batches
    assert session.listed() == [("/dev/ttyUSB0", ("Left wing",), count) for count in counts]
    assert session.library.entries()[0].is_running is (connections[-1] is not CLOSED)


def test_an_error_in_the_recorder_does_not_reach_the_worker(
    session: Session, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(_batch: Batch) -> None:
        raise RuntimeError("a bug")

    monkeypatch.setattr(session.recording, "_on_batch", fail)
    session.say(some(1.0))
    assert len(session.handed_on) == 1
    assert "could not be recorded" in caplog.text


# In the window


def test_a_recorded_session_streams_on_every_page_and_is_closed_with_the_window(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with simulated("paged?uptime=60"), window(qapp, tmp_path, entries=page_entries("live", "triggers")) as assembly:
        assembly.window.go_to("triggers")
        connect(qtbot, assembly, "sim://paged?uptime=60")
        qtbot.waitUntil(lambda: assembly.ports.module.view.is_streaming)
        assert not assembly.ports.current.stream.is_wanted
        assert assembly.ports.current.stream.is_recorded
        taken: list[StatusSample] = []
        assembly.ports.current.batch.connect(lambda batch: taken.extend(batch.samples))
        qtbot.waitUntil(lambda: len(taken) > 100)
        assert taken[-1].at - taken[-101].at < 10.0  # polled it would be 50 s
        library = assembly.storage.library
        assembly.window.close_now()
        qtbot.waitUntil(lambda: not any(entry.is_running for entry in library.entries()))
        assert [entry.was_cut_off for entry in library.entries()] == [False]


def test_a_person_switches_the_recording_off_and_on_again(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("switched"), window(qapp, tmp_path, entries=PAGES[:1]) as assembly:
        switch, library = assembly.window.top_bar.record, assembly.storage.library
        connect(qtbot, assembly, "sim://switched")
        module = assembly.ports.module
        qtbot.waitUntil(lambda: module.can_be_named)
        module.say_name("M-07")
        qtbot.waitUntil(lambda: "Recorded since" in switch.accessibleName())
        assert (switch.text(), switch.isChecked()) == ("REC", True)
        press(qtbot, switch)
        assert (switch.text(), switch.isChecked()) == ("REC off", False)
        assert switch.accessibleName() == "Record: Not recorded"
        qtbot.waitUntil(lambda: not assembly.ports.current.stream.is_recorded)
        assert assembly.ports.current.stream.is_wanted, "Live draws it all the same"
        qtbot.waitUntil(lambda: [entry.is_running for entry in library.entries()] == [False])
        size = library.entries()[0].size_bytes
        qtbot.wait(1200)  # more than it takes to flush
        assert [entry.size_bytes for entry in library.entries()] == [size]
        press(qtbot, switch)
        qtbot.waitUntil(lambda: sum(entry.is_running for entry in library.entries()) == 1)
        qtbot.waitUntil(lambda: [entry.module for entry in library.entries()] == ["M-07", "M-07"])


def test_an_unwritable_disk_is_shown_and_the_link_continues(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("unkept"), window(qapp, tmp_path, entries=PAGES[:1]) as assembly:
        folder = assembly.storage.library.folder
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.write_text("a file stands where the folder should be", encoding="utf-8")
        connect(qtbot, assembly, "sim://unkept")
        bar, sign = assembly.window.notice_bar, assembly.window.top_bar.record
        qtbot.waitUntil(lambda: "Not recording" in notice_text(bar))
        assert bar.button("recordings") is not None
        qtbot.waitUntil(lambda: "Not recording" in sign.accessibleName())
        assert assembly.ports.current.is_open
