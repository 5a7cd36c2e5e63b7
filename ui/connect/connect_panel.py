"""Choosing a port and connecting, in the room of the page: the module's state stays visible above it."""

from functools import partial

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QHideEvent, QKeyEvent, QShowEvent
from PySide6.QtWidgets import (
    QComboBox,
    QFrame,
    QGridLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from app.diagnosis.link_state import Phase, words
from app.engine.ports import NOT_LISTED
from app.engine.target import Target
from app.text.i18n import tr
from protocol.catalogue import BAUD_RATES, DEFAULT_BAUD_RATE
from protocol.translatable import marked
from ui.connect.port_list import PortChoice, PortList, choice_of
from ui.core.connector import Connector
from ui.core.port_watcher import PortWatcher, key_of
from ui.core.preferences import LastPort
from ui.core.texts import Texts
from ui.style.icons import Icon, icon
from ui.style.theme import Space, scaled
from ui.widgets.controls import control
from ui.widgets.layouts import in_column, in_row
from ui.widgets.naming import named
from ui.widgets.sliders import WheelGuard

SIMULATED_PORT = "sim://demo?lifelike&noise=1"
CARD_PX = 520
FIND_RATE = 0
"""The entry of the rate box that stands for "find it"."""


class ConnectPanel(QScrollArea):
    """A card in the middle. Refreshes itself while it is open; nothing in it waits for a port."""

    connect_wanted = Signal(object)
    """A `Target`."""
    disconnect_wanted = Signal()
    shown = Signal()
    """Opened or closed."""

    def __init__(self, connector: Connector, ports: PortWatcher, texts: Texts, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("connect_panel")
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._connector = connector
        self._ports = ports
        self._texts = texts
        self._last: LastPort | None = None
        self.list = PortList()
        self.other = control(QLineEdit(), texts, "port_address", says="Other port")
        self.rate = control(QComboBox(), texts, "rate_box", says="Baud rate")
        self.connect_button = control(QPushButton(), texts, "connect_button", "Connect", slot=self.connect_chosen)
        self.disconnect_button = control(QPushButton(), texts, "disconnect_button", "Disconnect",
                                         key="Ctrl+D", slot=self.disconnect_wanted)  # fmt: skip
        self.empty = named(QLabel(), "no_ports_hint")
        self.said = named(QLabel(), "connect_state")
        self.options = control(QToolButton(), texts, "connect_options", "Other port or baud rate",
                               picture=Icon.CHEVRON_DOWN, role="quiet", is_checkable=True)  # fmt: skip
        self._close = control(QToolButton(), texts, "connect_close", says="Close", key="Esc", slot=self.hide)
        WheelGuard(self).guard(self.rate)
        self._build()
        self._name()
        self.list.chosen_changed.connect(self._choose)
        self.list.activated_choice.connect(self._connect_choice)
        self.other.textEdited.connect(self._type)
        self.other.returnPressed.connect(self.connect_chosen)
        ports.listed.connect(self.refresh)
        connector.changed.connect(self.refresh)
        self.hide()

    def prefer(self, last: LastPort | None) -> None:
        """Choose this port beforehand, as soon as it is listed."""
        self._last = last
        if last is not None:
            self.rate.setCurrentIndex(max(0, self.rate.findData(last.baud_rate)))
            if not last.identity and not last.device.startswith("sim:"):
                self.other.setText(last.device)
            self.options.setChecked(bool(self.other.text()) or self.rate.currentIndex() > 0)
        self.refresh()

    def refresh(self) -> None:
        """Show what is known now."""
        if self.isHidden():
            return
        target = self._connector.target if self._connector.is_wanted else None
        choices = [
            choice_of(
                port,
                is_new=self._ports.is_new(port),
                is_connected=target is not None and self._connector.is_open and target.device == port.device,
                is_last=self._last is not None and bool(port.identity) and port.identity == self._last.identity,
            )
            for port in self._ports.ports
        ]
        is_simulating = target is not None and target.is_simulated and self._connector.is_open
        choices.append(
            PortChoice(
                SIMULATED_PORT,
                "",
                tr("Simulated module"),
                "",
                tr("Nothing to plug in"),
                Icon.SIMULATOR,
                tr("connected") if is_simulating else "",
            )
        )
        self.list.show_choices(choices)
        if self.list.chosen is None and not self.other.text():
            self._choose_beforehand()
        self.empty.setVisible(not self._ports.ports)
        if self._ports.has_looked and not self._ports.is_current:
            self.empty.setText(tr(NOT_LISTED))
        elif self._ports.has_looked:
            self.empty.setText(tr("No serial port found. Plug the adapter in, or try another cable."))
        else:
            self.empty.setText(tr("Looking for ports…"))
        self._show_state()

    def chosen_target(self) -> Target | None:
        """What Connect would open, None while nothing is chosen."""
        rate = int(self.rate.currentData())
        begins_at, finds = (rate or DEFAULT_BAUD_RATE), rate == FIND_RATE
        typed = self.other.text().strip()
        if typed:
            return Target(typed, begins_at, finds_rate=finds)
        choice = self.list.chosen
        if choice is None:
            return None
        return Target(choice.device, begins_at, choice.identity, choice.title, finds)

    def connect_chosen(self) -> None:
        target = self.chosen_target()
        if target is not None:
            self.connect_wanted.emit(target)

    # Making

    def _build(self) -> None:
        title = control(QLabel(), self._texts, "connect_title", "Choose a port", role="title")
        self._close.setIcon(icon(Icon.CROSS))
        self._close.setProperty("role", "quiet")
        self._form = named(QWidget(), "connect_form")
        self._form.setLayout(self._build_form())
        self._form.hide()
        self.options.toggled.connect(self._form.setVisible)
        head = in_row((title, 1), self._close)
        buttons = in_row(1, self.disconnect_button, self.connect_button, spacing=Space.S)
        options = in_row(self.options, 1)
        parts = head, self.list, self.empty, options, self._form, self.said, buttons
        card = named(QFrame(), "connect_card", "card")
        self._card = card
        in_column(*parts, of=card, spacing=Space.M, margins=(Space.XL, Space.L, Space.XL, Space.XL))
        card.setMaximumWidth(scaled(CARD_PX))
        for label in (self.empty, self.said):
            label.setWordWrap(True)
            label.setTextFormat(Qt.TextFormat.PlainText)
            label.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Minimum)
            label.setProperty("role", "muted")
        self.connect_button.setProperty("role", "primary")
        self.connect_button.setMinimumWidth(120)
        ground = named(QWidget(), "connect_ground")
        middle = in_row(1, (card, 100), 1)
        in_column(1, middle, 2, of=ground, margins=Space.M)
        self.setWidget(ground)
        for transparent in (self.viewport(), ground):
            transparent.setAutoFillBackground(False)

    def _build_form(self) -> QGridLayout:
        form = QGridLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.setHorizontalSpacing(Space.M)
        form.setVerticalSpacing(Space.S)
        for row, (field, english) in enumerate(((self.other, marked("Other port")), (self.rate, marked("Baud rate")))):
            label = QLabel()
            label.setBuddy(field)
            label.setProperty("role", "muted")
            self._texts.bind(label.setText, english)
            form.addWidget(label, row, 0)
            form.addWidget(field, row, 1)
        form.setColumnStretch(1, 1)
        for number, rate in enumerate((DEFAULT_BAUD_RATE, *(one for one in BAUD_RATES if one != DEFAULT_BAUD_RATE))):
            self.rate.addItem(str(rate), rate)
            if rate == DEFAULT_BAUD_RATE:
                self._texts.bind(partial(self.rate.setItemText, number), "115200 (usual)")
        self.rate.addItem("", FIND_RATE)
        self._texts.bind(partial(self.rate.setItemText, self.rate.count() - 1), "Find the rate")
        return form

    def _name(self) -> None:
        bind = self._texts.bind
        bind(self.setAccessibleName, "Choose a port")
        bind(self.list.setAccessibleName, "Ports")
        bind(self.other.setPlaceholderText, "device or socket://host:port")

    # Doing

    def _choose_beforehand(self) -> None:
        last = self._last
        if last is not None and self.list.choose(last.identity or last.device):
            return
        ports = self._ports.ports
        likely = [port for port in ports if self._ports.is_new(port)] or [port for port in ports if port.identity]
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

    def _connect_choice(self, _choice: PortChoice) -> None:
        self.connect_chosen()

    def _show_state(self) -> None:
        state = self._connector.state
        said = words(state, self._connector.clock())
        is_closed = state.phase is Phase.CLOSED
        self.said.setText(self._what_next() if is_closed else f"{said.what} {said.next_step}".strip())
        self.said.setVisible(bool(self.said.text()))
        self._show_buttons()

    def _what_next(self) -> str:
        """As long as nothing is connected."""
        target = self.chosen_target()
        return "" if target is None else tr("Connecting only reads the module.")

    def _show_buttons(self) -> None:
        self.disconnect_button.setVisible(self._connector.is_wanted)
        self.connect_button.setEnabled(self.chosen_target() is not None)

    # Qt

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self.hide()
        else:
            super().keyPressEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.shown.emit()
        self._ports.watch(True)
        self.refresh()
        self.list.setFocus()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self._ports.watch(False)
        if not event.spontaneous():
            self._ports.settle()
        self.shown.emit()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.LanguageChange:
            self.refresh()
        elif event.type() == QEvent.Type.PaletteChange and hasattr(self, "_card"):
            self._card.setMaximumWidth(scaled(CARD_PX))
            self.list.scheduleDelayedItemsLayout()
