"""The switch that shares the port of the window with readers over TCP."""

from PySide6.QtWidgets import QCheckBox, QFrame, QLineEdit

from app.text.i18n import tr
from app.text.sentences import join_names
from ui.services.context import Services
from ui.style.theme import Meaning, Space
from ui.widgets.controls import control, named, set_role
from ui.widgets.labels import SELECTABLE, TickingLabel, text_label
from ui.widgets.layouts import in_column, in_row

USUAL_ADDRESS = "127.0.0.1:7001"


class SharingCard(QFrame):
    """What it says is of the port that the window shows."""

    def __init__(self, services: Services) -> None:
        super().__init__()
        named(self, "sharing_card", "card")
        self._ports = services.ports
        self.switch = control(QCheckBox(tr("Share this port, read-only")), "sharing_switch", slot=self._press)
        self.address = control(QLineEdit(USUAL_ADDRESS), "sharing_address", says=tr("Address for readers"))
        self.state = text_label("sharing_state", "muted", is_selectable=True)
        self.last = named(TickingLabel(), "sharing_last")
        self.last.setAccessibleName(self.switch.text())
        self.last.setWordWrap(True)
        self.last.setTextInteractionFlags(SELECTABLE)
        in_column(
            in_row(self.switch, (self.address, 1), spacing=Space.M), self.state, self.last, of=self, spacing=Space.S
        )
        self._ports.changed.connect(self._show)
        self._ports.shown.connect(self._show)
        for port in self._ports.all:
            port.sharing.changed.connect(self._show)
        self._ports.added.connect(lambda port: port.sharing.changed.connect(self._show))
        self._show()

    def _press(self, is_on: bool) -> None:
        sharing = self._ports.current.sharing
        sharing.start(self.address.text()) if is_on else sharing.stop()
        self._show()

    def _show(self) -> None:
        sharing = self._ports.current.sharing
        is_on = sharing.address != ""
        self.switch.setChecked(is_on)
        self.switch.setEnabled(is_on or self._ports.current.is_open)
        self.address.setEnabled(not is_on)
        text = tr("Other programs on this computer may ask, and may send LOCK. TCP has no authentication.")
        if is_on:
            text = join_names((sharing.address, tr("readers: {count}", count=sharing.readers)))
        self.state.setText(text)
        self.last.setText(sharing.last)
        set_role(self.last, "attention" if sharing.meaning is Meaning.ATTENTION else "")
