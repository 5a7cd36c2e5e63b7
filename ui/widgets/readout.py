"""Large value display and state chip (icon, word, colour). Both are painted, so that nothing moves when a digit is
added. The page decides what is fresh, stale or unknown."""

from collections.abc import Iterable
from math import ceil
from typing import Final

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPainterPath, QPaintEvent
from PySide6.QtWidgets import QApplication, QSizePolicy

from app.engine.conversation import Known
from app.safety.last_known import Activation, SeenActivation
from app.safety.trigger_flags import TriggerFlags
from app.text.durations import duration
from app.text.i18n import tr
from ui.style import icons
from ui.style.icons import Icon
from ui.style.painted_widget import Freshness, PaintedWidget, hatch, pen, unknown_box
from ui.style.theme import Meaning, Size, Space, current, font, scale_in_use, scaled

_LEFT: Final = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter


class Readout(PaintedWidget):
    """Caption, number with unit and limit, and a note or an age below; unknown at first.

    `template` is the widest number expected, such as "000.0", whose width is reserved. `size` is that of the number.
    """

    def __init__(self, caption: str, *, unit: str = "", template: str = "000", size: Size = Size.NUMBER) -> None:
        super().__init__()
        self._caption, self._unit, self._template, self._size, self._limit = caption, unit, template, size, ""
        self.text = self.note = self._widest_limit = ""
        self._notes: tuple[str, ...] = ()
        self._measured: tuple[object, object, QSize] = (None, None, QSize())
        self.meaning: Meaning | None = None
        self.freshness = Freshness.UNKNOWN
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._changed()

    def set_caption(self, caption: str) -> None:
        """Sets the caption, in the language in use."""
        self._caption = caption
        self.updateGeometry()
        self._changed()

    def set_limit(self, limit: str) -> None:
        """Sets the limit with its unit, such as "1.8 V", shown after a slash; "" for none."""
        if limit != self._limit:
            self._limit = limit
            self._changed()

    def reserve(self, notes: Iterable[str], *, limit: str = "") -> None:
        """Reserves room for the widest of `notes` and for `limit`, so that nothing beside it moves."""
        self._notes, self._widest_limit = tuple(notes), limit
        self.updateGeometry()

    def show_unknown(self) -> None:
        """Shows a hatched "unknown"."""
        self.show_value("", freshness=Freshness.UNKNOWN)

    def show_value(
        self, text: str, *, freshness: Freshness = Freshness.FRESH, meaning: Meaning | None = None, note: str = ""
    ) -> None:
        """`meaning` colours the value and adds an icon to the note, which of a stale one is its age."""
        if (freshness, text, note, meaning) != (self.freshness, self.text, self.note, self.meaning):
            self.freshness, self.text, self.note, self.meaning = freshness, text, note, meaning
            self._changed()

    def _changed(self) -> None:
        gap = "" if self._unit == "°" else " "
        value = tr("unknown") if self.freshness is Freshness.UNKNOWN else f"{self.text}{gap}{self._unit}"
        name = f"{self._caption}: {value}"
        if self._limit:
            name += f", {tr('limit {value}', value=self._limit)}"
        self.announce(f"{name}, {self.note}" if self.note else name, name=self._caption)

    def _widths(self) -> tuple[float, float, float]:
        """Widths of the number, the gap and the unit."""
        number = QFontMetricsF(font(self._size, is_bold=True)).horizontalAdvance(self._template)
        unit = QFontMetricsF(font(self._unit_font_size())).horizontalAdvance(self._unit)
        return (number, 0.0 if self._unit == "°" else float(Space.XS), unit)

    def _unit_font_size(self) -> Size:
        if self._unit == "°":
            return self._size
        return Size.BODY if self._size < Size.HERO else Size.TITLE

    def _unknown_px(self) -> float:
        """Width of the box with "unknown"."""
        return QFontMetricsF(font(Size.SMALL, is_bold=True)).horizontalAdvance(tr("unknown")) + 2 * Space.M

    def _number_room(self) -> QRectF:
        """The line of the number; the caption is above, if there is one, the note below."""
        small, number = QFontMetricsF(font(Size.SMALL)), QFontMetricsF(font(self._size, is_bold=True))
        if not self._caption:
            return QRectF(0, 0, self.width(), number.height())
        top = max(0.0, (self.height() - number.height()) / 2 - small.height())
        return QRectF(0, top + small.height(), self.width(), number.height())

    def sizeHint(self) -> QSize:
        """Measured once for the same words in the same letters: a layout asks many times."""
        words = (self._caption, self._limit, self._widest_limit, self._notes, tr("unknown"))
        letters = (QApplication.font().toString(), scale_in_use(), current().name)
        if self._measured[:2] != (words, letters):
            self._measured = (words, letters, self._measure())
        return self._measured[2]

    def _measure(self) -> QSize:
        small, body = QFontMetricsF(font(Size.SMALL)), QFontMetricsF(font(Size.BODY))
        limits = [f"/ {limit}" for limit in (self._limit, self._widest_limit) if limit]
        limit_px = max((body.horizontalAdvance(limit) + Space.S for limit in limits), default=0.0)
        words_px = max(map(small.horizontalAdvance, (self._caption, *self._notes)))
        least_px = max(small.horizontalAdvance("000 min") + 8, self._unknown_px())
        number = QFontMetricsF(font(self._size, is_bold=True))
        width = max(sum(self._widths()) + limit_px, words_px, least_px)
        return QSize(round(width) + 2, ceil(2 * small.height() + number.height()) + 2)

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = self.begin_paint()
        small = font(Size.SMALL)
        line_px = QFontMetricsF(small).height()
        painter.setFont(small)
        painter.setPen(QColor(theme.muted))
        body = self._number_room()
        painter.drawText(QRectF(0, body.top() - line_px, self.width(), line_px), _LEFT, self._caption)
        if self.note:
            self._paint_note(painter, QRectF(0, body.bottom(), self.width(), line_px))
        if self.freshness is Freshness.UNKNOWN:
            width = min(self.width(), max(sum(self._widths()), self._unknown_px()))
            edge = 2 if self._caption else 0
            box = QRectF(0, body.top(), width, body.height()).adjusted(0, edge, 0, -edge)
            unknown_box(painter, theme, box, tr("unknown"), font(Size.SMALL, is_bold=True))
        else:
            self._paint_number(painter, body)
        painter.end()

    def _paint_note(self, painter: QPainter, room: QRectF) -> None:
        theme, metrics = current(), QFontMetricsF(font(Size.SMALL))
        if self.meaning is not None:
            side = Size.SMALL
            square = QRectF(0, room.top() + (room.height() - side) / 2, side, side)
            icons.draw(painter, icons.MEANING_ICONS[self.meaning], square, theme.ink(self.meaning))
            room = room.adjusted(side + Space.XS, 0, 0, 0)
        painter.setPen(theme.ink(self.meaning) if self.meaning else QColor(theme.muted))
        painter.drawText(room, _LEFT, metrics.elidedText(self.note, Qt.TextElideMode.ElideRight, room.width()))

    def _paint_number(self, painter: QPainter, body: QRectF) -> None:
        theme = current()
        number_font = font(self._size, is_bold=True)
        metrics = QFontMetricsF(number_font)
        number, gap, unit = self._widths()
        text = metrics.elidedText(self.text, Qt.TextElideMode.ElideRight, self.width())
        text_px = metrics.horizontalAdvance(text)
        number = max(number, text_px)
        base = body.top() + (body.height() - metrics.height()) / 2 + metrics.ascent()
        is_stale = self.freshness is Freshness.STALE
        painter.setFont(number_font)
        painter.setPen(QColor(theme.muted) if is_stale else theme.ink(self.meaning))
        painter.drawText(QPointF(0, base), text)
        painter.setFont(font(self._unit_font_size()))
        painter.setPen(QColor(theme.muted))
        # A degree sign follows its number; other units stay in place.
        painter.drawText(QPointF(text_px if self._unit == "°" else number + gap, base), self._unit)
        right = (text_px if self._unit == "°" else number + gap) + unit
        if is_stale:
            # Underlined with dashes, so that stale is not shown by colour alone.
            painter.setPen(pen(theme.muted, theme.border_px, is_dashed=True))
            line = min(base + 4, self.height() - 1.0)
            painter.drawLine(QPointF(0, line), QPointF(text_px, line))
        if self._limit:
            painter.setFont(font(Size.BODY))
            painter.setPen(QColor(theme.muted))
            painter.drawText(QPointF(right + Space.S, base), f"/ {self._limit}")


