"""Form in which a person assigns the columns of a CSV file."""

from collections.abc import Sequence
from typing import Any, Final

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QFrame,
    QLabel,
    QPushButton,
    QWidget,
)

from app.flight_logs.csv_columns import ATTITUDES, FORCES, CsvColumns, CsvRole
from app.text.i18n import tr
from app.text.sentences import labelled
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.pages.flights.texts import short_name
from ui.services.page import HEIGHT_PX
from ui.style.icons import Icon
from ui.style.theme import Space
from ui.widgets.controls import control, named
from ui.widgets.labels import ElidedLabel, text_label
from ui.widgets.layouts import in_column, in_row, scroll_area
from ui.widgets.sliders import WheelGuard, label_for

NONE: Final[tuple[CsvRole, ...]] = ()
_TIME_UNITS: Final = {CsvRole.TIME_S: "s", CsvRole.TIME_MS: "ms", CsvRole.TIME_US: "µs"}
_TILT, _ROLL_PITCH, _LENGTH, _AXES_3 = (
    marked("Tilt"),
    marked("Roll and pitch"),
    marked("Magnitude"),
    marked("Three axes"),
)
_ATTITUDE_WORDS: Final = dict(zip(
    ATTITUDES, ((_TILT, "°"), (marked("Quaternion"), ""), (_ROLL_PITCH, "°"), (_ROLL_PITCH, "rad")), strict=True,
))  # fmt: skip
_FORCE_WORDS: Final = dict(zip(
    FORCES, ((_LENGTH, "g"), (_LENGTH, "m/s²"), (_AXES_3, "g"), (_AXES_3, "m/s²")), strict=True,
))  # fmt: skip
_AXES: Final = {
    "tilt_deg": marked("Tilt"), "roll_deg": marked("Roll"), "pitch_deg": marked("Pitch"), "roll_rad": marked("Roll"),
    "pitch_rad": marked("Pitch"), "acceleration_g": marked("Acceleration"), "acceleration_m_s2": marked("Acceleration"),
}  # fmt: skip
_MAX_PARTS: Final = 4


