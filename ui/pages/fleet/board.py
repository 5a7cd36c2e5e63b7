"""The table of connected modules: a row for each port, with a tick and a LOCK button of its own."""

from collections.abc import Mapping
from typing import Final, NamedTuple

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QSize, Qt, Signal
from PySide6.QtGui import QFontMetrics, QIcon, QKeyEvent, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QPushButton,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from app.fleet.card import Applied, Card, Need
from app.preflight.verdict import Standing
from app.safety.last_known import Activation, trigger_flags
from app.settings.profiles import Profile
from app.settings.values import value_text
from app.text.i18n import tr
from app.text.messages import duration, in_brackets, labelled
from protocol.translatable import marked
from ui.forms.tables import list_rows
from ui.pages.fleet.group_jobs import GroupProfile
from ui.pages.fleet.members import FleetMembers
from ui.session.check import VERDICT_STYLES
from ui.session.port import Port
from ui.style.icons import MEANING_ICONS, Icon, icon
from ui.style.theme import IconSize, Meaning, Space, current, font, is_text_large, scaled
from ui.widgets.controls import control, in_column, named, set_role

_TITLES: Final = (
    marked("Module"),
    marked("LOCK"),
    marked("State"),
    marked("Triggers, cell"),
    marked("Verdict"),
    marked("Next step"),
)
MODULE, LOCK, STATE, TRIGGERS_CELL, VERDICT, NEXT = range(len(_TITLES))
# Every row has room for so many lines, so that no row moves when its texts change.
_LINES: Final = 3
# In a small window the page scrolls instead.
_LEAST_ROWS: Final = 3
# Characters of a column but the last: texts wrap, and a name that is longer is whole in the tooltip.
_WIDEST: Final = 26
_WIDEST_LARGE: Final = 18
# Characters of a width in which all columns have room.
_WIDTH_OF_ALL: Final = 95
_NEEDS: Final[Mapping[Meaning, tuple[Need, ...]]] = {
    Meaning.DANGER: (Need.TRIGGERED, Need.NOT_LOCKED, Need.MAY_HAVE_FIRED, Need.NO_GO),
    Meaning.ATTENTION: (Need.WAS_ACTIVE, Need.LINK, Need.OUTSIDE, Need.ACTIVE, Need.VOID, Need.ACTIVE_READY),
    Meaning.INFORMATION: (Need.NAME, Need.CHECK, Need.ACTIVATE),
    Meaning.UNKNOWN: (Need.WAIT,),
    Meaning.GOOD: (Need.NOTHING,),
}
NEED_MEANINGS: Final = {need: meaning for meaning, needs in _NEEDS.items() for need in needs}
_NO_VERDICT: Final = {
    Standing.NOT_CHECKED: Meaning.UNKNOWN,
    Standing.CHECKING: Meaning.INFORMATION,
    Standing.VOID: Meaning.ATTENTION,
}
_APPLIED: Final[Mapping[Meaning, tuple[Applied, ...]]] = {
    Meaning.DANGER: (Applied.FAILED,),
    Meaning.ATTENTION: (Applied.REFUSED, Applied.UNREACHABLE),
    Meaning.INFORMATION: (Applied.WRITING, Applied.ACKNOWLEDGED),
    Meaning.GOOD: (Applied.NOTHING_TO_DO, Applied.VERIFIED),
}
_APPLIED_MEANINGS: Final = {state: meaning for meaning, states in _APPLIED.items() for state in states}


class _Cell(NamedTuple):
    text: str
    meaning: Meaning | None = None
    picture: Icon | None = None


class _Ticked(QStyledItemDelegate):
    """Qt measures a cell without the size that the style sheet gives its check box."""

    def sizeHint(self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex) -> QSize:
        return super().sizeHint(option, index) + QSize(scaled(IconSize.TEXT), 0)


