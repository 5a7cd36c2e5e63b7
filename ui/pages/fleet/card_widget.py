"""Card of one module, readable from two metres; a click shows the module on the other pages."""

from collections.abc import Callable, Mapping
from typing import ClassVar, Final

from PySide6.QtCore import QRectF, Qt, Signal
from PySide6.QtGui import QAccessible, QColor, QKeyEvent, QMouseEvent, QPainter, QPainterPath, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QFrame, QMenu, QPushButton, QSizePolicy, QToolButton, QWidget

from app.diagnosis.link_state import link_text
from app.fleet.card import Card, Need
from app.fleet.check_set import word_of
from app.text.durations import duration
from app.text.i18n import tr
from app.text.sentences import capitalised, labelled
from ui.session.check import VERDICT_STYLES
from ui.session.port import Port
from ui.style.icons import MEANING_ICONS, Icon
from ui.style.painted_widget import pen
from ui.style.theme import Meaning, Size, Space, current, scaled
from ui.widgets.controls import control, named, set_role
from ui.widgets.labels import ElidedLabel, IconLabel, text_label
from ui.widgets.layouts import in_column, in_row
from ui.widgets.readout import Readout, StateChip, show_activation, show_known_trigger

CARD_PX: Final = 324
"""Minimum width of a card at 100 %."""
CARD_HEIGHT_PX: Final = 256
_STRIPE_PX: Final = 5
_SHOWN: Final = ("triggered", "active", "cell_voltage_v", "charging")
"""What a card shows of the conversation; stale, with an age that ticks."""
NEED_MEANINGS: Final[Mapping[Need, Meaning]] = {
    Need.TRIGGERED: Meaning.DANGER,
    Need.NOT_LOCKED: Meaning.DANGER,
    Need.WAS_ACTIVE: Meaning.ATTENTION,
    Need.LINK: Meaning.ATTENTION,
    Need.NO_GO: Meaning.DANGER,
    Need.OUTSIDE: Meaning.ATTENTION,
    Need.ACTIVE: Meaning.ATTENTION,
    Need.VOID: Meaning.ATTENTION,
    Need.ACTIVE_READY: Meaning.ATTENTION,
    Need.NAME: Meaning.INFORMATION,
    Need.CHECK: Meaning.INFORMATION,
    Need.ACTIVATE: Meaning.INFORMATION,
    Need.WAIT: Meaning.UNKNOWN,
    Need.NOTHING: Meaning.GOOD,
}


