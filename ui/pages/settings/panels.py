"""The baud rate, the last row of the table, with a line of its own because changing it can cut the link; and the
calibration of the light threshold: bay closed, bay open, proposal with margins."""

from functools import partial

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QBoxLayout, QFrame, QLabel, QPushButton, QStackedLayout, QWidget

from app.engine.worker import Job
from app.procedures.baud import BaudChanged, BaudEnd, change_baud
from app.procedures.light import Band, CalibrationFault, Proposal, measure_light, propose
from app.safety.acts import TITLES, Act
from app.safety.interlocks import Interlock
from app.safety.permit import Origin, Permit
from app.text.i18n import tr
from app.text.sentences import join_sentences, labelled
from protocol.catalogue import BAUD_RATE
from protocol.translatable import marked
from ui.acts.confirm import Confirm
from ui.acts.outcomes import not_begun, open_conditions
from ui.forms.field_editors import ChoiceEditor, ValueLabel, explain_setting, make_editor
from ui.pages.settings.row import CELL_GAP, aligned_cells
from ui.services.context import Services
from ui.session.running_job import RunningJob
from ui.style.icons import Icon, set_icon_size
from ui.style.theme import Meaning, Space
from ui.widgets.controls import TEXT_GAP_PX, control, named
from ui.widgets.labels import text_label
from ui.widgets.layouts import Gap, in_column, in_row, stacked
from ui.widgets.notice_bar import Choice, Notice, NoticeBar

_AS_IT_STANDS = (BaudEnd.CHANGED, BaudEnd.UNCHANGED, BaudEnd.ELSEWHERE)


