"""Rows, columns, wrapping rows and elided texts."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from tests.support.window.cut_off import cut_off_in_paint
from tests.support.window.painted_text import watching
from ui.style.theme import Space
from ui.widgets.labels import ElidedLabel
from ui.widgets.layouts import FlowRow, Gap, in_column, in_row

WIDTH, HEIGHT = 100, 30


class Foot(QWidget):
    """Three boxes at the left and one at the right; boxes, because a style sheet of another test dresses buttons."""

    def __init__(self, qtbot: QtBot) -> None:
        super().__init__()
        qtbot.addWidget(self)
        self.boxes = [QWidget() for _ in range(4)]
        for box in self.boxes:
            box.setFixedSize(WIDTH, HEIGHT)
        row = FlowRow()
        row.add(*self.boxes[:3])
        row.add_right(self.boxes[3])
        self.column = column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addLayout(row)
        column.addStretch(1)
        self.show()

    def places(self, width: int) -> list[tuple[int, int]]:
        self.resize(width, 300)
        self.column.activate()
        return [(one.x(), one.y()) for one in self.boxes]


def test_with_room_it_is_one_line(qtbot: QtBot) -> None:
    step = WIDTH + Space.S
    assert Foot(qtbot).places(600) == [(0, 0), (step, 0), (2 * step, 0), (500, 0)]


def test_without_room_it_wraps_and_the_main_button_stays_last(qtbot: QtBot) -> None:
    step, below = WIDTH + Space.S, HEIGHT + Space.S
    foot = Foot(qtbot)
    assert foot.places(350) == [(0, 0), (step, 0), (2 * step, 0), (250, below)]
    assert foot.places(240) == [(0, 0), (step, 0), (0, below), (140, below)]
    assert foot.places(110) == [(0, 0), (0, below), (0, 2 * below), (10, 3 * below)]


def test_hidden_widgets_take_no_room(qtbot: QtBot) -> None:
    foot = Foot(qtbot)
    foot.boxes[1].hide()
    assert foot.places(350)[3] == (250, 0)


def test_it_asks_for_the_height_that_it_takes(qtbot: QtBot) -> None:
    holder = QWidget()
    qtbot.addWidget(holder)
    row = FlowRow(holder)
    for _ in range(3):
        box = QWidget()
        box.setFixedSize(WIDTH, HEIGHT)
        row.add(box)
    row.setContentsMargins(5, 5, 5, 5)
    assert row.heightForWidth(400) == HEIGHT + 10
    assert row.heightForWidth(120) == 3 * HEIGHT + 2 * Space.S + 10
    assert row.minimumSize().width() == WIDTH + 10
    assert row.itemAt(3) is None
    assert row.takeAt(2) is not None
    assert (row.count(), row.takeAt(7)) == (2, None)


def test_an_elided_text_is_whole_in_the_tooltip(qtbot: QtBot) -> None:
    window = QWidget()  # Windows makes none as narrow as the label
    qtbot.addWidget(window)
    label = ElidedLabel()
    label.setParent(window)
    label.setText("The module answers. Next: Settings, then Pre-flight.")
    label.resize(800, 20)
    window.resize(900, 20)
    window.show()
    assert label.toolTip() == ""
    label.resize(label.fontMetrics().horizontalAdvance("The module") + 10, 20)  # whatever font other tests left
    assert label.toolTip() == label.text() == "The module answers. Next: Settings, then Pre-flight."
    assert label.minimumSizeHint().width() == 0
    wide = label.grab().toImage()
    label.setText("The module")
    assert label.toolTip() == ""
    assert label.grab().toImage() != wide


def test_a_label_is_found_where_it_is_elided_and_not_where_its_text_ends_with_dots(qtbot: QtBot) -> None:
    window = QWidget()
    qtbot.addWidget(window)
    label = ElidedLabel()
    label.setParent(window)
    label.setText("Looking for thresholds…")
    found = []
    for width_px in (800, 60):
        label.resize(width_px, 20)
        with watching() as drawn:
            label.grab()
        label.setToolTip("")
        found.append(cut_off_in_paint(drawn))
    assert found[0] == []
    assert len(found[1]) == 1


def test_a_column_keeps_order_margins_and_stretches(qtbot: QtBot) -> None:
    page, first, second, third = QWidget(), QWidget(), QWidget(), QWidget()
    qtbot.addWidget(page)
    inner = in_row(second, (third, Qt.AlignmentFlag.AlignRight), spacing=3)
    column = in_column(first, Gap(7), (inner, 2), 1, of=page, spacing=5, margins=(4, 6))
    assert page.layout() is column
    margins = column.contentsMargins()
    assert (margins.left(), margins.top(), margins.right(), margins.bottom()) == (4, 6, 4, 6)
    assert (column.spacing(), inner.spacing()) == (5, 3)
    items = [item for place in range(column.count()) if (item := column.itemAt(place)) is not None]
    assert [items[0].widget(), items[2].layout()] == [first, inner]
    assert items[1].sizeHint().height() == 7
    assert [column.stretch(place) for place in range(4)] == [0, 0, 2, 1]
    last = inner.itemAt(1)
    assert last is not None
    assert last.alignment() == Qt.AlignmentFlag.AlignRight
    assert all(one.parentWidget() is page for one in (first, second, third))


def test_margins_are_equal_or_separate(qtbot: QtBot) -> None:
    even, odd = in_row(1, margins=2).contentsMargins(), in_row(1, margins=(1, 2, 3, 4)).contentsMargins()
    assert (even.left(), even.bottom()) == (2, 2)
    assert (odd.left(), odd.top(), odd.right(), odd.bottom()) == (1, 2, 3, 4)
