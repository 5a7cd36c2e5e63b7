"""Recordings on the Logs page: listed, judged, shown, exported, deleted; damage is said."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

import app.__main__ as program
from app.recordings.library import recordings_folder
from app.text.i18n import CHINESE
from tests.files.recordings.test_damage import chunks_in
from tests.support.cli_line import Printed
from tests.support.records.recordings_desk import Desk, made, record
from tests.support.records.recordings_made import NOON
from tests.support.window.controls import moved, places
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import WAIT_MS, connect, page_entries, simulated, window
from tests.support.window.steps import await_child, choosing, given, let_lay_out, notice_text
from tests.support.window.walk import SMALL_SCREEN
from ui.main import WindowOptions
from ui.pages.live.page import LivePage
from ui.pages.logs.page import LogsPage
from ui.pages.logs.rows import LogColumn
from ui.plots.lanes import Span
from ui.style.theme import Choice, Meaning

pytest_plugins = ["tests.support.cli_fixtures"]


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recorded once."""
    return record(tmp_path_factory.mktemp("template"))


@pytest.fixture
def one(qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path) -> Iterator[Desk]:
    """The list, with a single recording in it."""
    with made(qtbot, qapp, tmp_path, template) as desk:
        yield desk


# The list


def test_it_is_listed_and_searched_and_judged_on_a_side(one: Desk) -> None:
    record(one.library.folder, module="", seconds=20)
    one.list_again(2)
    assert sorted(one.texts(LogColumn.NAME)) == ["Left wing", "ttyUSB0"]
    assert all(f"{NOON.astimezone():%m-%d %H:%M}" in text for text in one.texts(LogColumn.WHEN))
    one.page.table.selectAll()
    one.page.table.setFocus()
    one.qtbot.keyClick(one.page.table, Qt.Key.Key_M)
    one.until(lambda: one.page.counts.text() == "Must fire: 2 of 2 fire in time")
    assert sorted(one.texts(LogColumn.ANSWER)) == ["10.0 s", "1:00.0"]
    assert one.said() == ""
    one.page.list.search.setText("left WING")
    assert one.texts(LogColumn.NAME) == ["Left wing"]
    one.page.list.search.setText("nothing like it")
    assert one.page.list.no_match.isVisible()


def test_one_that_cannot_be_read_is_listed_with_its_reason_and_hinders_no_proposal(one: Desk) -> None:
    broken = record(one.library.folder, seconds=2)
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


def test_opened_with_the_program_it_is_shown_while_a_module_goes_on(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path
) -> None:
    """From a folder of somebody else's, on a small screen; Live stays live, and LOCK works."""
    options = WindowOptions(language=CHINESE)
    with (
        simulated("beside", tilt=33),
        window(qapp, tmp_path, entries=page_entries("live", "logs"), options=options) as assembly,
    ):
        main = assembly.window
        assembly.appearance.choose(Choice.SUNLIGHT)
        main.resize(SMALL_SCREEN)
        live, page = await_child(qtbot, main, LivePage), await_child(qtbot, main, LogsPage)
        connect(qtbot, assembly, "sim://beside")
        qtbot.waitUntil(lambda: live.data.has_samples)
        main.files.open(template)
        qtbot.waitUntil(lambda: page.view.plot is not None, timeout=WAIT_MS)
        let_lay_out(page)
        assert not cut_off(page.view)
        count = len(live.data.tilt)
        qtbot.waitUntil(lambda: len(live.data.tilt) > count + 3)
        assert main.top_bar.lock.isEnabled()
        page.on_escape()
        qtbot.waitUntil(lambda: any(row.entry is not None and row.entry.is_running for row in page.work.rows()))
        page.table.selectAll()
        assert not page.removing.isEnabled()  # one of them is being written
        assembly.ports.current.disconnect_port()
        qtbot.waitUntil(lambda: assembly.ports.current.recording.state.since is None)


# Exported, deleted


@pytest.mark.parametrize("suffix", [".csv", ".mcap"])
def test_it_is_exported(one: Desk, tmp_path: Path, suffix: str) -> None:
    one.page.table.selectRow(0)
    path, asked = tmp_path / f"all{suffix}", list[tuple[str, Path, str]]()
    one.page.ask_path = choosing(path, asked)
    given(one.page.exporting).click()
    one.until(lambda: one.said().startswith(f"Saved to {path}"))
    assert asked[0][1].name.startswith("dps-s Left-wing ")
    assert path.read_bytes()[:4] == (b"\x89MCA" if suffix == ".mcap" else b"time")
    one.page.ask_path = choosing(tmp_path / "missing" / "all.csv")
    given(one.page.exporting).click()
    one.until(lambda: "cannot be written" in one.said())


def test_it_is_deleted_once_that_is_confirmed(one: Desk) -> None:
    page = one.page
    page.table.selectRow(0)
    let_lay_out(page)
    before = places(page)
    page.table.setFocus()
    one.qtbot.keyClick(page.table, Qt.Key.Key_Delete)
    let_lay_out(page)
    assert moved(before, places(page)) == []
    assert one.said().startswith("Delete for good?")
    assert given(page.strip.button("keep_recordings")).hasFocus()
    one.qtbot.keyClick(page, Qt.Key.Key_Escape)
    assert one.said() == ""
    assert len(one.library.entries()) == 1
    page.removing.trigger()
    one.answer("delete_recordings")
    one.until(lambda: one.said() == "Recordings deleted: 1.")
    one.until(page.list.empty.isVisible)
    assert one.library.entries() == ()


# Damage


def damage(path: Path) -> None:
    """Changes one bit in a chunk in the middle."""
    data = bytearray(path.read_bytes())
    chunks = chunks_in(data)
    start, end = chunks[len(chunks) // 2]
    data[(start + end) // 2] ^= 0x10
    path.write_bytes(data)


def test_the_command_line_reports_damage(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    damage(path := record(recordings_folder()))
    assert program.main(["decode", str(path)]) == 4
    assert "Damaged or altered" in Printed(capsys).err
    for name in ("x.csv", "x.mcap"):
        assert program.main(["recordings", "export", "latest", str(tmp_path / name)]) == 4
        printed = Printed(capsys)
        assert "Saved to" in printed.out
        assert "Damaged or altered" in printed.err
    assert "damaged data left out" in (tmp_path / "x.csv").read_text("utf-8-sig")


def test_the_window_reports_damage_at_export_and_where_it_is_shown(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    damage(damaged := record(tmp_path / "template"))
    with made(qtbot, qapp, tmp_path / "data", damaged) as desk:
        desk.page.table.selectRow(0)
        desk.page.ask_path = choosing(tmp_path / "x.csv")
        given(desk.page.exporting).click()
        desk.until(lambda: "Saved" in desk.said())
        assert "Damaged or altered" in notice_text(desk.page.strip)
        assert given(desk.page.strip.notice).meaning is Meaning.ATTENTION
        desk.page.open_row(desk.page.work.rows()[0])
        desk.until(lambda: desk.page.view.plot is not None)
        assert "Damaged or altered" in desk.page.view.details.text()
