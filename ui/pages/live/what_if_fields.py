"""Fields of "Would it have fired?", created from the catalogue."""

from collections.abc import Mapping
from functools import partial
from typing import Final

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QLayout, QSizePolicy, QVBoxLayout, QWidget

from app.firing.what_if_drafts import TRIED, SettingSource, Wanted
from app.settings.drafts import Draft
from protocol.catalogue import Command
from ui.core.texts import Texts
from ui.forms.field_editors import FieldEditor, FlagEditor, make_editor
from ui.style.theme import Space
from ui.widgets.layouts import FlowRow, in_row
from ui.widgets.naming import named
from ui.widgets.sliders import WheelGuard

_SWITCH_PX: Final = 108
"""With the sign of the chosen one."""


class WhatIfFields(QWidget):
    """Edits what is wanted; where nothing is, a field shows what the module has, in the colour of what is not typed."""

    changed = Signal()

    def __init__(self, wanted: Wanted, texts: Texts, guard: WheelGuard) -> None:
        super().__init__()
        self.setObjectName("fired_fields")
        self._wanted = wanted
        self.editors: dict[str, FieldEditor] = {}
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        for command in TRIED:
            label = named(QLabel(), f"fired_{command.name}_label")
            label.setProperty("role", "caption")
            texts.bind(label.setText, command.title)
            editor = self._editor(command, texts, guard)
            label.setBuddy(editor.focusProxy() or editor)
            column.addLayout(_row(label, editor))
            self.editors[command.key] = editor
        self._shown: Mapping[str, tuple[Draft | None, SettingSource | None]] = {}
        self.show_wanted()

    def show_wanted(self) -> None:
        """Everything as it is wanted and known now."""
        wanted = self._wanted
        shown = {key: (wanted.draft(key), wanted.standing.get(key)) for key in self.editors}
        for key, (draft, standing) in shown.items():
            if self._shown.get(key, ()) != (draft, standing):
                self._show(key, draft, standing)
        self._shown = shown

    def _show(self, key: str, draft: Draft | None, standing: SettingSource | None) -> None:
        editor, stands = self.editors[key], None if standing is None else standing.value
        if isinstance(editor, FlagEditor) and draft is None and isinstance(stands, bool):
            draft = Draft("", stands)  # a switch has no other way to show what the module has
        editor.show_draft(draft, stands)

    def _editor(self, command: Command, texts: Texts, guard: WheelGuard) -> FieldEditor:
        editor = make_editor(command, texts, guard)
        # The same names stand on the Settings page.
        editor.setObjectName(f"fired_{command.name}")
        for child in editor.findChildren(QWidget):
            child.setObjectName(f"fired_{child.objectName()}")
        wanted, key = self._wanted, command.key
        editor.typed.connect(lambda text: self._do(partial(wanted.type_text, key, text)))
        editor.chosen.connect(lambda value: self._do(partial(wanted.choose, key, value)))
        if isinstance(editor, FlagEditor):
            editor.cancelled.connect(lambda: self._do(partial(wanted.withdraw, key)))
            for button in (editor.on, editor.off):
                button.setMinimumWidth(_SWITCH_PX)
        return editor

    def _do(self, act: "partial[None]") -> None:
        act()
        self._shown = {}  # a button that was pressed has changed its own looks already
        self.show_wanted()
        self.changed.emit()


def _row(label: QLabel, editor: FieldEditor) -> QLayout:
    """The name of a number breaks; the words of a switch cannot, so that goes below where it has to."""
    if isinstance(editor, FlagEditor):
        flow = FlowRow()
        flow.add(label)
        flow.add_right(editor)
        return flow
    label.setWordWrap(True)
    label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
    return in_row((label, 1), editor, spacing=Space.S)
