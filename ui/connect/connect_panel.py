"""Panel for choosing a port and connecting. It replaces the page, so that the module's state stays visible above it."""

from functools import partial
from typing import Final, NamedTuple

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import (
    QAbstractScrollArea,
    QComboBox,
    QFormLayout,
    QFrame,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QToolButton,
    QWidget,
)

from app.diagnosis.link_state import Phase
from app.engine.ports import NOT_LISTED, PortInfo, is_flight_controller
from app.engine.target import Target, is_simulated
from app.text.i18n import tr
from app.text.messages import join_sentences, labelled
from protocol.catalogue import BAUD_RATES, DEFAULT_BAUD_RATE
from ui.core.preferences import LastPort
from ui.session.ports import Ports
from ui.style.icons import Icon, icon, set_icon_size
from ui.style.theme import IconSize, Space, is_text_large, scaled
from ui.widgets.controls import control, in_column, in_row, named, retain_size, scroll_area, text_label
from ui.widgets.number_line import WheelGuard
from ui.widgets.step_button import FocusBack
from ui.widgets.visibility_timer import VisibilityTimer

SIMULATED_PORT: Final = "sim://demo?lifelike"
# Data of the entry "Find the baud rate".
FIND_RATE: Final = 0


class PortRow(NamedTuple):
    """A row of the list, and what it opens."""

    device: str
    identity: str
    title: str
    product: str = ""
    detail: str = ""
    is_connected: bool = False

    @property
    def key(self) -> str:
        return self.identity or self.device

    def item(self) -> QListWidgetItem:
        badge = tr("connected") if self.is_connected else ""
        spoken = ", ".join(filter(None, (self.title, self.product, self.detail, badge)))
        lines = (_listed(self.title, badge, self.product), self.detail)
        item = QListWidgetItem("\n".join(filter(None, lines)))
        item.setIcon(icon(Icon.SIMULATOR if self.device == SIMULATED_PORT else Icon.PLUG))
        item.setData(Qt.ItemDataRole.AccessibleTextRole, spoken)
        item.setToolTip(spoken)
        return item


def _listed(*parts: str) -> str:
    return " · ".join(filter(None, parts))


def _row_of(port: PortInfo, connected: str) -> PortRow:
    title = port.device.removeprefix("/dev/")
    # Drivers often repeat the manufacturer in the product name.
    maker = "" if port.maker and port.maker.casefold() in port.description.casefold() else port.maker
    product = "" if port.description == title else port.description
    serial = tr("serial number {number}", number=port.serial_number) if port.serial_number else ""
    kind = tr("flight controller") if is_flight_controller(port.identity) else ""
    detail = _listed(kind, maker, serial) or (tr("no serial number") if product else tr("built in"))
    return PortRow(port.device, port.identity, title, product, detail, is_connected=port.device == connected)


