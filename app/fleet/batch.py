"""A batch of new modules, one after the other at one port: what each gets, what is kept of it, and what is left to do.

For `dps-s provision`. What is READY gets the name and its record under it, what is not is set aside with its reason and
without a name. Everything is a fact of the store, so that the same names and settings go on where they were left.
"""

import logging
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

from app.engine.conversation import Interrupted
from app.engine.procedure import Pause, Procedure
from app.fleet.card import whats_not_as_written
from app.limits.past import Past
from app.modules.labels import Label, Paper, Printer, write_labels
from app.modules.names import Remembered, modules, remembered
from app.preflight.checks import Person
from app.preflight.evidence import Evidence, read_state
from app.preflight.run import run_preflight
from app.preflight.verdict import Verdict
from app.procedures.write import SettingChange, WriteContext, write_all
from app.records.filing import judge_check, keep_check, local_now
from app.records.report import check_target
from app.settings.profile_file import read_profile
from app.settings.profiles import Profile
from app.settings.values import SETTINGS_BY_KEY, fingerprint
from app.store.fact_store import Facts, Store
from app.store.rows import ModuleProvisioned
from app.text.messages import UserError, UserMessage, joined, message, message_from_json, visible
from protocol.catalogue import BAUD_RATE, BOOT_COUNT, BOOTS
from protocol.translatable import marked

_log = logging.getLogger(__name__)
READY, SET_ASIDE, OPEN = marked("READY"), marked("SET ASIDE"), marked("open")
TAKEN = marked("{module} is the name of another module: left out.")
# Marks the labels of a batch, which a batch may replace.
FORMAT = "dps-s batch"
# Of the module that was named last, where it is plugged in again: its contacts may bounce.
REPLUGGED_STARTS = 3
EXAMPLE: Final = "M-001..M-050"
MAX_BATCH: Final = 1000
MAX_NAME_LENGTH: Final = 60
_LOOK_EVERY_S = 1.0


def counted_names(text: str) -> tuple[str, ...] | None:
    """ "M-001..M-050": names that count upwards, with as many digits; or one name. None where it is neither."""
    first, dots, last = text.partition("..")
    begin, end = (re.fullmatch(r"(.*?)([0-9]{1,9})", name) for name in (first, last))
    names: tuple[str, ...] = (first,)
    if begin is not None and end is not None and begin[1] == end[1]:
        low, high, digits = int(begin[2]), int(end[2]), len(begin[2])
        names = tuple(f"{begin[1]}{number:0{digits}}" for number in range(low, min(high, low + MAX_BATCH) + 1))
        is_valid = len(names) <= MAX_BATCH and names[-1:] == (last,)
    else:
        is_valid = not dots
    is_valid &= all(visible(name) == name and 0 < len(name.strip()) == len(name) <= MAX_NAME_LENGTH for name in names)
    return names if is_valid else None


def batch_profile(path: Path) -> Profile:
    """Read the profile of a batch. Raises `UserError`, also where no module can be READY by it."""
    profile = read_profile(path)
    if not batch_changes(profile):
        raise UserError(marked("{path} holds no settings."), path=path)
    if profile.tests_within_days or any(line.is_required for line in profile.manual):
        raise UserError(marked("The profile demands manual checks or guided tests, which a batch does not have."))
    return profile


def batch_changes(profile: Profile) -> tuple[SettingChange, ...]:
    """All settings of the profile but the baud rate, which a batch does not change."""
    every = (SettingChange(SETTINGS_BY_KEY[key], value) for key, value in profile.settings.items())
    return tuple(change for change in every if change.command is not BAUD_RATE)


class BatchRow(NamedTuple):
    """A name, or a module that was set aside, which has none."""

    name: str
    result: str = OPEN
    at: str = ""
    code: str = ""
    why: UserMessage = UserMessage("")


