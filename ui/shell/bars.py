"""What stands around a page: the top bar with the states and LOCK, the sidebar, the area that scrolls, the foot."""

from collections.abc import Iterable
from typing import Final

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QFrame,
    QLayout,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QStackedWidget,
    QStyleOptionViewItem,
    QToolButton,
    QWidget,
)

from app.diagnosis.link_state import LinkState, Phase
from app.engine.conversation import ConversationView
from app.engine.target import is_simulated
from app.limits.limits import LimitsInUse, last_cell_outside
from app.safety.last_known import Activation, trigger_flags
from app.text.i18n import tr
from app.text.messages import duration, in_brackets, join_names, labelled
from protocol.translatable import marked
from ui.services.context import PageEntry
from ui.session.ports import Ports
from ui.session.recording import RecordingState
from ui.style.icons import Icon, battery, icon, set_icon_size
from ui.style.theme import IconSize, Meaning, Size, Space, font, is_text_large, scale_in_use, scaled
from ui.widgets.controls import ElidedLabel, IconLabel, control, in_column, in_row, named, set_role, without_key
from ui.widgets.readout import StateChip, age_of
from ui.widgets.visibility_timer import VisibilityTimer

# Icon of the link, and the meaning that colours it.
_PHASES: Final = {
    Phase.CLOSED: (Icon.UNPLUGGED, Meaning.UNKNOWN),
    Phase.OPENING: (Icon.CONNECTING, Meaning.INFORMATION),
    Phase.FINDING: (Icon.CONNECTING, Meaning.INFORMATION),
    Phase.ASKING: (Icon.CONNECTING, Meaning.INFORMATION),
    Phase.SILENT: (Icon.LINK_LOST, Meaning.ATTENTION),
    Phase.ONLINE: (Icon.LINK, Meaning.GOOD),
    Phase.LATE: (Icon.LINK_LOST, Meaning.ATTENTION),
    Phase.OFFLINE: (Icon.LINK_LOST, Meaning.ATTENTION),
    Phase.LOST: (Icon.UNPLUGGED, Meaning.ATTENTION),
    Phase.SWITCHED_OFF: (Icon.UNPLUGGED, Meaning.INFORMATION),
    Phase.FAILED: (Icon.LINK_LOST, Meaning.ATTENTION),
}
# Word, icon and meaning; what was ACTIVE keeps its colour, since nobody has seen the module locked.
_ACTIVATIONS: Final = {
    Activation.ACTIVE: (marked("ACTIVE"), Icon.ACTIVE, Meaning.ATTENTION),
    Activation.WAS_ACTIVE: (marked("was ACTIVE"), Icon.ACTIVE, Meaning.ATTENTION),
    Activation.LOCKED: (marked("LOCKED"), Icon.LOCK, None),
    Activation.WAS_LOCKED: (marked("LOCKED"), Icon.LOCK, None),
}


def port_name(device: str) -> str:
    return device.removeprefix("/dev/")


class PortButton(QPushButton):
    """Shows the module's name, or the port of one without a name, above the state of the link, and opens the list of
    ports."""

    def __init__(self) -> None:
        super().__init__()
        self._shown: object = None
        control(self, "port_button", tip=tr("Choose a port"), key="Ctrl+K", role="quiet")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self._sign = IconLabel("port_sign", 20, keeps_place=True)
        self.title, self.word = named(ElidedLabel(), "port_title", "strong"), named(ElidedLabel(), "port_state")
        self.title.setMinimumWidth(scaled(40))
        lines = in_column(self.title, self.word, spacing=0, margins=0)
        arrow = IconLabel("port_arrow", 12, keeps_place=True)
        arrow.show_icon(Icon.CHEVRON_DOWN, is_muted=True)
        row = in_row(self._sign, lines, arrow, 1, of=self, spacing=Space.S, margins=(Space.S, Space.XS))
        row.setSizeConstraint(QLayout.SizeConstraint.SetMinimumSize)

    def show_link(self, name: str, title: str, link: LinkState, word: str) -> None:
        if (name, title, link, word) == self._shown:
            return
        self._shown = name, title, link, word
        picture, meaning = _PHASES[link.phase]
        self._sign.show_icon(picture, meaning)
        port = title.partition(" · ")[0] if is_text_large() else title
        self.title.setText(name or port)
        # Always two lines, or the bar would be lower without a module.
        state = word if word != title else link.next_step
        self.word.setText(f"{state} · {port}" if name else state)
        set_role(self.word, "attention" if meaning is Meaning.ATTENTION else "small")
        # Without the duration, which would be announced every second.
        told = tr("Port {port}: {state}", port=title, state=link.word)
        self.setAccessibleName(join_names([labelled(tr("Module"), name), told] if name else [told]))
        self.setAccessibleDescription(f"{link.what} {link.next_step}".strip())


