"""Which module is it? The field in which a person says its name, and what speaks against it."""

from PySide6.QtCore import QObject, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QFocusEvent
from PySide6.QtWidgets import QComboBox, QLineEdit, QToolButton

from app.modules.labels import MAX_NAME_LENGTH
from app.modules.names import what_differs
from app.text.i18n import tr
from app.text.messages import join_sentences
from ui.session.ports import Ports
from ui.session.shown_module import ShownModule
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning
from ui.widgets.controls import named
from ui.widgets.notice_bar import Choice, Notice
from ui.widgets.number_line import WheelGuard


class NameQuestion(QObject):
    """Of the module that is shown. Where nothing speaks against a name, one press says it; else a second one is
    needed, beside what speaks against it. Neither is ever the default button."""

    changed = Signal()
    """There is another notice."""

    def __init__(self, ports: Ports) -> None:
        super().__init__(ports)
        self._ports = ports
        self._wanted = ""
        """A name against which something speaks, and that a person has said once."""
        self._is_declined = False
        """A person does not want to be asked for the former name in this conversation."""
        self._watched: ShownModule | None = None
        ports.name_wanted.connect(self.say)
        ports.shown.connect(self._on_shown)

    def say(self, name: str) -> None:
        module = self._ports.module
        if not module.is_going or not module.is_read:
            return
        if name and module.what_speaks_against(name) and name != self._wanted:
            self._wanted = name
        else:
            self._wanted = ""
            self._is_declined = True
            module.say_name(name)
        self.changed.emit()

    def notice(self) -> Notice | None:
        """None while there is nothing to ask."""
        port = self._ports.current
        module = port.module
        if not module.is_going or not module.is_read:
            return None
        is_answered = self._is_declined or bool(module.name)
        name = self._wanted or ("" if is_answered else port.last_name)
        if not name:
            return None
        against = module.what_speaks_against(name)
        parts = [tr("Is it {module}?", module=name)]
        parts += [tr("Against it: {what}.", what=what.translated()) for what in against]
        known = module.remembered(name)
        if known is not None:
            differs = [text.translated() for text in what_differs(known, module.view, module.now_s)]
            if differs:
                parts.append(tr("Settings: {what}.", what="; ".join(differs)))
        yes = tr("It is {module}", module=name)
        if self._wanted:
            yes = tr("It is {module} all the same", module=name)
        return Notice(
            Meaning.ATTENTION if against else Meaning.INFORMATION,
            join_sentences(parts),
            (
                Choice("name_same", yes, lambda: self.say(name), is_step=True),
                Choice("name_other", tr("Another module"), self._decline),
            ),
        )

    def _decline(self) -> None:
        self._wanted = ""
        self._is_declined = True
        self._ports.current.last_name = ""
        self.changed.emit()

    def _on_shown(self, module: ShownModule) -> None:
        self._wanted = ""
        self._is_declined = False
        if module is not self._watched:  # the same port may be chosen again
            self._watched = module
            module.changed.connect(self.changed)
        self.changed.emit()


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
