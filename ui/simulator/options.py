"""Collapsible options of the simulated module's panel."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.simulator.bench import SimulatedBench
from app.simulator.options import BY_NAME, Option, OptionRefused, as_text, default_text, parse_value
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.naming import named
from ui.widgets.sliders import NUMBER_PX, WheelGuard, label_for

PERCENT = 100.0
Rows = tuple[tuple[str, str], ...]
_LINE: Rows = (
    ("rate", marked("Stream rate")),
    ("drop", marked("Lost answers")),
    ("lose", marked("Lost bytes")),
    ("corrupt", marked("Bit errors")),
    ("garbage", marked("Garbage")),
    ("double", marked("Duplicate replies")),
    ("direction", marked("Direction of faults")),
    ("delay_ms", marked("Delay")),
    ("jitter_ms", marked("Jitter")),
    ("split_ms", marked("Split, pause")),
    ("min_gap_ms", marked("Minimum gap")),
    ("lag_ms", marked("Wireless lag")),
    ("echo", marked("Echo of the host's bytes")),
    ("mute", marked("Mute")),
    ("half_duplex", marked("Half duplex")),
)
_DIALECT: Rows = (
    ("ack", marked("E2: acknowledges by")),
    ("voltage_code", marked("E3: voltage code")),
    ("freefall_ack", marked("E4: code for 17")),
    ("records", marked("E6: records")),
    ("empty_slots", marked("E7: empty slots")),
    ("baud_ack", marked("E9: acknowledges")),
    ("stream", marked("Streams")),
    ("light_inverted", marked("E11: light the other way round")),
    ("odd_voltage", marked("E12: records with 4.70 V")),
    ("remembers", marked("E15: remembers its state")),
    ("keeps", marked("Keeps what is set")),
    ("clamps", marked("Clamps what is set")),
    ("refuses", marked("Refuses what is set")),
)
_LIES: Rows = (
    ("cross_talk", marked("Set changes other")),
    ("read_changes", marked("Query changes")),
    ("revert_ms", marked("Reverts after")),
    ("clamp_ms", marked("Clamps after")),
    ("silent_restart_ms", marked("Silent restart after")),
    ("restart_at_s", marked("Silent restart every")),
    ("forgets", marked("A restart loses the settings")),
    ("mute_codes", marked("Not answered")),
    ("double_codes", marked("Answered twice")),
    ("double_ms", marked("Repeated after")),
    ("foreign_replies", marked("Foreign answers")),
    ("drop_records", marked("Records left out")),
    ("stream_jitter_ms", marked("Jitter of the stream")),
    ("active_late_ms", marked("Reports active late")),
    ("activates", marked("Activates")),
    ("locks", marked("Locks")),
    ("zeroes", marked("Zeroes")),
    ("shuts_down", marked("Shuts down")),
)
_SECTIONS = (
    ("line", marked("Faults of the line"), marked("What goes wrong between computer and module."), _LINE),
    ("dialect", marked("Protocol differences"), marked("Ways that the vendor's table leaves open."), _DIALECT),
    ("lies", marked("Lies and defects"), marked("What a module does other than it says."), _LIES),
)
_NUMBERS = {
    "SHARE": (" %", 0.0, PERCENT, 1 / PERCENT),
    "HZ": (" Hz", 1.0, 1440.0, 1.0),
    "MS": (" ms", 0.0, 10_000.0, 1.0),
    "S": (" s", 0.0, 86_400.0, 1.0),
}
"""By metavar: unit, smallest, largest, and the option's value for one step."""
_WORDS = {
    "to-host": marked("to the host"),
    "to-module": marked("to the module"),
    "both": marked("both ways"),
    "echo": marked("the value"),
    "one": marked("01"),
    "together": marked("in one go"),
    "spaced": marked("one by one"),
    "pieces": marked("in pieces"),
    "none": marked("left out"),
    "zeros": marked("sent as 00"),
    "ones": marked("sent as FF"),
    "old": marked("at the old rate"),
    "new": marked("at the new rate"),
    "restart": marked("at a restart"),
    "yes": marked("yes"),
    "acknowledged": marked("acknowledged only"),
    "silent": marked("not answered"),
}


