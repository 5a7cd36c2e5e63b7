"""Prints a report page as A4 PDF with the record attached. Needs no screen.

Chinese is embedded where the computer has a font for it; the size of the text is the largest at which all of it fits.
"""

import sys

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

MARGIN_MM = 12.0
LARGEST_PT, SMALLEST_PT, STEP_PT = 9.0, 4.0, 0.25
RESOLUTION_DPI = 600
ATTACHED_AS = "record.json"
_LIGATURES = QFont.Tag("liga")
_CHINESE = ("WenQuanYi Micro Hei", "Noto Sans CJK SC", "Microsoft YaHei", "PingFang SC", "SimSun")


def print_report(body: str, attachment: bytes) -> bytes:
    """The PDF of the HTML `body`, with `attachment`. Raises `RuntimeError`."""
    _application()
    _timers = QEventLoop()  # gives a background thread the event dispatcher that the timers of the text layout need
    data = QByteArray()
    buffer = QBuffer(data)
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    writer = QPdfWriter(buffer)
    writer.setResolution(RESOLUTION_DPI)
    writer.setPageSize(QPageSize(QPageSize.PageSizeId.A4))
    margins = QMarginsF(MARGIN_MM, MARGIN_MM, MARGIN_MM, MARGIN_MM)
    writer.setPageMargins(margins, QPageLayout.Unit.Millimeter)
    writer.setTitle("DPS-S pre-flight check")
    writer.setCreator("DPS-S Configurator")
    writer.addFileAttachment(ATTACHED_AS, QByteArray(attachment), "application/json")
    page = QSizeF(writer.width(), writer.height())
    document = _fitting(body, page, writer)  # before the painter: an error must not leave it active
    painter = QPainter()
    if not painter.begin(writer):
        raise RuntimeError("the PDF cannot be started")
    document.drawContents(painter)
    if not painter.end():
        raise RuntimeError("the PDF cannot be finished")
    buffer.close()
    return bytes(data.data())


def _fitting(body: str, page: QSizeF, writer: QPdfWriter) -> QTextDocument:
    """The document at the largest font size that fits on one page."""
    size_pt = LARGEST_PT
    while True:
        document = _document(body, page, writer, size_pt)
        if document.size().height() <= page.height():
            return document
        del document  # in its own thread: the traceback of the error may outlive it
        if size_pt <= SMALLEST_PT:
            raise RuntimeError("the report does not fit on one page")
        size_pt -= STEP_PT


def _document(body: str, page: QSizeF, writer: QPdfWriter, size_pt: float) -> QTextDocument:
    document = QTextDocument()
    document.documentLayout().setPaintDevice(writer)
    document.setDefaultFont(_font(size_pt))
    document.setDocumentMargin(0.0)
    option = QTextOption()
    option.setWrapMode(QTextOption.WrapMode.WrapAtWordBoundaryOrAnywhere)
    document.setDefaultTextOption(option)
    document.setHtml(body)
    document.setTextWidth(page.width())
    return document


def _font(size_pt: float) -> QFont:
    """A sans-serif font, followed by one with Simplified Chinese glyphs."""
    families = QFontDatabase.families(QFontDatabase.WritingSystem.SimplifiedChinese)
    chinese = [name for name in _CHINESE if name in families] or families[:1]
    font = QFont()
    font.setFamilies(["DejaVu Sans", "Arial", "Helvetica", *chinese])
    font.setStyleHint(QFont.StyleHint.SansSerif)
    font.setPointSizeF(size_pt)
    font.setFeature(_LIGATURES, 0)  # who copies text out of the report gets letters
    return font


def _application() -> QGuiApplication:
    """The application that fonts need; the command line makes one without a screen."""
    existing = QGuiApplication.instance()
    if isinstance(existing, QGuiApplication):
        return existing
    words = ["dps-s", "-platform", "offscreen"] if sys.platform == "linux" else ["dps-s"]
    _applications.append(QGuiApplication(words))
    return _applications[-1]


_applications: list[QGuiApplication] = []
"""Keeps the application alive."""
