"""Writes the program's icon to files:  .venv/bin/python packaging/icon_files.py

Updates packaging/linux/dps-s-configurator.svg from `ui.style.icons`; a test compares them. Builds draw the other sizes
and formats from it.
"""

import struct
import sys
from pathlib import Path
from typing import Final

from environment import ROOT
from release import NAME

LINUX_SIDES: Final = (16, 22, 24, 32, 48, 64, 128, 256, 512)
"""The sizes of the hicolor theme, in pixels."""
_ICO_SIDES: Final = (16, 20, 24, 32, 40, 48, 64, 128, 256)
_ICNS_SIDES: Final = {
    b"icp4": 16,
    b"icp5": 32,
    b"ic07": 128,
    b"ic08": 256,
    b"ic09": 512,
    b"ic10": 1024,
    b"ic11": 32,
    b"ic12": 64,
    b"ic13": 256,
    b"ic14": 512,
}
"""Types of Apple's format that contain a PNG; 11 to 14 are for screens with two pixels per point."""
SVG: Final = ROOT / "packaging" / "linux" / f"{NAME}.svg"


def png(side: int) -> bytes:
    """The icon as a PNG of `side` pixels."""
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
    image.save(buffer, "PNG")  # type: ignore[call-overload]  # takes any device and a name, says Qt
    return bytes(buffer.data().data())


def ico() -> bytes:
    """The icon in Windows' format: a table, then the pictures as PNG."""
    pictures = [png(side) for side in _ICO_SIDES]
    offset = 6 + 16 * len(pictures)
    table = struct.pack("<HHH", 0, 1, len(pictures))
    for side, picture in zip(_ICO_SIDES, pictures, strict=True):
        table += struct.pack("<BBBBHHII", side % 256, side % 256, 0, 0, 1, 32, len(picture), offset)
        offset += len(picture)
    return table + b"".join(pictures)


def icns() -> bytes:
    """The icon in Apple's format: type and length before each PNG."""
    blocks = b""
    for kind, side in _ICNS_SIDES.items():
        picture = png(side)
        blocks += kind + struct.pack(">I", len(picture) + 8) + picture
    return b"icns" + struct.pack(">I", len(blocks) + 8) + blocks


def write_program_icons(folder: Path) -> None:
    """Write the icons of the executables for Windows and macOS."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{NAME}.ico").write_bytes(ico())
    (folder / f"{NAME}.icns").write_bytes(icns())


def write_theme_icons(folder: Path) -> None:
    """Write the icon in every size of the hicolor theme and as SVG."""
    for side in LINUX_SIDES:
        place = folder / f"{side}x{side}" / "apps" / f"{NAME}.png"
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(png(side))
    place = folder / "scalable" / "apps" / f"{NAME}.svg"
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(SVG.read_bytes())


def main() -> int:
    sys.path.insert(0, str(ROOT))
    from ui.style.icons import app_icon_svg

    SVG.write_bytes(app_icon_svg())
    print(SVG.relative_to(ROOT))
    return 0


if __name__ == "__main__":
    sys.exit(main())
