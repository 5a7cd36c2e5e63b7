"""The Recordings page, and a recording on the Live page."""

import gc
import threading
import weakref
from collections.abc import Callable, Iterator
from datetime import UTC
from functools import partial
from pathlib import Path
from shutil import copyfile

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QLabel
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from app.recordings.entry_texts import size_text
from app.recordings.export import export
from app.recordings.recording import tilt_outline
from tests.support.records import recordings_made
from tests.support.records.recordings_desk import SECONDS, Desk, made, record
from tests.support.records.recordings_made import NOON
from tests.support.window.fakes_ui import WAIT_MS, connect, page_entries, simulated, window
from tests.support.window.steps import await_child, choosing, find, given, notice_text
from ui.pages.live.page import LivePage
from ui.pages.recordings.model import Column
from ui.pages.recordings.page import RecordingsPage
from ui.plots.lanes import Span
from ui.style.painted_widget import Freshness


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recorded once."""
    return record(tmp_path_factory.mktemp("template"))


@pytest.fixture
def one(qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path) -> Iterator[Desk]:
    """The list, with a single recording in it."""
    with made(qtbot, qapp, tmp_path, template, RecordingsPage) as desk:
        yield desk


@pytest.fixture
def opened(qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path) -> Iterator[Desk]:
    """The Live page, with a recording on it."""
    with made(qtbot, qapp, tmp_path, template, LivePage) as desk:
        desk.storage.recordings.open(desk.library.entries()[0])
        desk.until(lambda: desk.live.recording is not None)
        yield desk


# The list


def test_the_list_is_searched_and_sorted(one: Desk) -> None:
    record(one.library.folder, module="Tail", seconds=20)
    one.list_again(2)
    assert one.texts(Column.DURATION) in (["0:20", "2:00"], ["2:00", "0:20"])  # equal start times
    one.page.table.sortByColumn(Column.SAMPLES, Qt.SortOrder.AscendingOrder)
    assert one.texts(Column.MODULE) == ["Tail", "Left wing"]
    assert one.texts(Column.SAMPLES) == ["200", "1,200"]
    assert one.texts(Column.WHEN) == [f"{NOON.astimezone():%Y-%m-%d %H:%M}"] * 2
    one.page.list.search.setText("left WING")
    assert one.texts(Column.MODULE) == ["Left wing"]


def test_it_refreshes_only_while_it_is_seen(one: Desk) -> None:
    page = one.page
    page.hide()
    record(one.library.folder, seconds=2)
    page.work.refresh()
    one.until(lambda: len(page.work.entries) == 2)
    assert page.table.source.rowCount() == 1
    page.show()
    assert page.table.source.rowCount() == 2


@pytest.mark.parametrize(
    ("size", "text"), [(0, "0 kB"), (90_000, "88 kB"), (5 << 20, "5.0 MB"), (300 << 20, "300 MB"), (3 << 30, "3.0 GB")]
)
def test_sizes_are_rounded(size: int, text: str) -> None:
    assert size_text(size) == text


def test_a_damaged_recording_is_listed_with_its_reason(one: Desk) -> None:
    broken = record(one.library.folder, seconds=2)
    broken.write_bytes(bytes(8) + broken.read_bytes()[8:])
    one.list_again(2)
    one.until(lambda: "cannot be read" in one.texts(Column.REMARKS))
    one.page.table.selectRow(one.texts(Column.REMARKS).index("cannot be read"))
    assert not one.page.detail.open.isEnabled()
    assert one.page.detail.delete.isEnabled()
    detail = one.page.detail
    assert detail.title.text() == broken.stem
    assert detail.remarks.text().startswith(f"{broken.name} cannot be read")
    assert not detail.facts["duration"].isVisible()
    assert detail.remarks.width() >= detail.remarks.sizeHint().width()  # no part of the name is cut off


def test_each_recording_has_an_outline_of_its_tilt(one: Desk) -> None:
    page, entry = one.page, one.library.entries()[0]
    page.refresh()
    one.until(lambda: bool(page.outlines.of(entry)))
    recording = recordings_made.opened(entry.path)
    highest = recording.tilt.decimated(recording.start_s, recording.end_s).high.max()
    assert max(high for _, high in page.outlines.of(entry)) == highest
    page.table.selectRow(0)
    assert page.detail.facts["duration"].text() == one.texts(Column.DURATION)[0]
    entry.path.write_bytes(b"")
    assert tilt_outline(entry, 8) == ()
    outlines, outline = page.outlines, page.outlines.of(entry)
    grown = entry._replace(is_running=True, sample_count=int(entry.sample_count * 1.04))
    outlines.read([grown])
    assert not outlines._reading.is_running
    outlines.read([grown._replace(sample_count=entry.sample_count * 2)])
    one.until(lambda: outlines.of(entry) != outline)


def test_a_recording_that_vanished_is_reported(one: Desk) -> None:
    path = one.library.entries()[0].path
    path.rename(path.with_name("elsewhere"))
    one.page.table.selectRow(0)
    one.click(one.page.detail.open)
    one.until(lambda: "cannot be read" in one.said())


# On the Live page


def test_a_recording_is_shown_whole_and_never_as_live(opened: Desk) -> None:
    live, recording = opened.live, opened.live.recording
    assert recording is not None
    assert live.plot.time_range.span == Span(recording.start_s, recording.end_s)
    assert not live.plot.time_range.is_live
    assert live.plot.time_range.is_recorded
    assert live.banner.isVisible()
    assert find(live, QLabel, "live_title").text() == "Recording"
    said = notice_text(live.banner)
    assert said.startswith(f"Recording of {NOON.astimezone():%Y-%m-%d %H:%M} · not live · ")
    assert "Left wing" in said
    words = [mark.word for mark in live.plot.canvas.marks]
    assert words == ["named", "connected", "activated", "triggered", "trigger ended"]


def test_the_numbers_are_those_under_the_cursor(opened: Desk) -> None:
    live = opened.live
    live.refresh()
    panel = live.panel
    assert panel.tilt.accessibleName() == "Tilt: 10°, limit 60°"  # of the last report
    assert panel.activation.accessibleName() == "Activation: ACTIVE"
    live.plot.time_range.show_instant(1000.0 + SECONDS / 2 + 0.5)
    live.refresh()
    assert panel.tilt.accessibleName() == "Tilt: 75°, limit 60°, over 60°"
    assert panel.trigger.accessibleName() == "Trigger: TRIGGERED"
    assert panel.light.accessibleName() == "Light: 0.4 V, limit 1.8 V, bay closed (assumed)"
    assert panel.cell.accessibleName() == "Cell voltage: 3.90 V"
    at = f"{NOON.astimezone():%H:%M}"[:2]
    assert panel.moment.accessibleName().startswith(f"Time under the cursor: {at}:01:00.5")
    assert not panel.stream.isVisible()
    live.plot.time_range.show_instant(1010.0)
    live.refresh()
    assert panel.activation.accessibleName() == "Activation: LOCKED"


def test_the_visible_span_is_saved(opened: Desk, tmp_path: Path) -> None:
    opened.live.plot.time_range.choose_length(10.0)
    saving, path = opened.live.save, tmp_path / "seen.csv"
    asked: list[tuple[str, Path, str]] = []
    saving.note.ask_path = choosing(path, asked)
    opened.click(saving.csv)
    opened.qtbot.waitUntil(lambda: not saving.note.job.is_writing)
    lines = path.read_text("utf-8-sig").splitlines()[1:]
    assert 100 <= len([line for line in lines if line.split(",")[2]]) <= 101
    assert lines[0].startswith(f"{NOON.astimezone(UTC):%Y-%m-%d %H:}")
    assert asked[0][1].name == f"dps-s Left-wing {NOON.astimezone():%Y-%m-%d %H-%M-%S}.csv"


@pytest.mark.parametrize("way", ["button", "esc"])
def test_back_to_live_without_a_module_is_the_empty_page(opened: Desk, way: str) -> None:
    assert opened.live.recording is not None
    recording = weakref.ref(opened.live.recording)
    if way == "button":
        opened.click(opened.live.banner.button("recorded_back"))
    else:
        opened.qtbot.keyClick(opened.live, Qt.Key.Key_Escape)
    assert opened.live.recording is None
    assert opened.live.is_empty
    assert not opened.live.banner.isVisible()
    opened.qtbot.waitUntil(lambda: gc.collect() >= 0 and recording() is None)  # it may hold hundreds of megabytes


# What is done with them


def test_it_is_exported_as_csv_and_mcap(one: Desk, tmp_path: Path) -> None:
    one.page.table.selectRow(0)
    buttons, asked = one.page.detail, list[tuple[str, Path, str]]()
    for button, path in ((buttons.csv, tmp_path / "all.csv"), (buttons.mcap, tmp_path / "all.mcap")):
        one.page.ask_path = choosing(path, asked)
        one.click(button)
        one.until(partial(_is_saved, one, path))
        assert asked[-1][1].name == f"dps-s Left-wing {NOON.astimezone():%Y-%m-%d %H-%M-%S}{path.suffix}"
    rows = (tmp_path / "all.csv").read_text("utf-8-sig").splitlines()
    assert len([row for row in rows[1:] if row.split(",")[2]]) == 10 * SECONDS
    assert len(recordings_made.opened(tmp_path / "all.mcap").tilt) == 10 * SECONDS


def test_an_export_that_cannot_be_written_is_reported(one: Desk, tmp_path: Path) -> None:
    one.page.table.selectRow(0)
    one.page.ask_path = choosing(tmp_path / "missing" / "all.csv")
    one.click(one.page.detail.csv)
    one.until(lambda: "cannot be written" in one.said())
    assert one.page.detail.csv.isEnabled()


def test_a_long_export_shows_progress_and_can_be_cancelled(
    one: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended = threading.Event()
    never = threading.Event()

    def endless(_entry: object, _path: Path, *, is_table: bool, on_progress: Callable[[float], object]) -> None:
        assert is_table
        try:
            while True:
                on_progress(0.4)
                never.wait(0.01)
        finally:
            ended.set()

    monkeypatch.setattr("app.recordings.export.export", endless)
    one.page.table.selectRow(0)
    one.page.ask_path = choosing(tmp_path / "all.csv")
    one.click(one.page.detail.csv)
    one.until(lambda: one.said() == "Exporting all.csv: 40 %")
    assert not one.page.detail.delete.isEnabled()
    one.page.open_file(one.library.entries()[0].path)
    assert one.said().startswith("Exporting all.csv: 40 %. Not opened meanwhile: ")
    one.answer("cancel")
    one.until(lambda: one.said() == "Cancelled.")
    assert ended.wait(WAIT_MS / 1000)
    assert list(tmp_path.glob("*.csv")) == []


def test_an_export_is_finished_after_the_window_has_closed(
    one: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, may_go_on = threading.Event(), threading.Event()

    def held(*asked: object, **more: object) -> object:
        begun.set()
        may_go_on.wait()
        return export(*asked, **more)  # type: ignore[arg-type]

    monkeypatch.setattr("app.recordings.export.export", held)
    one.page.table.selectRow(0)
    one.page.ask_path = choosing(tmp_path / "all.csv")
    one.click(one.page.detail.csv)
    assert begun.wait(WAIT_MS / 1000)
    one.storage.close()
    may_go_on.set()
    assert one.storage.recordings._writing.wait(WAIT_MS / 1000)
    assert (tmp_path / "all.csv").is_file()


def test_a_recording_is_pinned_and_unpinned(one: Desk) -> None:
    one.page.table.selectRow(0)
    assert one.page.detail.pin.text() == "Pin"
    one.click(one.page.detail.pin)
    one.until(lambda: one.texts(Column.PINNED) == ["pinned"])
    assert one.page.detail.pin.text() == "Unpin"  # still selected
    assert (
        one.page.bounds.text() == "1 · 0 kB of 2.5 GB used; then the oldest are deleted."
    )  # it takes no room of others
    one.until(one.page.detail.pin.isEnabled)
    one.click(one.page.detail.pin)
    one.until(lambda: one.texts(Column.PINNED) == [""])


def test_deleting_asks_first_in_the_window(one: Desk) -> None:
    one.page.table.selectRow(0)
    one.qtbot.keyClick(one.page.table, Qt.Key.Key_Delete)
    assert one.said().startswith("Delete for good?")
    spare = given(one.page.strip.button("keep_recordings"))
    assert spare.hasFocus()
    one.qtbot.keyClick(one.page, Qt.Key.Key_Escape)
    assert one.said() == ""
    assert len(one.library.entries()) == 1
    one.click(one.page.detail.delete)
    one.answer("delete_recordings")
    one.until(lambda: one.said() == "Recordings deleted: 1.")
    one.until(one.page.list.empty.isVisible)
    assert one.library.entries() == ()


def test_deleting_the_opened_recording_returns_to_live_first(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path
) -> None:
    with made(qtbot, qapp, tmp_path, template, RecordingsPage, LivePage) as both:
        both.open()
        both.page.table.selectRow(0)
        both.click(both.page.detail.delete)
        both.answer("delete_recordings")
        both.until(lambda: both.library.entries() == ())
        assert both.live.recording is None
        assert both.live.is_empty


# In the window


def test_from_the_empty_page_to_a_recording_and_back_while_a_module_goes_on(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path
) -> None:
    with simulated("beside", tilt=33), window(qapp, tmp_path, entries=page_entries("live", "recordings")) as assembly:
        main, connector = assembly.window, assembly.ports
        pages = (RecordingsPage, LivePage)
        qtbot.waitUntil(lambda: all(main.findChild(kind) for kind in pages))
        page, live = (main.findChild(kind) for kind in pages)
        assert isinstance(page, RecordingsPage)
        assert isinstance(live, LivePage)
        desk = Desk(qtbot, assembly.storage, page, live)
        main.panel.hide()
        desk.until(live.empty.recordings.isVisible)
        desk.click(live.empty.recordings)
        desk.until(lambda: page.isVisible() and page.work.is_known)
        assert page.list.empty.isVisible()
        assert page.bounds.text() == "0 · 0 kB of 2.5 GB used; then the oldest are deleted."
        assert not page.detail.open.isEnabled()
        desk.library.folder.mkdir(parents=True, exist_ok=True)
        copyfile(template, desk.library.folder / template.name)

        connect(qtbot, assembly, "sim://beside")
        desk.list_again(2)
        desk.until(lambda: any("being recorded" in text for text in desk.texts(Column.REMARKS)))
        page.table.selectAll()
        assert not page.detail.delete.isEnabled()  # one of them is being written

        desk.open(desk.texts(Column.MODULE).index("Left wing"))
        desk.until(live.isVisible)
        live.refresh()
        count = len(live.data.tilt)
        desk.until(lambda: len(live.data.tilt) > count + 3)
        assert live.panel.tilt.accessibleName() == "Tilt: 10°, limit 60°"
        assert main.top_bar.lock.isEnabled()
        assert main.top_bar.activation.word == "LOCKED"

        desk.click(live.banner.button("recorded_back"))
        desk.until(lambda: live.panel.tilt.accessibleName() == "Tilt: 33°, limit 60°, trigger not known")
        assert live.panel.tilt.freshness is Freshness.FRESH
        assert live.plot.time_range.is_live
        assert not live.panel.moment.isVisible()
        assert find(live, QLabel, "live_title").text() == "Live"
        connector.current.disconnect_port()
        desk.until(lambda: assembly.ports.current.recording.state.since is None)


@pytest.mark.parametrize("is_shown_port", [True, False])
def test_whoever_connects_a_module_sees_it_and_no_recording(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path, is_shown_port: bool
) -> None:
    """After three other modules were connected, Live still showed what was recorded four minutes before."""
    with (
        simulated("first", tilt=11), simulated("second", tilt=22),
        window(qapp, tmp_path, entries=page_entries("live", "recordings")) as assembly,
    ):  # fmt: skip
        live = await_child(qtbot, assembly.window, LivePage)
        connect(qtbot, assembly, "sim://first")
        folder = assembly.storage.recordings.library.folder
        folder.mkdir(parents=True, exist_ok=True)
        path = Path(copyfile(template, folder / template.name))
        assembly.window.files.open(path)
        qtbot.waitUntil(lambda: live.recording is not None)
        if is_shown_port:
            connect(qtbot, assembly, "sim://second")
        else:
            other = assembly.ports.add()
            other.connect_to(Target("sim://second", 115200))
            qtbot.waitUntil(lambda: other.module.is_going)
            assert live.recording is not None  # it is in the fleet, and nobody asked to see it
            assembly.ports.choose(other)
        qtbot.waitUntil(lambda: live.panel.tilt.accessibleName().startswith("Tilt: 22°"))
        assert live.recording is None
        assert find(live, QLabel, "live_title").text() == "Live"


# Looks


def _is_saved(desk: Desk, path: Path) -> bool:
    return desk.said().startswith("Saved") and str(path) in desk.said()
