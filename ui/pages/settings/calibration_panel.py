"""Panel for calibrating the light threshold: bay closed, bay open, proposal with margins."""

from functools import partial

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QFrame, QLabel, QPushButton, QWidget

from app.engine.worker import Job
from app.procedures.light_calibration import Band, CalibrationFault, Proposal, measure_light, propose
from app.text.i18n import tr
from app.text.sentences import join_sentences
from protocol.translatable import marked
from ui.core.texts import Texts
from ui.services.context import Services
from ui.services.running_job import RunningJob
from ui.style.icons import Icon, set_icon_size
from ui.style.theme import Space
from ui.widgets.controls import TEXT_GAP_PX, control, named
from ui.widgets.labels import text_label
from ui.widgets.layouts import Gap, in_column, in_row

CLOSED, OPEN = "closed", "open"


class CalibrationPanel(QWidget):
    """`proposed` carries the accepted threshold in volts, which becomes an edit like any other."""

    proposed = Signal(float)
    closed = Signal()

    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("calibration_panel")
        self._services = services
        self._bands: dict[str, Band] = {}
        self._job = RunningJob(services.connector, self)
        self._measuring = ""
        self._is_link_lost = False
        texts = services.texts
        self._title = text_label("calibration_title", "title")
        self._intro = text_label("calibration_intro", "muted")
        self.sides = {
            CLOSED: _Side(CLOSED, texts, marked("1. Bay closed"), Icon.BAY_CLOSED),
            OPEN: _Side(OPEN, texts, marked("2. Bay open"), Icon.BAY_OPEN),
        }
        for name, side in self.sides.items():
            side.button.clicked.connect(partial(self._measure, name))
        texts.bind(self._title.setText, "Measure the light threshold")
        texts.bind(
            self._intro.setText,
            "Measure in the light of the flight day, with no hand over the sensor.",
        )
        self.result = text_label("calibration_result", "strong")
        self.detail = text_label("calibration_detail", "small")
        self.take = control(QPushButton(), texts, "calibration_take", "Use this threshold", role="primary",
                            slot=self._use_proposal)  # fmt: skip
        self.back = control(QPushButton(), texts, "calibration_back", "Back", key="Esc",
                            slot=self._leave)  # fmt: skip
        self._lay_out()
        services.connector.invalidated.connect(self._bands.clear)
        self._job.changed.connect(self.refresh)

    @property
    def proposal(self) -> Proposal | CalibrationFault | None:
        if len(self._bands) < len(self.sides):
            return None
        return propose(self._bands[CLOSED], self._bands[OPEN])

    def begin(self) -> None:
        self._bands.clear()
        self._is_link_lost = False
        self.sides[CLOSED].button.setFocus()

    def refresh(self) -> None:
        for name, side in self.sides.items():
            side.button.setEnabled(self._job.can_run)
            side.text.setText(self._side_text(name))
        found = self.proposal
        self.take.setEnabled(isinstance(found, Proposal))
        match found:
            case Proposal():
                self.result.setText(found.sentence)
                parts = [tr(found.direction.value), tr("Vendor's advice: {volts:.1f} V.", volts=found.vendors_v)]
                if not found.is_steady:
                    parts.append(tr("The readings scatter: measure again in steady light."))
                self.detail.setText(join_sentences(parts))
            case CalibrationFault():
                self.result.setText(tr(found.value))
                self.detail.setText("")
            case _:
                self.result.setText("")
                self.detail.setText(tr("The link was lost.") if self._is_link_lost else "")

    def _side_text(self, name: str) -> str:
        if self._job.is_running and self._measuring == name:
            done = 0 if self._job.progress is None else self._job.progress.done
            return tr("measuring… {done}", done=done)
        band = self._bands.get(name)
        if band is None or not band.raws:
            return tr("not measured yet")
        return tr("{median:.1f} V ({low:.1f} to {high:.1f} V)", median=band.median_v, low=band.low_v, high=band.high_v)

    def _measure(self, name: str, _is_checked: bool = False) -> None:
        if not self._job.is_running:
            self._measuring, self._is_link_lost = name, False
            self._bands.pop(name, None)
            self._job.run(measure_light(), partial(self._end, name))

    def _end(self, name: str, job: Job[Band]) -> None:
        if job.run.error is None:
            self._bands[name] = job.outcome()
            if name == CLOSED:
                self.sides[OPEN].button.setFocus()
        else:
            self._is_link_lost = True

    def _use_proposal(self) -> None:
        found = self.proposal
        if isinstance(found, Proposal):
            self.proposed.emit(found.threshold_v)

    def _leave(self) -> None:
        self._job.cancel()
        self.closed.emit()

    def _lay_out(self) -> None:
        sides = in_row(*((side, 1) for side in self.sides.values()), spacing=Space.M)
        words = in_column(self._title, self._intro, sides, Gap(Space.S), self.result, self.detail, spacing=Space.S)
        foot = in_row(1, self.back, self.take, spacing=Space.S)
        in_column(words, 1, foot, of=self, spacing=Space.S, margins=(Space.M, Space.M, Space.M, Space.S))


class _Side(QFrame):
    """One position of the bay."""

    def __init__(self, name: str, texts: Texts, title: str, picture: Icon) -> None:
        super().__init__()
        named(self, f"calibration_{name}", "card")
        self.title = control(QLabel(), texts, f"calibration_{name}_title", title, role="strong")
        self.text = text_label(f"calibration_{name}_text")
        self.button = control(QPushButton(), texts, f"calibration_{name}_measure", "Measure", picture=picture)
        texts.bind(self._name_button, title)
        set_icon_size(self.button, 20, gap_px=TEXT_GAP_PX)
        in_column(
            self.title, self.text, (self.button, Qt.AlignmentFlag.AlignLeft), of=self, spacing=Space.S, margins=Space.M
        )

    def _name_button(self, title: str) -> None:
        self.button.setAccessibleName(tr("{setting}: {what}", setting=title, what=tr("Measure")))
