"""Search and marks in the traffic list."""

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.support.window.steps import press
from tests.ui.pages.diagnosis.test_diagnosis_page import diagnosis
from tests.ui.pages.diagnosis.test_traffic import cell, sent, streamed
from ui.pages.diagnosis.traffic import hex_part, matches
from ui.pages.diagnosis.traffic_model import MAX_ROWS, Column, Filter, TrafficModel


def test_bytes_and_words_are_found() -> None:
    assert hex_part("41 75 3") == ""
    assert hex_part("41 75 3A") == "41753a"
    assert hex_part("tilt") == ""
    status = streamed(1)[0]
    assert matches(status, "41 75", "4175")
    assert matches(status, "tilt 7", "")
    assert matches(status, "stream", "")
    assert not matches(status, "boot count", "")


def test_search_wraps_around_and_reports_no_match(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        traffic = page.traffic
        page.go_to("traffic")
        traffic.model.append([*streamed(3000), sent("light"), *streamed(2000), sent("boot_count")])
        traffic.draw()
        qtbot.keyClick(assembly.window, Qt.Key.Key_F, Qt.KeyboardModifier.ControlModifier)
        assert traffic.search.field.hasFocus()
        qtbot.keyClicks(traffic.search.field, "query")

        def found() -> list[int]:
            return [index.row() for index in traffic.table.selectionModel().selectedRows()]

        qtbot.waitUntil(lambda: found() in ([3000], [5001]))
        first = found()
        qtbot.keyClick(traffic.search.field, Qt.Key.Key_Return)
        qtbot.waitUntil(lambda: found() not in (first, []))
        qtbot.keyClick(traffic.search.field, Qt.Key.Key_Return)
        qtbot.waitUntil(lambda: found() == first)
        press(qtbot, traffic.search.before)
        qtbot.waitUntil(lambda: found() not in (first, []))
        traffic.search.field.clear()
        qtbot.keyClicks(traffic.search.field, "FF FF FF")
        qtbot.waitUntil(lambda: traffic._count.text() == "No matches")
        traffic.search.field.selectAll()
        qtbot.keyClicks(traffic.search.field, "query")
        qtbot.waitUntil(lambda: traffic._count.text() != "No matches")
        traffic.search.field.selectAll()
        qtbot.keyClicks(traffic.search.field, "FF FF FF")
        qtbot.waitUntil(lambda: traffic._count.text() == "No matches")
        traffic.search.field.selectAll()
        qtbot.keyClick(traffic.search.field, Qt.Key.Key_Delete)
        qtbot.waitUntil(lambda: traffic._count.text() != "No matches")


def test_marks_are_seen_filtered_and_outlive_the_list(qapp: QApplication) -> None:
    model = TrafficModel()
    model.append([sent("light"), *streamed(5)])
    model.show_new()
    model.mark([0, 2])
    assert model.is_marked(0)
    spoken = model.index(0, Column.TIME.value).data(Qt.ItemDataRole.AccessibleTextRole)
    assert "Marked" in spoken
    assert not model.index(0, Column.TIME.value).data(Qt.ItemDataRole.DecorationRole).isNull()
    assert model.index(1, Column.TIME.value).data(Qt.ItemDataRole.DecorationRole) is None
    model.mark([2])
    assert not model.is_marked(2)
    model.append(streamed(MAX_ROWS))
    model.show_new()
    model.use_filter(Filter.MARKED)
    assert model.rowCount() == 1
    assert "light" in cell(model, 0, Column.MEANING)
    model.mark([0])
    assert model.rowCount() == 0


def test_mark_by_key(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        page.go_to("traffic")
        page.traffic.model.append([sent("light"), sent("boot_count")])
        page.traffic.draw()
        page.traffic.table.selectRow(1)
        qtbot.keyClick(page.traffic.table, Qt.Key.Key_M, Qt.KeyboardModifier.ControlModifier)
        assert page.traffic.model.is_marked(1)
        press(qtbot, page.traffic.mark)
        assert not page.traffic.model.is_marked(1)


def test_a_search_backwards_selects_what_it_found_alone(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """Shift is still down, with which a person extends a selection."""
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        page.go_to("traffic")
        traffic = page.traffic
        traffic.model.append([sent("light"), *streamed(3), sent("light"), *streamed(3)])
        traffic.draw()
        traffic.table.selectRow(traffic.model.rowCount() - 1)
        traffic.search.field.setText("query: light")
        qtbot.keyPress(traffic.search.field, Qt.Key.Key_Return, Qt.KeyboardModifier.ShiftModifier)
        assert [index.row() for index in traffic.table.selectionModel().selectedRows()] == [4]
