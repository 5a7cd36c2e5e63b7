"""Shows a module value with its source and age; unknown and stale values look different."""

from collections.abc import Mapping
from typing import Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPaintEvent
from PySide6.QtWidgets import QSizePolicy

from app.engine.device import How, Known, StaleReason
from app.settings.setting_texts import value_text
from app.text.durations import duration
from app.text.i18n import tr
from protocol.catalogue import Command
from protocol.translatable import marked
from ui.style.painted_widget import Freshness, PaintedWidget, pen, unknown_box
from ui.style.theme import Size, current, font, scaled

WIDTH_PX: Final = 112
_GAP_PX: Final = 2
_LEFT: Final = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter

HOW_WORDS: Final[Mapping[How, str]] = {
    How.READ: marked("read {time} ago"),
    How.ACKNOWLEDGED: marked("acknowledged {time} ago"),
    How.STREAMED: marked("seen {time} ago"),
}
STALE_WORDS: Final[Mapping[StaleReason, str]] = {
    StaleReason.RESTARTED: marked("before the restart"),
    StaleReason.LINK_LOST: marked("before the link was lost"),
    StaleReason.WRITE_UNCONFIRMED: marked("before an unconfirmed write"),
    StaleReason.AGED: marked("too old"),
    StaleReason.LATE: marked("arrived late"),
}


def how_known(known: Known, now: float) -> str:
    """Source, age and doubt in the language in use: "read 12 s ago, too old"."""
    said = tr(HOW_WORDS[known.how], time=duration(max(0.0, now - known.at)))
    return said if known.stale_reason is None else f"{said}, {tr(STALE_WORDS[known.stale_reason])}"


class ValueLabel(PaintedWidget):
    """Shows the module's value of one setting."""

    def __init__(self, command: Command) -> None:
        super().__init__()
        self.setObjectName(f"{command.name}_stands")
        self._command = command
        self.text = self.note = self._name = ""
        self.freshness = Freshness.UNKNOWN
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.show_known(None, 0.0)

    def show_known(self, known: Known | None, now: float) -> None:
        if known is None:
            freshness, text = Freshness.UNKNOWN, tr("unknown")
            note = tr("not read yet") if self._command.reads_back else tr("cannot be read")
        else:
            freshness = Freshness.STALE if known.is_stale else Freshness.FRESH
            text, note = value_text(self._command, known.value), how_known(known, now)
        name = tr("{setting} on the module: {value}", setting=tr(self._command.title), value=text)
        if (freshness, text, note, name) == (self.freshness, self.text, self.note, self._name):
            return
        self._name = name
        self.freshness, self.text, self.note = freshness, text, note
        self.setToolTip(note)
        self.announce(f"{name}, {note}" if note else name, name=name)

    def sizeHint(self) -> QSize:
        title, small = QFontMetricsF(font(Size.BODY, is_bold=True)), QFontMetricsF(font(Size.SMALL))
        return QSize(scaled(WIDTH_PX), round(title.height() + small.height() + _GAP_PX))

    def minimumSizeHint(self) -> QSize:
        return QSize(WIDTH_PX, self.sizeHint().height())

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = self.begin_paint()
        title, small = font(Size.BODY, is_bold=True), font(Size.SMALL)
        metrics, fine = QFontMetricsF(title), QFontMetricsF(small)
        if self.freshness is Freshness.UNKNOWN:
            word_font = font(Size.SMALL, is_bold=True)
            width = max(88.0, QFontMetricsF(word_font).horizontalAdvance(self.text) + 28)
            unknown_box(painter, theme, QRectF(0, 0, width, metrics.height()), self.text, word_font)
        else:
            is_stale = self.freshness is Freshness.STALE
            painter.setFont(title)
            painter.setPen(QColor(theme.muted if is_stale else theme.text))
            shown = metrics.elidedText(self.text, Qt.TextElideMode.ElideRight, self.width())
            painter.drawText(QPointF(0, metrics.ascent()), shown)
            if is_stale:
                # Not by colour alone.
                painter.setPen(pen(theme.muted, theme.border_px, is_dashed=True))
                line = min(metrics.ascent() + 3, metrics.height())
                painter.drawLine(QPointF(0, line), QPointF(metrics.horizontalAdvance(shown), line))
        room = QRectF(0, metrics.height() + _GAP_PX, self.width(), fine.height())
        painter.setFont(small)
        painter.setPen(QColor(theme.muted))
        painter.drawText(room, _LEFT, fine.elidedText(self.note, Qt.TextElideMode.ElideRight, room.width()))
        painter.end()