class BaudPanel(QFrame):
    def __init__(self, services: Services) -> None:
        super().__init__()
        named(self, "baud_panel", "marked-row")
        self._services, self._connector = services, services.ports
        self._job = RunningJob(services.ports, self)
        self._doubtful_since: float | None = None
        """When a change was broken off after it may have been sent, until the module answers."""
        self.title = named(QLabel(tr(BAUD_RATE.title)), "baud_title")
        self.title.setWordWrap(True)
        self._warning = text_label("baud_warning", "small")
        self.conditions = text_label("baud_conditions", "attention")
        self._message = QStackedLayout()  # the height stays the same whatever it shows
        self.value_label = ValueLabel(BAUD_RATE)
        editor = make_editor(BAUD_RATE)
        if not isinstance(editor, ChoiceEditor):
            raise TypeError("the baud rate has a choice editor")
        self.editor = editor
        self.confirm = Confirm("baud", ask=f"{TITLES[Act.CHANGE_BAUD]}…", go=marked("Change now"))
        self.notice_bar = named(NoticeBar(), "baud_said")
        self._warning.setText(tr("The vendor advises not to change it."))
        self.editor.chosen.connect(lambda _value: self.confirm.withdraw())
        self.confirm.asked.connect(self._job.dismiss)
        self.confirm.confirmed.connect(self._change)
        explain_setting(self, BAUD_RATE)
        self._lay_out()
        self._connector.invalidated.connect(self._reset)
        self._job.changed.connect(self.refresh)

    def refresh(self) -> None:
        port = self._connector.current
        now = port.clock()
        self._end_doubt()
        self.value_label.show_known(port.device.known("baud_rate", now), now)
        refusals = open_conditions(self._services, Act.CHANGE_BAUD)
        self.conditions.setText(join_sentences(refusal.sentence for refusal in refusals))
        blocking = [refusal for refusal in refusals if refusal.condition is not Interlock.FRESH_STATUS]
        is_another = self.editor.value is not None and self.editor.value != port.connection.baud_rate
        is_free = self._job.can_run
        self.editor.setEnabled(is_free)
        self.confirm.set_possible(is_free and is_another and not blocking)
        notice = self._job.notice(marked("Changing the baud rate…"), can_cancel=False)
        self.notice_bar.show_notice(notice)
        words = self.conditions if refusals else self._warning
        self._message.setCurrentWidget(words if notice is None else self.notice_bar)

    def _reset(self) -> None:
        self._doubtful_since = None
        self.editor.show_value(None, None)
        self.confirm.withdraw()

    def _change(self) -> None:
        rate = self.editor.value
        if rate is None:
            return
        port = self._connector.current
        permit = Permit(Act.CHANGE_BAUD, Origin.CONFIRMATION, port.clock())
        journal = port.journal()
        change = change_baud(rate, journal, permit=permit, armed=self._services.armed)
        self._doubtful_since = None
        self._job.run(change, partial(self._end, rate, permit))

    def _end(self, rate: int, permit: Permit, job: Job[BaudChanged]) -> None:
        self.editor.show_value(None, None)
        if job.run.error is not None and not permit.is_spent:
            self._job.set_notice(not_begun())
        elif job.run.error is not None:
            self._doubtful_since = self._connector.clock()
            self._job.notify(
                Meaning.DANGER,
                tr("Interrupted: maybe at {rate} baud now.", rate=rate),
            )
        else:
            self._job.set_notice_of_now(partial(self._ended, job.outcome(), self._connector.current.conversation))

    def _ended(self, changed: BaudChanged, said_in: tuple[int, int]) -> Notice | None:
        """What the module and the port are at is said no longer once another module may be there."""
        port = self._connector.current
        if changed.end in _AS_IT_STANDS and not (port.is_open and port.conversation == said_in):
            return None
        meaning = {
            BaudEnd.CHANGED: Meaning.GOOD,
            BaudEnd.LOST: Meaning.DANGER,
            BaudEnd.ELSEWHERE: Meaning.DANGER,
        }.get(changed.end, Meaning.ATTENTION)
        find: tuple[Choice, ...] = ()
        if changed.end is BaudEnd.LOST:
            find = (Choice("find_lost", tr("Find the baud rate"), self._connector.find_rate, is_main=True),)
        return Notice(meaning, changed.sentence, find, self._job.dismiss)

    def _end_doubt(self) -> None:
        """Once the same module answers, its rate is known."""
        port, since = self._connector.current, self._doubtful_since
        known = port.device.known("baud_rate", port.clock())
        if since is None or known is None or known.is_stale or known.at <= since or not port.identity.is_settled:
            return
        self._doubtful_since = None
        rate = int(known.value)
        self._job.notify(Meaning.INFORMATION, tr("The module answers at {rate} baud.", rate=rate))

    def _lay_out(self) -> None:
        stacked(self._message, self._warning, self.conditions, self.notice_bar)
        row = in_row(*aligned_cells(self.title, self.value_label, self.editor), 1, spacing=CELL_GAP)
        self._below = in_row((self._message, 1), self.confirm, spacing=CELL_GAP)
        in_column(row, self._below, of=self, spacing=0, margins=(Space.S, Space.XS))

    def fold(self, *, is_narrow: bool) -> None:
        """What it says lies beside its button, or above it."""
        direction = QBoxLayout.Direction
        self._below.setDirection(direction.TopToBottom if is_narrow else direction.LeftToRight)


CLOSED, OPEN = "closed", "open"


