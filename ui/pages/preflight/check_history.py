"""Past checks of a module or an aircraft, with the cell voltage over them."""

from collections.abc import Sequence
from functools import partial
from typing import ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QSize, Signal
from PySide6.QtGui import QColor, QIcon
from PySide6.QtWidgets import QComboBox, QLabel, QPushButton, QSizePolicy, QWidget

from app.preflight.verdict import Verdict, verdict_named
from app.records.checks import CheckLine, aircraft_in, checks_in, measuring
from app.stations.station import fingerprint_of, own_station
from app.store.fact_store import Facts, Store
from app.store.trouble import StoreTrouble
from app.system.wall_clock import local_time
from app.text.i18n import tr
from app.text.sentences import in_brackets, labelled
from app.text.user_error import UserError
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.forms.rows_table import RowsTable
from ui.forms.table_kit import TableColumn, select_row
from ui.plots.static_plot import StaticPlot
from ui.services.context import Services
from ui.session.check import VERDICT_STYLES
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, Space, Theme, scaled
from ui.widgets.controls import control, named
from ui.widgets.labels import text_label
from ui.widgets.layouts import in_column, in_row, scroll_area
from ui.widgets.sliders import WheelGuard
from ui.widgets.visibility_timer import VisibilityTimer

_DOT_PX: Final = 7


class VoltageTrend(StaticPlot):
    """Equal distances between the checks, since days or minutes may lie between them."""

    usual: ClassVar = QSize(240, 96)
    least: ClassVar = QSize(160, 88)
    head_rows: ClassVar = 1

    def __init__(self) -> None:
        super().__init__("trend_cell_voltage_v")
        self.values: tuple[float, ...] = ()
        self._title = named(QLabel(), "trend_cell_voltage_v_title", "small")
        self._last = named(QLabel(), "trend_cell_voltage_v_last", "small")
        self.column.addLayout(in_row(self._title, 1, self._last))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def show_values(self, values: Sequence[float]) -> None:
        """From the oldest to the newest."""
        self.values = tuple(values)
        title = tr("Cell voltage")
        self._title.setText(title)
        self._last.setText(_volts(values[-1]) if values else "")
        text = labelled(title, tr("not measured yet"))
        if values:
            text = tr(
                "{title}: {low} to {high}, last {last}; checks: {count}",
                title=title,
                count=len(values),
                low=_volts(min(values)),
                high=_volts(max(values)),
                last=_volts(values[-1]),
            )
        self.setToolTip(text)
        self.announce(text)
        self.redraw()

    def draw(self, theme: Theme) -> None:
        values = self.values
        if not values:
            self.show_nothing(tr("not measured yet"))
            return
        low = min(values)
        high = max(values)
        colour = QColor(theme.curves[0])
        edge = (high - low) / 5 or 1.0  # room for the symbols
        self.set_range((-0.2, len(values) - 0.8), (low - edge, high + edge))
        line = pg.mkPen(colour, width=theme.line_px + 0.5)
        curve = pg.PlotDataItem(
            values, pen=line, symbol="o", symbolSize=scaled(_DOT_PX), symbolBrush=colour, symbolPen=None, antialias=True
        )
        self.add(curve)
        self.show_ticks("left", [(value, _volts(value)) for value in sorted({low, high})])


def _volts(value: float) -> str:
    return f"{value:.2f} V"


_ROW_PX: Final = 26
_TABLE_PX: Final = 110


def _verdict(check: CheckLine) -> str:
    return check.words.translated()


def _widest_verdict() -> str:
    return max((tr(verdict.value) + in_brackets(tr("simulated")) for verdict in Verdict), key=len)


def _verdict_icon(check: CheckLine) -> QIcon:
    counts = not check.is_void and not check.is_simulated and not check.is_fired_since
    return icon(*VERDICT_STYLES[verdict_named(check.verdict)]) if counts else icon(Icon.CROSS, Meaning.UNKNOWN)


_COLUMNS: Final = (
    TableColumn[CheckLine](marked("Time"), lambda check: local_time(check.at), widest=lambda: "0000-00-00 00:00:00"),
    TableColumn[CheckLine](marked("Verdict"), _verdict, picture=_verdict_icon, widest=_widest_verdict),
    TableColumn[CheckLine](marked("Module"), lambda check: check.module or "—", stretches=True),
    TableColumn[CheckLine](marked("Aircraft"), lambda check: check.aircraft or "—", stretches=True, is_spare=True),
    TableColumn[CheckLine](marked("Checked by"), lambda check: check.who or "—", stretches=True, is_spare=True),
    TableColumn[CheckLine](
        marked("Settings code"), lambda check: check.code or "—", widest=lambda: "MMMM-MMMM", is_spare=True
    ),
)


def _row_sentence(check: CheckLine) -> str:
    return " · ".join(column.text(check) for column in _COLUMNS)