class StateChip(PaintedWidget):
    """One state as icon, word and colour; unknown at first.

    Good and neutral states are plain, attention and danger filled, unknown hatched and dashed; a stale state is dashed
    and shows its age. `is_measured`: the word contains a measured value. `is_stacked`: the part after a comma and the
    age are in small letters below the word, and with `is_captioned` the caption where there is neither.
    """

    def __init__(
        self, caption: str, *, size: Size = Size.BODY, is_measured: bool = False, is_stacked: bool = False,
        is_captioned: bool = False,
    ) -> None:  # fmt: skip
        super().__init__()
        self._caption, self._size = caption, size
        self._is_measured, self._is_stacked = is_measured, is_stacked
        self._is_captioned = is_captioned
        self._shown: object = None
        self._unknown = ""
        self._reserved: tuple[str, ...] = ()
        self._reserved_below: tuple[str, ...] = ()
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.show_unknown()

    def set_caption(self, caption: str) -> None:
        """Sets what the state is of, for screen readers and the tooltip."""
        self._caption = caption
        self._changed()

    def name_unknown(self, text: str) -> None:
        """Sets the text shown for unknown, such as "Trigger unknown"; a stacked chip shows it above "unknown"."""
        self._unknown = text
        self.updateGeometry()
        self.update()

    def reserve(self, words: Iterable[str], *, below: Iterable[str] = ()) -> None:
        """Reserves room for the widest of `words`, and of `below` in small letters."""
        self._reserved, self._reserved_below = tuple(words), tuple(below)
        self.updateGeometry()

    def show_state(
        self,
        word: str,
        icon: Icon,
        meaning: Meaning | None = None,
        *,
        age: str = "",
        stale_age: str = "",
        keeps_colour: bool = False,
        detail: str = "",
    ) -> None:
        """`stale_age` marks a stale state, which with `keeps_colour` keeps the colour of its meaning, hatched; one that
        is not stale may have an `age`. `detail` is only for the tooltip and screen readers."""
        new = (word, icon, meaning, age, stale_age, keeps_colour and bool(stale_age), detail)
        if new != self._shown:
            self._shown = new
            self.word, self._icon, self.meaning, self._age, self._stale_age, self._has_fixed_colour, self._detail = new
            self.updateGeometry()
            self._changed()

    def show_unknown(self) -> None:
        self.show_state(tr("unknown"), Icon.UNKNOWN, Meaning.UNKNOWN)

    def _changed(self) -> None:
        name = f"{self._caption}: {self.word}"
        text = ", ".join(filter(None, (name, self._detail, self._stale_age or self._age)))
        self.announce(text, name=self._caption if self._is_measured else name)
        self.setToolTip(self.accessibleName())

    @property
    def _is_filled(self) -> bool:
        return self.meaning in (Meaning.ATTENTION, Meaning.DANGER) and not self._stale_age

    @property
    def _lines(self) -> tuple[str, str]:
        """The text in the size of the chip, and the one below it in small letters, or ""."""
        if self.meaning is Meaning.UNKNOWN and self._unknown:
            return self._unknown, self.word if self._is_stacked else ""
        if not self._is_stacked:
            return f"{self.word} · {self._stale_age}" if self._stale_age else f"{self.word} {self._age}".rstrip(), ""
        word, _, more = self.word.replace("，", ", ").partition(", ")
        return word, self._stale_age or more or (self._caption if self._is_captioned else "")

    def _icon_px(self) -> int:
        return scaled(self._size + 4)

    def sizeHint(self) -> QSize:
        metrics, small = QFontMetricsF(font(self._size, is_bold=True)), QFontMetricsF(font(Size.SMALL))
        words = max(metrics.horizontalAdvance(line) for line in (self._lines[0], *self._reserved))
        words = max(words, *(small.horizontalAdvance(line) for line in self._reserved_below), 0.0)
        width = Space.S + self._icon_px() + Space.XS + 2 + words + Space.S
        lines = metrics.height() + (small.height() + 2 * current().border_px if self._lines[1] else Space.S)
        return QSize(round(width) + 1, max(scaled(30), round(lines)))

    def paintEvent(self, _event: QPaintEvent) -> None:
        theme = current()
        painter = self.begin_paint()
        edge = theme.border_px
        outline = QPainterPath()
        outline.addRoundedRect(QRectF(self.rect()).adjusted(edge / 2, edge / 2, -edge / 2, -edge / 2), 6, 6)
        tint = theme.tint(self.meaning) if self.meaning else None
        ink = theme.ink(self.meaning)
        is_unknown = self.meaning is Meaning.UNKNOWN
        if tint and self._is_filled:
            painter.fillPath(outline, QColor(tint.fill))
            painter.setPen(pen(tint.ink, edge))
            ink = QColor(tint.on_fill)
        else:
            painter.fillPath(outline, QColor(theme.surface))
            if is_unknown:
                hatch(painter, outline, theme.divider if edge == 1 else theme.muted)
            if tint and self._has_fixed_colour:
                hatch(painter, outline, tint.ink)
            is_dashed = is_unknown or bool(self._stale_age)
            line = theme.border if is_dashed else theme.divider
            painter.setPen(pen(tint.ink if tint and self._has_fixed_colour else line, edge, is_dashed=is_dashed))
        painter.drawPath(outline)
        self._paint_word(painter, ink)
        painter.end()

    def _paint_word(self, painter: QPainter, ink: QColor) -> None:
        theme = current()
        side = self._icon_px()
        square = QRectF(Space.S, (self.height() - side) / 2, side, side)
        # In a plain state only the icon is coloured.
        is_quiet = not self._is_filled and self.meaning is not Meaning.UNKNOWN
        is_dim = bool(self._stale_age) and not self._has_fixed_colour
        text = QColor(theme.muted) if is_dim else (QColor(theme.text) if is_quiet else ink)
        left = square.right() + Space.XS + 2
        room = QRectF(left, 0, self.width() - left - Space.S, self.height())
        bold, small = font(self._size, is_bold=True), font(Size.SMALL)
        above, below = self._lines
        below = QFontMetricsF(small).elidedText(below, Qt.TextElideMode.ElideRight, room.width())
        if self.meaning is Meaning.UNKNOWN or self._has_fixed_colour:
            # Without hatching behind the word.
            words = max(QFontMetricsF(bold).horizontalAdvance(above), QFontMetricsF(small).horizontalAdvance(below))
            ground = QRectF(square.left() - 3, 3, square.width() + words + Space.XS + 10, self.height() - 6.0)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(QColor(theme.surface))
            painter.drawRoundedRect(ground, 4, 4)
            text = QColor(theme.text)
        icons.draw(painter, self._icon, square, QColor(theme.muted) if is_dim else ink)
        painter.setFont(bold)
        painter.setPen(text)
        if not below:
            painter.drawText(room, _LEFT, above)
            return
        high, low = QFontMetricsF(bold).height(), QFontMetricsF(small).height()
        top = (self.height() - high - low) / 2
        painter.drawText(QRectF(left, top, room.width(), high), _LEFT, above)
        painter.setFont(small)
        painter.drawText(QRectF(left, top + high, room.width(), low), _LEFT, below)


