"""Past checks of a module, with the cell voltage over them; their reports exported, printed and verified."""

from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from functools import partial
from pathlib import Path
from tempfile import mkdtemp
from typing import ClassVar, Final

import pyqtgraph as pg
from PySide6.QtCore import QObject, QSize, Qt, Signal
from PySide6.QtGui import QColor, QIcon
from PySide6.QtWidgets import QComboBox, QLabel, QPushButton, QSizePolicy, QWidget

from app.limits.limits import LimitsInUse
from app.modules.labels import Printer
from app.preflight.verdict import Verdict, verdict_named
from app.records.filing import CheckLine, checks_in, voltages_of, weeks_since_charge
from app.records.record import SignedRecord
from app.records.report import suggested_name, write_report
from app.records.verification import RecordState, Verification, is_green, verify_file
from app.store.fact_store import Store
from app.store.opening import StoreTrouble
from app.system.clock import local_time
from app.system.files import CANNOT_READ
from app.text.i18n import tr
from app.text.messages import UserError, clean, error_text, in_brackets, join_sentences, labelled, not_written
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask, Running
from ui.files.file_dialogs import AskPath, ThenPath, ask_open, ask_path
from ui.files.report_printer import print_pages
from ui.forms.tables import RowsTable, TableColumn, select_row
from ui.plots.static_plot import StaticPlot
from ui.services.context import Services
from ui.services.job_notice import JobNotice
from ui.services.storage import Storage
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
        self.values: tuple[float, ...] = ()
        self._days: tuple[float, ...] = ()
        self._ends: tuple[str, ...] = ()
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def show_measured(self, measured: Sequence[tuple[datetime, float]]) -> None:
        """From the oldest to the newest."""
        values = self.values = tuple(volts for _at, volts in measured)
        self._days = tuple((at - measured[0][0]) / timedelta(days=1) for at, _volts in measured)
        self._ends = tuple(f"{at.astimezone():%Y-%m-%d}" for at, _volts in measured)
        text = labelled(tr("Cell voltage"), tr("not measured yet"))
        if values:
            text = tr(
                "{title}: {low} to {high}, last {last}; checks: {count}",
                title=tr("Cell voltage"),
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
        days, limit = self._days, self._in_use.profile.limit("cell_voltage_min_v")
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
        labelled_at = {low, high}
        if min(limit - low, high - limit) > (high - low) / 4:  # else its label would be on another one
            labelled_at.add(limit)
        self.show_ticks("left", [(value, _volts(value)) for value in sorted(labelled_at)])
        dates = {self._ends[0]: days[0], self._ends[-1]: days[-1]}
        self.show_ticks("bottom", [(day, date) for date, day in dates.items()])


def _volts(value: float) -> str:
    return f"{value:.2f} V"


def _widest_verdict() -> str:
    return max((tr(verdict.value) + in_brackets(tr("simulated")) for verdict in Verdict), key=len)


def _verdict_icon(check: CheckLine) -> QIcon:
    counts = not check.is_void and not check.is_simulated and not check.is_fired_since
    return icon(*VERDICT_STYLES[verdict_named(check.verdict)]) if counts else icon(Icon.CROSS, Meaning.UNKNOWN)


_COLUMNS: Final = (
    TableColumn[CheckLine](marked("Time"), lambda check: local_time(check.at), widest=lambda: "0000-00-00 00:00:00"),
    TableColumn[CheckLine](
        marked("Verdict"), lambda check: check.words.translated(), picture=_verdict_icon, widest=_widest_verdict
    ),
    TableColumn[CheckLine](marked("Module"), lambda check: check.module or "—", stretches=True),
    TableColumn[CheckLine](marked("Aircraft"), lambda check: check.aircraft or "—", stretches=True, is_spare=True),
    TableColumn[CheckLine](marked("Checked by"), lambda check: check.who or "—", stretches=True, is_spare=True),
    TableColumn[CheckLine](
        marked("Settings code"), lambda check: check.code or "—", widest=lambda: "MMMM-MMMM", is_spare=True
    ),
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
        self.filter = named(QComboBox(), "past_checks_filter")
        self.filter.setAccessibleName(tr("Past checks"))
        self.filter.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        WheelGuard(self.filter)
        self.filter.activated.connect(self._read)
        self.count = named(QLabel(), "past_checks_count", "muted")
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
        self.charged = text_label("past_checks_charged", "small")
        self.trend.hide()  # until its values are known: an axis that grows is drawn cut off
        self.export = named(QPushButton(icon(Icon.SAVE), tr("Export report…")), "past_checks_export")
        self.export.clicked.connect(self._export)
        head = in_row(self.filter, 1, self.count, spacing=Space.M)
        foot = in_row((self.charged, 1), self.export)
        parts = (head, (self.table, 1), self.trend, foot)
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
        if not isinstance(error, StoreTrouble):
            raise error
        self._show(())
        self.count.setText(error.sentence)

    def _show(self, checks: Sequence[CheckLine]) -> None:
        self.checks = tuple(checks)
        self.count.setText(tr("Checks: {count}", count=len(checks)))
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

    def _export(self) -> None:
        for check in self.table.chosen():
            self.export_wanted.emit(check.id)


SUFFIXES: Final = (".json", ".pdf")
_NO_RECORD: Final = marked("No pre-flight record: {why}.")
AskRecord = Callable[[QWidget, ThenPath], object]


def ask_record(parent: QWidget, then: ThenPath) -> None:
    ask_open(parent, Path.home(), tr("Verify a file…"), "*.json *.pdf", then)


class RecordFiles(QObject):
    def __init__(self, storage: Storage, result: JobNotice, parent: QWidget) -> None:
        super().__init__(parent)
        self.ask_path: AskPath = ask_path
        self.ask_record: AskRecord = ask_record
        self.printer: Printer = print_pages
        self._storage, self._result, self._window = storage, result, parent
        self._folder = Path.home()

    # Reports

    def export(self, signed: SignedRecord) -> None:
        """Ask for a file name, then write the report as PDF and JSON."""
        suggested = self._folder / f"{suggested_name(signed.record)}.pdf"
        write = partial(self._write_report, signed)
        self.ask_path(self._window, tr("Export report…"), suggested, "*.pdf", write)

    def print(self, signed: SignedRecord) -> None:
        """Open the report in the system's own viewer, which knows the printers."""
        path = Path(mkdtemp(prefix="dps-s-")) / f"{suggested_name(signed.record)}.pdf"
        self._write(signed, path, lambda: self._result.open_file(path))

    def _write_report(self, signed: SignedRecord, path: Path) -> None:
        self._folder = path.parent
        saved = tr("Saved to {path}.", path=f"{path}, {path.with_suffix('.json')}")
        self._write(signed, path, lambda: self._result.notify_saved(path, saved))

    def _write(self, signed: SignedRecord, path: Path, then: Callable[[], object]) -> None:
        write = partial(write_report, path, signed, self.printer)
        self._result.begin(tr("Saving…"), lambda _running: write(), lambda _done: then(), partial(not_written, path))

    # Verifying

    def choose_and_verify(self) -> None:
        self.ask_record(self._window, self.verify)

    def verify(self, path: Path) -> None:
        """Verify a file in the background: it may be large, and on a slow disk. It replaces one being read."""
        storage = self._storage

        def work(_running: Running) -> Verification:
            from app.archive.archive import known_names  # no start waits for it

            return verify_file(path, known_names(storage.begun))

        doing = tr("Reading: {what}", what=path.name)
        self._result.begin(doing, work, partial(self._notify_verified, path), partial(_why_unread, path), writes=False)

    def _notify_verified(self, path: Path, done: Verification) -> None:
        meaning = Meaning.INFORMATION  # an intact NO-GO is not shown in green
        if done.state is not RecordState.INTACT:
            meaning = Meaning.DANGER
        elif is_green(done):
            meaning = Meaning.GOOD
        sentences = join_sentences(sentence.translated() for sentence in done.sentences())
        self._result.notify(meaning, f"{clean(path.name, longest=60)} — {sentences}")


def _why_unread(path: Path, error: Exception) -> str:
    file = clean(path.name, longest=60)
    if isinstance(error, UserError):
        return f"{file} — {tr(_NO_RECORD, why=error.sentence)}"
    return tr(CANNOT_READ, file=file, why=error_text(error))
