"""Controller of the Triggers page: reads the records, merges them with the stored ones, stores judgements."""

from collections import Counter
from functools import partial
from typing import NamedTuple

from PySide6.QtCore import QObject, Signal

from app.engine.identity import Trust
from app.engine.procedure import Cancelled, TwoModules
from app.engine.worker import Job
from app.limits.past import LastAnswer
from app.preflight.module_checks import RecordsWord
from app.store.fact_store import Facts, Store, utc_now
from app.store.trouble import StoreTrouble
from app.system.wall_clock import DAY, local_time
from app.text.i18n import tr
from app.text.sentences import join_sentences, labelled
from app.text.user_error import UserError
from app.trigger_records.filing import PossiblyOther, TriggersReading, file_triggers, read_triggers, say_new
from app.trigger_records.history import Judgement, in_order, record_of
from app.trigger_records.kept import KeptTriggers, SeenRecord, Visit
from protocol.link_states import Presence
from protocol.messages import TriggerRecord
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.services.context import Services
from ui.services.module_name import not_kept
from ui.session.running_job import RunningJob
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


class TriggerRow(NamedTuple):
    """One trigger. `is_stored`: it is in the store and can be judged. `is_being_stored`: it is being stored.
    `is_seen_once`: it came in one reading only, so it is uncertain."""

    seen: SeenRecord
    record: TriggerRecord
    is_new: bool
    is_on_module: bool
    is_stored: bool
    is_seen_once: bool = False
    is_being_stored: bool = False


