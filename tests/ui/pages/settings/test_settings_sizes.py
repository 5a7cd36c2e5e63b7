"""The Settings page on small screens and in large text: what is needed is in sight, nothing lies sideways, and nothing
moves under the hand."""

from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QSize
from PySide6.QtWidgets import QApplication, QLabel
from pytestqt.qtbot import QtBot

from app.text.i18n import CHINESE, ENGLISH
from tests.support.window import walk
from tests.support.window.settings_bench import Desk, desk, pick, type_into, written
from tests.support.window.steps import let_lay_out
from ui.core.preferences import Preferences
from ui.style.theme import Choice
from ui.widgets.step_button import is_in_sight

LANGUAGES = [ENGLISH, CHINESE]
SMALL = QSize(1024, 600)


def resize(one: Desk, size: QSize) -> None:
    one.assembly.window.resize(size)
    one.settings.refresh()
    let_lay_out(one.assembly.window)


def sideways(one: Desk) -> list[int]:
    areas = (one.assembly.window.area, one.settings.scroll_area)
    return [area.horizontalScrollBar().maximum() for area in areas]


def cut(one: Desk) -> list[str]:
    """Labels of the page that are visible and have less room than they need."""
    labels = [label for label in one.settings.findChildren(QLabel) if label.isVisible() and label.text()]
    return [
        f"{label.objectName()}: {label.text()}"
        for label in labels
        if label.width() < label.minimumSizeHint().width()
        or label.height() < (label.heightForWidth(label.width()) if label.wordWrap() else label.sizeHint().height())
    ]


@pytest.mark.parametrize("spoken", LANGUAGES, indirect=True)
@pytest.mark.parametrize("theme", [Choice.LIGHT, Choice.SUNLIGHT])
def test_on_the_smallest_screen_all_is_in_sight(spoken: str, theme: Choice, one: Desk) -> None:
    one.assembly.appearance.choose(theme)
    resize(one, SMALL)
    page = one.settings
    cells = [row.editor for row in page.rows.values()]
    for widget in (*cells, page.baud.editor, page.open, page.recent, page.save, page.code, page.revert, page.write):
        assert is_in_sight(widget), widget.objectName()
    assert sideways(one) == [0, 0]
    assert cut(one) == []
    one.assembly.appearance.choose(Choice.LIGHT)


@pytest.mark.parametrize("spoken", LANGUAGES, indirect=True)
def test_in_text_of_twice_the_size_the_main_button_stays_in_sight(
    spoken: str, qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    Preferences(tmp_path / "window.ini").zoom_percent = 200
    with desk(qtbot, qapp, tmp_path, "settings") as one:
        page = one.settings
        resize(one, SMALL)
        assert is_in_sight(page.write)
        assert sideways(one) == [0, 0]
        assert cut(one) == []
        type_into(one, "attitude_threshold", "40")
        pick(one, "attitude_trigger", False)
        written(one)
        resize(one, SMALL)
        button = page.strip.button("write_anyway")
        assert button is not None
        assert is_in_sight(button)
        assert is_in_sight(page.write)
        assert sideways(one) == [0, 0]
        assert cut(one) == []
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


@pytest.mark.parametrize("size", [SMALL, QSize(1366, 768)])
def test_editors_stay_where_they_are_whatever_the_rows_say(size: QSize, one: Desk) -> None:
    page = one.settings

    def places() -> list[QPoint]:
        page.refresh()
        let_lay_out(page)
        bar = page.scroll_area.verticalScrollBar()
        bar.setValue(0)
        return [row.editor.mapTo(page, QPoint()) for row in page.rows.values()]

    resize(one, size)
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
