"""The smaller panels of the Diagnosis page: sharing of the port, statistics, and the support bundle."""

import copy
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtWidgets import QCheckBox, QFormLayout, QFrame, QLabel, QLineEdit, QPlainTextEdit, QPushButton, QWidget

from app import version
from app.diagnosis.support_bundle import bundle_files, write_bundle
from app.text import i18n
from app.text.i18n import tr
from app.text.messages import error_text, in_brackets, join_names, labelled
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask, Running
from ui.files.file_dialogs import AskPath, ask_path, default_name
from ui.pages.diagnosis.traffic import TrafficModel
from ui.services.context import Services
from ui.session.page_job import PageJob
from ui.style.icons import Icon
from ui.style.theme import Meaning, Size, Space, fixed_font
from ui.widgets.controls import SELECTABLE, TickingLabel, control, in_column, in_row, named, set_role, text_label
from ui.widgets.visibility_timer import VisibilityTimer

USUAL_ADDRESS = "127.0.0.1:7001"


class SharingCard(QFrame):
    """What it says is of the port that the window shows."""

    def __init__(self, services: Services) -> None:
        super().__init__()
        named(self, "sharing_card", "card")
        self._ports = services.ports
        self.switch = control(QCheckBox(tr("Share this port, read-only")), "sharing_switch", slot=self._press)
        self.address = control(QLineEdit(USUAL_ADDRESS), "sharing_address", says=tr("Address for readers"))
        self.state = text_label("sharing_state", "muted", is_selectable=True)
        self.last = named(TickingLabel(), "sharing_last")
        self.last.setAccessibleName(self.switch.text())
        self.last.setWordWrap(True)
        self.last.setTextInteractionFlags(SELECTABLE)
        in_column(
            in_row(self.switch, (self.address, 1), spacing=Space.M), self.state, self.last, of=self, spacing=Space.S
        )
        self._ports.changed.connect(self._show)
        self._ports.shown.connect(self._show)
        for port in self._ports.all:
            port.sharing.changed.connect(self._show)
        self._ports.added.connect(lambda port: port.sharing.changed.connect(self._show))
        self._show()

    def _press(self, is_on: bool) -> None:
        sharing = self._ports.current.sharing
        sharing.start(self.address.text()) if is_on else sharing.stop()
        self._show()

    def _show(self) -> None:
        sharing = self._ports.current.sharing
        is_on = sharing.address != ""
        self.switch.setChecked(is_on)
        self.switch.setEnabled(is_on or self._ports.current.is_open)
        self.address.setEnabled(not is_on)
        text = tr("Other programs on this computer may ask, and may send LOCK. TCP has no authentication.")
        if is_on:
            text = join_names((sharing.address, tr("readers: {count}", count=sharing.readers)))
        self.state.setText(text)
        self.last.setText(sharing.last)
        set_role(self.last, "attention" if sharing.meaning is Meaning.ATTENTION else "")


# The share of requests without reply from which a warning is shown.
LOSS_ATTENTION: Final = 0.01
_FIGURES: Final = (
    ("sent", marked("Requests")),
    ("lost", marked("Without reply")),
    ("trip", marked("Round trip")),
    ("late", marked("95th percentile")),
    ("slowest", marked("Slowest answer")),
    ("lag", marked("Lag")),
    ("restarts", marked("Restarts")),
    ("losses", marked("Port lost")),
    ("rejected", marked("Invalid bytes")),
    ("reasons", marked("Why")),
)


