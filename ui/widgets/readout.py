"""Large values and state chips as labels of Qt; the base of the few widgets that paint themselves.

The page decides what is fresh, stale or unknown. What a label looks like is its property "look", see `style.qss`.
"""

from collections.abc import Iterable
from enum import Enum
from typing import ClassVar

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QAccessible, QColor, QFont, QFontMetrics, QPen
from PySide6.QtWidgets import QFrame, QLabel, QSizePolicy, QWidget

from app.engine.conversation import Known
from app.text.i18n import tr
from app.text.messages import duration
from ui.style.appearance import Spoken
from ui.style.icons import MEANING_ICONS, Icon
from ui.style.theme import IconSize, Meaning, Size, Space, current, font
from ui.widgets.controls import IconLabel, in_column, in_row, set_look


class Freshness(Enum):
    """How a value is known."""

    FRESH = "fresh"
    STALE = "stale"
    UNKNOWN = "unknown"


class PaintedWidget(Spoken, QWidget):
    """Measures and repaints after a change of theme."""

    accessible_role: ClassVar = QAccessible.Role.StaticText  # See `ui.style.appearance`
    usual: ClassVar = QSize()  # Its size hint, where that does not depend on what it shows
    least: ClassVar = QSize()  # Its minimum size hint; without one it is the size hint

    def sizeHint(self) -> QSize:
        return QSize(self.usual)

    def minimumSizeHint(self) -> QSize:
        return QSize(self.least) if self.least.isValid() else self.sizeHint()

    def changeEvent(self, event: QEvent) -> None:
        if event.type() == QEvent.Type.PaletteChange:
            self.updateGeometry()
            self.update()
        super().changeEvent(event)

    def announce(self, text: str, *, name: str = "") -> None:
        """Lets screen readers say `text`, see `Spoken.say`, and paints again."""
        self.say(text, name=name)
        self.update()


def pen(colour: QColor | str, width: float, *, is_dashed: bool = False) -> QPen:
    """A pen with flat ends, so that dashes keep their length."""
    flat_pen = QPen(QColor(colour), width)
    flat_pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    if is_dashed:
        flat_pen.setDashPattern([4, 3])
    return flat_pen


def _bold(size: Size = Size.BODY) -> QFontMetrics:
    """As wide as letters get: they are bold in sunlight."""
    bold = QFont(font(size))
    bold.setBold(True)
    return QFontMetrics(bold)


def _label(role: str) -> QLabel:
    label = QLabel()
    label.setProperty("role", role)
    label.setAccessibleName(role)  # without one Qt tells each change of its text; the frame around it speaks
    return label


class Readout(Spoken, QFrame):
    """Caption, number with unit and limit, and a note or an age below; unknown at first.

    `template` is a number of the usual width, whose room is kept. `size` is that of the number.
    """

    accessible_role: ClassVar = QAccessible.Role.StaticText

    def __init__(self, caption: str, *, unit: str = "", template: str = "000", size: Size = Size.NUMBER) -> None:
        super().__init__()
        self._unit, self._limit = unit, ""
        self.text = self.note = ""
        self.meaning: Meaning | None = None
        self.freshness = Freshness.UNKNOWN
        self._template, self._size = template, size
        caption_label = _label("small")
        caption_label.setText(caption)
        self._caption = caption
        self._number = _label("number" if size is Size.NUMBER else "amount")
        self._number.setIndent(0)  # Qt's own is larger with a border
        self._unit_label, self._limit_label = _label("muted"), _label("muted")
        self._unit_label.setText("" if unit == "°" else unit)
        self._icon, self._note_label = IconLabel("", Size.SMALL), _label("small")
        self._icon.hide()
        line = in_row(self._number, self._unit_label, self._limit_label, 1, spacing=Space.XS)
        below = in_row(self._icon, (self._note_label, 1), spacing=Space.XS)
        in_column(caption_label, line, below, of=self, spacing=0, margins=0)
        self._show()

    def set_limit(self, limit: str) -> None:
        """Sets the limit with its unit, such as "1.8 V", shown after a slash; "" for none."""
        if limit != self._limit:
            self._limit = limit
            self._limit_label.setText(f"/ {limit}" if limit else "")
            self._say()

    def reserve(self, notes: Iterable[str], *, limit: str = "") -> None:
        """Keeps room for the widest of `notes` and for `limit`, so that nothing beside it moves."""
        small, body = QFontMetrics(font(Size.SMALL)), QFontMetrics(font())
        notes_px = max(map(small.horizontalAdvance, notes), default=0) + small.height() + Space.XS
        number_px = _bold(self._size).horizontalAdvance(self._template)
        line_px = number_px + body.horizontalAdvance(f"{self._unit} / {limit}") + 2 * Space.XS
        self.setMinimumWidth(max(notes_px, line_px))

    def show_unknown(self) -> None:
        self.show_value("", freshness=Freshness.UNKNOWN)

    def show_value(
        self, text: str, *, freshness: Freshness = Freshness.FRESH, meaning: Meaning | None = None, note: str = ""
    ) -> None:
        """`meaning` colours the value and adds an icon to the note, which of a stale one is its age."""
        if (freshness, text, note, meaning) != (self.freshness, self.text, self.note, self.meaning):
            self.freshness, self.text, self.note, self.meaning = freshness, text, note, meaning
            self._show()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.StyleChange:  # another theme: its numbers may be wider
            self._show()

    def _show(self) -> None:
        is_known = self.freshness is not Freshness.UNKNOWN
        number = f"{self.text}°" if self._unit == "°" else self.text
        # A label of a fixed size does not have the page laid out again at each new number.
        shown = number if is_known else tr("unknown")
        metrics = QFontMetrics(font(self._size, is_bold=current().line_px > 1))  # as the style sheet has it
        width_px = max(map(metrics.horizontalAdvance, (self._template, shown))) + Space.XS
        if width_px != self._number.minimumWidth():
            self._number.setFixedSize(width_px, metrics.height())
        self._number.setText(shown)
        self._unit_label.setVisible(is_known and bool(self._unit_label.text()))
        meaning = "" if self.meaning is None else self.meaning.value
        set_look(meaning if self.freshness is Freshness.FRESH else self.freshness.value, self._number)
        if self._note_label.text() != self.note:
            self._note_label.setText(self.note)
        self._icon.setVisible(self.meaning is not None and bool(self.note))
        if self.meaning is not None:
            self._icon.show_icon(MEANING_ICONS[self.meaning], self.meaning)
        set_look(meaning, self._note_label)
        self._say()

    def _say(self) -> None:
        gap = "" if self._unit == "°" else " "
        value = tr("unknown") if self.freshness is Freshness.UNKNOWN else f"{self.text}{gap}{self._unit}"
        limit = tr("limit {value}", value=self._limit) if self._limit else ""
        self.say(", ".join(filter(None, (f"{self._caption}: {value}", limit, self.note))), name=self._caption)


