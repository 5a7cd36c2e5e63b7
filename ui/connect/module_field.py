"""Editable combo box for the name of the module."""

from PySide6.QtCore import QEvent, QSignalBlocker, Qt
from PySide6.QtWidgets import QComboBox, QLineEdit

from ui.core.texts import Texts
from ui.services.module_name import LONGEST_NAME, ModuleName
from ui.widgets.naming import named
from ui.widgets.sliders import WheelGuard


class ModuleField(QComboBox):
    """A name to type or to choose; it counts when the field is left, at Enter, or when one is chosen."""

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
        edit.setMaxLength(LONGEST_NAME)
        edit.editingFinished.connect(self._take)
        self.activated.connect(self._take)
        texts.bind(self.setAccessibleName, "Module")
        texts.bind(edit.setAccessibleName, "Module")
        texts.bind(edit.setPlaceholderText, "not named")
        texts.bind(self.setToolTip, "Without a serial number its name identifies it")
        naming.changed.connect(self.show_name)
        self.show_name()

    def show_name(self) -> None:
        with QSignalBlocker(self):
            self.clear()
            self.addItems([one.name for one in self._naming.known])
            self.setCurrentIndex(self.findText(self._naming.name, Qt.MatchFlag.MatchExactly))
            self.setEditText(self._naming.name)

    def _take(self) -> None:
        self._naming.choose(self.currentText())
        self.setEditText(self._naming.name)

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Show:
            self.show_name()
        return super().event(event)
