"""Writes the trigger pictures (ui/help/guide/images/tilt-*.svg): attitude of the aircraft, angles at which it
fires and rearms, and free fall.

    python3 docs/generate/trigger_pictures.py
"""

import math
from collections.abc import Iterator
from typing import Final

from guide_svg import BLUE, GREY, INK, ORANGE, PAPER, line, picture, shape, text, write

_FIRES_DEG, _REARMS_DEG = 60, 50
_RADIUS: Final = 84
_BASE_Y: Final = 136
_TEXTS: Final = {
    "en": ("Level: 0°", "60° fires", "50° rearms", "Tilted past the threshold", "Free fall: below 0.5 g", "for 1.60 s"),
    "zh_CN": ("水平：0°", "60° 开伞", "50° 复位", "倾斜超过阈值", "失重：低于 0.5 g", "持续 1.60 秒"),
}


def triggers_svg(language: str) -> str:
    return picture(640, 230, _parts(*_TEXTS[language]))


def _parts(level: str, fires: str, rearms: str, tilted: str, falling: str, lasting: str) -> Iterator[str]:
    yield line(f"M20 {_BASE_Y} H180", GREY, 2, is_dashed=True)
    yield from _aircraft(100, _BASE_Y, 0, INK)
    yield text(100, 215, level)
    yield from _gauge(310, fires, rearms)
    yield text(310, 215, tilted)
    for x in (496, 540, 584):
        yield line(f"M{x} 20 v44", GREY, 3)
    yield from _aircraft(540, 100, 0, ORANGE)
    yield line("M540 124 v34", ORANGE, 4)
    yield shape("M540 172 l-8 -16 h16 z", ORANGE)
    yield text(540, 197, falling)
    yield text(540, 217, lasting)


def _gauge(x: int, fires: str, rearms: str) -> Iterator[str]:
    """Tilt increases from the right (level) to the left (upside down)."""
    fire_x, fire_y = _at(x, _FIRES_DEG, _RADIUS)
    arc = f"A{_RADIUS} {_RADIUS} 0 0 0"
    yield line(f"M{x - _RADIUS} {_BASE_Y} H{x + _RADIUS}", GREY, 2)
    yield line(f"M{x + _RADIUS} {_BASE_Y} {arc} {fire_x:.1f} {fire_y:.1f}", GREY, 2)
    yield line(f"M{fire_x:.1f} {fire_y:.1f} {arc} {x - _RADIUS} {_BASE_Y}", ORANGE, 6)
    for degrees, colour, word, drop in ((_FIRES_DEG, ORANGE, fires, -6), (_REARMS_DEG, BLUE, rearms, 8)):
        (x1, y1), (x2, y2) = _at(x, degrees, _RADIUS - 8), _at(x, degrees, _RADIUS + 8)
        yield line(f"M{x1:.1f} {y1:.1f} L{x2:.1f} {y2:.1f}", colour, 3)
        yield text(round(x2 + 6, 1), round(y2 + drop, 1), word, "start", colour=colour, is_bold=True)
    yield from _aircraft(x, _BASE_Y, _FIRES_DEG + 8, ORANGE)


def _aircraft(x: int, y: int, tilt_deg: int, colour: str) -> Iterator[str]:
    """A multicopter from behind, whose right arm rises with the tilt."""
    yield f'<g transform="translate({x} {y}) rotate({-tilt_deg})" stroke="{colour}" stroke-width="4" fill="none">'
    yield '<path d="M-56 0 H56 M-48 0 V-10 M48 0 V-10 M-64 -10 H-32 M32 -10 H64 M-10 8 L-16 20 M10 8 L16 20"/>'
    yield f'<rect x="-16" y="-10" width="32" height="18" rx="5" fill="{PAPER}"/>'
    yield "</g>"


def _at(x: int, degrees: float, radius: float) -> tuple[float, float]:
    angle = math.radians(degrees)
    return x + radius * math.cos(angle), _BASE_Y - radius * math.sin(angle)


if __name__ == "__main__":
    write("tilt", triggers_svg, _TEXTS)