class CalibrationPanel(QWidget):
    """`proposed` carries the accepted threshold in volts, which becomes an edit like any other."""

    proposed = Signal(float)
    closed = Signal()

    def __init__(self, services: Services) -> None:
        super().__init__()
        self.setObjectName("calibration_panel")
        self._bands: dict[str, Band] = {}
        self._conversation: object = None
        """In which the last one was measured."""
        self._connector = services.ports
        self._job = RunningJob(services.ports, self)
        self._measuring = ""
        self._is_link_lost = False
        self._title = text_label("calibration_title", "title")
        self._intro = text_label("calibration_intro", "muted")
        self.sides = {
            CLOSED: _Side(CLOSED, 1, tr("Bay closed"), Icon.BAY_CLOSED),
            OPEN: _Side(OPEN, 2, tr("Bay open"), Icon.BAY_OPEN),
        }
        for name, side in self.sides.items():
            side.button.clicked.connect(partial(self._measure, name))
        self._title.setText(tr("Measure the light threshold"))
        self._intro.setText(tr("Measure in the light of the flight day, with no hand over the sensor."))
        self.result = text_label("calibration_result", "strong")
        self.detail = text_label("calibration_detail", "small")
        self.take = control(
            QPushButton(tr("Use this threshold")), "calibration_take", role="primary", slot=self._use_proposal
        )
        self.back = control(QPushButton(tr("Back")), "calibration_back", key="Esc", slot=self.close_panel)
        self._lay_out()
        for is_over in (services.ports.invalidated, services.ports.broke_in_doubt):
            is_over.connect(self._reset)
        self._job.changed.connect(self.refresh)

    @property
    def proposal(self) -> Proposal | CalibrationFault | None:
        if len(self._bands) < len(self.sides):
            return None
        return propose(self._bands[CLOSED], self._bands[OPEN])

    def begin(self) -> None:
        self._reset()
        self.sides[CLOSED].button.setFocus()

    def close_panel(self) -> None:
        self._job.cancel()
        self._job.drop()
        self.closed.emit()

    def _reset(self) -> None:
        self._bands.clear()
        self._is_link_lost = False

    def refresh(self) -> None:
        for name, side in self.sides.items():
            side.button.setEnabled(self._job.can_run)
            side.text.setText(self._side_text(name))
        proposal = self.proposal
        self.take.setEnabled(isinstance(proposal, Proposal))
        match proposal:
            case Proposal():
                self.result.setText(proposal.sentence)
                parts = [
                    tr(proposal.direction.value),
                    tr("Vendor advises: {advice}.", advice=f"{proposal.vendors_v:.1f} V"),
                ]
                if not proposal.is_steady:
                    parts.append(tr("The readings scatter: measure again in steady light."))
                self.detail.setText(join_sentences(parts))
            case CalibrationFault():
                self.result.setText(tr(proposal.value))
                self.detail.setText("")
            case _:
                self.result.setText("")
                self.detail.setText(tr("Link lost.") if self._is_link_lost else "")

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
            before, self._conversation = self._conversation, self._connector.current.conversation
            if before != self._conversation:  # another module may have taken its place
                self._bands.clear()
            self._bands.pop(name, None)
            self._job.run(measure_light(), partial(self._end, name))

    def _end(self, name: str, job: Job[Band]) -> None:
        if job.run.error is None:
            self._bands[name] = job.outcome()
            if isinstance(self.proposal, Proposal):
                self._connector.current.keep_light_direction(self.proposal.direction)
            if name == CLOSED:
                self.sides[OPEN].button.setFocus()
        else:
            self._is_link_lost = True

    def _use_proposal(self) -> None:
        proposal = self.proposal
        if isinstance(proposal, Proposal):
            self.proposed.emit(proposal.threshold_v)

    def _lay_out(self) -> None:
        sides = in_row(*((side, 1) for side in self.sides.values()), spacing=Space.M)
        words = in_column(self._title, self._intro, sides, Gap(Space.S), self.result, self.detail, spacing=Space.S)
        foot = in_row(1, self.back, self.take, spacing=Space.S)
        in_column(words, 1, foot, of=self, spacing=Space.S, margins=(Space.M, Space.M, Space.M, Space.S))


class _Side(QFrame):
    def __init__(self, name: str, number: int, title: str, picture: Icon) -> None:
        super().__init__()
        named(self, f"calibration_{name}", "card")
        self.title = named(QLabel(f"{number}. {title}"), f"calibration_{name}_title", "strong")
        self.text = text_label(f"calibration_{name}_text")
        self.button = control(QPushButton(tr("Measure")), f"calibration_{name}_measure", picture=picture)
        self.button.setAccessibleName(labelled(title, tr("Measure")))
        set_icon_size(self.button, 20, gap_px=TEXT_GAP_PX)
        in_column(
            self.title, self.text, (self.button, Qt.AlignmentFlag.AlignLeft), of=self, spacing=Space.S, margins=Space.M
        )