class Board(QTableWidget):
    """Rows stand in the order in which the ports were connected, and nothing sorts them: no LOCK moves under a hand.
    While a profile is open the last column compares each module with it."""

    # A person wants this `Port` on the other pages.
    chosen = Signal(object)
    # Another one is ticked.
    ticked = Signal()

    def __init__(self, members: FleetMembers, profile: GroupProfile) -> None:
        super().__init__(0, len(_TITLES))
        named(self, "fleet_board", says=tr("Modules"))
        self._members = members
        self._profile = profile
        # By port, in the order of the rows.
        self._items: dict[Port, list[QTableWidgetItem]] = {}
        self._locks: dict[Port, QPushButton] = {}
        # What stands in the cells, and in which theme.
        self._shown: dict[Port, object] = {}
        self._fitted: Profile | None = None
        self._row_px = _LINES * QFontMetrics(font()).lineSpacing() + Space.S
        list_rows(self, row_px=self._row_px)
        self.setItemDelegateForColumn(MODULE, _Ticked(self))
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setWordWrap(True)
        self.setMinimumHeight(_LEAST_ROWS * self._row_px)
        header = self.horizontalHeader()
        widest = _WIDEST_LARGE if is_text_large() else _WIDEST
        header.setMaximumSectionSize(widest * QFontMetrics(font()).averageCharWidth())
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(NEXT, QHeaderView.ResizeMode.Stretch)
        self.itemChanged.connect(self._on_ticked)
        self.cellDoubleClicked.connect(lambda row, _column: self.chosen.emit(list(self._items)[row]))
        profile.changed.connect(self._fit_profile)
        self._name_columns()

    @property
    def marked(self) -> Port | None:
        item = self.currentItem()
        return next((port for port, items in self._items.items() if item in items), None)

    def show_cards(self, cards: Mapping[Port, Card], now: float) -> None:
        self.blockSignals(True)  # a change of ours is no tick of a person
        for port in [port for port in self._items if port not in cards]:
            self.removeRow(self._items.pop(port)[0].row())
            del self._locks[port]
            self._shown.pop(port, None)
        for port, card in cards.items():
            if port not in self._items:
                self._add(port)
            self._show(port, card, now)
        self.blockSignals(False)

    def _add(self, port: Port) -> None:
        row = self.rowCount()
        self.insertRow(row)
        items = self._items[port] = [QTableWidgetItem() for _ in _TITLES]
        is_ticked = port not in self._members.unticked
        items[MODULE].setCheckState(Qt.CheckState.Checked if is_ticked else Qt.CheckState.Unchecked)
        for column, item in enumerate(items):
            self.setItem(row, column, item)
        lock = self._locks[port] = control(
            QPushButton(tr("LOCK")), "fleet_lock", picture=Icon.LOCK, slot=port.lock.press
        )
        # With room around it, so that a finger between two rows presses neither.
        holder = QWidget()
        in_column(lock, of=holder, margins=(0, Space.XS, Space.XS, Space.XS))
        self.setCellWidget(row, LOCK, holder)
        # Qt measures a widget without the padding of its cell.
        lock.ensurePolished()
        items[LOCK].setSizeHint(holder.sizeHint() + QSize(2 * scaled(Space.S), 0))

    def _show(self, port: Port, card: Card, now: float) -> None:
        lock = self._locks[port]
        lock.setAccessibleName(labelled(tr("LOCK"), card.name or card.port))
        set_role(lock, "primary" if card.activation.may_fire else "")
        cells = {
            MODULE: _module(card),
            STATE: _state(card, now),
            TRIGGERS_CELL: _values(card, now),
            VERDICT: _verdict(card, now),
            NEXT: self._next(port, card),
        }
        shown = current().name, cells
        if shown == self._shown.get(port):
            return
        self._shown[port] = shown
        items = self._items[port]
        for column, cell in cells.items():
            items[column].setText(cell.text)
            items[column].setToolTip(cell.text)
            items[column].setForeground(current().ink(cell.meaning))
            items[column].setIcon(QIcon() if cell.picture is None else icon(cell.picture, cell.meaning))
        # Also of columns that are left out.
        items[MODULE].setToolTip("\n".join(cell.text for cell in cells.values()))

    def _next(self, port: Port, card: Card) -> _Cell:
        """What a person does next; with a profile, what writing it changes or has come to."""
        if self._profile.profile is None or port in self._members.unticked:
            need, sentence = card.needed()
            meaning = NEED_MEANINGS[need]
            return _Cell(sentence, meaning, MEANING_ICONS[meaning])
        applied = self._profile.result(port)
        if applied is not None:
            meaning = _APPLIED_MEANINGS[applied.state]
            text, why = tr(applied.state.value), applied.why.translated()
            return _Cell(labelled(text, why) if why else text, meaning, MEANING_ICONS[meaning])
        lines = []
        for row in self._profile.differences(port):
            value = tr("unknown") if row.module_value is None else value_text(row.command, row.module_value.value)
            target = "" if row.target is None else value_text(row.command, row.target)
            lines.append(f"{tr(row.command.title)} {value} → {target}")
        return _Cell("\n".join(lines), Meaning.ATTENTION, Icon.SETTINGS)

    def _fit_profile(self) -> None:
        """All differences are in sight when a profile is opened; the rows keep their heights until it is closed."""
        profile = self._profile.profile
        if profile is self._fitted:
            return
        self._fitted = profile
        self._name_columns()
        self.show_cards({port: self._members.card(port) for port in self._items}, self._members.now())
        for row in range(self.rowCount()):
            self.setRowHeight(row, self._row_px if profile is None else max(self._row_px, self.sizeHintForRow(row)))

    def _name_columns(self) -> None:
        profile = self._profile.profile
        title = tr(_TITLES[NEXT]) if profile is None else labelled(tr("Profile"), profile.name)
        self.setHorizontalHeaderLabels([*map(tr, _TITLES[:NEXT]), title])
        self._hide_columns()

    def _hide_columns(self) -> None:
        """Two of them, where a profile, large text or a narrow window takes their room."""
        is_narrow = self.width() < _WIDTH_OF_ALL * QFontMetrics(font()).averageCharWidth()
        for column in (TRIGGERS_CELL, VERDICT):
            self.setColumnHidden(column, is_narrow or self._profile.profile is not None)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._hide_columns()

    def _on_ticked(self, item: QTableWidgetItem) -> None:
        port = next(port for port, items in self._items.items() if item in items)
        self._members.unticked.discard(port)
        if self._items[port][MODULE].checkState() is Qt.CheckState.Unchecked:
            self._members.unticked.add(port)
        self.ticked.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and self.marked is not None:
            self.chosen.emit(self.marked)
        else:
            super().keyPressEvent(event)


