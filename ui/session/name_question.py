"""Which module is it? A person says its name again in each conversation; what speaks against it stands beside."""

from PySide6.QtCore import QObject, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QFocusEvent
from PySide6.QtWidgets import QComboBox, QLineEdit

from app.modules.labels import MAX_NAME_LENGTH
from app.modules.names import what_differs
from app.text.i18n import tr
from app.text.messages import join_sentences
from ui.session.ports import Ports
from ui.session.shown_module import ShownModule
from ui.style.theme import Meaning
from ui.widgets.controls import named
from ui.widgets.notice_bar import Choice, Notice
from ui.widgets.number_line import WheelGuard


class NameQuestion(QObject):
    """Of the module that is shown. Where nothing speaks against a name, one press says it; else a second one is
    needed, beside what speaks against it. Neither is ever the default button."""

    changed = Signal()  # There is another notice

    def __init__(self, ports: Ports) -> None:
        super().__init__(ports)
        self._ports = ports
        # A name against which something speaks, and that a person has said once.
        self._wanted = ""
        # A person does not want to be asked for the former name in this conversation.
        self._is_declined = False
        self._watched: ShownModule | None = None
        ports.name_wanted.connect(self.say)
        ports.shown.connect(self._on_shown)

    def say(self, name: str) -> None:
        module = self._ports.module
        if not module.can_be_named:
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
        is_answered = self._is_declined or bool(module.name)
        name = self._wanted or ("" if is_answered else port.last_name)
        if not name or not module.can_be_named:
            return None
        against = module.what_speaks_against(name)
        parts = [tr("Is it {module}?", module=name)]
        parts += [tr("Against it: {what}.", what=what.translated()) for what in against]
        known = module.remembered(name)
        differs = [] if known is None else what_differs(known, module.view, module.now_s)
        if differs:
            parts.append(tr("Settings: {what}.", what="; ".join(text.translated() for text in differs)))
        yes = tr("It is {module} all the same", module=name) if self._wanted else tr("It is {module}", module=name)

        def decline() -> None:
            self._wanted = port.last_name = ""
            self._is_declined = True
            self.changed.emit()

        same = Choice("name_same", yes, lambda: self.say(name), is_step=True)
        meaning = Meaning.ATTENTION if against else Meaning.INFORMATION
        return Notice(meaning, join_sentences(parts), (same, Choice("name_other", tr("Another module"), decline)))

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
            self._ports.name_wanted.emit(text)
        self.show_name()
