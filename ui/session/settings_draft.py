"""The settings of one module as a person edits them: drafts, the running write and what came of it.

Everything ends with the conversation. What was written by then stays as a report of the port, and what was not written
as an offer to take it over; see `Interruptions`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

from PySide6.QtCore import QObject

from app.engine.procedure import Cancelled, Job
from app.procedures.act import Armed
from app.procedures.read import READABLE, Readings, read_everything
from app.procedures.write import SettingChange, WriteContext, WriteFault, WriteReport, risk_message, write_all
from app.safety.permit import Interlock
from app.settings.form import FORM_COMMANDS, SettingDraft
from app.settings.values import value_text
from app.text.i18n import tr
from app.text.messages import join_names, join_sentences, joined, message
from protocol.catalogue import Command
from protocol.fields import Value
from protocol.translatable import marked
from ui.session.shown_module import Remainder, ShownModule
from ui.style.theme import Meaning
from ui.widgets.notices import Choice, Notice


class SettingsDraft(QObject):
    # A QObject, so that Qt itself ends the connection when it goes with its module.
    def __init__(self, module: ShownModule) -> None:
        super().__init__(module)
        self._module = module
        # By the setting's key, in the order of the rows.
        self.drafts = {command.key: SettingDraft(command) for command in FORM_COMMANDS}
        self.job = module.job("settings")
        self._writes = module.last_writes()
        module.named.connect(self._ask_for_writes)
        module.ended.connect(self._on_ended)

    # What is wanted

    @property
    def rows(self) -> tuple[SettingDraft, ...]:
        """The rows, with what the module says of each now."""
        for draft in self.drafts.values():
            draft.take(self._module.view.known(draft.command.key, self._module.now_s))
        return tuple(self.drafts.values())

    @property
    def changes(self) -> list[SettingChange]:
        """The changes that Write would send."""
        pending = ((draft.command, draft.pending) for draft in self.rows)
        return [SettingChange(command, value) for command, value in pending if value is not None]

    @property
    def wanted(self) -> dict[str, Value | str]:
        """The edits by the setting's key; text is what was typed and cannot be sent."""
        return {key: draft.wanted for key, draft in self.drafts.items() if draft.wanted is not None}

    @property
    def impossible(self) -> list[Command]:
        return [draft.command for draft in self.drafts.values() if isinstance(draft.wanted, str)]

    @property
    def is_writing(self) -> bool:
        return any(draft.is_writing for draft in self.drafts.values())

    @property
    def can_edit(self) -> bool:
        return self._module.is_going and not self.is_writing

    def count_unsent(self) -> int:
        """Edits that leaving the module would lose. Those of an ended conversation are kept with its port."""
        if not self._module.is_going:
            return 0
        return sum(draft.is_writing or draft.unsent is not None for draft in self.rows)

    def last_write(self, key: str) -> str:
        """When and by whom it was last written, from what to what; "" where that is not known, or not yet."""
        asked = self._writes
        if asked is None or not asked.done() or asked.cancelled() or asked.exception() is not None:
            return ""
        told = asked.result().get(key)
        return "" if told is None else told.translated()

    def _ask_for_writes(self) -> None:
        self._writes = self._module.last_writes()

    def fill(self, values: Mapping[str, Value | str | None]) -> None:
        """Edit all of these, by the setting's key; None discards an edit, and nothing is sent."""
        if self.can_edit:
            for key, value in values.items():
                if key in self.drafts:  # what is no row, such as the baud rate of a profile, is left out
                    self.drafts[key].want(value)
            self.job.dismiss()  # what was said last no longer holds

    def revert(self) -> None:
        self.fill(dict.fromkeys(self.drafts))

    def beside(self, remainder: Remainder) -> str:
        """Edits of an ended conversation beside what the module holds now: "Free-fall time 1.60 s → 1.20 s"."""
        texts = []
        for key, wanted in (remainder.drafts or {}).items():
            command, held = self.drafts[key].command, self._module.view.fresh(key, self._module.now_s)
            text = wanted if isinstance(wanted, str) else value_text(command, wanted)
            values = text if held is None else f"{value_text(command, held)} → {text}"
            texts.append(f"{tr(command.title)} {values}")
        return join_names(texts)

    @property
    def notices(self) -> list[Notice]:
        """Progress, a question or a result; and why nothing can be written."""
        notices = self.job.notices
        if self.impossible and self._module.is_going:
            text = tr("Nothing can be written until this is corrected: {names}.", names=_titles(self.impossible))
            notices.append(Notice(Meaning.ATTENTION, text, cause="impossible"))
        return notices

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

    def write(self, armed: Armed, note: str = "", *, ticked: Mapping[str, Value] | None = None) -> None:
        """Write all edits and verify each, unless something stands in a field that cannot be sent; or what is `ticked`
        of a profile: other edits were not even shown, and stay edits. `note`: who writes, and why."""
        if ticked is not None:
            self.fill(ticked)
        if ticked is not None or not self.impossible:
            changes = [one for one in self.changes if ticked is None or one.command.key in ticked]
            self._write(changes, WriteContext(journal=self._module.journal, armed=armed, note=note))

    def _write(self, changes: Sequence[SettingChange], context: WriteContext) -> None:
        """The procedure refuses what a person has to accept first."""
        if changes and self.job.can_run:
            for change in changes:
                draft = self.drafts[change.command.key]
                draft.is_writing, draft.result = True, None
            context = replace(context, keep_as_found=self._module.keep_as_found())
            self.job.run(write_all(changes, context), partial(self._end_writing, changes, context))

    def _end_writing(self, changes: Sequence[SettingChange], context: WriteContext, job: Job[WriteReport]) -> None:
        # One that ended with an error had not begun.
        report = WriteReport(results=()) if job.error is not None else job.outcome()
        results = {written.command.key: written for written in report.results}
        for key, draft in self.drafts.items():
            draft.end_write(results.get(key), self._module.view.known(key, self._module.now_s))
        self._ask_for_writes()
        if report.results and self._module.is_going:
            self._module.keep()  # else the next question for its name would hold our own writing against it
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
            anyway = partial(self._write, changes, replace(context, accepted_risks=frozenset(changes)))
            unlocked = partial(self._write, changes, replace(context, is_unlocked=True))
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
        if not self.is_writing:  # else the end of the write knows better what was written
            self._keep_interrupted(WriteReport(results=()))

    def _keep_interrupted(self, report: WriteReport) -> None:
        """Keep what became of each setting ("Tilt threshold: verified then, before the interruption"), and what the
        module did not have."""
        told = []
        for written in report.results:
            why = marked("verified") if written.fault is None else written.fault.value
            if written.fault is WriteFault.INTERRUPTED:
                why = marked("unknown")  # why it was interrupted stands above
            told.append(message(marked("{name}: {value}"), name=message(written.command.title), value=message(why)))
        if told:
            self._module.keep_report(joined(told))
        for key, draft in self.drafts.items():
            draft.take(self._module.view.values.get(key))  # what it had said by then, although that is stale now
        drafts = {key: draft.unsent for key, draft in self.drafts.items() if draft.unsent is not None}
        if drafts:
            self._module.keep_drafts(drafts)


def _titles(commands: Sequence[Command]) -> str:
    return join_names(tr(command.title) for command in commands)


def _written_notice(report: WriteReport) -> Notice:
    verified = sum(1 for written in report.results if written.verified)
    acknowledged = sum(1 for written in report.results if written.fault is None and written.verified is None)
    bad = [written.command for written in report.results if written.fault is not None]
    parts = (
        tr("Read back as written: {count}.", count=verified) if verified else "",
        tr("Acknowledged, cannot be read: {count}.", count=acknowledged) if acknowledged else "",
        tr("Not verified: {names}.", names=_titles(bad)) if bad else "",
        *(refusal.sentence for refusal in report.refusals),
    )
    meaning = Meaning.GOOD if verified else Meaning.INFORMATION
    return Notice(meaning if report.is_fine else Meaning.DANGER, join_sentences(parts))