class CheckHistory(QWidget):
    """`print_wanted`: the id of a kept check."""

    closed = Signal()
    print_wanted = Signal(str)

    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("check_history")
        self._services = services
        self.checks: tuple[CheckLine, ...] = ()
        self._loading: BackgroundTask[tuple[Sequence[str], Sequence[CheckLine]]] = BackgroundTask(
            "dps-s past checks", self
        )
        self.filter = control(QComboBox(), "check_history_filter", says=tr("Past checks"))
        self.filter.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        WheelGuard(self.filter)
        self.count = named(QLabel(), "check_history_count", "muted")
        self.table = RowsTable(
            "check_history_table",
            tr("Past checks"),
            _COLUMNS,
            lambda check: check.id,
            _row_sentence,
            row_px=_ROW_PX,
            is_single=True,
        )
        self.trend = VoltageTrend()
        self.station = text_label("station_own", "muted", is_selectable=True)
        self.back = control(
            QPushButton(tr("Back")), "check_history_back", key="Esc", picture=Icon.CHEVRON_LEFT, slot=self.closed
        )
        self.print = control(
            QPushButton(tr("Export report…")), "check_history_print", picture=Icon.SAVE, slot=self._print
        )
        self.filter.activated.connect(self.refresh_rows)
        self.table.selectionModel().selectionChanged.connect(self._enable)
        self._lay_out()
        VisibilityTimer(self, restyle=self._fit_table)
        self._fit_table()

    def _fit_table(self) -> None:
        """Some rows are in sight however large the text: the page scrolls below them."""
        self.table.setMinimumHeight(scaled(_TABLE_PX))

    def open(self) -> None:
        """Reload everything and select the named module."""
        ports = self._services.ports
        name = ports.module.name
        self._reload(("module", name if name in ports.known_names() else None))

    def refresh_rows(self) -> None:
        self._reload(self.filter.currentData() or ("module", None))

    def _reload(self, chosen: tuple[str, str | None]) -> None:
        """`chosen`: the entry of the filter, a module or an aircraft."""
        self._show_station()
        store, (kind, which) = self._services.storage.store, chosen
        if not isinstance(store, Store):
            self._fail(store)
            return

        def read(facts: Facts) -> tuple[Sequence[str], Sequence[CheckLine]]:
            checks = checks_in(facts, aircraft=which) if kind == "aircraft" else checks_in(facts, which)
            return aircraft_in(facts), checks

        self._loading.run(lambda _running: store.read(read), partial(self._show_read, chosen), self._fail)

    def _show_read(self, chosen: tuple[str, str | None], read: tuple[Sequence[str], Sequence[CheckLine]]) -> None:
        aircraft, checks = read
        self.filter.clear()
        for known in self._services.ports.known_names():
            self.filter.addItem(labelled(tr("Module"), known), ("module", known))
        for name in aircraft:
            self.filter.addItem(labelled(tr("Aircraft"), name), ("aircraft", name))
        self.filter.addItem(tr("Unnamed"), ("module", None))
        entries = [self.filter.itemData(place) for place in range(self.filter.count())]
        self.filter.setCurrentIndex(entries.index(chosen) if chosen in entries else self.filter.count() - 1)
        self._show(checks, is_of_module=chosen[0] == "module")

    def _fail(self, error: Exception) -> None:
        if not isinstance(error, StoreTrouble):
            raise error
        self._show(())
        self.count.setText(error.sentence)

    def _show(self, checks: Sequence[CheckLine], *, is_of_module: bool = True) -> None:
        self.checks = tuple(checks)
        self.count.setText(tr("Checks: {count}", count=len(checks)))
        self.table.show_rows(self.checks)
        if checks:
            select_row(self.table, 0)
        self._enable()
        voltages = [check.cell_voltage_v for check in reversed(measuring(checks))]
        self.trend.show_values([voltage for voltage in voltages if voltage is not None])
        self.trend.setVisible(is_of_module)

    def _show_station(self) -> None:
        """By what `dps-s verify` names it on another computer."""
        try:
            fingerprint = fingerprint_of(own_station(self._services.storage.folder).public)
        except UserError as trouble:
            self.station.setText(trouble.sentence)
        else:
            self.station.setText(tr("This station: {fingerprint}", fingerprint=fingerprint))

    def _enable(self) -> None:
        self.print.setEnabled(any(not check.is_void for check in self.table.chosen()))

    def _print(self) -> None:
        for check in self.table.chosen():
            self.print_wanted.emit(check.id)

    def _lay_out(self) -> None:
        title = named(QLabel(tr("Past checks")), "check_history_title", "title")
        head = in_row(title, 1, self.count, self.filter, spacing=Space.M)
        self.trend.hide()  # until its values are known: an axis that grows is drawn cut off
        content = named(QWidget(), "check_history_content")
        in_column((self.table, 1), self.trend, self.station, of=content, spacing=Space.S, margins=0)
        scroll = scroll_area(content, "check_history_scroll", tr("Past checks"), is_vertical=True)
        foot = in_row(self.back, 1, self.print, spacing=Space.S)
        in_column(head, (scroll, 1), foot, of=self, spacing=Space.S, margins=(Space.M, Space.S))
