"""The Settings page on small screens and in large text: what is needed is in sight, nothing lies sideways, and nothing
moves under the hand."""

from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QSize
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.text.i18n import CHINESE
from tests.support.window import walk
from tests.support.window.settings_bench import Desk, desk, pick, type_into, written
from tests.support.window.steps import let_lay_out
from ui.core.preferences import Preferences
from ui.widgets.step_button import is_in_sight

SMALL = QSize(1024, 600)


def resize(one: Desk, size: QSize) -> None:
    one.assembly.window.resize(size)
    one.settings.refresh()
    let_lay_out(one.assembly.window)


def sideways(one: Desk) -> list[int]:
    areas = (one.assembly.window.area, one.settings.scroll_area)
    return [area.horizontalScrollBar().maximum() for area in areas]


@pytest.mark.parametrize("spoken", [CHINESE], indirect=True)
def test_in_text_of_twice_the_size_the_main_button_stays_in_sight(
    spoken: str, qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    Preferences(tmp_path / "window.ini").zoom_percent = 200
    with desk(qtbot, qapp, tmp_path, "settings") as one:
        page = one.settings
        resize(one, SMALL)
        assert is_in_sight(page.write)
        assert sideways(one) == [0, 0]
        type_into(one, "attitude_threshold", "40")
        pick(one, "attitude_trigger", False)
        written(one)
        resize(one, SMALL)
        button = page.strip.button("write_anyway")
        assert button is not None
        assert is_in_sight(button)
        assert is_in_sight(page.write)
        assert sideways(one) == [0, 0]
        page.work.job.dismiss()
        profile = tmp_path / "H6.toml"
        profile.write_text(walk.PROFILE, encoding="utf-8")
        page.open_file(profile)
        resize(one, SMALL)
        assert is_in_sight(page.compare.apply)
        assert sideways(one) == [0, 0]
        page.on_escape()
        page.measure.click()
        resize(one, SMALL)
        assert is_in_sight(page.calibration.take)
        assert sideways(one) == [0, 0]


def test_editors_stay_where_they_are_whatever_the_rows_say(one: Desk) -> None:
    page = one.settings

    def places() -> list[QPoint]:
        page.refresh()
        let_lay_out(page)
        bar = page.scroll_area.verticalScrollBar()
        bar.setValue(0)
        return [row.editor.mapTo(page, QPoint()) for row in page.rows.values()]

    resize(one, SMALL)
    before = places()
    type_into(one, "freefall_time", "9999")
    assert places() == before
    type_into(one, "freefall_time", "1.1")
    type_into(one, "attitude_threshold", "40")
    assert places() == before
    pick(one, "freefall_trigger", True)
    assert places() == before
    written(one)
    assert places() == before