class StatisticsView(QWidget):
    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("link_figures_view")
        self._ports = services.ports
        self.figures: dict[str, QLabel] = {}
        card = named(QFrame(), "figures_card", "card")
        form = QFormLayout(card)
        form.setHorizontalSpacing(Space.XL)
        for key, english in _FIGURES:
            figure = self.figures[key] = named(TickingLabel(), f"figures_{key}")
            figure.setTextInteractionFlags(SELECTABLE)
            figure.setAccessibleName(tr(english))
            form.addRow(named(QLabel(tr(english)), f"figures_{key}_name", "muted"), figure)
        in_column(card, 1, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        VisibilityTimer(self, self.refresh, every_ms=500)

    def refresh(self) -> None:
        statistics, lag_s = self._ports.module.statistics, self._ports.module.view.lag_s
        totals = statistics.totals
        share = min(1.0, totals.time_outs / totals.sent) if totals.sent else 0.0
        # "0 %", "0.03 %", "12 %"
        percent = f"{share * 100:.0f} %" if share >= 0.1 or not share else f"{share * 100:.2g} %"
        rejected = ((why, n) for why, n in totals.rejected_bytes.most_common() if n)
        texts = {
            "sent": f"{totals.sent:,}",
            "lost": f"{totals.time_outs:,}{in_brackets(percent)}" if totals.sent else "—",
            "lag": "—" if lag_s is None else f"{lag_s:.2f} s",
            "restarts": f"{totals.restarts:,}",
            "losses": f"{statistics.losses:,}",
            "rejected": f"{totals.rejected:,}",
            "reasons": "\n".join(labelled(tr(why.value), f"{n:,}") for why, n in rejected),
        }
        for key, quantile in (("trip", 0.5), ("late", 0.95), ("slowest", 1.0)):
            trip_s = statistics.quantile_s(quantile)
            texts[key] = "—" if trip_s is None else f"{trip_s * 1000:.1f} ms"
        for key, text in texts.items():
            self.figures[key].setText(text)
        warned = {"lost": share > LOSS_ATTENTION, "rejected": totals.rejected > 0, "losses": statistics.losses > 0}
        for key, is_warned in warned.items():
            set_role(self.figures[key], "attention" if is_warned else "")


class BundlePreview(QWidget):
    """The support bundle, made each time it is shown, and seen before it is saved."""

    def __init__(self, services: Services, traffic: TrafficModel, result: PageJob) -> None:
        super().__init__()
        self.setObjectName("bundle_preview")
        self.ask_path: AskPath = ask_path
        self._services, self._traffic, self._result = services, traffic, result
        self.log = services.log
        # Texts by the name of the file.
        self.files: dict[str, str] | None = None
        self._making: BackgroundTask[dict[str, str]] = BackgroundTask("dps-s support bundle", self)
        self._folder = Path.home()
        promise = text_label("bundle_promise")
        promise.setText(
            tr(
                "The names of the user and the computer are replaced. Names of modules, files and ports, serial "
                "numbers and addresses stay: read everything before you pass it on. Nothing is sent."
            )
        )
        self.text = control(QPlainTextEdit(), "bundle_text", says=tr("Contents"))
        self.text.setReadOnly(True)
        self.text.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self.text.setTabChangesFocus(True)
        self.text.setFont(fixed_font(Size.SMALL))
        save = QPushButton(tr("Save support bundle…"))
        self.save = control(save, "bundle_save", picture=Icon.BUNDLE, role="primary", slot=self.choose_and_save)
        renew = control(QPushButton(tr("Refresh")), "bundle_renew", picture=Icon.AGAIN, slot=self.make)
        self._where = text_label("bundle_log_path", "small", is_selectable=True)
        buttons = in_row(1, renew, self.save, spacing=Space.S)
        in_column(promise, buttons, (self.text, 1), self._where, of=self, spacing=Space.S, margins=(Space.M, Space.S))
        self._timer = VisibilityTimer(self, self.make)

    def begin_again(self) -> None:
        """What is shown, or still being made, is of the former module."""
        self._making.cancel()
        self.files = None
        self.text.clear()
        self._timer.refresh_seen()

    def make(self) -> None:
        """Makes the bundle in the background from the present state, of which a copy is taken now."""
        services, log = self._services, self.log
        make = partial(
            bundle_files,
            version=version(),
            connection=services.ports.current.connection,
            conversation=services.ports.module.view,
            now=services.ports.clock(),
            statistics=copy.copy(services.ports.module.statistics),
            preferences={"language": i18n.language(), "theme": services.appearance.choice.value},
            traffic=self._traffic.events,
        )
        self.save.setEnabled(False)

        def pack(_running: Running) -> dict[str, str]:
            return make(log="" if log is None else log.text())

        def fail(error: Exception) -> None:
            self._result.notify(Meaning.ATTENTION, tr("Failed: {why}.", why=error_text(error)))

        self._making.run(pack, self._show, fail)

    def choose_and_save(self) -> None:
        """Saves the bundle that is shown."""
        files = self.files
        if files is None or self._result.is_writing:
            return

        def save(path: Path) -> None:
            self._folder = path.parent
            self._result.write_file(path, partial(write_bundle, path, files))

        name = default_name("support", ".zip", datetime.now().astimezone())
        self.ask_path(self, tr("Save support bundle…"), self._folder / name, "*.zip", save)

    def _show(self, files: dict[str, str]) -> None:
        self.files = files
        self.save.setEnabled(True)
        self.text.setPlainText("\n".join(f"——— {name} ———\n{text}" for name, text in files.items()))
        if self.log is not None:
            self._where.setText(tr("Log file: {path}", path=self.log.trouble or self.log.path))
        self._where.setVisible(self.log is not None)
