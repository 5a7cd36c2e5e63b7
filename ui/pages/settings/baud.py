"""The last row of the table: the baud rate, which is no setting like the others, as changing it can cut the link."""

from PySide6.QtCore import QObject

from app.safety.acts import TITLES, Act
from app.safety.interlocks import Interlock
from app.text.i18n import tr
from app.text.sentences import join_sentences
from protocol.catalogue import BAUD_RATE
from protocol.translatable import marked
from ui.acts.confirm import Confirm
from ui.acts.outcomes import open_conditions
from ui.forms.field_editors import HeldValue, make_editor
from ui.pages.settings.rows import LARGE_SHARES, MIDDLE, SHARES, SettingsTable
from ui.services.context import Services
from ui.widgets.controls import set_role
from ui.widgets.labels import text_label


class BaudRow(QObject):
    """An act of its own, with a confirmation. What came of it is a notice of the port."""

    def __init__(self, table: SettingsTable, services: Services) -> None:
        super().__init__(table)
        self._services, self._ports = services, services.ports
        self._rate: int | None = None
        """Chosen, and not yet confirmed."""
        self.name = text_label("baud_title")
        self.name.setText(tr(BAUD_RATE.title))
        self.held = HeldValue(BAUD_RATE)
        self.editor = make_editor(BAUD_RATE)
        self.name.setBuddy(self.editor)
        self.message = text_label("baud_message", "small")
        self.confirm = Confirm("baud", ask=f"{TITLES[Act.CHANGE_BAUD]}…", go=marked("Change now"))
        place = table.add_cells(self.name, self.held, self.editor)
        if table.shares is LARGE_SHARES:
            table.grid.addWidget(self.message, place + 1, 0, 1, len(LARGE_SHARES))
        else:
            table.grid.addWidget(self.message, place, 3, 1, len(SHARES) - 3, MIDDLE)
        table.grid.addWidget(self.confirm, place + 2, 0, 1, len(table.shares))
        self.editor.chosen.connect(self._choose)
        self.confirm.confirmed.connect(self._change)

    def refresh(self) -> None:
        port = self._ports.current
        self.held.show_known(port.module.view.known(BAUD_RATE.key, port.now_s), port.now_s)
        refusals = open_conditions(self._services, Act.CHANGE_BAUD)
        if port.is_changing_rate:
            self._say(tr("Changing the baud rate…"), "small")
        elif refusals:
            self._say(join_sentences(refusal.sentence for refusal in refusals), "attention")
        else:
            self._say(tr("The vendor advises not to change it."), "small")
        # An old status does not disable the button: the procedure asks for a new one before it decides.
        is_refused = any(refusal.condition is not Interlock.FRESH_STATUS for refusal in refusals)
        is_free = port.module.is_going and not port.is_changing_rate
        self.editor.setEnabled(is_free)
        self.confirm.set_possible(is_free and not is_refused and self._rate not in (None, port.connection.baud_rate))

    def _say(self, text: str, role: str) -> None:
        self.message.setText(text)
        set_role(self.message, role)

    def _choose(self, rate: int) -> None:
        self._rate = rate
        self.confirm.withdraw()
        self.refresh()

    def forget_choice(self) -> None:
        """It was made for the module before."""
        self._rate = None
        self.editor.show_value(None, None)

    def _change(self) -> None:
        rate = self._rate
        self.forget_choice()
        if rate is not None:
            self._ports.current.change_rate(rate, self._services.armed)
