"""Row of one dangerous act: description, unmet conditions, confirmation, outcome."""

from dataclasses import replace
from functools import partial
from typing import Final

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFontMetrics
from PySide6.QtWidgets import QFrame, QLabel, QStackedLayout, QWidget

from app.engine.procedure import Job
from app.engine.target import is_socket
from app.fleet.card import Need
from app.procedures.act import Performed, perform
from app.safety.journal import EFFECTS, TITLES, Act, Outcome
from app.safety.permit import Interlock, Origin, Permit, Refusal, inputs_at, refusals
from app.text.i18n import tr
from app.text.messages import UserMessage, duration, join_names, labelled
from protocol.translatable import marked
from ui.acts.confirm import Confirm
from ui.services.context import Services
from ui.session.page_job import PageJob
from ui.session.shown_module import ShownModule
from ui.style.theme import Meaning, Space, font
from ui.widgets.controls import ElidedLabel, in_column, in_row, named, retain_size, stacked, text_label
from ui.widgets.notice_bar import NoticeBar

# Without a module, or with perhaps another one, all other conditions follow from that.
_FIRST: Final = (Interlock.ONLINE, Interlock.NOT_SHARED, Interlock.LINE_IS_QUICK)


def open_conditions(services: Services, act: Act) -> list[Refusal]:
    """Open conditions of `act`, apart from the person's confirmation, which is what they are about to do."""
    port, module = services.ports.current, services.ports.module
    if not port.is_open:
        return [Refusal(Interlock.ONLINE, UserMessage(marked("Not connected")))]
    inputs = replace(
        inputs_at(module.view, port.now_s),
        armed=services.armed.act,
        is_audit_ready=module.journal.is_ready,
        sets_rate=not is_socket(port.connection.port),
    )
    asked_anyway = (Interlock.CONFIRMED, Interlock.RITUAL_DONE)
    return [refusal for refusal in refusals(act, inputs) if refusal.condition not in asked_anyway]


def is_blocked(open_ones: list[Refusal]) -> bool:
    """An old status does not disable a button: the procedure asks for a new one before it decides."""
    return any(refusal.condition is not Interlock.FRESH_STATUS for refusal in open_ones)


def say_outcome(job: PageJob, module: ShownModule, done: Performed | None) -> None:
    """Say it on the module's own page; what left and was interrupted stays as a notice of the port, too: the next
    conversation shows nothing of this one."""
    if done is None:
        job.notify(Meaning.ATTENTION, tr("Link lost. Nothing was sent."))
        return
    job.notify(outcome_meaning(done), done.sentence)
    if done.interrupted is not None and done.outcome is not Outcome.NOT_SENT:
        module.keep_report(UserMessage(labelled(tr(TITLES[done.act]), done.sentence)))


def outcome_meaning(done: Performed) -> Meaning:
    if done.outcome is Outcome.UNKNOWN or (done.outcome is Outcome.CONFIRMED and done.act is Act.DEPLOY):
        return Meaning.DANGER
    is_hot = done.act is Act.ACTIVATE or (done.act is Act.ZERO and not done.is_level)
    return Meaning.GOOD if done.outcome is Outcome.CONFIRMED and not is_hot else Meaning.ATTENTION