def show_activation(chip: StateChip, seen: SeenActivation, now: float) -> None:
    """A stale ACTIVE keeps its colour, hatched, since nobody has seen the module locked."""
    age = "" if seen.at is None else tr("{time} ago", time=duration(now - seen.at))
    match seen.state:
        case Activation.UNKNOWN:
            chip.show_unknown()
        case Activation.ACTIVE:
            chip.show_state(tr("ACTIVE"), Icon.ACTIVE, Meaning.ATTENTION)
        case Activation.WAS_ACTIVE:
            chip.show_state(tr("was ACTIVE"), Icon.ACTIVE, Meaning.ATTENTION, stale_age=age, keeps_colour=True)
        case Activation.LOCKED:
            chip.show_state(tr("LOCKED"), Icon.LOCK)
        case Activation.WAS_LOCKED:
            chip.show_state(tr("LOCKED"), Icon.LOCK, stale_age=age)


def show_known_trigger(chip: StateChip, known: Known | None, now: float) -> None:
    """Triggered or not, as the module reported it; None if unknown."""
    if known is None:
        chip.show_unknown()
    elif known.value is True:
        age = age_of(known, now)
        chip.show_state(tr("TRIGGERED"), Icon.PARACHUTE, Meaning.DANGER, stale_age=age, keeps_colour=True)
    else:
        chip.show_state(tr("NOT TRIGGERED"), Icon.NOT_TRIGGERED, stale_age=age_of(known, now))


def show_trigger_flags(chip: StateChip, flags: TriggerFlags) -> None:
    """Whether the automatic triggers are on, as far as that is known."""
    if flags.is_one_off:
        chip.show_state(flags.text, Icon.WARNING, Meaning.ATTENTION)
    elif flags.are_on:
        chip.show_state(flags.text, Icon.CHECK)
    else:
        chip.show_state(flags.text, Icon.UNKNOWN, Meaning.UNKNOWN)


def age_of(known: Known, now: float) -> str:
    """The age of a stale value, else ""."""
    return tr("{time} ago", time=duration(now - known.at)) if known.is_stale else ""