class OptionRows(QWidget):
    """One row for each option. `show_values` follows the bench without acting on it."""

    changed = Signal(str, object)
    """Name and value of an option that a person changed."""

    def __init__(self, texts: Texts, guard: WheelGuard, rows: Rows) -> None:
        super().__init__()
        self._texts, self._guard = texts, guard
        self._show: dict[str, Callable[[Any], None]] = {}
        self.form = QFormLayout(self)
        self.form.setContentsMargins(0, 0, 0, 0)
        self.form.setHorizontalSpacing(Space.M)
        self.form.setVerticalSpacing(Space.S)
        self.form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        for name, title in rows:
            option = BY_NAME[name]
            if option.is_flag:
                self._add_flag(option, title)
            elif option.choices:
                self._add_choice(option, title)
            elif option.metavar in _NUMBERS:
                self._add_number(option, title)
            else:
                self._add_text(option, title)

    def show_values(self, values: Mapping[str, Any]) -> None:
        """Follow the bench."""
        for name, show in self._show.items():
            show(values[name])

    def _add_number(self, option: Option, title: str) -> None:
        unit, minimum, maximum, scale = _NUMBERS[str(option.metavar)]
        box = named(QDoubleSpinBox(), f"simulator_{option.name}")
        box.setDecimals(0)
        box.setRange(minimum, maximum)
        box.setSuffix(unit)
        box.setMinimumWidth(NUMBER_PX)
        box.setKeyboardTracking(False)
        box.setAlignment(Qt.AlignmentFlag.AlignRight)
        box.valueChanged.connect(lambda value: self.changed.emit(option.name, value * scale))

        def show(value: float) -> None:
            if not box.hasFocus():
                with QSignalBlocker(box):
                    box.setValue(value / scale)

        self._add(option, title, box, show)

    def _add_choice(self, option: Option, title: str) -> None:
        box = named(QComboBox(), f"simulator_{option.name}")
        box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        box.setMinimumContentsLength(6)
        for number, choice in enumerate(option.choices):
            box.addItem(choice)
            if choice in _WORDS:
                self._texts.bind(partial(box.setItemText, number), _WORDS[choice])
        values = [parse_value(option, choice) for choice in option.choices]
        box.activated.connect(lambda number: self.changed.emit(option.name, values[number]))
        self._add(option, title, box, lambda value: box.setCurrentIndex(values.index(value)))

    def _add_flag(self, option: Option, title: str) -> None:
        box = control(QCheckBox(), self._texts, f"simulator_{option.name}", title,
                      slot=lambda is_checked: self.changed.emit(option.name, is_checked))  # fmt: skip
        self._add(option, title, box, box.setChecked)

    def _add_text(self, option: Option, title: str) -> None:
        box = named(QLineEdit(), f"simulator_{option.name}")
        refusal = named(QLabel(), f"simulator_{option.name}_refusal", "danger")
        refusal.setWordWrap(True)
        refusal.hide()

        def finish() -> None:
            if not box.isModified():
                return
            box.setModified(False)
            try:
                value = parse_value(option, box.text())
            except OptionRefused as error:
                refusal.setText(str(error))
                refusal.show()
            else:
                refusal.hide()
                self.changed.emit(option.name, value)

        def show(value: Any) -> None:
            if not (box.hasFocus() or refusal.isVisible()):
                box.setText(as_text(value))

        box.editingFinished.connect(finish)
        self._add(option, title, box, show)
        self.form.addRow(refusal)

    def _add(self, option: Option, title: str, widget: QWidget, show: Callable[[Any], None]) -> None:
        self._guard.guard(widget)
        control(widget, self._texts, widget.objectName(), says=title, tip=option.text)
        self._show[option.name] = show
        show(parse_value(option, default_text(option)))
        if isinstance(widget, QCheckBox):
            self.form.addRow(widget)
        elif isinstance(widget, QDoubleSpinBox):
            self.form.addRow(label_for(self._texts, widget, title), widget)
        else:  # below its label, so that a narrow dock shows it whole
            label = label_for(self._texts, widget, title)
            label.setMinimumHeight(0)
            self.form.addRow(label)
            self.form.addRow(widget)


class SimulatorOptions(QWidget):
    """A fold for each kind of option, closed at first."""

    unfolded = Signal()

    def __init__(self, texts: Texts, guard: WheelGuard, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("simulator_options")
        self._bench: SimulatedBench | None = None
        self.folds: dict[str, QToolButton] = {}
        self._rows: list[OptionRows] = []
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(Space.S)
        for name, title, explanation, rows in _SECTIONS:
            fold = control(QToolButton(), texts, f"simulator_fold_{name}", title, tip=explanation, role="quiet",
                           is_checkable=True)  # fmt: skip
            fold.setArrowType(Qt.ArrowType.RightArrow)
            fold.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            body = named(OptionRows(texts, guard, rows), f"simulator_{name}_rows")
            body.changed.connect(self._change)
            body.hide()
            fold.toggled.connect(partial(self._unfold, fold, body))
            layout.addWidget(fold)
            layout.addWidget(body)
            self.folds[name] = fold
            self._rows.append(body)
        self.heal = control(QPushButton(), texts, "simulator_heal", "End all faults", slot=self._heal,
                            tip="Make the line perfect; quirks stay.")  # fmt: skip
        self._rows[0].form.addRow(self.heal)

    @property
    def widest_px(self) -> int:
        """Of all folds, also of those that are closed."""
        return max(rows.minimumSizeHint().width() for rows in self._rows)

    def use_bench(self, bench: SimulatedBench | None) -> None:
        self._bench = bench

    def show_values(self, values: Mapping[str, Any], *, rate_hz: float) -> None:
        """Follow the bench, as far as it is in sight."""
        for rows in self._rows:
            if rows.isVisible():
                rows.show_values({**values, "rate": rate_hz})

    def _unfold(self, fold: QToolButton, rows: OptionRows, is_open: bool) -> None:
        fold.setArrowType(Qt.ArrowType.DownArrow if is_open else Qt.ArrowType.RightArrow)
        rows.setVisible(is_open)
        self.unfolded.emit()

    def _change(self, name: str, value: Any) -> None:
        if self._bench is not None:
            self._bench.change(**{name: value})

    def _heal(self) -> None:
        if self._bench is not None:
            self._bench.heal()
