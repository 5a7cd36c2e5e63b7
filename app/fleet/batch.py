"""A batch of new modules, one after the other at one port: what each gets, what is kept of it, and what is left to do.

For `dps-s provision`. A module is read, written, verified, enabled and checked by `app.preflight.provision`; what is
READY gets the name and its record under it, what is not is set aside with its reason and without a name. Everything is
a fact of the store, so that the same names and settings go on where they were left.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from msgspec import convert, to_builtins

from app.engine.identity import IdentityEvidence, Trust, same_module
from app.engine.procedure import Procedure
from app.engine.setting_changes import BOOTS
from app.limits.past import Past
from app.preflight.evidence import Disturbance, Evidence
from app.preflight.findings import Case, Person
from app.preflight.module_checks import FINGERPRINT_KEYS
from app.preflight.provision import Provisioned, provision
from app.preflight.verdict import Verdict, assess
from app.procedures.write_all import SettingChange, WriteContext, WriteReport, why_not_verified
from app.records.filing import judge_check, keep_check, local_now
from app.settings.fingerprint import fingerprint
from app.settings.profile_file import read_profile
from app.settings.profiles import SETTINGS_BY_KEY, Profile
from app.store.fact_store import Facts, Store
from app.store.kinds import MessageText, ModuleProvisioned
from app.store.modules import evidence_of, module_named, modules, store_evidence
from app.text.messages import UserMessage, joined, message, message_from_json
from app.text.user_error import UserError
from protocol.catalogue import BAUD_RATE
from protocol.translatable import marked

READY, SET_ASIDE, OPEN = marked("READY"), marked("SET ASIDE"), marked("open")
PLUG_IN, UNPLUG = marked("PLUG IN: {module}"), marked("UNPLUG, NEXT")
TAKEN = marked("{module} is the name of another module: left out.")
_TRIGGERS = ("attitude_trigger", "freefall_trigger")
REPLUGGED_STARTS = 3
"""Of the module that was named last, where it is plugged in again: its contacts may bounce."""


class ModuleBatch(NamedTuple):
    """`names` in the order in which they are given."""

    names: tuple[str, ...]
    profile: Profile
    changes: tuple[SettingChange, ...]

    @property
    def title(self) -> str:
        return "..".join(dict.fromkeys((self.names[0], self.names[-1])))

    @property
    def key(self) -> str:
        """The same for the same names and settings: what is done is left out."""
        return f"{self.title} {len(self.names)} {fingerprint(self.profile.settings).code}"

    @property
    def enables_triggers(self) -> bool:
        """By its profile. Without both triggers no module is READY."""
        return all(self.profile.settings.get(key) is True for key in _TRIGGERS)


def batch_of(path: Path, names: tuple[str, ...], baud_rate: int | None) -> ModuleBatch:
    """`baud_rate`: of the port, which a batch does not change; None for any. Raises `UserError` where no module can be
    READY."""
    profile = read_profile(path)
    settings = {key: value for key, value in profile.settings.items() if SETTINGS_BY_KEY[key] is not BAUD_RATE}
    if not settings:
        raise UserError(marked("{path} holds no settings."), path=path)
    if baud_rate is not None and profile.settings.get(BAUD_RATE.key, baud_rate) != baud_rate:
        raise UserError(marked("A batch does not change the baud rate: take it out of the profile."))
    if profile.tests_within_days or any(line.is_required for line in profile.manual):
        raise UserError(marked("The profile demands manual checks or guided tests, which a batch does not have."))
    changes = tuple(SettingChange(SETTINGS_BY_KEY[key], value) for key, value in settings.items())
    return ModuleBatch(names, profile, changes)


class BatchRow(NamedTuple):
    """A name, or a module that was set aside, which has none."""

    name: str
    result: str = OPEN
    at: str = ""
    code: str = ""
    boot_count: object = None
    why: UserMessage | None = None


class Bench:
    """A batch in the store. `person`: who checks, and what is said of all its modules; `accepted`: the changes whose
    risk a person was shown and accepted."""

    def __init__(
        self,
        batch: ModuleBatch,
        store: Store,
        person: Person,
        *,
        is_enabling: bool,
        are_all_new: bool,
        accepted: frozenset[SettingChange],
    ) -> None:
        self.batch, self._store, self._person = batch, store, person
        self._is_enabling, self._are_all_new, self._accepted = is_enabling, are_all_new, accepted
        self._last = ""
        """The name given last."""

    def provision(self, evidence: Evidence, context: WriteContext) -> Procedure[Provisioned]:
        """The turn of one module, which fills `evidence`; reads from the store before it begins."""
        known, most_starts = self._store.read(self._known)
        context = replace(context, accepted_risks=self._accepted)
        find_known = partial(_resembling, known, most_starts=most_starts)
        return provision(evidence, self.batch.changes, context, find_known, is_enabling=self._is_enabling)

    def keep(
        self, facts: Facts, name: str, evidence: Evidence, done: Provisioned | None, adapter: str
    ) -> UserMessage | None:
        """Keep the record, under the name only where it is READY; why it is set aside. `done`: None for a turn that
        broke off. Within `Store.write`."""
        why = message((evidence.disturbance or Disturbance.DISCONNECTED).value) if done is None else done.why
        if why is None and done is not None:
            why = _write_fault(done.report)
        boot_count = None if done is None else done.boot_count
        profile = self.batch.profile
        person = replace(self._person, module=name)
        judged = assess(Case(evidence=evidence, profile=profile, past=Past(module=name), person=person))
        if why is None and judged.verdict is not Verdict.READY:
            why = joined(judged.titles_against)
        settings = {} if evidence.disturbance is not None else evidence.settings(FINGERPRINT_KEYS)  # may be another's
        if why is None and module_named(facts, name) is not None:
            why = message(TAKEN, module=name)
        person = replace(person, module=None if why else name)
        if evidence.began_at is not None:
            filed = judge_check(
                evidence,
                profile,
                person,
                Past(module=person.module),
                folder=self._store.folder,
                adapter=adapter or evidence.port,
                at=local_now(),
            )
            keep_check(facts, filed)
        if why is None:
            store_evidence(facts, name, (boot_count, settings))
        turn = ModuleProvisioned(
            batch=self.batch.key,
            name=name,
            why=None if why is None else convert(why.to_json(), MessageText),
            code=fingerprint(settings).code or "",
            boot_count=boot_count,
        )
        facts.add(turn, person.module)
        if why is None:
            self._last = name
        return why

    def rows(self, facts: Facts) -> list[BatchRow]:
        """Every name, then what was set aside, also in former runs."""
        kept = self._kept(facts)
        done = {row.name: row for row in kept if row.result == READY}
        names = [done.get(name, BatchRow(name)) for name in self.batch.names]
        return [*names, *(row for row in kept if row.result == SET_ASIDE)]

    def left(self, facts: Facts) -> tuple[list[str], list[str]]:
        """The names to give, and those that are left out, as they are other modules'."""
        names = [row.name for row in self.rows(facts) if row.result == OPEN]
        taken = [name for name in names if module_named(facts, name) is not None]
        return [name for name in names if name not in taken], taken

    def _known(self, facts: Facts) -> tuple[list[tuple[str, IdentityEvidence]], int]:
        """The modules that one may be that is plugged in, and how often it may have started since."""
        names, most_starts = [module.name for module in modules(facts)], BOOTS
        if self._are_all_new:
            names, most_starts = [self._last or self._named_last(facts)], REPLUGGED_STARTS if self._last else 0
        return [(name, IdentityEvidence(*evidence_of(facts, name))) for name in names if name], most_starts

    def _named_last(self, facts: Facts) -> str:
        """In a former run: it may still be plugged in."""
        turns = facts.of_kind(ModuleProvisioned, is_newest_first=True)
        return next((turn.content.name for turn in turns if turn.content.why is None), "")

    def _kept(self, facts: Facts) -> list[BatchRow]:
        rows = []
        for turn in facts.of_kind(ModuleProvisioned):
            content = turn.content
            if content.batch != self.batch.key:
                continue
            if content.why is None:
                rows.append(BatchRow(content.name, READY, turn.at, content.code, content.boot_count))
            else:
                why = message_from_json(to_builtins(content.why))
                rows.append(BatchRow("", SET_ASIDE, turn.at, content.code, content.boot_count, why))
        return rows


def _resembling(
    known: Sequence[tuple[str, IdentityEvidence]], now: IdentityEvidence, *, most_starts: int
) -> str | None:
    """The first module that nothing refutes, and that started as often since at most; what is known too little of
    refutes itself."""
    fits = (name for name, before in known if before.is_complete and same_module(before, now) is not Trust.REFUTED
            and ((now.boot_count or 0) - (before.boot_count or 0)) % BOOTS <= most_starts)  # fmt: skip
    return next(fits, None)


def _write_fault(report: WriteReport | None) -> UserMessage | None:
    """The first setting that was not verified; None where all are."""
    if report is None or report.is_fine:
        return None
    for written in report.results:
        why = why_not_verified(written, report.refusals)
        if why is not None:
            return message(marked("{value}: {why}"), value=message(written.command.title), why=why)
    return message(marked("A setting changed without being written, or could not be read again."))
