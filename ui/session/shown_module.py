"""One conversation as the window shows it: all that is known of a module, and what stays when it has ended.

A port has one `ShownModule` at a time. It begins empty with each conversation and is complete within half a second.
Pages show the one they are given and keep nothing of a module themselves, so that no page can show a value of the
module before. When the conversation ends the object stays, greyed, until the next one begins.

Of the conversations that ended there is one notice, however many there were. Beside it stays what a person must not
miss, each by itself: the report of what was interrupted, a TRIGGERED that was seen, and the drafts that were not
written.
"""

import logging
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from app.diagnosis.link_state import LinkStatistics
from app.engine.conversation import ConversationView
from app.engine.procedure import Job, Procedure, Report, Result
from app.engine.target import Target
from app.engine.worker import Batch
from app.modules.names import Remembered, remember, remembered, store_as_found, what_speaks_against
from app.safety.journal import Journal
from app.safety.last_known import SeenActivation, seen_activation
from app.safety.left_active import note_go, note_named
from app.store.acts import Where, claim_fired, note_triggered
from app.store.fact_store import Facts, StoreError
from app.store.rows import Row
from app.text.i18n import tr
from app.text.messages import UserMessage, capitalised, clean, join_sentences, labelled
from protocol.catalogue import READABLE_SETTINGS
from protocol.events import Ended, EndReason
from protocol.fields import Value
from ui.services.storage import ORIGIN, Storage

if TYPE_CHECKING:
    from app.preflight.checks import Person
    from app.preflight.verdict import CheckState
    from app.procedures.light import LightDirection
    from app.settings.profiles import Profile
    from ui.session.check import ModuleCheck
    from ui.session.guided import Guided
    from ui.session.page_job import PageJob
    from ui.session.port import Port
    from ui.session.settings_draft import SettingsDraft
    from ui.session.trigger_reading import TriggerReading

# A person ends these on purpose, so nobody has to be told.
UNTOLD = frozenset({EndReason.CLOSED, EndReason.RATE_CHANGED, EndReason.ANOTHER})


@dataclass(frozen=True, slots=True, eq=False)
class Remainder:
    """What stays of one conversation is a report, drafts, or, with neither, a TRIGGERED that was seen."""

    # The module's name, or "".
    module: str
    text: UserMessage | None = None
    # By the setting's key, as they stood when the conversation ended; not written. Text is what cannot be sent.
    drafts: Mapping[str, Value | str] | None = None
    # When it was kept, in seconds since 1970.
    at: float = field(default_factory=time.time)

    @property
    def is_trigger(self) -> bool:
        return self.text is None and self.drafts is None


class Interruptions(QObject):
    """The interruptions of one port. They belong to the window's thread."""

    changed = Signal()

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        # How often a conversation ended since the notice was closed; when the first and the last of these did, in
        # seconds since 1970, and why the last one did.
        self.count = 0
        self.first_at = self.last_at = 0.0
        self.last: UserMessage | None = None
        self.remainders: tuple[Remainder, ...] = ()

    def note(self, reason: EndReason, text: UserMessage) -> None:
        """A conversation that had begun is over."""
        if reason in UNTOLD:
            return
        self.last, self.last_at = text, time.time()
        self.first_at = self.first_at if self.count else self.last_at
        self.count += 1
        self.changed.emit()

    def close(self) -> None:
        """A person has read of the interruptions."""
        self.count, self.last = 0, None
        self.changed.emit()

    def keep(self, remainder: Remainder) -> None:
        self.remainders += (remainder,)
        self.changed.emit()

    def close_remainder(self, remainder: Remainder) -> None:
        self.remainders = tuple(one for one in self.remainders if one is not remainder)
        self.changed.emit()

    def count_drafts(self) -> int:
        """Settings that were edited, are kept here and are not written."""
        return sum(len(one.drafts or ()) for one in self.remainders)

    def discard_drafts(self) -> None:
        """A person does not want them."""
        self.remainders = tuple(one for one in self.remainders if one.drafts is None)
        self.changed.emit()


