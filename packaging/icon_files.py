"""The program's icon, as files that builds draw from the one that the window shows."""

import struct
from pathlib import Path

from environment import ROOT
from release import NAME

LINUX_SIDES = (16, 22, 24, 32, 48, 64, 128, 256, 512)
"""The sizes of the hicolor theme, in pixels."""
_ICO_SIDES = (16, 20, 24, 32, 40, 48, 64, 128, 256)
SVG = ROOT / "ui" / "style" / "svg" / f"{NAME}.svg"


def picture(side: int, kind: str = "PNG") -> bytes:
    """The icon of `side` pixels, in a format that Qt writes."""
    from PySide6.QtCore import QBuffer, QByteArray, Qt
    from PySide6.QtGui import QImage, QPainter
    from PySide6.QtSvg import QSvgRenderer

    image = QImage(side, side, QImage.Format.Format_ARGB32)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    QSvgRenderer(QByteArray(SVG.read_bytes())).render(painter)
    painter.end()
    buffer = QBuffer()
    buffer.open(QBuffer.OpenModeFlag.WriteOnly)
    image.save(buffer, kind)  # type: ignore[call-overload]  # takes any device and a name, says Qt
    return bytes(buffer.data().data())


def write_icons(folder: Path) -> None:
    """Write the icon in the formats of Windows, a table and then the pictures as PNG, and of macOS."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures = [picture(side) for side in _ICO_SIDES]
    table = struct.pack("<HHH", 0, 1, len(pictures))
    offset = len(table) + 16 * len(pictures)
    for side, content in zip(_ICO_SIDES, pictures, strict=True):
        table += struct.pack("<BBBBHHII", side % 256, side % 256, 0, 0, 1, 32, len(content), offset)
        offset += len(content)
    (folder / f"{NAME}.ico").write_bytes(table + b"".join(pictures))
    (folder / f"{NAME}.icns").write_bytes(picture(1024, "ICNS"))
