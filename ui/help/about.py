"""About box: version, licences, components."""

import platform
from collections.abc import Iterator
from importlib.metadata import PackageMetadata, PackageNotFoundError, metadata
from typing import Final

from PySide6.QtCore import QSize, Qt
from PySide6.QtWidgets import QMessageBox, QWidget

from app import version
from app.text.i18n import tr
from ui.style.icons import app_icon

_PARTS: Final = ("PySide6-Essentials", "shiboken6", "numpy", "pyqtgraph", "pyserial", "platformdirs", "mcap")

_CLASSIFIER: Final = "License :: "


def show_about(window: QWidget) -> QMessageBox:
    """Shows a modeless message box."""
    box = QMessageBox(window)
    box.setObjectName("about_box")
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    box.setWindowModality(Qt.WindowModality.NonModal)
    box.setWindowTitle(tr("About"))
    box.setIconPixmap(app_icon().pixmap(QSize(64, 64)))
    box.setText(f"{tr('DPS-S Configurator')} {version()}")
    box.setInformativeText("\n".join((tr("MIT licence. Made with:"), *_made_with())))
    box.show()
    return box


def _made_with() -> Iterator[str]:
    """Name, version and licence of each component, from its metadata."""
    yield f"Python {platform.python_version()} (PSF-2.0)"
    for name in _PARTS:
        try:
            data = metadata(name)
        except PackageNotFoundError:  # left out of some bundles
            continue
        licence = _licence(data)
        yield f"{data['Name']} {data['Version']}" + (f" ({licence})" if licence else "")


def _licence(data: PackageMetadata) -> str:
    """From the current field, the older one, or the classifiers; "" where there is none."""
    fields = data.json
    written = str(fields.get("license_expression") or fields.get("license") or "").strip()
    if written:
        return written.splitlines()[0]
    classifiers = fields.get("classifier") or ()
    named = [one.rpartition(" :: ")[2] for one in classifiers if one.startswith(_CLASSIFIER)]
    return named[0].removesuffix(" License") if named else ""
