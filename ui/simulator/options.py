"""Collapsible options of the simulated module's panel."""

from collections.abc import Callable
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
from app.simulator.setup import OPTIONS, Group, Option, Setup, as_text, default_text, parse_value
from app.text.user_error import UserError
from ui.core.texts import Texts
from ui.style.theme import Space
from ui.widgets.controls import control, named
from ui.widgets.sliders import NUMBER_PX, WheelGuard, label_for

PERCENT = 100.0
_SECTIONS = {"line": Group.FAULTS, "protocol": Group.QUIRKS, "defects": Group.DEFECTS}
_NUMBERS = {
    "SHARE": (" %", 0.0, PERCENT, 1 / PERCENT),
    "HZ": (" Hz", 1.0, 1440.0, 1.0),
    "MS": (" ms", 0.0, 10_000.0, 1.0),
    "S": (" s", 0.0, 86_400.0, 1.0),
}
"""By metavar: unit, minimum, maximum, and the option's value for one step."""


class OptionRows(QWidget):
    """One row for each option of a group."""

    changed = Signal(str, object)
    """Name and value of an option that the user changed."""

    def __init__(self, texts: Texts, guard: WheelGuard, group: Group) -> None:
        super().__init__()
        self._texts, self._guard = texts, guard
        self._show: dict[str, Callable[[Any], None]] = {}
        self.form = QFormLayout(self)
        self.form.setContentsMargins(0, 0, 0, 0)
        self.form.setHorizontalSpacing(Space.M)
        self.form.setVerticalSpacing(Space.S)
        self.form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        self.form.setRowWrapPolicy(QFormLayout.RowWrapPolicy.WrapLongRows)  # for narrow docks
        for option in (option for option in OPTIONS if option.group is group):
            if option.is_flag:
                self._add_flag(option)
            elif option.choices:
                self._add_choice(option)
            elif option.metavar in _NUMBERS:
                self._add_number(option)
            else:
                self._add_text(option)

    def show_setup(self, setup: Setup) -> None:
        """Show these values without emitting `changed`."""
        for name, show in self._show.items():
            show(getattr(setup, name))

    def _add_number(self, option: Option) -> None:
        unit, minimum, maximum, scale = _NUMBERS[str(option.metavar)]
        box = named(QDoubleSpinBox(), f"simulator_option_{option.name}")
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

        self._add(option, box, show)

    def _add_choice(self, option: Option) -> None:
        box = named(QComboBox(), f"simulator_option_{option.name}")
        box.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        box.setMinimumContentsLength(6)
        box.addItems(option.choices)
        values = [parse_value(option, choice) for choice in option.choices]
        box.activated.connect(lambda number: self.changed.emit(option.name, values[number]))
        self._add(option, box, lambda value: box.setCurrentIndex(values.index(value)))

    def _add_flag(self, option: Option) -> None:
        box = control(QCheckBox(), self._texts, f"simulator_option_{option.name}", option.text,
                      slot=lambda is_checked: self.changed.emit(option.name, is_checked))  # fmt: skip
        self._add(option, box, box.setChecked)

    def _add_text(self, option: Option) -> None:
        box = named(QLineEdit(), f"simulator_option_{option.name}")
        refusal = named(QLabel(), f"simulator_option_{option.name}_refusal", "danger")
        refusal.setWordWrap(True)
        refusal.hide()

        def finish() -> None:
            if not box.isModified():
                return
            box.setModified(False)
            try:
                value = parse_value(option, box.text())
            except UserError as error:
                self._texts.bind(refusal.setText, error.message.text, **dict(error.message.values))
                refusal.show()
            else:
                refusal.hide()
                self.changed.emit(option.name, value)

        def show(value: Any) -> None:
            if not (box.hasFocus() or refusal.isVisible()):
                box.setText(as_text(value))

        box.editingFinished.connect(finish)
        self._add(option, box, show)
        self.form.addRow(refusal)

    def _add(self, option: Option, widget: QWidget, show: Callable[[Any], None]) -> None:
        self._guard.guard(widget)
        control(widget, self._texts, widget.objectName(), says=option.text)
        widget.setToolTip(f"{option.flag} {option.metavar or ''}")
        self._show[option.name] = show
        show(parse_value(option, default_text(option)))
        if isinstance(widget, QCheckBox):
            self.form.addRow(widget)
        elif isinstance(widget, QDoubleSpinBox):
            self.form.addRow(label_for(self._texts, widget, option.text), widget)
        else:  # below its label, for narrow docks
            label = label_for(self._texts, widget, option.text)
            label.setMinimumHeight(0)
            self.form.addRow(label)
            self.form.addRow(widget)


class SimulatorOptions(QWidget):
    """A collapsible section for each group of options, initially closed."""

    unfolded = Signal()

    def __init__(self, texts: Texts, guard: WheelGuard) -> None:
        super().__init__()
        self.setObjectName("simulator_options")
        self._bench: SimulatedBench | None = None
        self.folds: dict[str, QToolButton] = {}
        self._rows: list[OptionRows] = []
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(Space.S)
        for name, group in _SECTIONS.items():
            fold = control(QToolButton(), texts, f"simulator_fold_{name}", group.value, role="quiet", is_checkable=True)
            fold.setArrowType(Qt.ArrowType.RightArrow)
            fold.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            body = named(OptionRows(texts, guard, group), f"simulator_{name}_rows")
            body.changed.connect(self._change)
            body.hide()
            fold.toggled.connect(partial(self._unfold, fold, body))
            layout.addWidget(fold)
            layout.addWidget(body)
            self.folds[name] = fold
            self._rows.append(body)
        self.heal = control(QPushButton(), texts, "simulator_heal", "End all faults", slot=self._end_faults)
        self._rows[0].form.addRow(self.heal)

    @property
    def widest_px(self) -> int:
        """Width of the widest row, also of closed sections."""
        return max(rows.minimumSizeHint().width() for rows in self._rows)

    def use_bench(self, bench: SimulatedBench | None) -> None:
        self._bench = bench

    def show_setup(self, setup: Setup) -> None:
        """Show these values in the open sections."""
        for rows in self._rows:
            if rows.isVisible():
                rows.show_setup(setup)

    def _unfold(self, fold: QToolButton, rows: OptionRows, is_open: bool) -> None:
        fold.setArrowType(Qt.ArrowType.DownArrow if is_open else Qt.ArrowType.RightArrow)
        rows.setVisible(is_open)
        self.unfolded.emit()

    def _change(self, name: str, value: Any) -> None:
        if self._bench is not None:
            self._bench.change(**{name: value})

    def _end_faults(self) -> None:
        if self._bench is not None:
            self._bench.end_faults()
