"""What is shown beside the list of recordings, and a recording on the Live page of a small screen."""

from collections.abc import Iterator
from pathlib import Path
from shutil import copyfile

import pytest
from PySide6.QtCore import QPoint, QSize
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from app.text.i18n import CHINESE, ENGLISH
from tests.support.records.recordings_desk import Desk, made, record
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import WAIT_MS, simulated, wait_online, window
from tests.support.window.moved import moved, places
from tests.support.window.steps import await_child, find
from tests.support.window.walk import SMALL_SCREEN
from ui.main import PAGES, WindowOptions
from ui.pages.live.page import LivePage
from ui.pages.recordings.page import RecordingsPage
from ui.style.theme import Choice

FULL_HD_AT_200 = QSize(960, 540)
ENTRIES = tuple(entry for entry in PAGES if entry.key in ("live", "recordings"))


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
    with simulated("small"), window(qapp, tmp_path, entries=ENTRIES, options=options) as assembly:
        main = assembly.window
        assembly.appearance.choose(theme)
        main.resize(size)
        await_child(qtbot, main, RecordingsPage)
        live = find(main, LivePage)
        assembly.storage.recordings.library.folder.mkdir(parents=True, exist_ok=True)
        copyfile(template, assembly.storage.recordings.library.folder / template.name)
        main.connect_to(Target("sim://small", 115200))
        wait_online(qtbot, assembly)
        qtbot.waitUntil(lambda: live.data.has_samples and not live.is_empty, timeout=WAIT_MS)
        main.go_to("recordings")
        assembly.storage.recordings.open(assembly.storage.recordings.library.entries()[-1])
        qtbot.waitUntil(lambda: live.isVisible() and live.recording is not None, timeout=WAIT_MS)
        QApplication.processEvents()
        live.refresh()
        QApplication.processEvents()
        assert not cut_off(live.panel)
        for chip in (live.panel.activation, live.panel.trigger):
            assert chip.visibleRegion().boundingRect() == chip.rect()
        tops = {one.mapTo(live.panel, QPoint()).y() for one in (live.panel.tilt, live.panel.cell)}
        assert len(tops) == 1  # one row of values, which leaves the plots their room
        assert not cut_off(live)


def test_several_selected_recordings_are_summed_up(one: Desk) -> None:
    record(one.library.folder, seconds=60)
    one.list_again(2)
    one.page.table.selectAll()
    detail = one.page.detail
    assert detail.title.text() == "2 selected"
    assert (detail.facts["duration"].text(), detail.facts["samples"].text()) == ("1:10", "700")
    assert not detail.facts["port"].isVisible()
    QApplication.processEvents()
    heights = [detail.facts[key].height() for key in ("duration", "samples", "size")]
    assert max(heights) < 2 * detail.facts["size"].sizeHint().height()  # the rows stay together


def test_a_search_without_a_match_says_so(one: Desk) -> None:
    one.page.search.setText("nothing like it")
    assert one.page.no_match.isVisible()
    assert not one.page.detail.facts["when"].isVisible()
    one.page.search.clear()
    assert one.page.table.isVisible()


def test_the_buttons_stay_where_they_are_when_a_notice_is_shown(one: Desk) -> None:
    button = one.page.buttons.delete
    before = button.mapTo(one.page, QPoint())
    one.click(button)
    one.until(one.page.strip.isVisible)
    QApplication.processEvents()
    assert button.mapTo(one.page, QPoint()) == before


def test_a_question_is_whole_in_sunlight_and_moves_no_control(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, template: Path
) -> None:
    with window(qapp, tmp_path, entries=ENTRIES) as assembly:
        main = assembly.window
        assembly.appearance.choose(Choice.SUNLIGHT)
        main.resize(FULL_HD_AT_200)
        page = await_child(qtbot, main, RecordingsPage)
        assembly.storage.recordings.library.folder.mkdir(parents=True, exist_ok=True)
        copyfile(template, assembly.storage.recordings.library.folder / template.name)
        main.go_to("recordings")
        page.work.refresh()
        qtbot.waitUntil(lambda: bool(page.table.chosen()), timeout=WAIT_MS)
        QApplication.processEvents()
        before = places(page)
        page._ask_to_delete()
        QApplication.processEvents()
        assert page.strip.isVisible()
        assert not cut_off(page.strip)
        assert moved(before, places(page)) == []
