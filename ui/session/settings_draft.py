"""The settings of one module as a person edits them: drafts, the running write and what came of it, the profile that is
compared, the calibration of the light threshold.

Everything ends with the conversation. What was written by then stays as a report of the port, and what was not written
as an offer to take it over; see `Interruptions`.
"""

from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from functools import partial

from PySide6.QtCore import QObject, Signal

from app.engine.procedure import Cancelled, Job
from app.procedures.act import Armed
from app.procedures.light import Band, CalibrationFault, Proposal, measure_light, propose
from app.procedures.read import READABLE, Readings, read_everything
from app.procedures.write import SettingChange, WriteContext, WriteFault, WriteReport, risk_message, write_all
from app.safety.permit import Interlock
from app.settings.form import FORM_COMMANDS, FormRow, ProfileRow, SettingsForm, compare, is_confirmed
from app.settings.profiles import Profile
from app.settings.values import value_text
from app.text.i18n import tr
from app.text.messages import join_names, join_sentences, joined, message
from protocol.catalogue import Command
from protocol.fields import Value
from protocol.translatable import marked
from ui.session.shown_module import Remainder, ShownModule
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


class Side(Enum):
    """The position of the bay while the light is measured."""

    CLOSED = "closed"
    OPEN = "open"


class SettingsDraft(QObject):
    # A draft, a running job, the notice or a panel is otherwise.
    changed = Signal()

    def __init__(self, module: ShownModule) -> None:
        super().__init__(module)
        self._module = module
        self.form = SettingsForm()
        # While a profile is compared: it, and what a person ticked or unticked, by the setting's key.
        self.comparison: Profile | None = None
        self._ticks: dict[str, bool] = {}
        # While the light threshold is calibrated: what was measured so far.
        self.bands: dict[Side, Band] | None = None
        self.measuring: Side | None = None
        self.job = module.job("settings")
        self.measure_job = module.job("calibration")
        self.job.changed.connect(self.changed)
        self.measure_job.changed.connect(self.changed)
        module.ended.connect(self._on_ended)

    # What is known

    @property
    def rows(self) -> tuple[FormRow, ...]:
        return self.form.rows(self._module.view, self._module.now_s)

    @property
    def changes(self) -> tuple[SettingChange, ...]:
        """What Write would send."""
        return self.form.changes(self._module.view, self._module.now_s)

    @property
    def can_edit(self) -> bool:
        return self._module.is_going and not self.form.is_writing

    def count_unsent(self) -> int:
        """Edits that leaving the module would lose. Those of an ended conversation are kept with its port."""
        return self.form.count_unsent(self._module.view, self._module.now_s) if self._module.is_going else 0

    def beside(self, remainder: Remainder) -> str:
        """Edits of an ended conversation beside what the module holds now: "Free-fall time 1.60 s → 1.20 s"."""
        texts = []
        for command in FORM_COMMANDS:
            held = self._module.view.fresh(command.key, self._module.now_s)
            wanted = remainder.mistyped.get(command.key, "")
            if remainder.drafts is not None and command.key in remainder.drafts:
                wanted = value_text(command, remainder.drafts[command.key])
            if wanted:
                values = wanted if held is None else f"{value_text(command, held)} → {wanted}"
                texts.append(f"{tr(command.title)} {values}")
        return join_names(texts)

    def notice(self) -> Notice | None:
        """Progress, a question or a result; else why nothing can be written."""
        notice = self.job.notice(marked("Asking the module…"))
        mistyped = [command for command in FORM_COMMANDS if command.key in self.form.mistyped]
        if notice is not None or not mistyped or not self._module.is_going:
            return notice
        text = tr("Nothing can be written until this is corrected: {names}.", names=_titles(mistyped))
        return Notice(Meaning.ATTENTION, text)

    # Editing

    def choose(self, key: str, value: Value) -> None:
        self.fill({key: value})

    def fill(self, values: Mapping[str, Value]) -> None:
        """Edit all of these; nothing is sent."""
        self._edit(partial(self.form.fill, values))

    def mistype(self, key: str, text: str) -> None:
        self._edit(partial(self.form.mistype, key, text))

    def revert(self, key: str | None = None) -> None:
        self._edit(partial(self.form.revert, key))

    def take_over(self, remainder: Remainder) -> None:
        """The edits of an ended conversation, also what stood in a field and cannot be sent."""
        self.fill(remainder.drafts or {})
        for key, text in remainder.mistyped.items():
            self.mistype(key, text)

    def _edit(self, act: Callable[[], object]) -> None:
        if self.can_edit:
            act()
            self.job.dismiss()  # what was said last no longer holds

    # The profile that is compared

    def compare_with(self, profile: Profile) -> None:
        self.comparison, self._ticks = profile, {}
        self.changed.emit()

    def compared(self) -> list[tuple[ProfileRow, bool]]:
        """Each setting, and whether it is to be written: at first where the module's differs, or is not known."""
        if self.comparison is None:
            return []
        compared = []
        for row in compare(self.comparison, self._module.view, self._module.now_s):
            is_ticked = self._ticks.get(row.command.key, row.is_worth_applying)
            compared.append((row, is_ticked and row.target is not None and row.command in FORM_COMMANDS))
        return compared

    def tick(self, key: str, is_ticked: bool) -> None:
        self._ticks[key] = is_ticked
        self.changed.emit()

    def write_ticked(self, armed: Armed) -> None:
        """Write what is ticked of the profile. Other edits were not ticked, nor even shown: they stay edits."""
        ticked: dict[str, Value] = {}
        for row, is_ticked in self.compared():
            if is_ticked and row.target is not None:
                ticked[row.command.key] = row.target
        self.close_panels()
        self.fill(ticked)
        self._write([change for change in self.changes if change.command.key in ticked], armed)

    # The calibration of the light threshold

    def calibrate(self) -> None:
        self.close_panels()
        self.bands = {}
        self.changed.emit()

    def measure(self, side: Side) -> None:
        """In place of what was measured of this side before."""
        if self.bands is not None and self.measure_job.can_run:
            self.bands.pop(side, None)
            self.measuring = side
            self.measure_job.run(measure_light(), partial(self._end_measuring, side))

    @property
    def proposal(self) -> Proposal | CalibrationFault | None:
        """None until both sides are measured."""
        if self.bands is None or len(self.bands) < len(Side):
            return None
        return propose(self.bands[Side.CLOSED], self.bands[Side.OPEN])

    def _end_measuring(self, side: Side, job: Job[Band]) -> None:
        self.measuring = None
        if self.bands is None or job.error is not None:
            return
        self.bands[side] = job.outcome()
        proposal = self.proposal
        if isinstance(proposal, Proposal):
            self._module.light_direction = proposal.direction

    def close_panels(self) -> None:
        self.measure_job.cancel()
        self.measure_job.drop()
        self.comparison = self.bands = self.measuring = None
        self.changed.emit()

    # Reading and writing

    def read_all(self) -> None:
        if self.job.can_run:
            self.job.run(read_everything(), self._end_reading)

    def _end_reading(self, job: Job[Readings]) -> None:
        if job.error is not None:
            self._say_ended(job.error)
            return
        missing = [command for command in READABLE if command.key in job.outcome().errors]
        if missing:
            text = tr("Could not read: {names}. Read again or check the wiring.", names=_titles(missing))
            again = Choice("read_again", tr("Read all"), self.read_all)
            self.job.set_notice(Notice(Meaning.ATTENTION, text, (again,), self.job.dismiss))

    def write(self, armed: Armed, note: str = "") -> None:
        """Write all edits and verify each, unless something stands in a field that cannot be sent."""
        if not self.form.mistyped:
            self._write(self.changes, armed, note=note)

    def _write(
        self,
        changes: Sequence[SettingChange],
        armed: Armed,
        *,
        note: str = "",
        accepted: frozenset[SettingChange] = frozenset(),
        is_unlocked: bool = False,
    ) -> None:
        """`note`: who writes, and why; `accepted`: the changes whose risk was accepted; `is_unlocked`: although the
        module is ACTIVE. The procedure refuses what a person has to accept first."""
        if not changes or not self.job.can_run:
            return
        context = WriteContext(
            journal=self._module.journal,
            armed=armed,
            is_unlocked=is_unlocked,
            accepted_risks=accepted,
            keep_as_found=self._module.keep_as_found(),
            note=note,
        )
        again = partial(self._write, changes, armed, note=note, accepted=accepted, is_unlocked=is_unlocked)
        self.form.begin_write(changes)
        self.job.run(write_all(changes, context), partial(self._end_writing, changes, again))

    def _end_writing(self, changes: Sequence[SettingChange], again: Callable[..., None], job: Job[WriteReport]) -> None:
        # One that ended with an error had not begun.
        report = WriteReport(results=()) if job.error is not None else job.outcome()
        self.form.on_written(report.results, self._module.view, self._module.now_s)
        if not self._module.is_going:
            self._keep_interrupted(report)
        elif job.error is not None:
            self._say_ended(job.error)
        elif report.is_cancelled:
            # So that the rows show what the module holds now.
            text = join_sentences((tr("Cancelled."), _written_notice(report).text))
            self.job.run(read_everything(), lambda _read: self.job.notify(Meaning.ATTENTION, text))
        elif not report.is_refused:
            self.job.set_notice(_written_notice(report))
        else:
            conditions = {refusal.condition for refusal in report.refusals}
            is_risk, is_active = conditions == {Interlock.RISK_ACCEPTED}, conditions == {Interlock.MAY_WRITE}
            # The buttons of the two questions never share a place, so each keeps its own while it is hidden.
            anyway, unlocked = partial(again, accepted=frozenset(changes)), partial(again, is_unlocked=True)
            choices = (
                Choice("not_now", tr("Cancel"), self.job.dismiss),
                Choice("write_anyway", tr("Write anyway"), anyway, is_step=True, is_shown=is_risk),
                Choice("unlock_once", tr("Unlock this one write"), unlocked, is_step=True, is_shown=is_active),
            )
            risk = risk_message(changes) if is_risk else None
            text = join_sentences((tr("Nothing was written."), *(refusal.sentence for refusal in report.refusals)))
            text = text if risk is None else risk.translated()
            self.job.set_notice(Notice(Meaning.ATTENTION, text, choices if is_risk or is_active else ()))

    def _say_ended(self, error: BaseException) -> None:
        """Why the conversation ended is a notice of the port."""
        if isinstance(error, Cancelled):
            self.job.notify(Meaning.INFORMATION, tr("Cancelled."))
        elif self._module.is_going:
            self.job.notify(Meaning.DANGER, str(error))

    # The end of the conversation

    def _on_ended(self) -> None:
        self.job.dismiss()
        self.close_panels()
        if not self.form.is_writing:  # else the end of the write knows better what was written
            self._keep_interrupted(WriteReport(results=()))

    def _keep_interrupted(self, report: WriteReport) -> None:
        """What became of each setting: "Tilt threshold: verified then, before the interruption"; and what the module
        did not have."""
        told = []
        for written in report.results:
            why = marked("verified") if written.fault is None else written.fault.value
            if written.fault is WriteFault.INTERRUPTED:
                why = marked("unknown")  # why it was interrupted stands above
            told.append(message(marked("{name}: {value}"), name=message(written.command.title), value=message(why)))
        if told:
            self._module.keep_report(joined(told))
        drafts = {
            command.key: self.form.edited[command.key]
            for command in FORM_COMMANDS
            if command.key in self.form.edited
            and not is_confirmed(command, self._module.view.values.get(command.key), self.form.edited[command.key])
        }
        if drafts or self.form.mistyped:
            self._module.keep_drafts(drafts, self.form.mistyped)


def _titles(commands: Sequence[Command]) -> str:
    return join_names(tr(command.title) for command in commands)


def _written_notice(report: WriteReport) -> Notice:
    verified = sum(1 for written in report.results if written.verified)
    acknowledged = sum(1 for written in report.results if written.is_fine and written.verified is None)
    bad = [written.command for written in report.results if not written.is_fine]
    changed = [] if report.changed is None else [report.changed.after.command]
    parts = (
        tr("Read back as written: {count}.", count=verified) if verified else "",
        tr("Acknowledged, cannot be read: {count}.", count=acknowledged) if acknowledged else "",
        tr("Not verified: {names}.", names=_titles(bad)) if bad else "",
        tr("Changed without being written: {names}.", names=_titles(changed)) if changed else "",
        tr("Not read back: {names}.", names=_titles(report.unread)) if report.unread else "",
        *(refusal.sentence for refusal in report.refusals),
    )
    meaning = Meaning.GOOD if verified else Meaning.INFORMATION
    return Notice(meaning if report.is_fine else Meaning.DANGER, join_sentences(parts))
