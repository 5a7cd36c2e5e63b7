"""Common parts of the guide's vector pictures: colours, texts, frame and folder.

The guide's viewer replaces ink and paper by the colours of its theme.
"""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Final

IMAGES: Final = Path(__file__).resolve().parents[2] / "ui" / "help" / "guide" / "images"
INK: Final = "#1a1c1e"
PAPER: Final = "#ffffff"
BLUE, ORANGE, GREY = "#0072b2", "#d55e00", "#7a7f85"
"""Okabe and Ito's palette, distinguishable by colour-blind people."""


def picture(width: int, height: int, parts: Iterable[str]) -> str:
    """A complete SVG file."""
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        'font-family="sans-serif" font-size="14">'
    )
    return "\n".join((head, f'<rect width="{width}" height="{height}" fill="{PAPER}"/>', *parts, "</svg>")) + "\n"


def text(x: float, y: float, words: str, anchor: str = "middle", *, colour: str = INK, is_bold: bool = False) -> str:
    bold = ' font-weight="bold"' if is_bold else ""
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}"{bold} fill="{colour}">{words}</text>'


def line(path: str, colour: str, width: int, *, is_dashed: bool = False) -> str:
    dashes = ' stroke-dasharray="5 5"' if is_dashed else ""
    return f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="{width}"{dashes}/>'


def shape(path: str, colour: str) -> str:
    return f'<path d="{path}" fill="{colour}"/>'


def box(x: float, width: float, height: float, name: str) -> str:
    """A part of the wiring: a frame with its name above."""
    frame = (
        f'<rect x="{x}" y="40" width="{width}" height="{height}" rx="6" fill="none" stroke="{INK}" stroke-width="2"/>'
    )
    return "\n".join((frame, text(x + width / 2, 28, name, is_bold=True)))


def write(name: str, make: Callable[[str], str], languages: Mapping[str, object]) -> None:
    """The picture in each language."""
    for language in languages:
        (IMAGES / f"{name}-{language}.svg").write_text(make(language), encoding="utf-8")
