"""What is shown beside the list of recordings, a recording on the Live page of a small screen, and damage: it is said
where a recording is exported and shown."""

from collections.abc import Iterator
from pathlib import Path
from shutil import copyfile

import pytest
from PySide6.QtCore import QPoint, QSize
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

import app.__main__ as program
from app.engine.target import Target
from app.recordings.library import recordings_folder
from app.recordings.recording import Recording
from app.text.i18n import CHINESE, ENGLISH
from tests.app.recordings.test_damage import chunks_in
from tests.support.cli_line import Printed
from tests.support.records.recordings_desk import Desk, made, record
from tests.support.window.controls import moved, places
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import page_entries, simulated, wait_online, window
from tests.support.window.steps import await_child, find, given, let_lay_out, notice_text
from tests.support.window.walk import SMALL_SCREEN
from ui.main import WindowOptions
from ui.pages.live.page import LivePage
from ui.pages.recordings.model import Column
from ui.pages.recordings.page import RecordingsPage
from ui.services.recording_jobs import ExportKind
from ui.style.theme import Choice, Meaning

pytest_plugins = ["tests.support.cli_fixtures"]

FULL_HD_AT_200 = QSize(960, 540)


@pytest.fixture(scope="module")
def template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recorded once."""
    return record(tmp_path_factory.mktemp("template"), seconds=10)


@pytest.fixture
def one(qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path) -> Iterator[Desk]:
    """The list, with a single recording in it."""
    with made(qtbot, qapp, tmp_path, template, RecordingsPage) as desk:
        yield desk


@pytest.mark.parametrize(
    ("language", "theme", "size"),
    [
        (ENGLISH, Choice.LIGHT, SMALL_SCREEN),
        (ENGLISH, Choice.SUNLIGHT, FULL_HD_AT_200),
        (CHINESE, Choice.SUNLIGHT, FULL_HD_AT_200),
    ],
)
def test_a_recording_that_is_opened_from_the_list_fits_on_a_small_screen(
    language: str,
    theme: Choice,
    size: QSize,
    qtbot: QtBot,
    qapp: QApplication,
    tmp_path: Path,
    template: Path,
) -> None:
    options = WindowOptions(language=language)
    with (
        simulated("small"),
        window(qapp, tmp_path, entries=page_entries("live", "recordings"), options=options) as assembly,
    ):
        main = assembly.window
        assembly.appearance.choose(theme)
        main.resize(size)
        await_child(qtbot, main, RecordingsPage)
        live = find(main, LivePage)
        assembly.storage.recordings.library.folder.mkdir(parents=True, exist_ok=True)
        copyfile(template, assembly.storage.recordings.library.folder / template.name)
        main.connect_to(Target("sim://small", 115200))
        wait_online(qtbot, assembly)
        qtbot.waitUntil(lambda: live.data.has_samples and not live.is_empty)
        main.go_to("recordings")
        assembly.storage.recordings.open(assembly.storage.recordings.library.entries()[-1])
        qtbot.waitUntil(lambda: live.isVisible() and live.recording is not None)
        let_lay_out(live)
        live.refresh()
        assert not cut_off(live.panel)
        for chip in (live.panel.activation, live.panel.trigger):
            assert chip.visibleRegion().boundingRect() == chip.rect()
        tops = {one.mapTo(live.panel, QPoint()).y() for one in (live.panel.tilt, live.panel.cell)}
        assert len(tops) == 1  # one row of values, which leaves the plots their room
        assert not cut_off(live)


def test_a_recording_of_a_module_without_a_name_is_told_by_its_port(one: Desk) -> None:
    record(one.library.folder, module="", seconds=20)
    one.list_again(2)
    assert sorted(one.texts(Column.MODULE)) == ["Left wing", "— ttyUSB0"]


def test_several_selected_recordings_are_summed_up(one: Desk) -> None:
    record(one.library.folder, seconds=60)
    one.list_again(2)
    one.page.table.selectAll()
    detail = one.page.detail
    assert detail.title.text() == "2 selected"
    assert (detail.facts["duration"].text(), detail.facts["samples"].text()) == ("1:10", "700")
    assert not detail.facts["port"].isVisible()
    let_lay_out(detail)
    heights = [detail.facts[key].height() for key in ("duration", "samples", "size")]
    assert max(heights) < 2 * detail.facts["size"].sizeHint().height()  # the rows stay together


def test_a_search_without_a_match_says_so(one: Desk) -> None:
    one.page.list.search.setText("nothing like it")
    assert one.page.list.no_match.isVisible()
    assert not one.page.detail.facts["when"].isVisible()
    one.page.list.search.clear()
    assert one.page.table.isVisible()


def test_the_buttons_stay_where_they_are_when_a_notice_is_shown(one: Desk) -> None:
    button = one.page.detail.delete
    before = button.mapTo(one.page, QPoint())
    one.click(button)
    one.until(one.page.strip.isVisible)
    let_lay_out(one.page)
    assert button.mapTo(one.page, QPoint()) == before


def test_a_question_is_whole_in_sunlight_and_moves_no_control(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path
) -> None:
    with window(qapp, tmp_path, entries=page_entries("live", "recordings")) as assembly:
        main = assembly.window
        assembly.appearance.choose(Choice.SUNLIGHT)
        main.resize(FULL_HD_AT_200)
        page = await_child(qtbot, main, RecordingsPage)
        assembly.storage.recordings.library.folder.mkdir(parents=True, exist_ok=True)
        copyfile(template, assembly.storage.recordings.library.folder / template.name)
        main.go_to("recordings")
        page.work.refresh()
        qtbot.waitUntil(lambda: bool(page.table.chosen()))
        let_lay_out(page)
        before = places(page)
        page._ask_to_delete()
        let_lay_out(page)
        assert page.strip.isVisible()
        assert not cut_off(page.strip)
        assert moved(before, places(page)) == []


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


@pytest.fixture
def desk(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    """The list and the Live page, with a recording of which a bit was changed."""
    template = record(tmp_path / "template")
    damage(template)
    with made(qtbot, qapp, tmp_path / "data", template, RecordingsPage, LivePage) as one:
        yield one


def test_the_window_reports_damage_at_export_and_on_the_live_page(desk: Desk, tmp_path: Path) -> None:
    desk.page.work.export(desk.page.work.entries[0], tmp_path / "x.csv", ExportKind.CSV)
    desk.until(lambda: "Saved" in desk.said())
    assert "Damaged or altered" in desk.said()
    assert given(desk.page.strip.notice).meaning is Meaning.ATTENTION
    desk.open()
    shown = desk.live.recording
    assert isinstance(shown, Recording)
    assert shown.damage is not None
    desk.until(lambda: "Damaged or altered" in notice_text(desk.live.banner))
