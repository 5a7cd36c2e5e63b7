"""Fields of "Would it have fired?", created from the catalogue, and the tried thresholds as lines in the plots."""

from collections.abc import Mapping, Sequence
from functools import partial
from math import inf
from typing import Final

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QLayout, QSizePolicy, QVBoxLayout, QWidget

from app.firing.what_if_drafts import (
    ATTITUDE_TRIGGER,
    FREEFALL_TRIGGER,
    TITLES,
    TRIED,
    SettingSource,
    WhatIfDrafts,
)
from app.samples.step_function import StepFunction
from protocol.catalogue import Command
from protocol.fields import Value
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.forms.field_editors import FieldEditor, FlagEditor, make_editor
from ui.plots.lanes import Lane, Limit
from ui.style.theme import Meaning, Space
from ui.widgets.controls import control
from ui.widgets.layouts import FlowRow, in_row
from ui.widgets.sliders import WheelGuard

_SWITCH_PX: Final = 116
"""Includes the check mark, in sunlight too."""
_LABELS: Final = TITLES | {ATTITUDE_TRIGGER.key: marked("Attitude"), FREEFALL_TRIGGER.key: marked("Free fall")}
"""Short enough for the switches beside them."""


class WhatIfFields(QWidget):
    """Edits the tried values; a field without one shows the module's value, muted."""

    changed = Signal()

    def __init__(self, drafts: WhatIfDrafts, texts: Texts, guard: WheelGuard) -> None:
        super().__init__()
        self.setObjectName("fired_fields")
        self._drafts = drafts
        self.editors: dict[str, FieldEditor] = {}
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        for command in TRIED:
            label = control(QLabel(), texts, f"fired_{command.name}_label", _LABELS[command.key], role="caption")
            editor = self._editor(command, texts, guard)
            label.setBuddy(editor.focusProxy() or editor)
            column.addLayout(_row(label, editor))
            self.editors[command.key] = editor
        self._shown: Mapping[str, tuple[Value | None, SettingSource | None]] = {}
        self.show_drafts()

    def show_drafts(self) -> None:
        drafts = self._drafts
        shown = {key: (drafts.values.get(key), drafts.standing.get(key)) for key in self.editors}
        for key, (edited, source) in shown.items():
            if self._shown.get(key, ()) != (edited, source):
                self._show(key, edited, source)
        self._shown = shown

    def _show(self, key: str, edited: Value | None, source: SettingSource | None) -> None:
        editor, value = self.editors[key], None if source is None else source.value
        if isinstance(editor, FlagEditor) and edited is None:
            edited = value  # a switch has nothing muted
        editor.show_value(edited, value)

    def _editor(self, command: Command, texts: Texts, guard: WheelGuard) -> FieldEditor:
        editor = make_editor(command, texts, guard)
        # The Settings page has the same names.
        editor.setObjectName(f"fired_{command.name}")
        for child in editor.findChildren(QWidget):
            child.setObjectName(f"fired_{child.objectName()}")
        drafts, key = self._drafts, command.key
        editor.chosen.connect(lambda value: self._do(partial(drafts.choose, key, value)))
        if isinstance(editor, FlagEditor):
            editor.cancelled.connect(lambda: self._do(partial(drafts.withdraw, key)))
            for button in (editor.on, editor.off):
                button.setMinimumWidth(_SWITCH_PX)
        return editor

    def _do(self, act: "partial[None]") -> None:
        act()
        self._shown = {}  # the clicked button has already changed itself
        self.show_drafts()
        self.changed.emit()


def _row(label: QLabel, editor: FieldEditor) -> QLayout:
    """The label of a number wraps; a switch wraps below its label."""
    if isinstance(editor, FlagEditor):
        flow = FlowRow()
        flow.add(label)
        flow.add_right(editor)
        return flow
    label.setWordWrap(True)
    label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
    return in_row((label, 1), editor, spacing=Space.S)


class DraftLines:
    """Constant lines, shared by all plots, which have to be drawn again after a change."""

    def __init__(self) -> None:
        self.attitude: Final = StepFunction()
        self.freefall: Final = StepFunction()

    def show(self, attitude_deg: float | None, freefall_g: float | None) -> bool:
        """Sets both lines, None: no line; returns whether anything changed."""
        is_other = (attitude_deg, freefall_g) != (self.attitude.value, self.freefall.value)
        for line, value in ((self.attitude, attitude_deg), (self.freefall, freefall_g)):
            line.clear()
            line.put(-inf, value)
        return is_other

    def added_to(self, lanes: Sequence[Lane]) -> tuple[Lane, ...]:
        """`lanes`, of which the first are tilt and acceleration, with these lines added."""
        tilt, acceleration, *others = lanes
        fires = Limit(self.attitude, marked("{value}° draft"), Meaning.ATTENTION, is_draft=True)
        falls = Limit(self.freefall, marked("{value} g draft"), Meaning.ATTENTION, 1, is_draft=True)
        return (
            tilt._replace(limits=(*tilt.limits, fires)),
            acceleration._replace(limits=(*acceleration.limits, falls)),
            *others,
        )
