"""The fold "Line and dialect": the options of the simulated module that can be changed while it runs."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import QCheckBox, QComboBox, QDoubleSpinBox, QFormLayout, QPushButton, QWidget

from app.simulator.bench import SimulatedBench
from app.simulator.options import BY_NAME, Option, default_text, parse_value
from protocol.text import marked
from ui.named import named
from ui.simulator_controls import NUMBER_PX, WheelGuard, describe, label_for
from ui.texts import Texts
from ui.theme import Space

PERCENT = 100.0
_SHARES = (
    ("drop", marked("Lost answers")),
    ("lose", marked("Lost bytes")),
    ("corrupt", marked("Turned bits")),
    ("garbage", marked("Garbage")),
    ("double", marked("Doubled answers")),
)
_TIMES = (
    ("delay_ms", marked("Delay")),
    ("jitter_ms", marked("Jitter")),
    ("split_ms", marked("Split, pause")),
    ("min_gap_ms", marked("Gap that the module needs")),
    ("lag_ms", marked("Lag of a wireless bridge")),
)
_FLAGS = (
    ("echo", marked("Echo of the host's bytes")),
    ("mute", marked("Mute")),
    ("half_duplex", marked("Half duplex")),
    ("light_inverted", marked("E11: light the other way round")),
    ("odd_voltage", marked("E12: records with 4.70 V")),
    ("remembers", marked("E15: remembers its state")),
    ("keeps", marked("Keeps what is set")),
    ("clamps", marked("Clamps what is set")),
    ("refuses", marked("Refuses what is set")),
)
_CHOICES = (
    ("direction", marked("Direction of faults")),
    ("ack", marked("E2: acknowledges by")),
    ("voltage_code", marked("E3: voltage code")),
    ("freefall_ack", marked("E4: code for 17")),
    ("records", marked("E6: records")),
    ("empty_slots", marked("E7: empty slots")),
    ("baud_ack", marked("E9: acknowledges")),
    ("stream", marked("Streams")),
)
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


class SimulatorOptions(QWidget):
    """One row for each option. `show_values` follows the bench without acting on it."""

    def __init__(self, texts: Texts, guard: WheelGuard, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("simulator_options")
        self._texts, self._guard = texts, guard
        self._bench: SimulatedBench | None = None
        self._show: dict[str, Callable[[Any], None]] = {}
        self._form = QFormLayout(self)
        self._form.setContentsMargins(0, 0, 0, 0)
        self._form.setHorizontalSpacing(Space.M)
        self._form.setVerticalSpacing(Space.S)
        self._form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        self._add_number(BY_NAME["rate"], marked("Stream rate"), unit=" Hz", maximum=1440, minimum=1)
        for name, title in _SHARES:
            self._add_number(BY_NAME[name], title, unit=" %", maximum=PERCENT, scale=1 / PERCENT)
        for name, title in _TIMES:
            self._add_number(BY_NAME[name], title, unit=" ms", maximum=2000)
        for name, title in _CHOICES:
            self._add_choice(BY_NAME[name], title)
        for name, title in _FLAGS:
            self._add_flag(BY_NAME[name], title)
        self.heal = named(QPushButton(), "simulator_heal")
        texts.bind(self.heal.setText, "End all faults")
        describe(texts, self.heal, marked("End all faults"), marked("Make the line perfect again; the dialect stays."))
        self.heal.clicked.connect(self._heal)
        self._form.addRow(self.heal)

    def use_bench(self, bench: SimulatedBench | None) -> None:
        self._bench = bench

    def show_values(self, values: Mapping[str, Any], *, rate_hz: float) -> None:
        """Follow the bench."""
        for name, show in self._show.items():
            show(rate_hz if name == "rate" else values[name])

    def _change(self, name: str, value: Any) -> None:
        if self._bench is not None:
            self._bench.change(**{name: value})

    def _heal(self) -> None:
        if self._bench is not None:
            self._bench.heal()

    def _add_number(
        self, option: Option, title: str, *, unit: str, maximum: float, minimum: float = 0.0, scale: float = 1.0
    ) -> None:
        box = named(QDoubleSpinBox(), f"simulator_{option.name}")
        box.setDecimals(0)
        box.setRange(minimum, maximum)
        box.setSuffix(unit)
        box.setMinimumWidth(NUMBER_PX)
        box.setKeyboardTracking(False)
        box.setAlignment(Qt.AlignmentFlag.AlignRight)
        box.valueChanged.connect(lambda value: self._change(option.name, value * scale))

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
        box.activated.connect(lambda number: self._change(option.name, values[number]))
        self._add(option, title, box, lambda value: box.setCurrentIndex(values.index(value)))

    def _add_flag(self, option: Option, title: str) -> None:
        box = named(QCheckBox(), f"simulator_{option.name}")
        self._texts.bind(box.setText, title)
        box.clicked.connect(lambda is_checked: self._change(option.name, is_checked))
        self._add(option, title, box, box.setChecked)

    def _add(self, option: Option, title: str, widget: QWidget, show: Callable[[Any], None]) -> None:
        self._guard.guard(widget)
        describe(self._texts, widget, title, option.text)
        self._show[option.name] = show
        show(parse_value(option, default_text(option)))
        if isinstance(widget, QCheckBox):
            self._form.addRow(widget)
        elif isinstance(widget, QComboBox):  # below its label, so that a narrow dock shows its words whole
            label = label_for(self._texts, widget, title)
            label.setMinimumHeight(0)
            self._form.addRow(label)
            self._form.addRow(widget)
        else:
            self._form.addRow(label_for(self._texts, widget, title), widget)
