"""Which module is it? A person says its name again in each conversation; what speaks against it stands beside."""

from PySide6.QtCore import QObject, Signal

from app.modules.names import what_differs
from app.text.i18n import tr
from app.text.sentences import join_sentences
from ui.session.ports import Ports
from ui.session.shown_module import ShownModule
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


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
