"""Writes the trigger pictures (ui/help/guide/images/tilt-*.svg): how the aircraft lies, where it fires and rearms, and
what free fall is.

    python3 docs/generate/trigger_pictures.py

Ink and paper are the two colours that the guide's viewer replaces by those of its theme.
"""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Final

IMAGES: Final = Path(__file__).resolve().parents[2] / "ui" / "help" / "guide" / "images"
INK: Final = "#1a1c1e"
PAPER: Final = "#ffffff"
_BLUE, _ORANGE, _GREY = "#0072b2", "#d55e00", "#7a7f85"
"""Okabe and Ito's, told apart by colour-blind people, too."""
_FIRES_DEG, _REARMS_DEG = 60, 50
_RADIUS: Final = 84
_BASE_Y: Final = 136
_TEXTS: Final = {
    "en": ("Level: 0°", "60° fires", "50° rearms", "Tilted past the threshold", "Free fall: below 0.5 g", "for 1.60 s"),
    "zh_CN": ("水平：0°", "60° 开伞", "50° 复位", "倾斜超过阈值", "失重：低于 0.5 g", "持续 1.60 秒"),
}


def triggers_svg(language: str) -> str:
    return "\n".join(_lines(*_TEXTS[language])) + "\n"


def _lines(level: str, fires: str, rearms: str, tilted: str, falling: str, lasting: str) -> Iterator[str]:
    yield (
        '<svg xmlns="http://www.w3.org/2000/svg" width="640" height="230" viewBox="0 0 640 230" '
        'font-family="sans-serif" font-size="14">'
    )
    yield f'<rect width="640" height="230" fill="{PAPER}"/>'
    yield f'<path d="M20 {_BASE_Y} H180" stroke="{_GREY}" stroke-width="2" stroke-dasharray="6 5"/>'
    yield from _aircraft(100, _BASE_Y, 0, INK)
    yield _text(100, 215, level)
    yield from _gauge(310, fires, rearms)
    yield _text(310, 215, tilted)
    for x in (496, 540, 584):
        yield f'<path d="M{x} 20 v44" stroke="{_GREY}" stroke-width="3"/>'
    yield from _aircraft(540, 100, 0, _ORANGE)
    yield f'<path d="M540 124 v34" stroke="{_ORANGE}" stroke-width="4"/>'
    yield f'<path d="M540 172 l-8 -16 h16 z" fill="{_ORANGE}"/>'
    yield _text(540, 197, falling)
    yield _text(540, 217, lasting)
    yield "</svg>"


def _gauge(x: int, fires: str, rearms: str) -> Iterator[str]:
    """Tilt counts from the right, level, to the left, upside down."""
    fire_x, fire_y = _at(x, _FIRES_DEG, _RADIUS)
    yield f'<path d="M{x - _RADIUS} {_BASE_Y} H{x + _RADIUS}" stroke="{_GREY}" stroke-width="2"/>'
    yield (
        f'<path d="M{x + _RADIUS} {_BASE_Y} A{_RADIUS} {_RADIUS} 0 0 0 {fire_x:.1f} {fire_y:.1f}" fill="none" '
        f'stroke="{_GREY}" stroke-width="2"/>'
    )
    yield (
        f'<path d="M{fire_x:.1f} {fire_y:.1f} A{_RADIUS} {_RADIUS} 0 0 0 {x - _RADIUS} {_BASE_Y}" fill="none" '
        f'stroke="{_ORANGE}" stroke-width="6"/>'
    )
    for degrees, colour, word, drop in ((_FIRES_DEG, _ORANGE, fires, -6), (_REARMS_DEG, _BLUE, rearms, 8)):
        (x1, y1), (x2, y2) = _at(x, degrees, _RADIUS - 8), _at(x, degrees, _RADIUS + 8)
        yield f'<path d="M{x1:.1f} {y1:.1f} L{x2:.1f} {y2:.1f}" stroke="{colour}" stroke-width="3"/>'
        yield f'<text x="{x2 + 6:.1f}" y="{y2 + drop:.1f}" fill="{colour}" font-weight="bold">{word}</text>'
    yield from _aircraft(x, _BASE_Y, _FIRES_DEG + 8, _ORANGE)


def _aircraft(x: int, y: int, tilt_deg: int, colour: str) -> Iterator[str]:
    """A multicopter from behind; its right arm rises with the tilt."""
    yield f'<g transform="translate({x} {y}) rotate({-tilt_deg})" stroke="{colour}" stroke-width="4" fill="none">'
    yield '<path d="M-56 0 H56 M-48 0 V-10 M48 0 V-10 M-64 -10 H-32 M32 -10 H64 M-10 8 L-16 20 M10 8 L16 20"/>'
    yield f'<rect x="-16" y="-10" width="32" height="18" rx="5" fill="{PAPER}"/>'
    yield "</g>"


def _at(x: int, degrees: float, radius: float) -> tuple[float, float]:
    angle = math.radians(degrees)
    return x + radius * math.cos(angle), _BASE_Y - radius * math.sin(angle)


def _text(x: int, y: int, words: str) -> str:
    return f'<text x="{x}" y="{y}" text-anchor="middle" fill="{INK}">{words}</text>'


if __name__ == "__main__":
    for language in _TEXTS:
        (IMAGES / f"tilt-{language}.svg").write_text(triggers_svg(language), encoding="utf-8")
