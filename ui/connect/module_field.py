"""Editable combo box for the name of the module."""

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtWidgets import QComboBox, QLineEdit

from ui.core.texts import Texts
from ui.services.module_name import MAX_NAME_LENGTH, ModuleName
from ui.widgets.naming import named
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer


class ModuleField(QComboBox):
    """A name to type or choose, applied by Enter, by leaving the field, or by choosing."""

    def __init__(self, name: str, naming: ModuleName, texts: Texts, guard: WheelGuard) -> None:
        super().__init__()
        named(self, name)
        self._naming = naming
        self.setEditable(True)
        self.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        self.setMinimumContentsLength(8)
        self.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        guard.guard(self)
        edit = QLineEdit()
        self.setLineEdit(edit)
        edit.setObjectName(f"{name}_edit")
        edit.setMaxLength(MAX_NAME_LENGTH)
        edit.editingFinished.connect(self._apply)
        self.activated.connect(self._apply)
        texts.bind(self.setAccessibleName, "Module")
        texts.bind(edit.setAccessibleName, "Module")
        texts.bind(edit.setPlaceholderText, "not named")
        texts.bind(self.setToolTip, "Without a serial number its name identifies it")
        naming.changed.connect(self.show_name)
        VisibilityTimer(self, self.show_name)
        self.show_name()

    def show_name(self) -> None:
        with QSignalBlocker(self):
            self.clear()
            self.addItems([one.name for one in self._naming.known])
            self.setCurrentIndex(self.findText(self._naming.name, Qt.MatchFlag.MatchExactly))
            self.setEditText(self._naming.name)

    def _apply(self) -> None:
        self._naming.choose(self.currentText())
        self.setEditText(self._naming.name)
