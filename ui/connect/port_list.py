"""List of ports with adapter name, manufacturer and serial number."""

from typing import NamedTuple

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtWidgets import QListWidget, QListWidgetItem

from app.engine.ports import PortInfo
from app.text.i18n import tr
from ui.style.icons import Icon, icon, set_icon_size
from ui.style.theme import Space, scaled

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

    @property
    def lines(self) -> tuple[str, str]:
        """The port with its badge, and what its adapter says of itself."""
        return _listed(self.title, self.badge, self.product), self.detail


def choice_of(port: PortInfo, *, is_new: bool, is_connected: bool, is_last: bool) -> PortChoice:
    name = port.device.removeprefix("/dev/")
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
                item = QListWidgetItem(icon(choice.icon), "\n".join(choice.lines))
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


def _listed(*parts: str) -> str:
    return " · ".join(filter(None, parts))