class ActRow(QFrame):
    """`refresh` updates the open conditions. `place` distinguishes rows of the same act on several pages."""

    # The act was confirmed and is being sent; then its `Performed`, None if the connection was lost before.
    begun = Signal()
    ended = Signal(object)

    def __init__(self, services: Services, act: Act, *, place: str = "act") -> None:
        super().__init__()
        name = f"{place}_{act.value}"
        named(self, name, "row")
        self.act = act
        self._services, self._ports = services, services.ports
        self._performed: Performed | None = None
        title = named(QLabel(tr(TITLES[act])), f"{name}_title", "strong")
        self._effect = text_label(f"{name}_effect", "small", tr(EFFECTS[act]))
        self.live = named(ElidedLabel(), f"{name}_live", "small")
        # On Pre-flight the verdict stands above.
        self.live.setVisible(act is Act.ACTIVATE and place == "act")
        self.conditions = text_label(f"{name}_conditions", "attention")
        self.confirm = Confirm(name, ask=f"{TITLES[act]}…", go=TITLES[act])
        self.notice_bar = named(NoticeBar(), f"{name}_said")
        # Stacked, each as high as the other, so that neither a reason nor a notice changes the height of the row.
        self._place, self._words, self._reasons = QStackedLayout(), QWidget(), QStackedLayout()
        for part in (self._effect, self.conditions, self._words, self.notice_bar):
            retain_size(part)
        for label in (self._effect, self.conditions):
            label.setAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop)
        stacked(self._reasons, self._effect, self.conditions)
        in_column(in_row(title, (self.live, 1), spacing=Space.M), self._reasons, of=self._words, spacing=2, margins=0)
        self._words.setMinimumHeight(2 * QFontMetrics(font()).lineSpacing() + Space.M)  # that of a notice
        stacked(self._place, self._words, self.notice_bar)
        in_row((self._place, 1), self.confirm, of=self, spacing=Space.L, margins=(Space.M, Space.XS))
        self.confirm.confirmed.connect(self._perform)
        self.confirm.asked.connect(self._dismiss)
        self._ports.shown.connect(self._on_shown)

    @property
    def _job(self) -> PageJob:
        """The job of the module shown; what came of it is shown on no other."""
        return self._ports.module.job(self.objectName())

    def _on_shown(self, _module: ShownModule) -> None:
        self._performed = None
        self.confirm.withdraw()
        self.refresh()

    def refresh(self) -> None:
        module, done = self._ports.module, self._performed
        if done is not None and done.act is Act.ACTIVATE:
            # What was said of an activation is no longer true: it was confirmed, and the module reports that it is not
            # active any more; or it is unknown, and the module was locked since.
            is_over = done.outcome is Outcome.UNKNOWN and self._ports.current.lock.is_reported
            if done.outcome is Outcome.CONFIRMED:
                is_over = module.view.fresh("active", module.now_s) is not True
            if is_over:
                self._dismiss()
        open_ones = open_conditions(self._services, self.act)
        # What is armed is visible on this page; another line in each row would move the button under the hand.
        shown = [refusal for refusal in open_ones if refusal.condition is not Interlock.NOTHING_ELSE_ARMED]
        # One condition at a time: a second line would move the rows below.
        shown.sort(key=lambda refusal: refusal.condition not in _FIRST)
        self.conditions.setText(shown[0].sentence if shown else "")
        self.live.setText(_verdict_text(module))
        self.confirm.set_possible(not is_blocked(open_ones) and not self._job.is_running)
        self.notice_bar.show_notices(self._job.notices)
        self._place.setCurrentWidget(self.notice_bar if self.notice_bar.notice else self._words)
        self._reasons.setCurrentWidget(self.conditions if shown else self._effect)

    def _perform(self) -> None:
        module, act, job = self._ports.module, self.act, self._job
        permit = Permit(act, Origin.CONFIRMATION, self._ports.clock(), module.number)
        self._performed = None
        if act is Act.ACTIVATE:
            self._ports.current.lock.give_up()
        self.begun.emit()
        performing = perform(act, module.journal, permit=permit, armed=self._services.armed)
        job.run(performing, partial(self._end, job, module), can_cancel=False)

    def _end(self, running: PageJob, module: ShownModule, job: Job[Performed]) -> None:
        done = None if job.error is not None else job.outcome()
        self._performed = done
        if done is not None and done.act is Act.SHUTDOWN and done.outcome is Outcome.CONFIRMED:
            self._ports.current.note_shutdown()
        say_outcome(running, module, done)
        self.ended.emit(done)

    def _dismiss(self) -> None:
        self._performed = None
        self._job.dismiss()


def _verdict_text(module: ShownModule) -> str:
    """The last verdict of a module with its age, or why it holds no more."""
    check = module.check_state
    if check.void is not None:
        return tr(Need.VOID.value, why=check.void.message.translated())
    text = tr(check.standing.value)
    if check.ended_at is not None:
        text = join_names((text, tr("{time} ago", time=duration(module.now_s - check.ended_at))))
    return labelled(tr("Verdict"), text)