@dataclass
class BatchRun:
    """A batch in the store. `names` in the order in which they are given; `person`: who checks, and what is said of all
    its modules; `last`: the name given last in this run."""

    names: tuple[str, ...]
    profile: Profile
    store: Store
    person: Person
    is_enabling: bool
    are_all_new: bool
    last: str = ""

    @property
    def key(self) -> str:
        """The same for the same names and settings: what is done is left out."""
        settings = " ".join(f"{key}={value}" for key, value in sorted(self.profile.settings.items()))
        return f"{self.names[0]}..{self.names[-1]} {len(self.names)} {settings}"

    def provision(self, evidence: Evidence, context: WriteContext) -> Procedure[UserMessage | None]:
        """The turn of one module, which fills `evidence`; reads from the store before it begins. Its result: why
        nothing was written, or not everything is as written; None where it was checked."""
        known, most_starts = self.store.read(modules), BOOTS // 2
        if self.are_all_new:
            # The last one, also of a former run, may still be plugged in.
            known = [module for module in known if module.name == self.last] or known[:1]
            most_starts = REPLUGGED_STARTS if self.last else 0
        return self._turn(evidence, context, known, most_starts)

    def _turn(
        self, evidence: Evidence, context: WriteContext, known: Sequence[Remembered], most_starts: int
    ) -> Procedure[UserMessage | None]:
        """In one conversation. `known`: the modules that this one may be, with so many starts since. Raises
        `Interrupted`: what was written is unknown then, and the module that answers next begins from the start."""
        before = yield from read_state()
        boot_count, status = before.settings.boot_count, before.status
        if not before.is_complete or boot_count is None or status is None:
            return message(marked("Cannot be read."))
        if status.active:
            return message(marked("The module is ACTIVE: lock it first."))
        settings = {key: value for key, value in before.settings.values.items() if key != BOOT_COUNT.key}
        # Without a serial number only these tell a new module from one that was provisioned before.
        for module in known:
            is_same = all(module.settings.get(key) == value for key, value in settings.items())
            was = module.boot_count
            if is_same and was is not None and (boot_count - was) % BOOTS <= most_starts:
                return message(marked("It may be {module}: boot count and settings fit."), module=module.name)
        report = yield from write_all(batch_changes(self.profile), context)
        if report.interrupted is not None:
            raise report.interrupted
        if not report.is_fine:
            return joined(whats_not_as_written(report), " ")
        yield from run_preflight(evidence, is_enabling=self.is_enabling, journal=context.journal)
        return None

    def keep(
        self, facts: Facts, name: str, evidence: Evidence, why: UserMessage | None, adapter: str
    ) -> UserMessage | None:
        """Keep the record, under the name only where it is READY; why it is set aside. `why`: what came of its turn.
        Within `Store.write`."""
        judge = partial(
            judge_check,
            evidence,
            self.profile,
            folder=self.store.folder,
            adapter=adapter or evidence.port,
            at=local_now(),
        )
        if evidence.void is not None:
            why = evidence.void.message
        if why is None:
            filed = judge(replace(self.person, module=name), Past(module=name))
            if filed.assessment.verdict is not Verdict.READY:
                why = joined(filed.assessment.titles_against)
            elif remembered(facts, name) is not None:
                why = message(TAKEN, module=name)
        # A name is spent only on what is READY: the next module gets it otherwise.
        module = None if why else name
        if evidence.conversation:  # it was checked, if not to the end
            keep_check(facts, filed if module else judge(replace(self.person, module=None), Past(module=None)))
        self.last = module or self.last
        code = fingerprint(evidence.values) or ""
        told = None if why is None else why.to_json()
        facts.add(ModuleProvisioned(batch=self.key, name=name, why=told, code=code), module)
        _log.debug("%s: %s", name, why)
        return why

    def rows(self, facts: Facts) -> list[BatchRow]:
        """Every name, then what was set aside, also in former runs."""
        done: dict[str, BatchRow] = {}
        aside: list[BatchRow] = []
        for turn in facts.of_kind(ModuleProvisioned):
            content = turn.content
            if content.batch == self.key and content.why is None:
                done[content.name] = BatchRow(content.name, READY, turn.at, content.code)
            elif content.batch == self.key:
                aside.append(BatchRow("", SET_ASIDE, turn.at, content.code, message_from_json(content.why)))
        return [*(done.get(name, BatchRow(name)) for name in self.names), *aside]

    def left(self, facts: Facts) -> tuple[list[str], list[str]]:
        """The names to give, and those that are left out, as they are other modules'."""
        names = [row.name for row in self.rows(facts) if row.result == OPEN]
        taken = [name for name in names if remembered(facts, name) is not None]
        return [name for name in names if name not in taken], taken


def await_gone() -> Procedure[None]:
    """Wait until the module is unplugged, with its adapter or without, or another one has taken its place."""
    try:
        while True:
            yield Pause(_LOOK_EVERY_S)
    except Interrupted:
        return


# Its labels


def write_batch_labels(path: Path, rows: Sequence[BatchRow], paper: Paper, printer: Printer) -> None:
    """Write labels of the names that are given, if any. Raises `UserError`, `OSError` or `RuntimeError`."""
    check_target(path, FORMAT)
    done = [row for row in rows if row.result == READY]
    labels = [Label(row.name, datetime.fromisoformat(row.at).astimezone(), row.code) for row in done]
    if labels:
        write_labels(path, labels, paper, printer)
