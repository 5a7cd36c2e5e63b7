"""The field for the name of the module, which a person says again in each conversation."""

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QFocusEvent
from PySide6.QtWidgets import QComboBox, QLineEdit

from app.modules.labels import MAX_NAME_LENGTH
from app.text.i18n import tr
from ui.session.ports import Ports
from ui.session.shown_module import ShownModule
from ui.widgets.controls import named
from ui.widgets.number_line import WheelGuard


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
        self._edit = named(_NameEdit(), f"{name}_edit")
        self.setLineEdit(self._edit)
        self.setCompleter(None)  # type: ignore[arg-type]  # it would make M-12 of a typed M-1
        self._edit.editingFinished.connect(self.apply)
        self.activated.connect(self.apply)
        for part in (self, self._edit):
            part.setAccessibleName(tr("Module"))
        self._edit.setPlaceholderText(tr("not named"))
        self.setToolTip(tr("Without a serial number its name identifies it"))
        ports.shown.connect(self._show_module)
        self._module: ShownModule | None = None
        self._show_module(ports.module)

    def _show_module(self, module: ShownModule) -> None:
        """Show another module: what was typed was meant for the former one."""
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
        self.setEnabled(self._ports.module.can_be_named)

    def show_name(self) -> None:
        if self._edit.isModified():
            return  # somebody types
        name, names = self._ports.module.name, self._ports.known_names()
        with QSignalBlocker(self):
            self.clear()
            # As long as a label takes, or as one that another station or a command gave.
            self._edit.setMaxLength(max(MAX_NAME_LENGTH, *map(len, (*names, name))))
            self.addItems(names)
            self.setCurrentIndex(self.findText(name, Qt.MatchFlag.MatchExactly))
            self.setEditText(name)

    def apply(self) -> None:
        """Say the name that stands in the field."""
        text = self.currentText().strip()
        self._edit.setModified(False)
        if text != self._ports.module.name:
            self._ports.module.name_it(text)
        self.show_name()
