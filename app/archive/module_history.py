"""History of one module over all stations: what is known of it, as sentences."""

from collections.abc import Mapping
from contextlib import suppress
from typing import Any, NamedTuple

from msgspec import to_builtins

from app.archive.archive import Archive
from app.guided.guided_store import told_test
from app.guided.results import TITLES as TEST_TITLES
from app.guided.results import VERDICT_WORDS
from app.modules.service import service_summary
from app.records.filing import CheckLine, check_line, noted
from app.safety.journal import TITLES, Act, Outcome
from app.settings.values import field_of, fitting, kept_value_message, setting_message
from app.store.acts import all_fired
from app.store.fact_store import Facts, Kept
from app.store.rows import (
    KIND_OF,
    ActEnded,
    ActIntended,
    Content,
    GuidedTestDone,
    MayHaveFired,
    ModuleNamed,
    ModuleProvisioned,
    ModuleVisited,
    PreflightCheck,
    Row,
    Serviced,
    SettingsSeen,
    TriggerRecordJudged,
    TriggerRecordSeen,
)
from app.text.messages import UserError, UserMessage, clean, joined, message
from app.trigger_records.history import JUDGEMENT_WORDS, Judgement, record_of, sentence
from protocol.catalogue import BOOTS, READABLE_SETTINGS
from protocol.fields import Value
from protocol.translatable import marked

RECORD_BYTES = 16
_OUTCOMES: Mapping[str, str] = {
    Outcome.CONFIRMED.value: marked("confirmed"),
    Outcome.REFUSED.value: marked("refused"),
    Outcome.UNKNOWN.value: marked("may have been carried out"),
    Outcome.NOT_SENT.value: marked("not sent"),
}


# After these it is told which settings were known.
_OF_SETTINGS = (SettingsSeen, ModuleVisited, ActIntended, PreflightCheck)


class HistoryEvent(NamedTuple):
    """One fact about a module as a sentence. `content`: as it is kept, of an act with its outcome and of a check
    without the signed document. `settings`: as they were known then, of a fact that tells of settings."""

    row: Row
    text: UserMessage
    content: dict[str, Any]
    settings: Mapping[str, Value] = {}


class _Known:
    """The settings as far as the facts tell them, from the oldest on; the boot count of the last reading."""

    def __init__(self) -> None:
        self.settings: dict[str, Value] = {}
        self._boot_count: int | None = None

    def read(self, content: SettingsSeen | ModuleVisited) -> UserMessage | None:
        """What a reading tells beside the one before: whether settings outlived a restart. None where nothing."""
        before, now = self.settings, dict(content.settings)
        last, self._boot_count = self._boot_count, content.boot_count
        if not now:
            return None
        self.settings = now
        # The flags of the triggers are never read: what is known of them was written, in one conversation.
        readable = {command.key: before[command.key] for command in READABLE_SETTINGS if command.key in before}
        changes = settings_changed(readable, now)
        has_restarted = last is not None and (last + 1) % BOOTS == content.boot_count
        if before and has_restarted:
            changed = joined(changes) if changes else message(marked("settings kept"))
            return message(marked("Over the restart: {what}."), what=changed)
        if before and changes:
            return message(marked("Read since: {what}."), what=joined(changes))
        if isinstance(content, ModuleVisited):
            return None
        every = joined([setting_message(key, value) for key, value in sorted(now.items())])
        return message(marked("{value}: {why}."), value=message(marked("Settings")), why=every)

    def write(self, detail: Mapping[str, Any], outcome: str) -> UserMessage:
        """What was written, with the value before."""
        told = []
        for key, value in sorted(detail.items()):
            before = {key: self.settings.pop(key)} if key in self.settings else {}
            told += settings_changed(before, {key: value}) or [setting_message(key, value)]
            if outcome == Outcome.CONFIRMED.value:
                self.settings[key] = value
            elif before and outcome != Outcome.UNKNOWN.value:
                self.settings |= before
        return joined(told)


