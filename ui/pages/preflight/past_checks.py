"""Past checks of a module, with the cell voltage over them."""

from collections.abc import Sequence
from datetime import datetime, timedelta
from functools import partial
from typing import ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QColor, QIcon
from PySide6.QtWidgets import QComboBox, QPushButton, QSizePolicy, QWidget

from app.limits.limits import LimitsInUse
from app.preflight.verdict import Verdict
from app.records.filing import CheckLine, checks_in, voltages_of, weeks_since_charge
from app.store.fact_store import Store, StoreError
from app.system.clock import local_time
from app.text.i18n import tr
from app.text.messages import in_brackets, labelled
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.forms.tables import RowsTable, TableColumn, select_row
from ui.plots.charts import StaticPlot
from ui.services.context import Services
from ui.session.check import VERDICT_STYLES
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning, RowHeight, Space, Theme, scaled
from ui.widgets.controls import in_column, in_row, named, text_label
from ui.widgets.number_line import WheelGuard

_DOT_PX: Final = 7


class VoltageTrend(StaticPlot):
    """The voltage at each check over the days, and below which the check warns."""

    usual: ClassVar = QSize(240, 108)
    least: ClassVar = QSize(160, 108)

    def __init__(self, in_use: LimitsInUse) -> None:
        super().__init__("trend_cell_voltage_v")
        self._in_use = in_use
        self._measured: Sequence[tuple[datetime, float]] = ()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    @property
    def values(self) -> tuple[float, ...]:
        return tuple(volts for _at, volts in self._measured)

    def show_measured(self, measured: Sequence[tuple[datetime, float]]) -> None:
        """From the oldest to the newest."""
        self._measured = measured
        values, text = self.values, labelled(tr("Cell voltage"), tr("not measured yet"))
        if values:
            span = tr("{low} to {high}", low=f"{min(values):.2f} V", high=f"{max(values):.2f} V")
            text = labelled(tr("Cell voltage"), span)
        self.setToolTip(text)
        self.announce(text)
        self.redraw()

    def draw(self, theme: Theme) -> None:
        values = self.values
        if not values:
            self.show_nothing(tr("not measured yet"))
            return
        first = self._measured[0][0]
        days = [(at - first) / timedelta(days=1) for at, _volts in self._measured]
        limit = self._in_use.profile.limit("cell_voltage_min_v")
        low, high = min(*values, limit), max(*values, limit)
        colour = QColor(theme.curves[0])
        edge = (high - low) / 5 or 1.0  # room for the symbols
        beside = days[-1] / 8 or 0.5  # and for the dates
        self.set_range((-beside, days[-1] + beside), (low - edge, high + edge))
        least = pg.mkPen(theme.tint(Meaning.ATTENTION).ink, width=theme.line_px, style=Qt.PenStyle.DashLine)
        self.add(pg.InfiniteLine(limit, angle=0, pen=least))
        line = pg.mkPen(colour, width=theme.line_px + 0.5)
        dots = {"symbol": "o", "symbolSize": scaled(_DOT_PX), "symbolBrush": colour, "symbolPen": None}
        self.add(pg.PlotDataItem(days, values, pen=line, antialias=True, **dots))
        self.show_ticks("left", [(value, f"{value:.2f} V") for value in sorted({low, limit, high})])
        ends = {f"{self._measured[end][0].astimezone():%Y-%m-%d}": days[end] for end in (0, -1)}
        self.show_ticks("bottom", [(day, date) for date, day in ends.items()])


def _verdict_icon(check: CheckLine) -> QIcon:
    counts = not check.is_void and not check.is_simulated and not check.is_fired_since
    return icon(*VERDICT_STYLES[Verdict(check.verdict)]) if counts else icon(Icon.UNKNOWN, Meaning.UNKNOWN)


_COLUMNS: Final[tuple[TableColumn[CheckLine], ...]] = (
    TableColumn(marked("Time"), lambda check: local_time(check.at), widest=lambda: "0000-00-00 00:00:00"),
    TableColumn(
        marked("Verdict"),
        lambda check: check.words.translated(),
        picture=_verdict_icon,
        widest=lambda: max((tr(one.value) + in_brackets(tr("simulated")) for one in Verdict), key=len),
    ),
    TableColumn(marked("Aircraft"), lambda check: check.aircraft or "—", stretches=True, is_spare=True),
    TableColumn(marked("Checked by"), lambda check: check.who or "—", stretches=True, is_spare=True),
    TableColumn(marked("Settings code"), lambda check: check.code or "—", widest=lambda: "MMMM-MMMM", is_spare=True),
)


class PastChecks(QWidget):
    """`export_wanted`: the id of a kept check."""

    export_wanted = Signal(str)

    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("past_checks")
        self._services = services
        self.checks: tuple[CheckLine, ...] = ()
        self._loading: BackgroundTask[Sequence[CheckLine]] = BackgroundTask("dps-s past checks", self)
        self.filter = named(QComboBox(), "past_checks_filter", says=tr("Past checks"))
        self.filter.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        WheelGuard(self.filter)
        self.filter.activated.connect(self._read)
        self.table = RowsTable(
            "past_checks_table",
            tr("Past checks"),
            _COLUMNS,
            identify=lambda check: check.id,
            row_px=RowHeight.LIST,
            is_single=True,
        )
        self.table.selectionModel().selectionChanged.connect(self._enable)
        self.trend = VoltageTrend(services.in_use)
        self.trend.hide()  # until its values are known: an axis that grows is drawn cut off
        self.charged = text_label("past_checks_charged", "small")
        self.export = named(QPushButton(icon(Icon.SAVE), tr("Export report…")), "past_checks_export")
        self.export.clicked.connect(lambda: self.export_wanted.emit(self.table.chosen()[0].id))
        foot = in_row((self.charged, 1), self.export)
        parts = (in_row(self.filter, 1), (self.table, 1), self.trend, foot)
        in_column(*parts, of=self, spacing=Space.S, margins=(Space.M, 0, Space.M, Space.S))

    def open(self) -> None:
        """Read the names again, and the checks of the named module."""
        names, name = self._services.ports.known_names(), self._services.ports.module.name
        self.filter.clear()
        for known in names:
            self.filter.addItem(labelled(tr("Module"), known), known)
        self.filter.addItem(tr("Unnamed"), None)
        self.filter.setCurrentIndex(self.filter.findData(name) if name in names else len(names))
        self._read()

    def _read(self) -> None:
        """The checks of the chosen module."""
        store, module = self._services.storage.store, self.filter.currentData()
        if isinstance(store, Store):
            read = partial(checks_in, module=module)
            self._loading.run(lambda _running: store.read(read), self._show, self._fail)
        else:
            self._fail(store)

    def _fail(self, error: Exception) -> None:
        if not isinstance(error, StoreError):
            raise error
        self._show(())
        self.charged.setText(error.sentence)

    def _show(self, checks: Sequence[CheckLine]) -> None:
        self.checks = tuple(checks)
        self.table.show_rows(self.checks)
        if checks:
            select_row(self.table, 0)
        self._enable()
        is_named = self.filter.currentData() is not None
        measured = voltages_of(checks) if is_named else []  # what has no name may be several modules
        self.trend.show_measured(measured)
        self.trend.setVisible(is_named)
        weeks = weeks_since_charge(measured)
        about = tr("Cell: last charge about {weeks} weeks before the last check.", weeks=weeks)
        self.charged.setText("" if weeks is None else about)

    def _enable(self) -> None:
        self.export.setEnabled(any(not check.is_void for check in self.table.chosen()))
