"""The time plots: mouse, keyboard and cursor."""

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QRectF, Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.window.plots.plot_bench import CONTROL, LEFT, NOW_S, Bench
from ui.plots.lanes import Mark
from ui.style.icons import Icon
from ui.style.theme import Meaning

# Mouse and keyboard


def test_the_wheel_zooms_with_ctrl_after_a_click_and_where_nothing_scrolls(bench: Bench, qtbot: QtBot) -> None:
    bench.area.resize(830, 300)  # the page can scroll
    QApplication.processEvents()
    assert not bench.wheel(0.5, 1)
    assert bench.plot.time_range.is_live
    assert bench.wheel(0.5, 1, CONTROL)
    assert bench.plot.time_range.span.length_s == pytest.approx(48)
    bench.plot.time_range.back_to_live()
    qtbot.mouseClick(bench.view.viewport(), LEFT, pos=bench.at(0.5))
    assert bench.wheel(0.25, -1)
    assert bench.plot.time_range.span.length_s == pytest.approx(75)
    bench.plot.time_range.back_to_live()
    bench.other.setFocus()
    bench.area.resize(830, 600)
    QApplication.processEvents()
    assert bench.wheel(0.5, 1)
    assert bench.plot.time_range.span.length_s == pytest.approx(48)


def test_dragging_moves_into_the_past_and_the_picture_stays_there(bench: Bench, qtbot: QtBot) -> None:
    viewport = bench.view.viewport()
    qtbot.mousePress(viewport, LEFT, pos=bench.at(0.2))
    qtbot.mouseMove(viewport, bench.at(0.7))
    qtbot.mouseRelease(viewport, LEFT, pos=bench.at(0.7))
    moved = bench.plot.time_range.span
    assert moved.end_s == pytest.approx(NOW_S - 30, abs=1)
    bench.plot.draw(NOW_S + 3)
    assert bench.plot.time_range.span == moved
    qtbot.mouseDClick(viewport, LEFT, pos=bench.at(0.5))
    assert bench.plot.time_range.is_live


def test_everything_by_keyboard(bench: Bench, qtbot: QtBot) -> None:
    view, shift = bench.view, Qt.KeyboardModifier.ShiftModifier
    view.setFocus()
    qtbot.keyClick(view, Qt.Key.Key_Space)
    assert not bench.plot.time_range.is_live
    qtbot.keyClick(view, Qt.Key.Key_End)
    assert bench.plot.time_range.is_live
    qtbot.keyClick(view, Qt.Key.Key_Left)
    assert bench.plot.time_range.span.end_s == pytest.approx(NOW_S - 6, abs=0.1)
    qtbot.keyClick(view, Qt.Key.Key_Right)
    qtbot.keyClick(view, Qt.Key.Key_Plus)
    assert bench.plot.time_range.span.length_s == pytest.approx(48)
    qtbot.keyClick(view, Qt.Key.Key_Minus)
    assert bench.plot.time_range.span.length_s == pytest.approx(60)
    qtbot.keyClick(view, Qt.Key.Key_Left, shift)
    assert "Tilt 12°" in bench.plot.reading
    assert view.accessibleDescription() == bench.plot.reading
    qtbot.keyClick(view, Qt.Key.Key_Tab)
    assert not view.hasFocus()


def test_the_mouse_leaves_the_plots(bench: Bench) -> None:
    """An error in here ended the program: Qt calls it while Python handles the event."""
    for widget in (bench.view.viewport(), bench.view):
        for kind in (QEvent.Type.Enter, QEvent.Type.Leave):
            QApplication.sendEvent(widget, QEvent(kind))


# The cursor


def test_the_cursor_shows_values_while_live(bench: Bench, qtbot: QtBot) -> None:
    assert bench.plot.reading == ""
    qtbot.mouseMove(bench.view.viewport(), bench.at(0.5))
    assert bench.plot.reading.startswith(("−30.0 s · ", "−29.9 s · "))
    assert bench.plot.reading.endswith("Tilt 12°, Acceleration 1.0 g")
    assert {"12°", "1.0 g"} <= set(bench.words)
    assert all(QRectF(bench.view.viewport().rect()).contains(room) for room in bench.words.values())
    middle = pytest.approx(bench.lane.box.center().x(), abs=1)
    assert bench.lines == [middle]
    dot = bench.dots[0]
    assert (dot.x(), dot.y()) == (middle, pytest.approx(bench.lane.y(12), abs=1))
    bench.plot.add_marks([Mark(NOW_S - 20, "triggered", Icon.PARACHUTE, Meaning.DANGER)])
    bench.plot.draw(NOW_S + 10)
    assert bench.plot.reading.startswith(("−30.0 s · ", "−29.9 s · "))
    assert " · triggered, Tilt 12°" in bench.plot.reading
    bench.plot.time_range.point(None)
    assert bench.plot.reading == ""
    assert not bench.dots


def test_the_cursor_of_a_recording_stays_where_the_pointer_left(recorded: Bench) -> None:
    recorded.plot.time_range.point(0.5)
    recorded.plot.time_range.point(None)
    assert recorded.plot.time_range.cursor_s == pytest.approx(NOW_S - 150)


def test_the_cursor_does_not_invent_what_was_not_measured(bench: Bench) -> None:
    bench.tilt.append([NOW_S + 20, NOW_S + 21], [5, 5])
    bench.plot.draw(NOW_S + 21)
    bench.plot.time_range.point_at(NOW_S + 11)
    assert bench.plot.reading.endswith("Tilt no data, Acceleration no data")
    assert not bench.dots


def test_the_cursor_reads_wherever_a_curve_is_drawn(bench: Bench) -> None:
    """Between slow samples it said "no data" beside a dot."""
    bench.acc.append(np.arange(NOW_S + 1, NOW_S + 10), np.ones(9))
    bench.plot.draw(NOW_S + 9)
    bench.plot.time_range.choose_length(10)
    for at_s in (NOW_S + 4.45, NOW_S + 4.55):
        bench.plot.time_range.point_at(at_s)
        assert bench.plot.reading.endswith("Acceleration 1.0 g")
        assert bench.dots[-1].x() == pytest.approx(bench.lane.x(round(at_s)), abs=1)  # the sample that is read
