"""The trigger records of one module: read once in its conversation, merged with the stored ones, judged by a person."""

from collections import Counter
from functools import partial
from typing import NamedTuple

from PySide6.QtCore import QObject, Signal

from app.engine.procedure import Cancelled, Job
from app.store.fact_store import Facts, StoreError, utc_now
from app.store.rows import Judgement
from app.text.i18n import tr
from app.text.messages import UserMessage, join_sentences
from app.trigger_records.history import (
    KeptTriggers,
    SeenRecord,
    TriggersReading,
    Visit,
    file_triggers,
    in_order,
    read_triggers,
    record_of,
)
from protocol.messages import TriggerRecord
from protocol.translatable import marked
from ui.core.background_task import BackgroundTask
from ui.services.storage import Storage
from ui.session.shown_module import ShownModule, not_kept
from ui.style.theme import Meaning
from ui.widgets.notices import Choice, Notice


class TriggerRow(NamedTuple):
    """One trigger. `is_stored`: it can be judged. `is_seen_once`: it came in one reading only, so it is uncertain."""

    seen: SeenRecord
    record: TriggerRecord
    is_on_module: bool
    is_stored: bool
    is_seen_once: bool = False


class TriggerReading(QObject):
    """The trigger records of one module. They are read once by themselves while somebody looks, and again after it
    fired."""

    # The rows, the progress or the notice are otherwise.
    changed = Signal()

    def __init__(self, module: ShownModule, storage: Storage) -> None:
        super().__init__(module)
        self._module, self._storage = module, storage
        # Oldest first.
        self.rows: tuple[TriggerRow, ...] = ()
        self.reading: TriggersReading | None = None
        self.job = module.job("triggers")
        self.job.changed.connect(self.changed)
        self._is_stored = False
        # It was read by itself since it last fired.
        self._has_asked = False
        self._had_fired = False
        self._filing: BackgroundTask[Visit | UserMessage] = BackgroundTask("dps-s triggers", self)
        # Judgements and notes that are not stored yet, by place.
        self._judging: dict[int, tuple[Judgement | None, str]] = {}
        module.named.connect(self._on_named)
        self.show_kept()

    @property
    def is_busy(self) -> bool:
        return self.job.is_running or self._filing.is_running

    @property
    def can_read(self) -> bool:
        return self._module.is_going and not self.is_busy

    # What is done

    def read(self) -> None:
        if self.can_read:
            self._has_asked = True
            self.job.run(read_triggers(), self._end, doing=marked("Reading the trigger records"))

    def read_unasked(self) -> None:
        """Read them where that is due; called while somebody looks."""
        has_fired = self._module.view.reported[0] is True
        if has_fired and not self._had_fired:
            self._has_asked = False
        self._had_fired = has_fired
        if self._module.is_read and not self._module.is_busy and not self._has_asked:
            self.read()

    def judge(self, seen: SeenRecord, judgement: Judgement | None, note: str) -> None:
        """Store a person's judgement of a record; a failure offers to try again."""
        store, name = self._storage.ready, self._module.name
        if store is None:
            return
        place = seen.place
        judged = self._judging[place] = judgement, note

        def work(facts: Facts) -> None:
            KeptTriggers(facts).judge(name, seen, judgement, note)

        def end(trouble: StoreError | None = None) -> None:
            if self._judging.get(place) is not judged:
                return  # it was judged again meanwhile
            del self._judging[place]
            if trouble is not None:
                choices = (Choice("judge_again", tr("Try again"), again),)
                self.job.set_notice(Notice(Meaning.DANGER, not_kept(trouble, name), choices, self.job.dismiss))
            self.show_kept()

        def again() -> None:
            self.job.dismiss()
            self.judge(seen, judgement, note)

        keeper: BackgroundTask[None] = BackgroundTask("dps-s judgement", self, for_once=True)
        keeper.run_in(store, work, lambda _none: end(), end)
        self.show_kept()

    # What came of it

    def _end(self, job: Job[TriggersReading]) -> None:
        if job.error is not None:
            is_cancelled = isinstance(job.error, Cancelled)
            text = tr("Cancelled.") if is_cancelled else str(job.error)
            meaning = Meaning.INFORMATION if is_cancelled else Meaning.DANGER
            self.job.notify(meaning, join_sentences((text, tr("Not kept."))))
            return
        self.reading = reading = job.outcome()
        if reading.history.is_confirmed:
            self._module.note_records_read()
        self._keep_reading()

    def _on_named(self) -> None:
        """Keep what was read: it is of the module that a person named now."""
        self.job.dismiss()
        self._keep_reading()

    def _keep_reading(self, *, is_same_module: bool = False) -> None:
        """Keep the reading under the module's name, if it has one."""
        reading, store, name, target = self.reading, self._storage.ready, self._module.name, self._module.target
        self._filing.cancel()
        self._is_stored = False
        if reading is not None and not reading.history.is_answered:
            self.job.notify(Meaning.ATTENTION, tr("No answer: the records are unknown."))
        elif reading is not None:
            if store is not None and target is not None and name:
                self.job.dismiss()
                work = partial(
                    file_triggers,
                    reading=reading,
                    name=name,
                    port=target.device,
                    adapter=target.identity,
                    is_same_module=is_same_module,
                )
                self._filing.run_in(store, work, self._end_filing, self._fail_filing)
            if not reading.history.is_confirmed:
                self.job.notify(Meaning.ATTENTION, tr("The readings differ: records may be missing. Read again."))
        self.show_kept()

    def _end_filing(self, filed: Visit | UserMessage) -> None:
        if isinstance(filed, UserMessage):
            name = self._module.name
            text = join_sentences((tr("Not kept."), tr("{name}: {value}", name=name, value=filed.translated())))
            choices = (
                Choice("another_module", tr("Another module"), self._module.treat_as_another, is_step=True),
                Choice("same_module", tr("It is {module}", module=name), self._keep_anyway, is_step=True),
            )
            self.job.set_notice(Notice(Meaning.ATTENTION, text, choices))
        else:
            self._is_stored = True
        self.show_kept()

    def _keep_anyway(self) -> None:
        self.job.dismiss()
        self._keep_reading(is_same_module=True)

    def _fail_filing(self, trouble: StoreError) -> None:
        self.job.notify(Meaning.DANGER, not_kept(trouble, self._module.name))
        self.show_kept()

    # The rows

    def show_kept(self) -> None:
        """The stored records of this name, then what was read and is not stored."""
        kept = self._kept() if self._is_stored or self.reading is None else ()
        history = None if self.reading is None else self.reading.history
        # How many of each were read and have no row yet.
        unshown = Counter[bytes]() if history is None else Counter(record.raw for record in history.all)
        rows: list[TriggerRow] = []
        for stored in reversed(kept):  # of two equal records the later one is on the module
            judgement, note = self._judging.get(stored.place, (stored.judgement, stored.note))
            is_on_module = unshown[stored.raw] > 0
            if is_on_module:
                unshown[stored.raw] -= 1
            seen = stored._replace(judgement=judgement, note=note)
            rows.append(TriggerRow(seen, record_of(seen.raw), is_on_module, is_stored=True))
        rows.reverse()
        if self.reading is not None and history is not None:
            # What came in one reading only is known for certain where it was stored at an earlier visit.
            for records, is_seen_once in ((history.records, False), (history.seen_once, True)):
                left = Counter(record.raw for record in records) & unshown
                unshown -= left
                for raw in in_order(list(left.elements()), self.reading.boot_count):
                    rows.append(_unstored_row(len(rows), raw, is_seen_once=is_seen_once))
        self.rows = tuple(rows)
        self.changed.emit()

    def _kept(self) -> tuple[SeenRecord, ...]:
        store, name = self._storage.ready, self._module.name
        if store is None or not name:
            return ()
        try:
            return store.read(lambda facts: KeptTriggers(facts).records(name))
        except StoreError as trouble:
            self.job.notify(Meaning.DANGER, not_kept(trouble, name))
            return ()


def _unstored_row(place: int, raw: bytes, *, is_seen_once: bool) -> TriggerRow:
    seen = SeenRecord(place, raw, utc_now().isoformat(timespec="seconds"), None, "")
    return TriggerRow(seen, record_of(raw), is_on_module=True, is_stored=False, is_seen_once=is_seen_once)
