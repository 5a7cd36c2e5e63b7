"""Shows the checksum of the settings, large enough to be read out over the radio."""

from PySide6.QtWidgets import QLabel, QWidget

from app.engine.device import DeviceView
from app.settings.fingerprint import fingerprint_of
from app.text.i18n import tr
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column
from ui.widgets.naming import named


class FingerprintView(QWidget):
    """A dash while anything that it covers is not known: half a code is none."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("fingerprint_view")
        self.code = named(QLabel(), "fingerprint")
        self.code.setProperty("role", "heading")
        self.note = text_label("fingerprint_note", "small")
        in_column(self.code, self.note, of=self, spacing=0, margins=0)

    def show_device(self, device: DeviceView, now: float) -> None:
        found = fingerprint_of(device, now)
        is_known = found.code is not None and found.is_complete
        self.code.setText((found.code or "") if is_known else "—")
        self._dress(role="heading" if is_known else "muted")
        self.code.setAccessibleName(tr("Fingerprint of the settings: {code}", code=self.code.text()))
        if found.missing:
            names = ", ".join(tr(command.title) for command in found.missing)
            self.note.setText(tr("Fingerprint: not known: {names}", names=names))
        else:
            self.note.setText(tr("Fingerprint of what can be read back: same settings, same code"))

    def _dress(self, *, role: str) -> None:
        """A dash as large as the code would look like a fault of the drawing."""
        if self.code.property("role") != role:
            self.code.setProperty("role", role)
            self.code.style().unpolish(self.code)
            self.code.style().polish(self.code)