_log = logging.getLogger(__name__)


class ShownModule(QObject):
    """See the module's docstring. Belongs to the window's thread."""

    changed = Signal()  # Something that is known of it is otherwise: a value, its age, its name, its check, its end
    batch = Signal(object)  # Each `Batch` of its conversation, after it was taken in
    named = Signal()  # A person said its name, or took it back
    ended = Signal()  # Its conversation is over: nothing acts on it any more
    check_changed = Signal()  # Another check began, or its check stands otherwise

    def __init__(self, port: "Port", storage: "Storage", view: ConversationView, *, parent: QObject) -> None:
        super().__init__(parent)
        self._port, self._storage = port, storage
        self.view = view
        # As a person said it in this conversation; "" where nobody did.
        self.name = ""
        # A name against which something speaks, and that a person has said once.
        self.doubted_name = ""
        # Names this conversation in the audit log: a module without a name is not known beyond it.
        self.run_id = os.urandom(4).hex()
        self.statistics = LinkStatistics()
        # The settings before the first write.
        self.as_found: Mapping[str, Value] | None = None
        # Which way the light reads; None until it was measured with the bay closed and open (E11).
        self.light_direction: LightDirection | None = None
        # The trigger records that a person had before them, as raw bytes.
        self.looked_at: Counter[bytes] = Counter()
        # A guided test makes it fire now, and says what comes next.
        self.is_fired_by_test = False
        # It reported TRIGGERED in this conversation.
        self.was_triggered = False
        # The last one, whoever began it.
        self.check: ModuleCheck | None = None
        self._work: dict[str, PageJob] = {}
        # Each with whether it goes on while another module is shown.
        self._jobs: dict[Job[Any], bool] = {}

    # What is known

    @property
    def number(self) -> int:
        """The number of its conversation; 0 while no module has answered yet."""
        return self.view.number

    @property
    def is_going(self) -> bool:
        """It answers: its conversation has begun and is not over."""
        return self.view.is_going

    @property
    def end(self) -> Ended | None:
        return self.view.ended

    @property
    def target(self) -> Target | None:
        """The port where it is connected."""
        return self._port.target

    @property
    def now_s(self) -> float:
        """The time by the clock of the engine."""
        return self._port.now_s

    @property
    def is_read(self) -> bool:
        """Everything that can be read was asked for once."""
        return all(command.key in self.view.values for command in READABLE_SETTINGS)

    @property
    def can_be_named(self) -> bool:
        """A name is said after everything was read, so that what speaks against it can be shown."""
        return self.is_going and self.is_read

    @property
    def activation(self) -> SeenActivation:
        return seen_activation(self.view, self._port.now_s)

    @property
    def may_have_fired(self) -> bool:
        """It was ACTIVE before it restarted, and what its trigger records say of that was not read and closed yet."""
        return self._port.firing_doubt.is_open

    @property
    def where(self) -> Where | None:
        """Where its acts are done, and what it is known by now; None without a port."""
        target = self.target
        return None if target is None else Where(target.device, ORIGIN, target.identity, self.name, self.run_id)

    @property
    def journal(self) -> Journal:
        return self._storage.journal(self.where)

    # What is done with it

    def run(
        self,
        procedure: Procedure[Result],
        then: Callable[[Job[Result]], None],
        *,
        on_progress: Callable[[Report], None] | None = None,
        expects: frozenset[EndReason] = frozenset(),
        goes_on: bool = False,
    ) -> Job[Result]:
        """Run a procedure in this conversation; `then` is called in the window's thread when it has ended, also where
        the conversation did. `on_progress` is called in the worker's thread: it may only remember what it is given.
        `goes_on`: also while another module is shown."""
        job: Job[Result] = Job(procedure, on_progress, conversation=self.number, expects=expects)
        self._jobs[job] = goes_on

        def end(ended: Job[Result]) -> None:
            self._jobs.pop(ended, None)
            then(ended)
            self.changed.emit()

        self._port.submit(job, end)
        return job

    def job(self, key: str) -> "PageJob":
        """Return what a page runs on it and shows of it, by the page's own key: progress, cancel, and what came of
        it."""
        from ui.session.page_job import PageJob

        if key not in self._work:
            work = self._work[key] = PageJob(self, module=self)
            work.changed.connect(self.changed)
        return self._work[key]

    @property
    def is_busy(self) -> bool:
        """A procedure that a person started is running on it."""
        return bool(self._jobs)

    def cancel_jobs(self) -> None:
        """Another module is shown now."""
        for job, goes_on in self._jobs.items():
            if not goes_on:
                job.cancel()

    # The first paint does not wait for these.

    @cached_property
    def settings(self) -> "SettingsDraft":
        """Its settings, as a person edits them."""
        from ui.session.settings_draft import SettingsDraft

        return SettingsDraft(self)

    @cached_property
    def triggers(self) -> "TriggerReading":
        """Its trigger records."""
        from ui.session.trigger_reading import TriggerReading

        reading = TriggerReading(self, self._storage)
        reading.changed.connect(self.changed)
        return reading

    @cached_property
    def guided(self) -> "Guided":
        """Its guided tests."""
        from ui.session.guided import Guided

        guided = Guided(self, self._storage, self._port.lock)
        guided.changed.connect(self.changed)
        return guided

    @property
    def is_checking(self) -> bool:
        return self.check is not None and self.check.is_running

    @property
    def check_state(self) -> "CheckState":
        from app.preflight.verdict import NOT_CHECKED

        return NOT_CHECKED if self.check is None else self.check.state

    def begin_check(self, profile: "Profile", person: "Person", *, is_enabling: bool) -> "ModuleCheck":
        """Begin a check in place of the last one, which is void then."""
        from ui.session.check import NEWER, ModuleCheck

        if self.check is not None:
            self.check.drop(NEWER)
        self.check = ModuleCheck(self, self._storage, profile, person, is_enabling=is_enabling)
        self.check.changed.connect(self.check_changed)
        self.check_changed.emit()
        return self.check

    # What is kept of it

    def keep_report(self, text: UserMessage) -> None:
        """Keep the report of what was interrupted with its conversation, as a notice, until a person closes it."""
        self._port.interruptions.keep(Remainder(self.name, text))

    def keep_drafts(self, drafts: Mapping[str, Value | str]) -> None:
        """Keep what was not written when its conversation ended, by the setting's key, until a person closes it."""
        self._port.interruptions.keep(Remainder(self.name, drafts=drafts))

    def keep_looked_at(self, records: Iterable[bytes]) -> None:
        self.looked_at |= Counter(records)

    def keep_as_found(self) -> Callable[[Mapping[str, Value], int | None], "Future[Row] | None"] | None:
        """Keep the settings before the first write; None once they are. For the worker's thread, which may be late."""
        port = "" if self._port.target is None else self._port.target.device
        name = self.name

        def keep(settings: Mapping[str, Value], boot_count: int | None) -> "Future[Row] | None":
            self.as_found = settings
            store = self._storage.begun
            if store is None:
                return None
            return store.write(
                partial(store_as_found, settings=settings, boot_count=boot_count, port=port, module=name)
            )

        return keep if self.as_found is None else None

    def note_records_read(self) -> None:
        """Note that its trigger records were read in this conversation."""
        self._port.firing_doubt.needs_records = False
        self._port.update_view()
        self.changed.emit()

    def note_go(self) -> None:
        """Note that its verdict is GO, so that to be left ACTIVE is its normal end."""
        self._write(partial(note_go, run=self.run_id))

    def _write(self, act: Callable[[Facts], object]) -> None:
        """Write into the store, whose trouble has a notice of its own."""

        def log_trouble(written: "Future[object]") -> None:
            error = None if written.cancelled() else written.exception()
            if error is not None:
                _log.warning("What is known of a module is not kept: %s", error)

        if self._storage.ready is not None:
            self._storage.ready.write(act).add_done_callback(log_trouble)

    # Its name

    def what_speaks_against(self, name: str) -> tuple[UserMessage, ...]:
        """Why it may be another module than the one of this name; empty where nothing is known to speak against it."""
        known = self.remembered(name)
        return () if known is None else what_speaks_against(known, self.view)

    def remembered(self, name: str) -> Remembered | None:
        """Return what was last kept under this name."""
        store = self._storage.ready
        if store is None or not name:
            return None
        try:
            return store.read(lambda facts: remembered(facts, name))
        except StoreError as trouble:
            _log.warning("What was last read of a module cannot be read: %s", trouble)
            return None

    def last_writes(self) -> "Future[dict[str, UserMessage]] | None":
        """Who last wrote each setting and when, under its name; behind what is still to be kept, in the store's
        thread."""
        from app.archive.report import last_writes

        store, name = self._storage.ready, self.name
        return store.write(lambda facts: last_writes(facts, name)) if store is not None and name else None

    def name_it(self, name: str) -> None:
        """A person says its name. Where something speaks against it, that is shown, and it has to be said again."""
        if not self.can_be_named:
            return
        if name and name != self.doubted_name and self.what_speaks_against(name):
            self.doubted_name = name
        else:
            self.doubted_name = ""
            self.say_name(name)
        self._port.update_view()

    def say_name(self, name: str) -> None:
        """A person says which module it is, after what speaks against it was shown; "" takes the name back."""
        name = clean(name.strip())
        if name == self.name or not self.is_going:
            return
        self.name = name
        where = self.where

        def note(facts: Facts) -> None:
            """What fired here without a name, and what was left ACTIVE under this one, was this module."""
            if where is not None:
                note_named(facts, where.run, where.name)
                if where.name:
                    claim_fired(facts, where.name, port=where.port, adapter=where.adapter)

        self._write(note)
        self.keep()
        self.named.emit()
        self.changed.emit()

    def treat_as_another(self) -> None:
        """A person says that it is another module than the one of this name: its conversation ends."""
        self._port.treat_as_another()

    def keep(self) -> None:
        """Keep under its name what is known of it, for the next time that a person is asked."""
        view = self.view
        if self._port.target is not None and self.name:
            settings = view.settings(self._port.now_s)
            self._write(partial(remember, name=self.name, boot_count=view.boot_count, settings=settings))

    # What happens, as its port tells

    def take_in(self, batch: Batch) -> None:
        """A batch of its conversation."""
        was_read, was_going = self.is_read, self.is_going
        self.view = batch.conversation
        self.statistics.on_batch(batch)
        # A TRIGGERED that was seen stays with the module: no verdict before it holds.
        is_triggered = self.view.fresh("triggered", batch.at) is True or any(one.triggered for one in batch.samples)
        if is_triggered and not self.was_triggered:
            self.was_triggered = True
            if (target := self._port.target) is not None:
                adapter = target.identity
                self._write(partial(note_triggered, module=self.name, port=target.device, adapter=adapter))
        if self.is_read and not was_read:
            self.keep()
        self.batch.emit(batch)
        if was_going and not self.is_going:
            self.ended.emit()


def module_label(name: str) -> str:
    """Return the module's name for sentences, in the language in use."""
    return name or tr("Unnamed")


def not_kept(trouble: StoreError, module: str) -> str:
    """Say that it was not kept, with the name of the module it is of: by the time that a slow store tells, another one
    may be shown."""
    return labelled(capitalised(module_label(module)), join_sentences((trouble.sentence, tr("Not kept."))))
