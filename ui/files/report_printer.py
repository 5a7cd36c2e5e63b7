"""Prints texts as PDF: a report on A4 with the record attached, labels on tape or sheets. Needs no screen.

Chinese is embedded where the computer has a font for it; the size of the text is the largest at which all of it fits.
"""

import sys
from collections.abc import Sequence
from math import ceil, sqrt

from PySide6.QtCore import QBuffer, QByteArray, QEventLoop, QIODevice, QMarginsF, QSizeF
from PySide6.QtGui import (
    QFont,
    QFontDatabase,
    QGuiApplication,
    QPageLayout,
    QPageSize,
    QPainter,
    QPdfWriter,
    QTextDocument,
    QTextOption,
)

from app.modules.labels import Paper

SMALLEST_PT, STEP_PT = 4.0, 0.25
RESOLUTION_DPI = 600
_EXACT = QPageSize.SizeMatchPolicy.ExactMatch
_CHINESE = ("WenQuanYi Micro Hei", "Noto Sans CJK SC", "Microsoft YaHei", "PingFang SC", "SimSun")


def print_pages(bodies: Sequence[str], paper: Paper, attachment: bytes | None = None) -> bytes:
    """The PDF of HTML texts, each in one place of the paper, with the record `attachment`. Raises `RuntimeError`."""
    _application()
    _timers = QEventLoop()  # gives a background thread the event dispatcher that the timers of the text layout need
    data = QByteArray()
    buffer = QBuffer(data)
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    writer = QPdfWriter(buffer)
    writer.setResolution(RESOLUTION_DPI)
    millimetre = QPageSize.Unit.Millimeter
    writer.setPageSize(QPageSize(QSizeF(paper.width_mm, paper.height_mm), millimetre, "", _EXACT))
    writer.setPageMargins(QMarginsF(), QPageLayout.Unit.Millimeter)
    writer.setTitle("DPS-S")
    writer.setCreator("DPS-S Configurator")
    if attachment is not None:
        writer.addFileAttachment("record.json", QByteArray(attachment), "application/json")
    place = QSizeF(writer.width() / paper.columns, writer.height() / paper.rows)
    margin = paper.margin_mm / 25.4 * RESOLUTION_DPI
    room = QSizeF(place.width() - 2 * margin, place.height() - 2 * margin)
    # Before the painter: an error must not leave it active.
    documents = [_fitting(body, room, writer, paper.largest_pt) for body in bodies]
    painter = QPainter()
    if not painter.begin(writer):
        raise RuntimeError("the PDF cannot be started")
    for number, document in enumerate(documents):
        row, column = divmod(number % (paper.columns * paper.rows), paper.columns)
        if number and not row and not column:
            writer.newPage()
        painter.save()
        painter.translate(column * place.width() + margin, row * place.height() + margin)
        document.drawContents(painter)
        painter.restore()
    if not painter.end():
        raise RuntimeError("the PDF cannot be finished")
    buffer.close()
    return bytes(data.data())


def _fitting(body: str, room: QSizeF, writer: QPdfWriter, largest_pt: float) -> QTextDocument:
    """The document at the largest font size that fits into its place."""
    families = QFontDatabase.families(QFontDatabase.WritingSystem.SimplifiedChinese)
    chinese = [name for name in _CHINESE if name in families] or families[:1]
    font = QFont(["DejaVu Sans", "Arial", "Helvetica", *chinese])
    font.setStyleHint(QFont.StyleHint.SansSerif)
    font.setFeature(QFont.Tag("liga"), 0)  # who copies text out of the report gets letters
    wrapped = QTextOption()
    wrapped.setWrapMode(QTextOption.WrapMode.WrapAtWordBoundaryOrAnywhere)
    size_pt = largest_pt
    while True:
        font.setPointSizeF(size_pt)
        document = QTextDocument()
        document.documentLayout().setPaintDevice(writer)
        document.setDefaultFont(font)
        document.setDocumentMargin(0.0)
        document.setDefaultTextOption(wrapped)
        document.setHtml(f'<body style="color:#000000">{body}</body>')  # else in the colour of the theme
        document.setTextWidth(room.width())
        share = room.height() / document.size().height()
        if share >= 1:
            return document
        del document  # in its own thread: the traceback of the error may outlive it
        if size_pt <= SMALLEST_PT:
            raise RuntimeError("the report does not fit on one page")
        # The height grows with the square of the size, and lines break in steps: no size that is passed over fits.
        size_pt = max(SMALLEST_PT, min(size_pt - STEP_PT, (ceil(size_pt * sqrt(share) / STEP_PT) + 1) * STEP_PT))


def _application() -> QGuiApplication:
    """The application that fonts need; the command line makes one without a screen."""
    existing = QGuiApplication.instance()
    if isinstance(existing, QGuiApplication):
        return existing
    words = ["dps-s", "-platform", "offscreen"] if sys.platform == "linux" else ["dps-s"]
    _applications.append(QGuiApplication(words))
    return _applications[-1]


_applications: list[QGuiApplication] = []  # Keeps the application alive
