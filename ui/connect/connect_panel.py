"""Panel for choosing a port and connecting. It replaces the page, so that the module's state stays visible above it."""

from functools import partial
from typing import NamedTuple

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import (
    QComboBox,
    QFormLayout,
    QFrame,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from app.diagnosis.link_state import Phase, link_text
from app.engine.ports import NOT_LISTED, PortInfo
from app.engine.target import Target, is_simulated
from app.text.i18n import tr
from app.text.sentences import join_sentences, labelled
from protocol.catalogue import BAUD_RATES, DEFAULT_BAUD_RATE
from protocol.translatable import marked
from ui.core.port_watcher import key_of
from ui.core.preferences import LastPort
from ui.session.ports import Ports
from ui.style.icons import Icon, icon, set_icon_size
from ui.style.theme import Space, scaled
from ui.widgets.controls import control, named
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row
from ui.widgets.sliders import WheelGuard, label_for
from ui.widgets.step_button import FocusBack
from ui.widgets.visibility_timer import VisibilityTimer

ROW_PX = 48
MAX_ROWS = 6
"""With more rows the list scrolls."""
_ICON_PX = 20
_CHOICE = Qt.ItemDataRole.UserRole


class PortChoice(NamedTuple):
    """One row. `badge` is one word, or ""."""

    device: str
    identity: str
    title: str
    product: str
    detail: str
    icon: Icon
    badge: str = ""

    @property
    def key(self) -> str:
        return self.identity or self.device


def choice_of(port: PortInfo, *, is_new: bool, is_connected: bool, is_last: bool) -> PortChoice:
    name = _short(port.device)
    serial = tr("serial number {number}", number=port.serial_number) if port.serial_number else ""
    # Drivers often repeat the manufacturer in the product name.
    maker = "" if port.maker and port.maker.casefold() in port.description.casefold() else port.maker
    product = "" if port.description == name else port.description
    detail = _listed(maker, serial) or (tr("no serial number") if product else tr("built in"))
    badge = tr("connected") if is_connected else tr("new") if is_new else tr("used last") if is_last else ""
    return PortChoice(port.device, port.identity, name, product, detail, Icon.PLUG, badge)


class PortList(QListWidget):
    """Keeps its selection while the list changes."""

    chosen_changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("port_list")
        set_icon_size(self, _ICON_PX)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setMouseTracking(True)
        self.itemSelectionChanged.connect(self.chosen_changed)

    def show_choices(self, choices: list[PortChoice]) -> None:
        """Replaces the rows; the selected port stays selected while it is listed."""
        if choices == [self.choice_at(row) for row in range(self.count())]:
            return
        chosen = self.chosen
        with QSignalBlocker(self):
            self.clear()
            for choice in choices:
                head = _listed(choice.title, choice.badge, choice.product)
                item = QListWidgetItem(icon(choice.icon), f"{head}\n{choice.detail}")
                item.setData(_CHOICE, choice)
                item.setData(Qt.ItemDataRole.AccessibleTextRole, _spoken(choice))
                item.setToolTip(_spoken(choice))
                self.addItem(item)
        if chosen is not None:
            self.choose(chosen.key)
        self.fit()
        self.chosen_changed.emit()

    def choice_at(self, row: int) -> PortChoice:
        choice: PortChoice = self.item(row).data(_CHOICE)
        return choice

    @property
    def chosen(self) -> PortChoice | None:
        rows = self.selectedIndexes()
        return self.choice_at(rows[0].row()) if rows else None

    def choose(self, key: str) -> bool:
        """Selects the row with this key; returns whether there is one."""
        for row in range(self.count()):
            if self.choice_at(row).key == key:
                self.setCurrentRow(row)
                return True
        return False

    def fit(self) -> None:
        """The height of a row, in the size of text in use."""
        for row in range(self.count()):
            self.item(row).setSizeHint(QSize(0, scaled(ROW_PX)))
        self.updateGeometry()

    def sizeHint(self) -> QSize:
        rows = min(MAX_ROWS, max(2, self.count()))
        return QSize(360, rows * scaled(ROW_PX) + 2 * Space.XS)

    def minimumSizeHint(self) -> QSize:
        return QSize(240, scaled(ROW_PX) + 2 * Space.XS)


def _spoken(choice: PortChoice) -> str:
    return ", ".join(filter(None, (choice.title, choice.product, choice.detail, choice.badge)))


def _short(device: str) -> str:
    return device.removeprefix("/dev/")


def _listed(*parts: str) -> str:
    return " · ".join(filter(None, parts))


SIMULATED_PORT = "sim://demo?lifelike"
CARD_PX = 520
FIND_RATE = 0
"""Data of the entry "Find the baud rate"."""


class ConnectPanel(QScrollArea):
    """A card in the middle, which refreshes itself while it is open and never blocks on a port."""

    connect_wanted = Signal(object)
    """A `Target`."""
    disconnect_wanted = Signal()
    shown = Signal()
    """Opened or closed."""

    def __init__(self, ports: Ports) -> None:
        super().__init__()
        self.setObjectName("connect_panel")
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._ports = ports
        self._watcher = watcher = ports.watcher
        self._last: LastPort | None = None
        self._connected: tuple[str, int] | None = None
        """Key and rate of the open port that the list and the rate were set to."""
        self._focus = FocusBack(self)
        self.list = PortList()
        self.other = control(QLineEdit(), "port_address", says=tr("Other port"))
        self.rate = control(QComboBox(), "rate_box", says=tr("Baud rate"))
        self.connect_button = control(
            QPushButton(tr("Connect")), "connect_button", role="primary", slot=self.connect_chosen
        )
        self.disconnect_button = control(
            QPushButton(tr("Disconnect")), "disconnect_button", key="Ctrl+D", slot=self.disconnect_wanted
        )
        self.empty, self.state_label = text_label("no_ports_hint", "muted"), text_label("connect_state", "muted")
        self.options = control(
            QToolButton(),
            "connect_options",
            text=tr("Other port or baud rate"),
            picture=Icon.CHEVRON_DOWN,
            role="quiet",
            is_checkable=True,
        )
        self.logs = control(
            QToolButton(),
            "connect_logs",
            text=tr("Drop flight logs here: would it have fired?"),
            picture=Icon.MAP,
            role="quiet",
        )
        self._close = control(
            QToolButton(),
            "connect_close",
            says=tr("Close"),
            key="Esc",
            picture=Icon.CROSS,
            role="quiet",
            slot=self.hide,
        )
        WheelGuard(self.rate)
        self.setAccessibleName(tr("Choose a port"))
        self.list.setAccessibleName(tr("Ports"))
        self.other.setPlaceholderText(tr("device or socket://host:port"))
        self._build()
        self.list.chosen_changed.connect(self._choose)
        self.list.itemActivated.connect(lambda _item: self.connect_chosen())
        self.other.textEdited.connect(self._type)
        self.other.returnPressed.connect(self.connect_chosen)
        watcher.listed.connect(self.refresh)
        ports.changed.connect(self.refresh)
        self.hide()
        VisibilityTimer(self, self._on_shown, restyle=self._restyle, hidden=self._on_hidden)

    def prefer(self, last: LastPort | None) -> None:
        """Preselects this port as soon as it is listed."""
        self._last = last
        if last is not None:
            self.rate.setCurrentIndex(max(0, self.rate.findData(last.baud_rate)))
            if not last.identity and not is_simulated(last.device):
                self.other.setText(last.device)
            self.options.setChecked(bool(self.other.text()) or self.rate.currentIndex() > 0)
        self.refresh()

    def refresh(self) -> None:
        if self.isHidden():
            return
        target = self._ports.current.target if self._ports.current.is_requested else None
        choices = [
            choice_of(
                port,
                is_new=self._watcher.is_new(port),
                is_connected=target is not None and self._ports.current.is_open and target.device == port.device,
                is_last=self._last is not None and bool(port.identity) and port.identity == self._last.identity,
            )
            for port in self._watcher.ports
        ]
        is_simulating = target is not None and target.is_simulated and self._ports.current.is_open
        badge = tr("connected") if is_simulating else ""
        choices.append(PortChoice(SIMULATED_PORT, "", tr("Simulated module"), "", "", Icon.SIMULATOR, badge))
        self.list.show_choices(choices)
        self._choose_connected()
        if self.list.chosen is None and not self.other.text():
            self._preselect()
        self.empty.setVisible(not self._watcher.ports)
        if self._watcher.has_listed and not self._watcher.is_current:
            self.empty.setText(tr(NOT_LISTED))
        elif self._watcher.has_listed:
            self.empty.setText(tr("No serial port. Plug the adapter in; try another cable or its driver."))
        else:
            self.empty.setText(tr("Looking for ports…"))
        self._show_state()

    def chosen_target(self) -> Target | None:
        """The target that Connect would open, None while nothing is chosen."""
        rate = int(self.rate.currentData())
        first_rate, finds = (rate or DEFAULT_BAUD_RATE), rate == FIND_RATE
        typed = self.other.text().strip()
        if typed:
            return Target(typed, first_rate, finds_rate=finds)
        choice = self.list.chosen
        if choice is None:
            return None
        return Target(choice.device, first_rate, choice.identity, finds_rate=finds)

    def connect_chosen(self) -> None:
        target = self.chosen_target()
        if target is not None:
            self.connect_wanted.emit(target)

    # Construction

    def _build(self) -> None:
        title = named(QLabel(tr("Choose a port")), "connect_title", "title")
        self._form = named(QWidget(), "connect_form")
        self._form.setLayout(self._build_form())
        self._form.hide()
        self.options.toggled.connect(self._form.setVisible)
        head = in_row((title, 1), self._close)
        buttons = in_row(1, self.disconnect_button, self.connect_button, spacing=Space.S)
        options = in_row(self.options, 1)
        logs = in_row(self.logs, 1)
        parts = head, self.list, self.empty, options, self._form, self.state_label, buttons, logs
        card = named(QFrame(), "connect_card", "card")
        self._card = card
        in_column(*parts, of=card, spacing=Space.M, margins=(Space.XL, Space.L, Space.XL, Space.XL))
        card.setMaximumWidth(scaled(CARD_PX))
        for label in (self.empty, self.state_label):
            label.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
        self.connect_button.setMinimumWidth(120)
        ground = named(QWidget(), "connect_ground")
        middle = in_row(1, (card, 100), 1)
        in_column(1, middle, 2, of=ground, margins=Space.M)
        self.setWidget(ground)
        for transparent in (self.viewport(), ground):
            transparent.setAutoFillBackground(False)

    def _build_form(self) -> QFormLayout:
        form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.setHorizontalSpacing(Space.M)
        form.setVerticalSpacing(Space.S)
        for field, english in ((self.other, marked("Other port")), (self.rate, marked("Baud rate"))):
            form.addRow(label_for(field, tr(english)), field)
        for number, rate in enumerate(dict.fromkeys((DEFAULT_BAUD_RATE, *BAUD_RATES))):
            self.rate.addItem(str(rate), rate)
            if rate == DEFAULT_BAUD_RATE:
                self.rate.setItemText(number, tr("115200 (usual)"))
        self.rate.addItem("", FIND_RATE)
        self.rate.setItemText(self.rate.count() - 1, tr("Find the baud rate"))
        return form

    # Choosing

    def _choose_connected(self) -> None:
        """Once for each connection: the panel names the port and the rate that are in use."""
        port = self._ports.current
        target = port.target if port.is_open else None
        connected = None if target is None else (target.key, port.connection.baud_rate)
        if connected == self._connected:
            return
        self._connected = connected
        if target is None or connected is None:
            return
        if not self.list.choose(target.key) and not self.list.choose(target.device):
            self.other.setText(target.device)
            self.list.clearSelection()
        self.rate.setCurrentIndex(max(0, self.rate.findData(connected[1])))
        self.options.setChecked(bool(self.other.text()) or self.rate.currentIndex() > 0)

    def _preselect(self) -> None:
        last = self._last
        if last is not None and self.list.choose(last.identity or last.device):
            return
        listed = self._watcher.ports
        likely = [port for port in listed if self._watcher.is_new(port)] or [port for port in listed if port.identity]
        if len(likely) == 1:
            self.list.choose(key_of(likely[0]))

    def _choose(self) -> None:
        if self.list.chosen is not None:
            self.other.clear()
        self._show_state()

    def _type(self) -> None:
        if self.other.text():
            self.list.clearSelection()
        self._show_state()

    def _show_state(self) -> None:
        state = self._ports.current.state
        words = link_text(state, self._ports.clock())
        is_closed = state.phase is Phase.CLOSED
        has_chosen = self.chosen_target() is not None
        next_step = tr("Connecting reads the module; Live also switches its serial output on.") if has_chosen else ""
        target = self._ports.current.target
        name = "" if target is None else tr("Simulated module") if target.is_simulated else _short(target.device)
        said = join_sentences((words.what, words.next_step))
        self.state_label.setText(next_step if is_closed else labelled(name, said) if name else said)
        self.state_label.setVisible(bool(self.state_label.text()))
        self.disconnect_button.setVisible(self._ports.current.is_requested)
        self.logs.setVisible(not self._ports.current.is_requested)
        self.connect_button.setEnabled(has_chosen)

    # Qt

    def setVisible(self, is_visible: bool) -> None:
        show = partial(super().setVisible, is_visible)
        show() if is_visible else self._focus.leave(show)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self.hide()
        else:
            super().keyPressEvent(event)

    def _on_shown(self) -> None:
        self.list.setFocus()  # before the page hides, which has it
        self.shown.emit()
        self._watcher.watch(True)
        self.refresh()

    def _on_hidden(self) -> None:
        self._watcher.watch(False)
        if self.isHidden():  # not only minimised
            self._watcher.settle()
            self._connected = None
        self.shown.emit()

    def _restyle(self) -> None:
        self._card.setMaximumWidth(scaled(CARD_PX))
        self.list.fit()
