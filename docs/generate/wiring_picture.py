"""Writes the wiring picture (ui/help/guide/images/wiring-*.svg): adapter, three wires, what stays open.

    python3 docs/generate/wiring_picture.py

Ink and paper are the two colours that the guide's viewer replaces by those of its theme.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

IMAGES: Final = Path(__file__).resolve().parents[2] / "ui" / "help" / "guide" / "images"
INK: Final = "#1a1c1e"
PAPER: Final = "#ffffff"
_BLUE, _ORANGE, _GREY = "#0072b2", "#d55e00", "#7a7f85"
"""Okabe and Ito's, told apart by colour-blind people, too."""
_TEXTS: Final = {
    "en": ("Computer", "USB", "Adapter", "Module", "leave open", "Level unknown? Set the adapter to 3.3 V."),
    "zh_CN": ("电脑", "USB", "适配器", "模块", "不接", "电平未知时，请把适配器设为 3.3 V。"),
}
_ADAPTER_PINS: Final = (("TX", 70), ("RX", 110), ("GND", 150), ("VCC", 190))
_MODULE_PINS: Final = (("RX", 70), ("TX", 110), ("GND", 150))
_ADAPTER_X, _MODULE_X = 340, 500
"""Where the wires begin and end."""


def wiring_svg(language: str) -> str:
    return "\n".join(_lines(*_TEXTS[language])) + "\n"


def _lines(computer: str, usb: str, adapter: str, module: str, left_open: str, level: str) -> Iterator[str]:
    yield (
        '<svg xmlns="http://www.w3.org/2000/svg" width="640" height="260" viewBox="0 0 640 260" '
        'font-family="sans-serif" font-size="14">'
    )
    yield f'<rect width="640" height="260" fill="{PAPER}"/>'
    for x, width, name in ((16, 100, computer), (210, 130, adapter), (500, 124, module)):
        yield f'<rect x="{x}" y="40" width="{width}" height="170" rx="6" fill="none" stroke="{INK}" stroke-width="2"/>'
        yield f'<text x="{x + width / 2:g}" y="28" text-anchor="middle" font-weight="bold" fill="{INK}">{name}</text>'
    yield f'<path d="M116 125 H210" stroke="{INK}" stroke-width="6"/>'
    yield f'<text x="163" y="112" text-anchor="middle" fill="{INK}">{usb}</text>'
    for name, y in _ADAPTER_PINS:
        yield from _pin(name, _ADAPTER_X, y, text_x=_ADAPTER_X - 14, anchor="end")
    for name, y in _MODULE_PINS:
        yield from _pin(name, _MODULE_X, y, text_x=_MODULE_X + 14, anchor="start")
    for (_, y), colour in zip(_MODULE_PINS, (_BLUE, _ORANGE, INK), strict=True):
        yield f'<path d="M{_ADAPTER_X + 5} {y} H{_MODULE_X - 5}" stroke="{colour}" stroke-width="3"/>'
    for y, direction, colour in ((70, 1, _BLUE), (110, -1, _ORANGE)):
        tip = 420 + 9 * direction
        yield f'<path d="M{tip} {y} l{-14 * direction} -7 v14 z" fill="{colour}"/>'
    yield f'<path d="M{_ADAPTER_X + 5} 190 h36" stroke="{_GREY}" stroke-width="3" stroke-dasharray="5 5"/>'
    yield f'<path d="M386 182 l16 16 m0 -16 l-16 16" stroke="{_GREY}" stroke-width="3"/>'
    yield f'<text x="412" y="195" fill="{INK}">{left_open}</text>'
    yield f'<text x="320" y="244" text-anchor="middle" fill="{INK}">{level}</text>'
    yield "</svg>"


def _pin(name: str, x: int, y: int, *, text_x: int, anchor: str) -> Iterator[str]:
    yield f'<circle cx="{x}" cy="{y}" r="5" fill="{INK}"/>'
    yield f'<text x="{text_x}" y="{y + 5}" text-anchor="{anchor}" fill="{INK}">{name}</text>'


if __name__ == "__main__":
    for language in _TEXTS:
        (IMAGES / f"wiring-{language}.svg").write_text(wiring_svg(language), encoding="utf-8")
