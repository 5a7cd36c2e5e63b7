"""Shows the fingerprint of the settings, to be read out over the radio."""

from PySide6.QtWidgets import QLabel, QWidget

from app.engine.device import DeviceView
from app.settings.fingerprint import fingerprint_of
from app.text.i18n import tr
from ui.core.texts import Texts
from ui.style.theme import Space
from ui.widgets.controls import control
from ui.widgets.layouts import in_row
from ui.widgets.naming import named


class FingerprintView(QWidget):
    """A dash while any covered setting is unknown."""

    def __init__(self, texts: Texts) -> None:
        super().__init__()
        self.setObjectName("fingerprint_view")
        self.code = named(QLabel(), "fingerprint", "strong")
        note = control(QLabel(), texts, "fingerprint_note", "Settings code", role="small")
        in_row(note, self.code, of=self, spacing=Space.S, margins=0)

    def show_device(self, device: DeviceView, now: float) -> None:
        found = fingerprint_of(device, now)
        is_known = found.code is not None and found.is_complete
        self.code.setText((found.code or "") if is_known else "—")
        self.code.setAccessibleName(tr("{setting}: {what}", setting=tr("Settings code"), what=self.code.text()))
        missing = ", ".join(tr(command.title) for command in found.missing)
        self.setToolTip(tr("Not known: {names}", names=missing) if missing else tr("Same settings, same code"))
