"""Labels of modules, to be printed: name, date, settings code, and a QR code of the name for a scanner."""

from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import Final, NamedTuple

from app.system.files import write_whole
from app.text.messages import UserError, clean, message
from app.text.template import page
from protocol.translatable import marked

MAX_NAME_LENGTH: Final = 60
"""Characters; a longer name has no QR code that a scanner reads from a tape."""


class Paper(NamedTuple):
    """A page of `columns` by `rows` equal places with one text each, which keeps `margin_mm` inside its place.
    `largest_pt`: size of the text where all of it fits."""

    width_mm: float
    height_mm: float
    margin_mm: float
    largest_pt: float
    columns: int = 1
    rows: int = 1


A4: Final = Paper(210, 297, 12, 9)
PAPERS: Final = {
    "62": Paper(62, 29, 2, 14),
    "24": Paper(60, 24, 3, 11),
    "A4": Paper(210, 297, 5, 14, columns=3, rows=8),
}
"""By the width of the tape in mm; A4 as sheets of 24 labels, 70 by 37 mm."""
Printer = Callable[[Sequence[str], Paper, bytes | None], bytes]
"""Prints HTML texts as a PDF that carries the JSON of the last argument. Passed in by the composition root because Qt
prints. May raise `OSError` or `RuntimeError`."""
_QR_MM: Final = 17
_CSS_PX_PER_MM: Final = 96 / 25.4
_QR_SCALE: Final = 20
"""Pixels of the picture for a module of the code: sharp at 600 dpi."""


class Label(NamedTuple):
    """`code`: the settings code, "" where it is not known."""

    name: str
    at: datetime
    code: str = ""


def label_body(label: Label) -> str:
    """The label as HTML. Raises `UserError` for a name without a usable QR code."""
    import segno

    name = clean(label.name.strip())
    if not name or len(name) > MAX_NAME_LENGTH:
        text = marked("{name}: at most {count} characters.")
        raise UserError(text, name=message(marked("Name")), count=MAX_NAME_LENGTH)
    from markupsafe import Markup

    code = segno.make(name, micro=False, error="m", encoding=None if name.isascii() else "utf-8")
    return page(
        "label.html",
        name=name,
        date=f"{label.at:%Y-%m-%d}",
        code=label.code,
        side=round(_QR_MM * _CSS_PX_PER_MM),
        picture=Markup(code.png_data_uri(scale=_QR_SCALE)),  # noqa: S704  of our own making
    )


def write_labels(
    path: Path, labels: Sequence[Label], paper: Paper, printer: Printer, *, carried: bytes | None = None
) -> None:
    """Raises `UserError`, `OSError` or `RuntimeError`."""
    write_whole(path, printer([label_body(label) for label in labels], paper, carried))
