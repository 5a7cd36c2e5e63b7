"""Labels of modules, to be printed: name, date, settings code, and a QR code of the name for a scanner."""

from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import Final, NamedTuple

from app.system.files import write_whole
from app.text.messages import UserError, clean, message
from app.text.template import page
from protocol.translatable import marked

# Of a longer name a scanner reads no QR code from a tape.
MAX_NAME_LENGTH: Final = 60


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
# By the width of the tape in mm; A4 as sheets of 24 labels, 70 by 37 mm.
PAPERS: Final = {
    "62": Paper(62, 29, 2, 14),
    "24": Paper(60, 24, 3, 11),
    "A4": Paper(210, 297, 5, 14, columns=3, rows=8),
}
# Prints HTML texts as a PDF that carries the JSON of the last argument. Passed in by the composition root because Qt
# prints. May raise `OSError` or `RuntimeError`.
Printer = Callable[[Sequence[str], Paper, bytes | None], bytes]
_QR_MM: Final = 17


class Label(NamedTuple):
    """`code`: the settings code, "" where it is not known."""

    name: str
    at: datetime
    code: str = ""


def label_body(label: Label) -> str:
    """The label as HTML. Raises `UserError` for a name without a usable QR code."""
    import segno
    from markupsafe import Markup

    name = clean(label.name.strip())
    if not name or len(name) > MAX_NAME_LENGTH:
        text = marked("{name}: at most {count} characters.")
        raise UserError(text, name=message(marked("Name")), count=MAX_NAME_LENGTH)
    code = segno.make(name, micro=False, error="m", encoding=None if name.isascii() else "utf-8")
    return page(
        "label.html",
        name=name,
        date=f"{label.at:%Y-%m-%d}",
        code=label.code,
        side=round(_QR_MM * 96 / 25.4),  # in pixels of CSS
        picture=Markup(code.png_data_uri(scale=20)),  # noqa: S704  of our own making, and sharp at 600 dpi
    )


def write_labels(path: Path, labels: Sequence[Label], paper: Paper, printer: Printer) -> None:
    """Write the labels as a PDF. Raises `UserError`, `OSError` or `RuntimeError`."""
    write_whole(path, printer([label_body(label) for label in labels], paper, None))