class TriggersController(QObject):
    """`changed`: rows, progress or notice changed."""

    changed = Signal()

    def __init__(self, services: Services, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._services, self._connector = services, services.ports
        self.rows: tuple[TriggerRow, ...] = ()
        """Oldest first."""
        self.reading: TriggersReading | None = None
        """Of the module that answers now; None before it was read, and where it may be another."""
        self.is_first_visit = True
        self._new: frozenset[int] = frozenset()
        self._is_stored = False
        self.job = RunningJob(services.ports, self)
        self.job.changed.connect(self.changed)
        self.reads_by_itself = True
        """Reads each module once as soon as the page is visible, and again when it came back or fired."""
        self._has_read = False
        self._was_settled, self._had_fired, self._breaks = True, False, 0
        self._filing: BackgroundTask[Visit | PossiblyOther] = BackgroundTask("dps-s triggers", self)
        self._wording: BackgroundTask[None] = BackgroundTask("dps-s new module", self)
        self._judging: dict[int, tuple[Judgement | None, str]] = {}
        """Judgements that are not stored yet, by record."""
        self._connector.changed.connect(self._watch_port)
        for is_over in (self._connector.came_online, self._connector.invalidated, self._connector.disconnected):
            is_over.connect(self._forget)
        self._connector.renamed.connect(self._on_name_changed)
        self._show_archive()

    @property
    def is_busy(self) -> bool:
        """Reading or storing."""
        return self.job.is_running or self._filing.is_running

    @property
    def can_read(self) -> bool:
        return self._connector.current.is_open and not self.is_busy

    def notice(self) -> Notice | None:
        return self.job.notice(marked("Reading the trigger records"))

    def read(self) -> None:
        if self.can_read:
            self.job.run(read_triggers(), self._end)

    def read_unasked(self) -> None:
        """Called while the page is visible."""
        connector = self._connector
        is_online = connector.current.is_open and connector.current.device.presence is Presence.ONLINE
        if connector.current.identity.trust is Trust.OPEN:  # what decides it is read first
            return
        if not (self.reads_by_itself and is_online and self.can_read):
            return
        if not (connector.is_busy or self._has_read):
            self._has_read = True
            self.read()

    def judge(self, record_id: int, judgement: Judgement | None, note: str, *, module: str | None = None) -> None:
        """Stores a judgement of a record of `module`, by default the shown one; a failure offers to try again."""
        store = self._store
        if store is None:
            return
        module = self._connector.current.module.name if module is None else module
        judged = self._judging[record_id] = judgement, note

        def end(offer: Notice | None = None) -> None:
            if self._judging.get(record_id) is judged:  # else it was judged again meanwhile
                del self._judging[record_id]
                if offer is not None:
                    self.job.set_notice(offer)
                self._show_archive()

        def fail(trouble: StoreTrouble) -> None:
            end(self._offer_to_judge_again(trouble, module, record_id, judged))

        work = partial(_judge, module=module, place=record_id, judgement=judgement, note=note)
        keeper: BackgroundTask[None] = BackgroundTask("dps-s judgement", self, for_once=True)
        keeper.run_in(store, work, lambda _none: end(), fail)
        self._show_archive()

    @property
    def _store(self) -> Store | None:
        store = self._services.storage.store
        return store if isinstance(store, Store) else None

    def _end(self, job: Job[TriggersReading]) -> None:
        if job.run.error is not None:
            if isinstance(job.run.error, UserError):
                self._forget()
            is_cancelled = isinstance(job.run.error, Cancelled) and not isinstance(job.run.error, TwoModules)
            meaning = Meaning.INFORMATION if is_cancelled else Meaning.DANGER
            self.job.notify(meaning, _broken_off(job.run.error))
        elif job.outcome().history.is_line_dead:
            self._clear_visit()
            self.reading = job.outcome()
            self._show_archive()
            self.job.notify(Meaning.DANGER, join_sentences((tr("The module does not answer."), tr("Not kept."))))
        else:
            self.reading = job.outcome()
            self._store_reading()

    def _store_reading(self, *, is_same_module: bool = False) -> None:
        """Stores the reading if the module has a name."""
        reading, store, name = self.reading, self._store, self._connector.current.module.name
        self._clear_visit()
        if reading is not None and reading.history.is_answered and store is not None and name:
            self.job.dismiss()
            port = self._connector.current
            work = partial(
                file_triggers, reading=reading, name=name, adapter=port.module.adapter, port=port.connection.port,
                is_same_module=is_same_module, is_compared=True,
            )  # fmt: skip
            self._filing.run_in(store, work, self._end_filing, partial(self._fail_filing, name))
        if reading is not None and not reading.history.is_confirmed:
            self.job.notify(Meaning.ATTENTION, tr("The readings differ: records may be missing. Read again."))
        if reading is not None and not reading.history.is_answered:
            self.job.set_notice_of_now(self._silent_notice)
        self._show_archive()

    def _clear_visit(self) -> None:
        self._filing.cancel()
        self._is_stored, self._new = False, frozenset()

    def _end_filing(self, filed: Visit | PossiblyOther) -> None:
        if isinstance(filed, PossiblyOther):
            self.job.set_notice(self._ask_which_module())
        else:
            self._is_stored, self.is_first_visit, self._new = True, filed.new is None, filed.new or frozenset()
        self._show_archive()

    def _fail_filing(self, name: str, trouble: StoreTrouble) -> None:
        self.job.notify(Meaning.DANGER, not_kept(trouble, name))
        self._show_archive()

    def _silent_notice(self) -> Notice:
        """The module does not answer the query; a person can say once that a named one is new."""
        text = tr("No answer: the records are unknown.")
        store, name = self._store, self._connector.current.module.name
        plain = Notice(Meaning.ATTENTION, text, dismiss=self.job.dismiss)
        if store is None or not name:
            return plain
        try:
            last_answer, is_said_new = store.read(lambda facts: _answers(facts, name))
        except StoreTrouble as trouble:
            return Notice(Meaning.DANGER, not_kept(trouble, name))
        if last_answer is not None:
            had = tr("It had {count} on {date}.", count=last_answer.count, date=local_time(last_answer.at, DAY))
            return plain._replace(text=join_sentences((text, had)))
        if is_said_new:
            sentence = join_sentences((text, tr("A person said that it is new.")))
            return Notice(Meaning.INFORMATION, sentence)
        if self._connector.current.device.reported[0] is not False:
            return plain
        words = labelled(tr(RecordsWord.NEW_MODULE.value), name)
        return plain._replace(choices=(Choice("say_new", words, partial(self._say_new, name)),))

    def _say_new(self, name: str) -> None:
        store = self._store
        if store is not None:
            self._wording.run_in(
                store, partial(say_new, names=[name]), lambda _none: self.changed.emit(),
                partial(self._fail_filing, name),
            )  # fmt: skip

    def _ask_which_module(self) -> Notice:
        module = self._connector.current.module
        name = module.name
        text = tr("The records do not follow those of {module}: is it the same module?", module=name)
        choices = (
            Choice("another_module", tr("New module"), module.treat_as_new, is_step=True),
            Choice("same_module", tr("It is {module}", module=name), self._store_anyway, is_step=True),
        )
        return Notice(Meaning.ATTENTION, text, choices)

    def _store_anyway(self) -> None:
        self.job.dismiss()
        self._store_reading(is_same_module=True)

    def _offer_to_judge_again(
        self, trouble: StoreTrouble, module: str, record_id: int, judged: tuple[Judgement | None, str]
    ) -> Notice:
        def again() -> None:
            self.job.dismiss()
            self.judge(record_id, *judged, module=module)

        choices = (Choice("judge_again", tr("Try again"), again),)
        return Notice(Meaning.DANGER, not_kept(trouble, module), choices, dismiss=self.job.dismiss)

    def _on_name_changed(self) -> None:
        """The reading belongs to that name, unless a module without one may have been exchanged since: while a port is
        lost, a name is of the one that is plugged in next."""
        self.job.dismiss()
        port = self._connector.current
        if self.reading is not None and not (port.is_open and self.reading.breaks == port.device.breaks):
            self._forget()
        else:
            self._store_reading()

    def _watch_port(self) -> None:
        port = self._connector.current
        is_settled = not port.is_open or port.identity.is_settled
        has_fired, breaks = port.device.reported[0] is True, port.device.breaks
        is_over = not is_settled and (self._was_settled or breaks != self._breaks)  # a third one may have come, too
        if has_fired > self._had_fired:
            self._has_read = False
        self._was_settled, self._had_fired, self._breaks = is_settled, has_fired, breaks
        if is_over:
            self._forget()
        self.changed.emit()

    def _forget(self) -> None:
        """What was read may be another module's."""
        self._clear_visit()
        self.reading, self._has_read = None, False
        self._show_archive()

    def _show_archive(self) -> None:
        self.rows = self._rows()
        self.changed.emit()

    def _rows(self) -> tuple[TriggerRow, ...]:
        """The stored records of this name, else the reading."""
        slots = Counter(record.raw for record in self.reading.history.all) if self.reading is not None else Counter()
        kept: tuple[SeenRecord, ...] = ()
        store, name = self._store, self._connector.current.module.name
        is_of_this_name = self._is_stored or self.reading is None
        if store is not None and name and is_of_this_name:
            try:
                kept = store.read(lambda facts: KeptTriggers(facts).records(name))
            except StoreTrouble as trouble:
                self.job.notify(Meaning.DANGER, not_kept(trouble, name))
        if not kept and self.reading is not None:
            history, is_filing = self.reading.history, self._filing.is_running
            ordered = [
                (raw, is_seen_once)
                for records, is_seen_once in ((history.records, False), (history.seen_once, True))
                for raw in in_order([record.raw for record in records], self.reading.boot_count)
            ]
            return tuple(_unstored_row(-1 - place, raw, is_seen_once=is_seen_once)._replace(is_being_stored=is_filing)
                         for place, (raw, is_seen_once) in enumerate(ordered))  # fmt: skip
        rows = []
        for stored in reversed(kept):  # of two equal records the later one is on the module
            judgement, note = self._judging.get(stored.id, (stored.judgement, stored.note))
            seen = stored._replace(judgement=judgement, note=note)
            is_on_module = slots[seen.raw] > 0
            slots[seen.raw] -= is_on_module
            rows.append(TriggerRow(seen, record_of(seen.raw), seen.id in self._new, is_on_module, is_stored=True))
        seen_once = () if self.reading is None else self.reading.history.seen_once
        unknown = Counter(record.raw for record in seen_once) & slots  # known from an earlier visit: certain
        return (*reversed(rows), *(_unstored_row(-1 - place, raw, is_seen_once=True)
                                   for place, raw in enumerate(unknown.elements(), len(rows))))  # fmt: skip


def _unstored_row(number: int, raw: bytes, *, is_seen_once: bool) -> TriggerRow:
    seen = SeenRecord(number, -1 - number, raw, utc_now().isoformat(timespec="seconds"), None, "")
    return TriggerRow(seen, record_of(raw), is_new=False, is_on_module=True, is_stored=False, is_seen_once=is_seen_once)


def _broken_off(error: BaseException) -> str:
    if isinstance(error, UserError):
        return error.sentence
    what = tr("Cancelled.") if isinstance(error, Cancelled) else tr("Link lost.")
    return join_sentences((what, tr("Not kept.")))


def _answers(facts: Facts, name: str) -> tuple[LastAnswer | None, bool]:
    """When it last answered the query, and whether a person said that it is new."""
    kept = KeptTriggers(facts)
    return kept.last_answer(name), kept.is_said_new(name)


def _judge(facts: Facts, module: str, place: int, judgement: Judgement | None, note: str) -> None:
    KeptTriggers(facts).judge(module, place, judgement, note)
