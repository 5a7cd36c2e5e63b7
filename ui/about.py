"""What this program is, its version, and what it is made with."""

import platform
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, metadata
from typing import Final

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QMessageBox, QWidget

from app import version
from app.i18n import tr
from ui.icons import app_icon

_PARTS: Final = ("PySide6-Essentials", "shiboken6", "numpy", "pyqtgraph", "pyserial", "platformdirs", "mcap")


def show_about(window: QWidget) -> QMessageBox:
    """A box that holds nothing up: the window stays in use beside it."""
    box = QMessageBox(window)
    box.setObjectName("about_box")
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setWindowModality(Qt.WindowModality.NonModal)
    box.setWindowTitle(tr("About"))
    box.setIconPixmap(app_icon().pixmap(QSize(64, 64)))
    box.setText(tr("DPS-S Configurator {version}", version=version()))
    about = tr("Configures, tests and watches a DPS-S parachute module over its serial port.")
    licence = tr("Free software under the MIT licence. It is made with:")
    box.setInformativeText("\n".join((about, "", licence, *_made_with())))
    box.show()
    return box


def _made_with() -> Iterator[str]:
    """Name, version and licence of each part, as it says of itself."""
    yield f"Python {platform.python_version()} (PSF-2.0)"
    for name in _PARTS:
        try:
            told = metadata(name)
        except PackageNotFoundError:  # a bundle may leave out what only installers need
            continue
        fields = told.json  # an older name of the field is still in use beside the newer one
        licence = str(fields.get("license_expression") or fields.get("license") or "").strip()
        yield f"{told['Name']} {told['Version']}" + (f" ({licence.splitlines()[0]})" if licence else "")
