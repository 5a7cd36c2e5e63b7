"""Writes the wiring picture (ui/help/guide/images/wiring-*.svg): adapter, three wires, and pins left open.

python3 docs/generate/wiring_picture.py
"""

from collections.abc import Iterator
from typing import Final

from guide_svg import BLUE, GREY, INK, ORANGE, box, line, picture, shape, text, write

_TEXTS: Final = {
    "en": ("Computer", "USB", "Adapter", "Module", "leave open", "Level unknown? Set the adapter to 3.3 V."),
    "zh_CN": ("电脑", "USB", "适配器", "模块", "不接", "电平未知时，请把适配器设为 3.3 V。"),
}
_ADAPTER_PINS: Final = (("TX", 70), ("RX", 110), ("GND", 150), ("VCC", 190))
_MODULE_PINS: Final = (("RX", 70), ("TX", 110), ("GND", 150))
_ADAPTER_X, _MODULE_X = 340, 500
"""Ends of the wires."""


def wiring_svg(language: str) -> str:
    return picture(640, 260, _parts(*_TEXTS[language]))


def _parts(computer: str, usb: str, adapter: str, module: str, left_open: str, level: str) -> Iterator[str]:
    for x, width, name in ((16, 100, computer), (210, 130, adapter), (500, 124, module)):
        yield box(x, width, 170, name)
    yield line("M116 125 H210", INK, 6)
    yield text(163, 112, usb)
    for name, y in _ADAPTER_PINS:
        yield from _pin(name, _ADAPTER_X, y, _ADAPTER_X - 14, "end")
    for name, y in _MODULE_PINS:
        yield from _pin(name, _MODULE_X, y, _MODULE_X + 14, "start")
    for (_, y), colour in zip(_MODULE_PINS, (BLUE, ORANGE, INK), strict=True):
        yield line(f"M{_ADAPTER_X + 5} {y} H{_MODULE_X - 5}", colour, 3)
    for y, direction, colour in ((70, 1, BLUE), (110, -1, ORANGE)):
        yield shape(f"M{420 + 9 * direction} {y} l{-14 * direction} -7 v14 z", colour)
    yield line(f"M{_ADAPTER_X + 5} 190 h36", GREY, 3, is_dashed=True)
    yield line("M386 182 l16 16 m0 -16 l-16 16", GREY, 3)
    yield text(412, 195, left_open, "start")
    yield text(320, 244, level)


def _pin(name: str, x: int, y: int, text_x: int, anchor: str) -> Iterator[str]:
    yield f'<circle cx="{x}" cy="{y}" r="5" fill="{INK}"/>'
    yield text(text_x, y + 5, name, anchor)


if __name__ == "__main__":
    write("wiring", wiring_svg, _TEXTS)
