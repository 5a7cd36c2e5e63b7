"""The field for the name of the module."""

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QFocusEvent
from PySide6.QtWidgets import QComboBox, QLineEdit, QToolButton

from app.modules.labels import MAX_NAME_LENGTH
from app.text.i18n import tr
from ui.services.port import Ports
from ui.style.icons import Icon, icon
from ui.widgets.controls import named
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer


class _NameEdit(QLineEdit):
    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Another program that comes to the front interrupts whoever types; it ends no editing."""
        self.blockSignals(event.reason() is Qt.FocusReason.ActiveWindowFocusReason)
        super().focusOutEvent(event)
        self.blockSignals(False)


class ModuleField(QComboBox):
    """A name to type or choose, applied by Enter, by choosing, or by leaving the field for another of the window."""

    def __init__(self, name: str, ports: Ports) -> None:
        super().__init__()
        named(self, name)
        self._ports = ports
        self.setEditable(True)
        self.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.setMinimumContentsLength(8)
        self.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        WheelGuard(self)
        self._edit = edit = _NameEdit()
        self.setLineEdit(edit)
        self.setCompleter(None)  # type: ignore[arg-type]  # it would make M-12 of a typed M-1
        edit.setObjectName(f"{name}_edit")
        self.label = named(edit.addAction(icon(Icon.LABEL), QLineEdit.ActionPosition.TrailingPosition), f"{name}_label")
        self.label.triggered.connect(ports.label_wanted)
        self.label.setText(tr("Print labels"))
        for button in edit.findChildren(QToolButton):
            named(button, f"{name}_label_button").setAccessibleName(tr("Print labels"))
        edit.editingFinished.connect(self._apply)
        self.activated.connect(self._apply)
        self.setAccessibleName(tr("Module"))
        edit.setAccessibleName(tr("Module"))
        edit.setPlaceholderText(tr("not named"))
        self.setToolTip(tr("Without a serial number its name identifies it"))
        ports.renamed.connect(self.show_name)
        for is_over in (ports.invalidated, ports.broke_in_doubt):
            is_over.connect(self._end_editing)  # what was typed was meant for the former module
        ports.changed.connect(self._watch_identity)
        self._was_settled = ports.current.identity.is_settled
        VisibilityTimer(self, self.show_name)
        self.show_name()

    def show_name(self) -> None:
        if self._edit.isModified():
            return  # somebody types
        module = self._ports.current.module
        names = [known.name for known in module.known]
        with QSignalBlocker(self):
            self.clear()
            # As long as a label takes, or as one that another station or a command gave.
            self._edit.setMaxLength(max(MAX_NAME_LENGTH, *map(len, (*names, module.name))))
            self.addItems(names)
            self.setCurrentIndex(self.findText(module.name, Qt.MatchFlag.MatchExactly))
            self.setEditText(module.name)
            self.label.setVisible(bool(module.name))

    def _watch_identity(self) -> None:
        """What was typed before it came in doubt which module answers was meant for the one before."""
        was_settled, self._was_settled = self._was_settled, self._ports.current.identity.is_settled
        if was_settled and not self._was_settled:
            self._end_editing()

    def _apply(self) -> None:
        self._ports.current.module.choose(self.currentText())
        self._end_editing()

    def _end_editing(self) -> None:
        self._edit.setModified(False)
        self.show_name()
