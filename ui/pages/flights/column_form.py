"""Form in which a person says which column of a CSV file holds what."""

from collections.abc import Sequence
from typing import Final

from PySide6.QtCore import QStringListModel, Signal
from PySide6.QtWidgets import QComboBox, QFormLayout, QFrame, QLabel, QPushButton, QWidget

from app.flight_logs.csv_columns import TIMES, CsvColumns, CsvRole
from app.text.i18n import tr
from app.text.sentences import in_brackets, labelled
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
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

_WORDS: Final = {
    "time": marked("Time"), "tilt": marked("Tilt"), "roll": marked("Roll"), "pitch": marked("Pitch"),
    "acceleration": marked("Acceleration"), "altitude": marked("Altitude"), "armed": marked("Arming state"),
}  # fmt: skip
_QUATERNION: Final = marked("Quaternion")
_UNITS: Final = {"us": "µs", "deg": "°", "m_s2": "m/s²"}


def role_text(role: CsvRole) -> str:
    """ "Roll (°)", "Quaternion W", "Acceleration X (g)"."""
    stem, _, unit = role.value.partition("_")
    word = _WORDS.get(stem, _QUATERNION if stem.startswith("q") else _WORDS["acceleration"])
    axis = "" if stem in _WORDS else f" {stem[-1].upper()}"
    return f"{tr(word)}{axis}{in_brackets(_UNITS.get(unit, unit)) if unit else ''}"


class ColumnForm(QWidget):
    """`chosen` gives the name of the file and its `CsvColumns`."""

    chosen = Signal(str, object)
    closed = Signal()

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("csv_form")
        self._name = ""
        self._fault: UserError | None = None
        self._columns = QStringListModel(self)
        """The names of the file's columns, after one that stands for none."""
        self.title = named(ElidedLabel(), "csv_title", "title")
        self.fault = text_label("csv_fault", "danger")
        self.boxes = {role: named(QComboBox(), f"csv_{role.value}") for role in CsvRole}
        self._labels = {role: named(QLabel(), f"csv_{role.value}_label") for role in CsvRole}
        self.read = control(QPushButton(), texts, "csv_read", "Read", picture=Icon.CHECK, role="primary",
                            slot=self._choose)  # fmt: skip
        self.cancel = control(QPushButton(), texts, "csv_cancel", "Cancel", key="Esc", slot=self.closed)
        card = named(QFrame(), "csv_card", "card")
        rows = QFormLayout(card)
        rows.setContentsMargins(Space.M, Space.M, Space.M, Space.M)
        rows.setVerticalSpacing(Space.XS)
        rows.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)
        for role, box in self.boxes.items():
            box.setModel(self._columns)
            box.setMinimumContentsLength(18)
            box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
            WheelGuard(box)
            self._labels[role].setBuddy(box)
            self._labels[role].setMinimumHeight(box.sizeHint().height())
            rows.addRow(self._labels[role], box)
        content = named(QWidget(), "csv_content")
        in_column(in_row((card, 2), 1), 1, of=content, margins=0)
        scroll = scroll_area(content, texts, "csv_scroll", "Columns")
        head = in_row((self.title, 1), self.cancel, self.read, spacing=Space.S)
        head.addStrut(HEIGHT_PX)
        in_column(head, self.fault, (scroll, 1), of=self, spacing=Space.S, margins=0)
        VisibilityTimer(self, retranslate=self._write)

    def show_file(self, name: str, head: Sequence[str]) -> None:
        self._name, self._fault = name, None
        self._columns.setStringList(["—", *head])
        for box in self.boxes.values():
            box.setCurrentIndex(0)
        self._write()
        self.boxes[CsvRole.TIME_S].setFocus()

    def _write(self) -> None:
        self.title.setText(labelled(tr("Columns"), short_name(self._name)))
        for role, label in self._labels.items():
            label.setText(role_text(role))
            self.boxes[role].setAccessibleName(label.text())
        self.fault.setText("" if self._fault is None else self._fault.sentence)
        self.fault.setVisible(self._fault is not None)

    def columns(self) -> CsvColumns:
        """The chosen columns. Raises `UserError` where they are not enough."""
        names = {role: box.currentText() for role, box in self.boxes.items() if box.currentIndex() > 0}
        if sum(role in names for role in TIMES) != 1:
            raise UserError(marked("Choose the one column with the time."))
        columns = CsvColumns(names)
        used = {*TIMES, *columns.attitude, *columns.force, CsvRole.ALTITUDE_M, CsvRole.ARMED}
        if names.keys() - used:
            raise UserError(marked("Choose all columns of an attitude and of an acceleration, or none."))
        return columns

    def _choose(self) -> None:
        try:
            self.chosen.emit(self._name, self.columns())
        except UserError as error:
            self._fault = error
            self._write()
