"""The program's icon, as files that builds draw from the one that the window shows."""

import struct
from pathlib import Path
from typing import Final

from environment import ROOT
from release import NAME

LINUX_SIDES: Final = (16, 22, 24, 32, 48, 64, 128, 256, 512)
"""The sizes of the hicolor theme, in pixels."""
_ICO_SIDES: Final = (16, 20, 24, 32, 40, 48, 64, 128, 256)
_SVG: Final = ROOT / "ui" / "style" / "svg" / f"{NAME}.svg"


def picture(side: int, kind: str = "PNG") -> bytes:
    """The icon of `side` pixels, in a format that Qt writes."""
    from PySide6.QtCore import QBuffer, QByteArray, Qt
    from PySide6.QtGui import QImage, QPainter
    from PySide6.QtSvg import QSvgRenderer

    image = QImage(side, side, QImage.Format.Format_ARGB32)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    QSvgRenderer(QByteArray(_SVG.read_bytes())).render(painter)
    painter.end()
    buffer = QBuffer()
    buffer.open(QBuffer.OpenModeFlag.WriteOnly)
    image.save(buffer, kind)  # type: ignore[call-overload]  # takes any device and a name, says Qt
    return bytes(buffer.data().data())


def ico() -> bytes:
    """The icon in Windows' format: a table, then the pictures as PNG."""
    pictures = [picture(side) for side in _ICO_SIDES]
    offset = 6 + 16 * len(pictures)
    table = struct.pack("<HHH", 0, 1, len(pictures))
    for side, content in zip(_ICO_SIDES, pictures, strict=True):
        table += struct.pack("<BBBBHHII", side % 256, side % 256, 0, 0, 1, 32, len(content), offset)
        offset += len(content)
    return table + b"".join(pictures)


def write_program_icons(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{NAME}.ico").write_bytes(ico())
    (folder / f"{NAME}.icns").write_bytes(picture(1024, "ICNS"))


def write_theme_icons(folder: Path) -> None:
    """Write the icon in every size of the hicolor theme and as SVG."""
    pictures = {f"{side}x{side}/apps/{NAME}.png": picture(side) for side in LINUX_SIDES}
    for name, content in {**pictures, f"scalable/apps/{NAME}.svg": _SVG.read_bytes()}.items():
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(content)
