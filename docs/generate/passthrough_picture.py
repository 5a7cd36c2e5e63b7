"""Writes the picture of a module behind the flight controller (ui/help/guide/images/passthrough-*.svg).

python3 docs/generate/passthrough_picture.py
"""

from collections.abc import Iterator
from typing import Final

from guide_svg import BLUE, INK, ORANGE, box, line, picture, text, write

_TEXTS: Final = {
    "en": ("Computer", "USB", "Flight controller", "UART", "Module", "Passthrough hands every byte on, both ways."),
    "zh_CN": ("电脑", "USB", "飞控", "串口", "模块", "串口直通：双向逐字节转发。"),
}


def passthrough_svg(language: str) -> str:
    return picture(640, 200, _parts(*_TEXTS[language]))


def _parts(computer: str, usb: str, controller: str, uart: str, module: str, below: str) -> Iterator[str]:
    for x, width, name in ((16, 110, computer), (230, 190, controller), (514, 110, module)):
        yield box(x, width, 110, name)
    yield line("M126 95 H230", INK, 6)
    yield text(178, 82, usb)
    for y, colour in ((80, BLUE), (110, ORANGE)):
        # Through the flight controller the bytes are the same; dashed, as it may stop handing them on.
        yield line(f"M234 {y} H416", colour, 3, is_dashed=True)
        yield line(f"M420 {y} H514", colour, 3)
    yield text(467, 68, uart)
    yield text(320, 184, below)


if __name__ == "__main__":
    write("passthrough", passthrough_svg, _TEXTS)
