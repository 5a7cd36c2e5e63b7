"""Shows a module value with its source and age; unknown and stale values look different."""

from collections.abc import Mapping
from typing import Final

from PySide6.QtCore import QSize
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QSizePolicy

from app.engine.device import How, Known, StaleReason
from app.settings.setting_texts import value_text
from app.text.durations import duration
from app.text.i18n import tr
from app.text.sentences import in_brackets
from protocol.catalogue import Command
from protocol.translatable import marked
from ui.style.painted_widget import Freshness
from ui.style.theme import Size, font, scaled
from ui.widgets.readout import Readout

WIDTH_PX: Final = 136

HOW_WORDS: Final[Mapping[How, str]] = {
    How.READ: marked("read {time} ago"),
    How.ACKNOWLEDGED: marked("acknowledged {time} ago"),
    How.STREAMED: marked("seen {time} ago"),
}
STALE_WORDS: Final[Mapping[StaleReason, str]] = {
    StaleReason.RESTARTED: marked("before the restart"),
    StaleReason.LINK_LOST: marked("before link loss"),
    StaleReason.WRITE_UNCONFIRMED: marked("before an unconfirmed write"),
    StaleReason.AGED: marked("too old"),
    StaleReason.LATE: marked("arrived late"),
}


def how_known(known: Known, now: float) -> str:
    """Doubt, source and age in the language in use: "too old (read 12 s ago)"; its end may be elided."""
    text = tr(HOW_WORDS[known.how], time=duration(max(0.0, now - known.at)))
    return text if known.stale_reason is None else tr(STALE_WORDS[known.stale_reason]) + in_brackets(text)


class ValueLabel(Readout):
    """Shows the module's value of one setting, without a caption."""

    def __init__(self, command: Command) -> None:
        self._command = command
        super().__init__("", size=Size.BODY)
        self.setObjectName(f"{command.name}_stands")
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.show_known(None, 0.0)

    def show_known(self, known: Known | None, now: float) -> None:
        if known is None:
            freshness, text = Freshness.UNKNOWN, tr("unknown")
            note = tr("not read yet") if self._command.reads_back else tr("cannot be read")
        else:
            freshness = Freshness.STALE if known.is_stale else Freshness.FRESH
            text, note = value_text(self._command, known.value), how_known(known, now)
        self.show_value(text, freshness=freshness, note=note)

    def _changed(self) -> None:
        name = tr("{setting} on the module: {value}", setting=tr(self._command.title), value=self.text)
        self.setToolTip(self.note)
        self.announce(f"{name}, {self.note}" if self.note else name, name=name)

    def sizeHint(self) -> QSize:
        lines = QFontMetricsF(font(Size.BODY, is_bold=True)), QFontMetricsF(font(Size.SMALL))
        return QSize(scaled(WIDTH_PX), round(sum(line.height() for line in lines)))

    def minimumSizeHint(self) -> QSize:
        return QSize(WIDTH_PX, self.sizeHint().height())