class TopBar(QFrame):
    """Port and link, module, states and LOCK, on every page. Text that is larger than usual has the states on a second
    line; what has no room then is elided, with a tooltip: the name and the port, never a state or LOCK."""

    panel_wanted = Signal()

    def __init__(self, ports: Ports, in_use: LimitsInUse) -> None:
        super().__init__()
        named(self, "top_bar", "bar")
        self._ports, self._in_use = ports, in_use
        self.menu = control(QToolButton(), "menu_button", says=tr("Menu"), key="F10", picture=Icon.MENU, role="quiet")
        set_icon_size(self.menu, 20)
        self.menu.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.port = PortButton()
        self.port.clicked.connect(self.panel_wanted)
        self.activation = named(StateChip(tr("Activation")), "activation_chip")
        self.trigger = named(StateChip(tr("Trigger")), "trigger_chip")
        self.triggers = named(StateChip(tr("triggers")), "triggers_chip")
        self.cell = named(StateChip(tr("Cell"), is_measured=True), "cell_chip")
        # Room for the widest words, so that nothing moves when a state changes.
        ages = [tr("{time} ago", time=duration(seconds)) for seconds in (59 * 60, 99, 1.9)]
        ages.append(tr("unknown"))
        self.activation.reserve((tr("LOCKED"), tr("ACTIVE"), tr("was ACTIVE"), tr("Activation")), below=ages)
        self.trigger.reserve((tr("NOT TRIGGERED"), tr("TRIGGERED")), below=ages)
        words = (tr("both on"), tr("both off"), tr("tilt off"), tr("fall off"), tr("not known"))
        self.triggers.reserve(words, below=(tr("triggers"),))
        # In large text there is no room for both words, and the rare move is the lesser evil.
        both = tr("charging") if is_text_large() else join_names((tr("charging"), tr("low")))
        self.cell.reserve(("4.00 V",), below=(*ages, both))
        self.record = named(QToolButton(), "record_button", "quiet")
        self.recording = named(QAction(self), "act_record")
        self.recording.setCheckable(True)
        self.recording.triggered.connect(self._record)
        self.record.setDefaultAction(self.recording)
        self.record.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        set_icon_size(self.record, IconSize.TEXT)
        lock = ports.lock
        self.lock = control(QPushButton(tr("LOCK")), "lock_button", key="Ctrl+L", picture=Icon.LOCK, slot=lock.press)
        self.lock.setMinimumSize(scaled(108), scaled(40))  # for gloves, and bold while the module is active
        # Of modules that are not shown and not known to be LOCKED; where it comes and goes, no state and no LOCK moves.
        self.lock_others = control(QPushButton(), "lock_others_button", role="danger", slot=lock.press_others)
        lock.buttons.update({self.lock: lock.press, self.lock_others: lock.press_others})
        chips = (self.activation, self.trigger, self.triggers, self.cell)
        for part in (*chips, self.lock, self.lock_others):
            part.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Expanding)
        states = in_row(*chips, spacing=Space.XS)
        head = (self.menu, (self.port, 1), self.record, self.lock_others)
        margins = (Space.XS, Space.XS, Space.M, Space.XS)
        if scale_in_use() > 1:
            first = in_row(*head, self.lock, spacing=Space.S)
            in_column(first, in_row(1, states), of=self, spacing=Space.XS, margins=margins)
        else:
            in_row(*head, states, self.lock, of=self, spacing=Space.S, margins=margins)
        self._show_others()
        self.refresh()
        ports.any_changed.connect(self._show_others)
        ports.changed.connect(self.refresh)
        VisibilityTimer(self, self.refresh)

    def _show_others(self) -> None:
        """Name another module that needs attention; of several the tooltip names all."""
        names = [port.module.name or port_name(port.connection.port) for port in self._ports.lock.others]
        self.lock_others.setVisible(bool(names))
        # In one line there is no room for its word, too.
        has_room = not names or scale_in_use() > 1
        styles = Qt.ToolButtonStyle
        self.record.setToolButtonStyle(styles.ToolButtonTextBesideIcon if has_room else styles.ToolButtonIconOnly)
        text = tr("LOCK ALL")
        if len(names) == 1:  # names and addresses differ at their ends
            name = self.fontMetrics().elidedText(names[0], Qt.TextElideMode.ElideLeft, scaled(60))
            text = tr("LOCK {module}", module=without_key(name))
        self.lock_others.setText(text)
        self.lock_others.setToolTip(tr("NOT reported, treat as ACTIVE: {names}", names=join_names(names)))

    def refresh(self) -> None:
        port, now = self._ports.current, self._ports.clock()
        module, state = port.module, port.state
        device = port.connection.port if port.target is None else port.target.device
        title = tr("Not connected")
        if state.phase is not Phase.CLOSED and device:
            name = port_name(device)
            rate = port.connection.baud_rate
            title = f"{name} · {rate}" if rate else name
            if is_simulated(device):
                title = tr("Simulated module")
        self.port.show_link(module.name if port.is_requested else "", title, state, state.word_at(now))
        seen = module.activation
        if seen.state is Activation.UNKNOWN:
            self.activation.show_unknown()
        else:
            word, picture, meaning = _ACTIVATIONS[seen.state]
            is_past = seen.state in (Activation.WAS_ACTIVE, Activation.WAS_LOCKED)
            age = tr("{time} ago", time=duration(now - seen.at)) if is_past and seen.at is not None else ""
            self.activation.show_state(tr(word), picture, meaning, stale_age=age)
        triggered = module.view.known("triggered", now)
        age = "" if triggered is None else age_of(triggered, now)
        if triggered is not None and triggered.value is True:
            self.trigger.show_state(tr("TRIGGERED"), Icon.PARACHUTE, Meaning.DANGER, stale_age=age)
        elif module.may_have_fired:
            self.trigger.show_state(tr("may have fired"), Icon.DANGER, Meaning.DANGER, detail=tr("before the restart"))
        elif triggered is None:
            self.trigger.show_unknown()
        else:
            self.trigger.show_state(tr("NOT TRIGGERED"), Icon.NOT_TRIGGERED, stale_age=age)
        flags = trigger_flags(module.view, now)
        picture, meaning = (Icon.CHECK, None) if flags.are_on else (Icon.UNKNOWN, Meaning.UNKNOWN)
        if flags.is_one_off:
            picture, meaning = Icon.WARNING, Meaning.ATTENTION
        self.triggers.show_state(flags.text, picture, meaning, below=tr("triggers"))
        self._show_cell(module.view, now)
        self._show_recording(port.recording.state)
        self.lock.setEnabled(port.is_requested)  # without a port it is owed
        set_role(self.lock, "primary" if port.is_active else "")

    def _record(self, is_on: bool) -> None:
        self._ports.current.set_recorded(is_on)

    def _show_recording(self, state: RecordingState) -> None:
        """Show the state of recording on the port that is shown."""
        words, picture, meaning = tr("Not recorded"), Icon.RECORD_OFF, None
        if state.trouble is not None:
            words, picture, meaning = state.trouble.translated(), Icon.WARNING, Meaning.ATTENTION
        elif state.since is not None:
            since, picture = f"{state.since.astimezone():%H:%M}", Icon.RECORD
            words = tr("Recorded since {time}", time=since)
        self.recording.setChecked(state.is_on)
        self.recording.setText(tr("Record"))
        self.recording.setIconText(tr("REC") if state.is_on else tr("REC off"))
        self.recording.setToolTip(words)
        self.recording.setIcon(icon(picture, meaning))
        self.record.setAccessibleName(labelled(tr("Record"), words))

    def _show_cell(self, view: ConversationView, now: float) -> None:
        voltage, charging = view.known("cell_voltage_v", now), view.known("charging", now)
        if voltage is None:
            self.cell.show_unknown()
            return
        volts, said = float(voltage.value), []
        if charging is None:
            said.append(tr("charger unknown"))
            picture = battery(None)
        elif charging.value is True:
            # The voltage is then the charger's, so a level would be a guess.
            said.append(tr("charging"))
            picture = Icon.BOLT
        else:
            picture = battery((volts - 3.3) / (4.2 - 3.3))  # the usual range of a lithium cell, for the icon only
        meaning, detail = None, ""
        outside = last_cell_outside(view, now, self._in_use.profile)
        if outside is not None:
            said.append(tr(outside.fault.value))
            picture, meaning, detail = Icon.WARNING, Meaning.ATTENTION, tr("limit {value}", value=outside.limit)
        age, below, word = age_of(voltage, now), join_names(said), f"{volts:.2f} V"
        self.cell.show_state(word, picture, meaning, below=below, stale_age=age, detail=detail)