class CardWidget(QFrame):
    chosen = Signal()
    """A person wants this module on the other pages."""
    accessible_role: ClassVar = QAccessible.Role.Button

    def __init__(self, port: Port, disconnect: Callable[[], object]) -> None:
        super().__init__()
        named(self, "fleet_card", "card")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.card: Card | None = None
        self._shown: tuple[object, ...] = ()
        self._is_pressed = False
        self.title = named(ElidedLabel(), "fleet_name", "heading")
        self.port = named(ElidedLabel(), "fleet_port", "small")
        self.lock = control(QPushButton(tr("LOCK")), "fleet_lock", picture=Icon.LOCK, slot=port.lock.press)
        self.more = control(QToolButton(), "fleet_card_more", says=tr("More"), picture=Icon.MORE, role="quiet")
        menu = named(QMenu(self.more), "fleet_card_more_menu")
        self.show_action, self.disconnect_action = menu.addAction(""), menu.addAction("")
        self.show_action.triggered.connect(self.chosen)
        self.disconnect_action.triggered.connect(disconnect)
        self.show_action.setText(tr("Show on all pages"))
        self.disconnect_action.setText(tr("Disconnect"))
        self.more.setMenu(menu)
        self.more.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.activation = named(StateChip("", size=Size.TITLE, is_stacked=True), "fleet_activation")
        self.trigger = named(StateChip("", is_stacked=True), "fleet_trigger")
        self.verdict = named(StateChip("", size=Size.TITLE), "fleet_verdict")
        self.activation.name_unknown(tr("Activation"))
        self.trigger.name_unknown(tr("Trigger"))
        self.cell = named(Readout("", unit="V", template="0.00", size=Size.TITLE), "fleet_cell")
        self.cell.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.need_icon = IconLabel("fleet_need_icon", 18)
        self.need = text_label("fleet_need", "strong")
        self.need.setAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop)
        self._lay_out()

    @property
    def meaning(self) -> Meaning:
        return Meaning.UNKNOWN if self.card is None else NEED_MEANINGS[self.card.need]

    def show_card(self, card: Card, now: float) -> None:
        need = card.next_step(now)
        age, ended_at = "", None if card.verdict is None else card.verdict.at
        if ended_at is not None and not card.is_checking:
            age = tr("{time} ago", time=duration(now - ended_at))
        link = link_text(card.link, now).word
        self.card = card
        known = [card.conversation.known(key, now) for key in _SHOWN]
        values = [None if one is None else (one.value, one.is_stale) for one in known]
        has_age = any(one is not None and one.is_stale for one in known)
        shown = (card, need, age, link, *values)
        if shown == self._shown and not has_age:
            return
        self._shown = shown
        self.activation.set_caption(tr("Activation"))
        self.trigger.set_caption(tr("Trigger"))
        self.verdict.set_caption(tr("Verdict"))
        self.cell.set_caption(tr("Cell"))
        self.title.setText(card.title)
        where = f"{link} · {card.port}"
        self.port.setText(f"{tr('Shown')} · {where}" if card.is_shown else where)
        show_activation(self.activation, card.activation, now)
        show_known_trigger(self.trigger, card.conversation.known("triggered", now), now)
        self._show_cell(card, now)
        self._show_verdict(card, age)
        self.lock.setEnabled(card.can_lock)
        set_role(self.lock, "primary" if card.activation.may_fire else "")
        self.lock.setAccessibleName(labelled(tr("LOCK"), _label(card)))
        self.more.setAccessibleName(labelled(tr("More"), _label(card)))
        self.need_icon.show_icon(MEANING_ICONS[self.meaning], self.meaning)
        self.need.setText(need)
        self.need.setToolTip(need)
        self.show_action.setEnabled(not card.is_shown)
        self.setAccessibleName(f"{card.title}, {card.port}: {need}")
        self.update()

    def _show_cell(self, card: Card, now: float) -> None:
        voltage = card.conversation.fresh("cell_voltage_v", now)
        if voltage is None:
            self.cell.show_unknown()
            return
        meaning = None if card.cell_outside is None else Meaning.ATTENTION
        note = tr("charging") if card.conversation.fresh("charging", now) else ""
        note = note if card.cell_outside is None else tr(card.cell_outside.fault.value)
        self.cell.show_value(f"{float(voltage):.2f}", meaning=meaning, note=note)

    def _show_verdict(self, card: Card, age: str) -> None:
        held = card.verdict
        if card.is_checking:
            self.verdict.show_state(capitalised(tr("checking…")), Icon.CONNECTING, Meaning.INFORMATION)
        elif held is None:
            self.verdict.show_state(word_of(None), Icon.UNKNOWN, Meaning.UNKNOWN)
        elif held.verdict is None:
            self.verdict.show_state(tr("void"), MEANING_ICONS[Meaning.ATTENTION], Meaning.ATTENTION, age=age)
        else:
            self.verdict.show_state(word_of(held.verdict), *VERDICT_STYLES[held.verdict], age=age)

    def _lay_out(self) -> None:
        head = in_row((in_column(self.title, self.port, spacing=0), 1), self.lock, self.more, spacing=Space.XS)
        head.setAlignment(self.lock, Qt.AlignmentFlag.AlignTop)
        head.setAlignment(self.more, Qt.AlignmentFlag.AlignTop)
        left = Qt.AlignmentFlag.AlignLeft
        chips = ((self.activation, left), (self.verdict, left), (self.trigger, left))
        states = in_column(*chips, 1, spacing=Space.S)
        numbers = in_column(self.cell, 1, spacing=Space.S)
        values = in_row(states, 1, numbers, spacing=Space.M)
        need = in_row(self.need_icon, (self.need, 1), spacing=Space.S)
        need.setAlignment(self.need_icon, Qt.AlignmentFlag.AlignTop)
        in_column(head, values, (need, 1), of=self, spacing=Space.S,
                  margins=(Space.M + _STRIPE_PX, Space.S, Space.S, Space.S))  # fmt: skip

    # Qt

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        theme, painter = current(), QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        outline = QPainterPath()
        outline.addRoundedRect(QRectF(self.rect()).adjusted(1, 1, -1, -1), 8, 8)
        painter.setClipPath(outline)
        tint = theme.tint(self.meaning)
        painter.fillRect(0, 0, scaled(_STRIPE_PX), self.height(), QColor(tint.fill))
        painter.setClipping(False)
        if self.hasFocus() or (self.card is not None and self.card.is_shown):
            painter.setPen(pen(theme.information.ink, 2, is_dashed=self.hasFocus()))
            painter.drawPath(outline)
        painter.end()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self._is_pressed = event.button() is Qt.MouseButton.LeftButton
        event.accept()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        was_pressed, self._is_pressed = self._is_pressed, False
        if was_pressed and self.rect().contains(event.position().toPoint()):
            self.chosen.emit()
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Space) and not event.isAutoRepeat():
            self.chosen.emit()
        else:
            super().keyPressEvent(event)


def _label(card: Card) -> str:
    """Its name, or its port where it has none."""
    return card.name or card.port


class Board(QWidget):
    """Cards in as many columns as fit, in the given order. None is a place that stays empty."""

    def __init__(self) -> None:
        super().__init__()
        named(self, "fleet_board")
        self._places: list[CardWidget | None] = []

    @property
    def cards(self) -> tuple[CardWidget, ...]:
        return tuple(card for card in self._places if card is not None)

    def arrange(self, cards: list[CardWidget], *, is_held: bool) -> None:
        """Show these cards; the caller deletes the ones that are gone. `is_held`: each keeps its place, and new ones
        come last."""
        places: list[CardWidget | None] = list(cards)
        if is_held:
            kept = [card if card in cards else None for card in self._places]
            places = [*kept, *(card for card in cards if card not in kept)]
        if places == self._places:
            return
        self._places = places
        before: QWidget | None = None
        for card in self.cards:
            if card.parent() is not self:
                card.setParent(self)
                card.show()
            if before is not None:
                self.setTabOrder(before, card)
            before = card
        self.place()

    def place(self) -> None:
        width, gap = max(1, self.width()), int(Space.M)
        columns = max(1, (width - gap) // (scaled(CARD_PX) + gap))
        card_px = (width - gap * (columns + 1)) // columns
        height = scaled(CARD_HEIGHT_PX)
        for place, card in enumerate(self._places):
            if card is None:
                continue
            row, column = divmod(place, columns)
            card.setGeometry(gap + column * (card_px + gap), gap + row * (height + gap), card_px, height)
        rows = -(-len(self._places) // columns)
        self.setMinimumHeight(gap + rows * (height + gap))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Also where a scroll bar comes or goes, which the page does not learn of."""
        super().resizeEvent(event)
        self.place()