def settings_changed(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[UserMessage]:
    """The settings that are in both with another value: "Attitude threshold 60° → 65°"."""
    told = []
    for key, value in sorted(after.items()):
        if key in before and before[key] != value:
            new = kept_value_message(key, value)
            told.append(message("{before} → {after}", before=setting_message(key, before[key]), after=new))
    return told


def as_edits(settings: Mapping[str, Any]) -> dict[str, Value]:
    """Those that can be written again. Another station may have kept any number."""
    edits = {}
    for command in READABLE_SETTINGS:
        with suppress(KeyError, UserError):
            edits[command.key] = fitting(field_of(command), settings[command.key])
    return edits


def module_history(archive: Archive, name: str) -> list[HistoryEvent]:
    """The oldest first; empty where no station knows a module of this name. Raises `UserError`."""
    return archive.read(lambda facts: _history(facts, name))


def _history(facts: Facts, name: str) -> list[HistoryEvent]:
    kept: list[Kept[Any]] = [one for type_ in KIND_OF for one in facts.of_module(type_, name)]
    fired = all_fired(facts, name)
    outcomes = {one.content.of: one.content.outcome for one in facts.of_module(ActEnded, name)}
    known = _Known()
    events = []
    for one in sorted(kept, key=lambda one: one.at):
        plain = to_builtins(one.content)
        text: UserMessage | None
        match one.content:
            case PreflightCheck():
                del plain["document"]
                text = _check(check_line(one).after(fired))
            case ActIntended():
                plain["outcome"] = outcomes.get(one.row.id, Outcome.UNKNOWN.value)
                text = _act(one.content, plain["outcome"], known)
            case SettingsSeen() | ModuleVisited():
                text = known.read(one.content)
            case GuidedTestDone():
                text = _guided_test(one)
            case content:
                text = _told(content)
        if text is not None:
            is_of_settings = isinstance(one.content, _OF_SETTINGS)
            events.append(HistoryEvent(one.row, text, plain, dict(known.settings) if is_of_settings else {}))
    return events


def _told(content: Content) -> UserMessage | None:
    """None for a kind that tells a person nothing, as each reading of a module."""
    match content:
        case ModuleNamed():
            return message(marked("Named, or met at another adapter."))
        case TriggerRecordSeen():
            raw = bytes.fromhex(content.raw)
            what = sentence(record_of(raw)) if len(raw) == RECORD_BYTES else UserMessage(content.raw)
            return message(marked("Trigger record: {what}"), what=what)
        case TriggerRecordJudged(judgement=None):
            return message(marked("Judgement taken back."))
        case TriggerRecordJudged():
            word = message(JUDGEMENT_WORDS[Judgement(content.judgement)])
            return _with_note(message(marked("Judged: {judgement}."), judgement=word), content.note)
        case MayHaveFired():
            return message(marked("It reported TRIGGERED, or was told to fire before it had this name."))
        case Serviced():
            return service_summary(content)
        case ModuleProvisioned():
            return message(marked("Made in the batch {batch}."), batch=clean(content.batch))
        case _:
            return None


def _with_note(text: UserMessage, note: str) -> UserMessage:
    return joined((text, UserMessage(f"“{clean(note)}”")), " ") if note else text


def _check(line: CheckLine) -> UserMessage:
    who = UserMessage(line.who) if line.who else message(marked("not named"))
    return message(marked("Pre-flight check: {verdict}, checked by: {who}."), verdict=line.words, who=who)


def _guided_test(one: Kept[GuidedTestDone]) -> UserMessage:
    test = told_test(one)
    if test is None:
        return UserMessage(clean(one.content.test))  # of a newer version
    verdict = message(VERDICT_WORDS[test.verdict])
    if test.is_simulated:
        verdict = noted(verdict, marked("simulated"))
    return message(marked("Guided test {test}: {verdict}."), test=message(TEST_TITLES[test.kind]), verdict=verdict)


def _act(intent: ActIntended, outcome: str, known: _Known) -> UserMessage:
    act = next((act for act in Act if act.value == intent.act), None)
    if act is None:
        what = UserMessage(clean(intent.act))  # of a newer version
    elif act is Act.WRITE:
        what = known.write(intent.detail, outcome)
    elif act is Act.CHANGE_BAUD:
        what = UserMessage(f"{message(TITLES[act]).in_english()} {intent.detail.get('new')}")
    else:
        what = message(TITLES[act])
    told = message(marked("{value}: {why}."), value=what, why=message(_OUTCOMES[outcome]))
    return _with_note(told, intent.note)