def _ago(at: float | None, now: float) -> str:
    return "" if at is None else tr("{time} ago", time=duration(now - at))


def _module(card: Card) -> _Cell:
    """Its name, also of the conversation that ended, in which it was said; and its port, which tells unnamed ones
    apart."""
    title = card.name or tr("Unnamed")
    if card.name and not card.conversation.is_going:
        title = card.name + in_brackets(tr("offline"))
    lines = [title, card.port.replace("/", "/\u200b")]  # a path may wrap
    if card.is_shown:
        lines.append(tr("Shown"))
    return _Cell("\n".join(lines))


def _state(card: Card, now: float) -> _Cell:
    """Whether it may fire, and whether it has fired; what is stale has its age."""
    seen = card.activation
    words = {
        Activation.UNKNOWN: labelled(tr("Activation"), tr("unknown")),
        Activation.ACTIVE: tr("ACTIVE"),
        Activation.WAS_ACTIVE: tr("was ACTIVE"),
    }
    triggered = card.conversation.known("triggered", now)
    is_triggered = triggered is not None and triggered.value is True
    if is_triggered:
        fired = tr("TRIGGERED")
    elif card.may_have_fired:
        fired = tr("may have fired")
    else:
        fired = labelled(tr("Trigger"), tr("unknown")) if triggered is None else tr("NOT TRIGGERED")
    lines = [words.get(seen.state, tr("LOCKED")), fired]
    if seen.state in (Activation.WAS_ACTIVE, Activation.WAS_LOCKED):
        lines.append(_ago(seen.at, now))
    elif triggered is not None and triggered.is_stale:
        lines.append(_ago(triggered.at, now))
    text = "\n".join(lines)
    if is_triggered or card.may_have_fired:
        return _Cell(text, Meaning.DANGER, Icon.PARACHUTE if is_triggered else Icon.DANGER)
    if seen.may_fire:
        return _Cell(text, Meaning.ATTENTION, Icon.ACTIVE)
    if seen.state is Activation.LOCKED:
        return _Cell(text, None, Icon.LOCK)
    return _Cell(text, Meaning.UNKNOWN, Icon.UNKNOWN if seen.state is Activation.UNKNOWN else Icon.LOCK)


def _values(card: Card, now: float) -> _Cell:
    flags = trigger_flags(card.conversation, now)
    voltage = card.conversation.fresh("cell_voltage_v", now)
    lines = [flags.text, tr("unknown") if voltage is None else f"{float(voltage):.2f} V"]
    if card.cell_outside is not None:
        lines.append(tr(card.cell_outside.fault.value))
    elif card.conversation.fresh("charging", now):
        lines.append(tr("charging"))
    if flags.is_one_off or card.cell_outside is not None:
        return _Cell("\n".join(lines), Meaning.ATTENTION)
    return _Cell("\n".join(lines), None if flags.are_on else Meaning.UNKNOWN)


def _verdict(card: Card, now: float) -> _Cell:
    check = card.check
    text = f"{tr(check.standing.value)}\n{_ago(check.ended_at, now)}".strip()
    if check.verdict is None:
        return _Cell(text, _NO_VERDICT[check.standing])
    picture, meaning = VERDICT_STYLES[check.verdict]
    return _Cell(text, meaning, picture)