# Larger names would take the pages' room; above this scale they stand without their icons, so that all are in sight.
_LARGEST_SCALE: Final = 1.25
_IN_SIGHT: Final = QSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)
# A stack asks for the room of all its pages; one whose size is ignored counts for nothing.
_OUT_OF_SIGHT: Final = QSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)


class _Pages(QStackedWidget):
    """The pages, at least as high as the page in sight needs: Qt would take the highest of all pages, and their usual
    heights."""

    def heightForWidth(self, width: int) -> int:
        page = self.currentWidget()
        layout = None if page is None else page.layout()
        return -1 if layout is None or not layout.hasHeightForWidth() else layout.minimumHeightForWidth(width)


class PageArea(QScrollArea):
    """Scrolls the page in sight where it does not fit. `stack` holds all pages."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("page_area")
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.stack = named(_Pages(), "pages")
        self.setWidget(self.stack)
        self.stack.currentChanged.connect(self._on_page)
        self.stack.setAutoFillBackground(False)

    def add(self, page: QWidget) -> None:
        page.setSizePolicy(_OUT_OF_SIGHT)
        self.stack.addWidget(page)

    def _on_page(self) -> None:
        for page in filter(None, map(self.stack.widget, range(self.stack.count()))):
            page.setSizePolicy(_IN_SIGHT if page is self.stack.currentWidget() else _OUT_OF_SIGHT)
        self.verticalScrollBar().setValue(0)


class Sidebar(QListWidget):
    """The sidebar has one row for each page: its icon above its name."""

    page_wanted = Signal(str)

    def __init__(self, entries: Iterable[PageEntry]) -> None:
        super().__init__()
        named(self, "navigation", "navigation")
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setMouseTracking(True)
        self.setAccessibleName(tr("Pages"))
        scale = min(scale_in_use(), _LARGEST_SCALE)
        # In large text the room that the names take comes from the icons: all rows are in sight at 1024x600.
        icon_px = round(scale * IconSize.NOTICE) if scale_in_use() <= _LARGEST_SCALE else IconSize.TEXT
        self.setIconSize(QSize(1, 1) * icon_px)
        letters = font()
        letters.setPixelSize(round(scale * Size.SMALL))
        self.setFont(letters)
        for number, entry in enumerate(entries, start=1):
            title = tr(entry.title)
            item = QListWidgetItem(icon(entry.icon), title)
            item.setData(Qt.ItemDataRole.UserRole, entry.key)
            item.setToolTip(title + in_brackets(f"Ctrl+{number % 10}"))
            self.addItem(item)
        self.setFixedWidth(self.sizeHintForColumn(0) + Space.L)
        self.currentItemChanged.connect(self._on_item)
        self.itemClicked.connect(self._on_item)  # from the list of ports back to the same page

    def choose(self, key: str) -> None:
        for row in range(self.count()):
            if self.item(row).data(Qt.ItemDataRole.UserRole) == key:
                self.setCurrentRow(row)

    @property
    def chosen(self) -> str:
        """The key of the page."""
        return str(self.currentIndex().data(Qt.ItemDataRole.UserRole) or "")

    def _on_item(self, item: QListWidgetItem | None) -> None:
        if item is not None:
            self.page_wanted.emit(item.data(Qt.ItemDataRole.UserRole))

    def initViewItemOption(self, option: QStyleOptionViewItem) -> None:
        super().initViewItemOption(option)
        option.decorationPosition = QStyleOptionViewItem.Position.Top
        option.displayAlignment = Qt.AlignmentFlag.AlignCenter