class StateChip(Spoken, QFrame):
    """A chip shows one state as icon, word and colour, with small letters below where there is more to say; unknown at
    first.

    Good and neutral states are plain, attention and danger filled, unknown dashed; a stale state is dashed and shows
    its age. `is_measured`: the word contains a measured value, of which each change is no news.
    """

    accessible_role: ClassVar = QAccessible.Role.StaticText

    def __init__(self, caption: str, *, is_measured: bool = False) -> None:
        super().__init__()
        self.setProperty("role", "chip")
        self._caption, self._is_measured = caption, is_measured
        self._shown: object = None
        self.word = self.stale_age = ""
        self.meaning: Meaning | None = None
        self._icon = IconLabel("", IconSize.STATE, keeps_place=True)
        self._above, self._below = _label("word"), _label("small")
        words = in_column(1, self._above, self._below, 1, spacing=0)
        in_row(self._icon, (words, 1), of=self, spacing=Space.XS, margins=(Space.S, 0))
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.show_unknown()

    def reserve(self, words: Iterable[str], *, below: Iterable[str] = ()) -> None:
        """Keeps room for the widest of `words`, and of `below` in small letters."""
        small = QFontMetrics(font(Size.SMALL))
        widths = [*map(_bold().horizontalAdvance, words), *map(small.horizontalAdvance, below)]
        self._above.setMinimumWidth(max(widths))

    def show_unknown(self) -> None:
        self.show_state(tr("unknown"), Icon.UNKNOWN, Meaning.UNKNOWN)

    def show_state(
        self,
        word: str,
        icon: Icon,
        meaning: Meaning | None = None,
        *,
        below: str = "",
        stale_age: str = "",
        detail: str = "",
    ) -> None:
        """`stale_age` marks a stale state, which keeps the colour of attention or danger. `detail` is only for the
        tooltip and screen readers."""
        new = (word, icon, meaning, below, stale_age, detail)
        if new == self._shown:
            return
        self._shown, self.word, self.meaning, self.stale_age = new, word, meaning, stale_age
        is_unknown = word == tr("unknown")
        self._above.setText(self._caption if is_unknown else word)
        self._below.setText(word if is_unknown else stale_age or below)
        self._below.setVisible(bool(self._below.text()))
        is_loud = meaning in (Meaning.ATTENTION, Meaning.DANGER)
        look = meaning.value if meaning is not None and is_loud else ""
        if meaning is Meaning.UNKNOWN:
            look = "unknown"
        elif stale_age:
            look = f"stale-{look}" if look else "stale"
        set_look(look, self, self._above, self._below)
        self._icon.show_icon(icon, meaning, is_muted=look == "stale", is_filled=is_loud and not stale_age)
        state = f"{self._caption}: {word}"
        more = "" if below == self._caption else below
        text = ", ".join(filter(None, (state, more, detail, stale_age)))
        self.say(text, name=self._caption if self._is_measured else state)
        self.setToolTip(text)


def age_of(known: Known, now: float) -> str:
    """The age of a stale value, else ""."""
    return tr("{time} ago", time=duration(now - known.at)) if known.is_stale else ""