class ColumnForm(QWidget):
    """`chosen` gives the name of the file and its `CsvColumns`."""

    chosen = Signal(str, object)
    closed = Signal()

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("csv_form")
        self._texts = texts
        self._name = ""
        self._head: tuple[str, ...] = ()
        self._fault: UserError | None = None
        self._guard = WheelGuard(self)
        self.title = named(ElidedLabel(), "csv_title", "title")
        self.fault = text_label("csv_fault", "danger")
        self.time = self._box("csv_time", marked("Time"))
        self.unit = self._box("csv_time_unit", marked("Unit"))
        self.attitude = self._box("csv_attitude", marked("Attitude"))
        self.force = self._box("csv_force", marked("Acceleration"))
        self.altitude = self._box("csv_altitude", marked("Altitude"))
        self.armed = self._box("csv_armed", marked("Arming state"))
        self.attitude_parts = [self._box(f"csv_attitude_{number}", marked("Attitude"))
                               for number in range(_MAX_PARTS)]  # fmt: skip
        self.force_parts = [self._box(f"csv_force_{number}", marked("Acceleration"))
                            for number in range(_MAX_PARTS - 1)]  # fmt: skip
        self._labels = {box: named(QLabel(), f"{box.objectName()}_label")
                        for box in (*self.attitude_parts, *self.force_parts)}  # fmt: skip
        self.read = control(QPushButton(), texts, "csv_read", "Read", picture=Icon.CHECK, role="primary",
                            slot=self._choose)  # fmt: skip
        self.cancel = control(QPushButton(), texts, "csv_cancel", "Cancel", key="Esc", slot=self.closed)
        self._lay_out()
        self.attitude.currentIndexChanged.connect(self._show_parts)
        self.force.currentIndexChanged.connect(self._show_parts)

    def show_file(self, name: str, head: Sequence[str]) -> None:
        self._name, self._head = name, tuple(head)
        self._show_fault(None)
        self.retranslate()
        self.time.setFocus()

    def retranslate(self) -> None:
        """Fills the boxes; the choices stay."""
        self.title.setText(labelled(tr("Columns"), short_name(self._name)))
        self._fill(self.unit, [(unit, role) for role, unit in _TIME_UNITS.items()])
        for box, kinds in ((self.attitude, _ATTITUDE_WORDS), (self.force, _FORCE_WORDS)):
            entries = [(" ".join((tr(word), unit)).strip(), roles) for roles, (word, unit) in kinds.items()]
            self._fill(box, [(tr("none"), NONE), *entries])
        columns = [(name, name) for name in self._head]
        for box in (self.time, *self.attitude_parts, *self.force_parts):
            self._fill(box, columns, is_open=True)
        for box in (self.altitude, self.armed):
            self._fill(box, [(tr("none"), ""), *columns])
        self._show_parts()
        self._show_fault(self._fault)

    def columns(self) -> CsvColumns:
        """The chosen columns. Raises `UserError` where they are not enough."""
        names = {self.unit.currentData(): self.time.currentData()}
        for kind, parts in ((self.attitude, self.attitude_parts), (self.force, self.force_parts)):
            names |= {role: box.currentData() for role, box in zip(kind.currentData(), parts, strict=False)}
        for role, box in ((CsvRole.ALTITUDE_M, self.altitude), (CsvRole.ARMED, self.armed)):
            if box.currentData():
                names[role] = box.currentData()
        if None in names.values():
            raise UserError(marked("Choose a column in each row."))
        return CsvColumns(names)

    # What happens

    def _choose(self) -> None:
        try:
            columns = self.columns()
        except UserError as error:
            self._show_fault(error)
            return
        self.chosen.emit(self._name, columns)

    def _show_fault(self, fault: UserError | None) -> None:
        self._fault = fault
        self.fault.setText("" if fault is None else fault.sentence)
        self.fault.setVisible(fault is not None)

    def _fill(self, box: QComboBox, entries: Sequence[tuple[str, Any]], *, is_open: bool = False) -> None:
        """`is_open`: nothing is preselected."""
        row = box.currentIndex()
        if [(box.itemText(row), box.itemData(row)) for row in range(box.count())] == list(entries):
            return
        was = box.currentData()
        box.blockSignals(True)
        box.clear()
        for text, data in entries:
            box.addItem(text, data)
        first = -1 if is_open else 0
        box.setCurrentIndex(
            next((number for number, (_, data) in enumerate(entries) if data == was and row >= 0), first)
        )
        box.blockSignals(False)

    def _show_parts(self) -> None:
        """Shows the columns that the chosen kinds need."""
        for kind, parts in ((self.attitude, self.attitude_parts), (self.force, self.force_parts)):
            roles = kind.currentData() or NONE
            for number, box in enumerate(parts):
                is_needed = number < len(roles)
                self._rows.setRowVisible(box, is_needed)
                if is_needed:
                    text = _part_text(roles[number])
                    box.setAccessibleName(text)
                    self._labels[box].setText(text)

    # Making

    def _box(self, name: str, says: str) -> QComboBox:
        box = control(QComboBox(), self._texts, name, says=says, tip=says)
        box.setProperty("title", says)
        self._texts.bind(box.setPlaceholderText, "choose")
        box.setMinimumContentsLength(18)
        box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self._guard.guard(box)
        return box

    def _lay_out(self) -> None:
        card = named(QFrame(), "csv_card", "card")
        self._rows = QFormLayout(card)
        self._rows.setContentsMargins(Space.M, Space.M, Space.M, Space.M)
        self._rows.setVerticalSpacing(Space.XS)
        self._rows.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        boxes = (
            self.time, self.unit, self.attitude, *self.attitude_parts, self.force, *self.force_parts, self.altitude,
            self.armed,
        )  # fmt: skip
        for box in boxes:
            if box in self._labels:  # the text depends on the chosen kind
                self._labels[box].setBuddy(box)
                self._labels[box].setMinimumHeight(box.sizeHint().height())
                self._rows.addRow(self._labels[box], box)
            else:
                self._rows.addRow(label_for(self._texts, box, str(box.property("title"))), box)
        content = named(QWidget(), "csv_content")
        in_column(in_row((card, 2), 1), 1, of=content, margins=0)
        scroll = scroll_area(content, self._texts, "csv_scroll", "Columns")
        head = in_row((self.title, 1), self.cancel, self.read, spacing=Space.S)
        head.addStrut(HEIGHT_PX)
        in_column(head, self.fault, (scroll, 1), of=self, spacing=Space.S, margins=0)
        self._show_fault(None)


def _part_text(role: CsvRole) -> str:
    """Name of a column: a translated word, or the letter of an axis."""
    word = _AXES.get(role.value)
    return tr(word) if word is not None else role.value.partition("_")[0].upper()