class ConnectPanel(QWidget):
    """A card in the middle, which refreshes itself while it is open and never blocks on a port. In large text its
    buttons stand below what scrolls, so that they stay in sight."""

    connect_wanted = Signal(object)  # A `Target`
    disconnect_wanted = Signal()
    shown = Signal()  # Opened or closed

    def __init__(self, ports: Ports) -> None:
        super().__init__()
        self.setObjectName("connect_panel")
        self.setAccessibleName(tr("Choose a port"))
        self._ports, self._watcher = ports, ports.watcher
        self._last: LastPort | None = None
        # Key and rate of the open port that the list and the rate were set to.
        self._in_use: tuple[str, int] | None = None
        self._focus = FocusBack(self)
        self.rows: list[PortRow] = []
        self.list = named(QListWidget(), "port_list", says=tr("Ports"))
        set_icon_size(self.list, IconSize.NOTICE)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setSizeAdjustPolicy(QAbstractScrollArea.SizeAdjustPolicy.AdjustToContents)
        self.list.setMouseTracking(True)
        self.other = named(QLineEdit(), "port_address", says=tr("Other port"))
        self.other.setPlaceholderText(tr("device or socket://host:port"))
        self.rate = named(QComboBox(), "rate_box", says=tr("Baud rate"))
        self.rate.addItem(tr("115200 (usual)"), DEFAULT_BAUD_RATE)
        for rate in BAUD_RATES:
            if rate != DEFAULT_BAUD_RATE:
                self.rate.addItem(str(rate), rate)
        self.rate.addItem(tr("Find the baud rate"), FIND_RATE)
        WheelGuard(self.rate)
        self.connect_button = control(
            QPushButton(tr("Connect")), "connect_button", role="primary", slot=self.connect_chosen
        )
        self.disconnect_button = control(
            QPushButton(tr("Disconnect")), "disconnect_button", key="Ctrl+D", slot=self.disconnect_wanted
        )
        retain_size(self.disconnect_button)
        self.empty, self.state_label = text_label("no_ports_hint", "muted"), text_label("connect_state", "muted")
        more = tr("Other port or baud rate")
        self.options = control(QToolButton(), "connect_options", text=more, picture=Icon.CHEVRON_DOWN, role="quiet")
        self.options.setCheckable(True)
        close = control(QToolButton(), "connect_close", says=tr("Close"), key="Esc", picture=Icon.CROSS, role="quiet")
        close.clicked.connect(self.hide)
        options = named(QWidget(), "connect_form")
        form = QFormLayout(options)
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(tr("Other port"), self.other)
        form.addRow(tr("Baud rate"), self.rate)
        options.hide()
        self.options.toggled.connect(options.setVisible)
        card = named(QFrame(), "connect_card", "card")
        card.setMaximumWidth(scaled(520))
        buttons = in_row(1, self.disconnect_button, self.connect_button)
        in_column(
            in_row((named(QLabel(tr("Choose a port")), "connect_title", "title"), 1), close),
            self.list,
            self.empty,
            (self.options, Qt.AlignmentFlag.AlignLeft),
            options,
            self.state_label,
            *(() if is_text_large() else (buttons,)),
            of=card,
            spacing=Space.M,
            margins=(Space.XL, Space.L, Space.XL, Space.XL),
        )
        # From a fixed place downwards: nothing above moves when a row or a line is added.
        ground = named(QWidget(), "connect_ground")
        in_column(in_row(1, (card, 100), 1), 1, of=ground, margins=(Space.M, Space.XL, Space.M, Space.M))
        scroll = scroll_area(ground, "connect_scroll", tr("Choose a port"), is_vertical=True)
        ground.setAutoFillBackground(False)
        if is_text_large():
            buttons.setContentsMargins(Space.M, Space.XS, Space.M, Space.XS)
            in_column((scroll, 1), buttons, of=self, spacing=0, margins=0)
        else:
            in_column(scroll, of=self, margins=0)
        self.list.itemSelectionChanged.connect(self._choose)
        self.list.itemActivated.connect(lambda _item: self.connect_chosen())
        self.other.textEdited.connect(self._type)
        self.other.returnPressed.connect(self.connect_chosen)
        self._watcher.listed.connect(self.refresh)
        ports.changed.connect(self.refresh)
        self.hide()
        VisibilityTimer(self, self._on_shown, hidden=self._on_hidden)

    def prefer(self, last: LastPort | None) -> None:
        """Preselects this port as soon as it is listed."""
        self._last = last
        if last is not None:
            if not last.identity and not is_simulated(last.device):
                self.other.setText(last.device)
            self._show_rate(last.baud_rate)
        self.refresh()

    def _show_rate(self, rate: int) -> None:
        """Chooses it, and opens the form where that or the address is unusual."""
        self.rate.setCurrentIndex(max(0, self.rate.findData(rate)))
        self.options.setChecked(bool(self.other.text()) or self.rate.currentIndex() > 0)

    def refresh(self) -> None:
        if self.isHidden():
            return
        port, watcher = self._ports.current, self._watcher
        target = port.target if port.is_open else None
        connected = "" if target is None else target.device
        is_demo = target is not None and target.is_simulated
        rows = [_row_of(one, connected) for one in watcher.ports]
        self._show_rows([*rows, PortRow(SIMULATED_PORT, "", tr("Simulated module"), is_connected=is_demo)])
        # Once for each connection: the panel names the port and the rate that are in use.
        in_use = None if target is None else (target.key, port.connection.baud_rate)
        if in_use != self._in_use:
            self._in_use = in_use
            if target is not None:
                if not self.choose(target.key) and not self.choose(target.device):
                    self.other.setText(target.device)
                    self.list.clearSelection()
                self._show_rate(port.connection.baud_rate)
        if self.chosen is None and not self.other.text():
            last, adapters = self._last, [one.identity for one in watcher.ports if one.identity]
            is_listed = last is not None and self.choose(last.identity or last.device)
            if not is_listed and len(adapters) == 1:
                self.choose(adapters[0])
        self.empty.setVisible(not watcher.ports)
        none = tr("No serial port. Plug the adapter in; try another cable or its driver.")
        found = none if watcher.is_current else tr(NOT_LISTED)
        self.empty.setText(found if watcher.has_listed else tr("Looking for ports…"))
        self._show_state()

    def _show_rows(self, rows: list[PortRow]) -> None:
        """The selected port stays selected while it is listed."""
        if rows == self.rows:
            return
        chosen, self.rows = self.chosen, rows
        with QSignalBlocker(self.list):
            self.list.clear()
            for row in rows:
                self.list.addItem(row.item())
        if chosen is not None:
            self.choose(chosen.key)
        self.list.updateGeometry()
        self.list.itemSelectionChanged.emit()

    @property
    def chosen(self) -> PortRow | None:
        places = [index.row() for index in self.list.selectedIndexes()]
        return self.rows[places[0]] if places else None

    def choose(self, key: str) -> bool:
        """Selects the row with this key; whether there is one."""
        keys = [row.key for row in self.rows]
        if key in keys:
            self.list.setCurrentRow(keys.index(key))
        return key in keys

    def chosen_target(self) -> Target | None:
        """The target that Connect would open, None while nothing is chosen."""
        rate, typed, choice = int(self.rate.currentData()), self.other.text().strip(), self.chosen
        if choice is None and not typed:
            return None
        device, identity = (typed, "") if typed or choice is None else (choice.device, choice.identity)
        return Target(device, rate or DEFAULT_BAUD_RATE, identity, finds_rate=rate == FIND_RATE)

    def connect_chosen(self) -> None:
        target = self.chosen_target()
        if target is not None:
            self.connect_wanted.emit(target)

    def _choose(self) -> None:
        if self.chosen is not None:
            self.other.clear()
        self._show_state()

    def _type(self) -> None:
        if self.other.text():
            self.list.clearSelection()
        self._show_state()

    def _show_state(self) -> None:
        """Show the state of the connection that there is, with its port and rate; else what connecting does."""
        port = self._ports.current
        state, target = port.state, port.target
        if state.phase is Phase.CLOSED or target is None:
            self.state_label.setText(tr("Connecting reads the module; Live also switches its serial output on."))
        else:
            name = tr("Simulated module") if target.is_simulated else target.device.removeprefix("/dev/")
            rate = tr("{rate} baud", rate=port.connection.baud_rate) if port.is_open else ""
            said = join_sentences((state.what, state.next_step))
            self.state_label.setText(labelled(_listed(name, rate), said))
        self.disconnect_button.setVisible(port.is_requested)
        self.connect_button.setEnabled(self.chosen_target() is not None)

    def setVisible(self, is_visible: bool) -> None:
        show = partial(super().setVisible, is_visible)
        show() if is_visible else self._focus.leave(show)

    def _on_shown(self) -> None:
        self.list.setFocus()  # before the page hides, which has it
        self.shown.emit()
        self._watcher.watch(True)
        self.refresh()

    def _on_hidden(self) -> None:
        self._watcher.watch(False)
        if self.isHidden():  # not only minimised
            self._in_use = None
        self.shown.emit()
