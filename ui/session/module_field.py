"""The field for the name of the module, which a person says again in each conversation."""

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QFocusEvent
from PySide6.QtWidgets import QComboBox, QLineEdit, QToolButton

from app.modules.labels import MAX_NAME_LENGTH
from app.text.i18n import tr
from ui.session.ports import Ports
from ui.session.shown_module import ShownModule
from ui.style.icons import Icon, icon
from ui.widgets.controls import named
from ui.widgets.sliders import WheelGuard


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
        edit.editingFinished.connect(self.apply)
        self.activated.connect(self.apply)
        self.setAccessibleName(tr("Module"))
        edit.setAccessibleName(tr("Module"))
        edit.setPlaceholderText(tr("not named"))
        self.setToolTip(tr("Without a serial number its name identifies it"))
        ports.shown.connect(self._show_module)
        self._module: ShownModule | None = None
        self._show_module(ports.module)

    def _show_module(self, module: ShownModule) -> None:
        """What was typed was meant for the former one."""
        if self._module is not None:
            self._module.named.disconnect(self.show_name)
            self._module.changed.disconnect(self._enable)
        self._module = module
        module.named.connect(self.show_name)
        module.changed.connect(self._enable)
        self._edit.setModified(False)
        self.show_name()
        self._enable()

    def _enable(self) -> None:
        """A name is said after everything was read, so that what speaks against it can be shown."""
        module = self._ports.module
        self.setEnabled(module.is_going and module.is_read)

    def show_name(self) -> None:
        if self._edit.isModified():
            return  # somebody types
        module = self._ports.module
        names = self._ports.known_names()
        with QSignalBlocker(self):
            self.clear()
            # As long as a label takes, or as one that another station or a command gave.
            self._edit.setMaxLength(max(MAX_NAME_LENGTH, *map(len, (*names, module.name))))
            self.addItems(names)
            self.setCurrentIndex(self.findText(module.name, Qt.MatchFlag.MatchExactly))
            self.setEditText(module.name)
            self.label.setVisible(bool(module.name))

    def apply(self) -> None:
        """Say the name that stands in the field."""
        text = self.currentText().strip()
        self._edit.setModified(False)
        if text != self._ports.module.name:
            self._ports.name_wanted.emit(text)
        self.show_name()
