"""History of one module over all stations: what is known of it, as sentences."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from msgspec import to_builtins

from app.archive.archive import Archive
from app.guided.guided_store import told_test
from app.guided.results import TITLES as TEST_TITLES
from app.guided.results import VERDICT_WORDS
from app.modules.service import service_summary
from app.records.checks import CheckLine, check_line, noted
from app.safety.acts import TITLES, Act
from app.safety.journal import Outcome
from app.settings.values import setting_message
from app.store.fact_store import Facts, Kept
from app.store.fired import all_fired
from app.store.kinds import (
    KIND_OF,
    ActEnded,
    ActIntended,
    Content,
    GuidedTestDone,
    MayHaveFired,
    ModuleNamed,
    ModuleProvisioned,
    PreflightCheck,
    Serviced,
    SettingsSeen,
    TriggerRecordJudged,
    TriggerRecordSeen,
)
from app.store.rows import Row
from app.text.messages import UserMessage, clean, joined, message
from app.trigger_records.history import JUDGEMENT_WORDS, Judgement, record_of, sentence
from protocol.translatable import marked

RECORD_BYTES = 16
_OUTCOMES: Mapping[str, str] = {
    Outcome.CONFIRMED.value: marked("confirmed"),
    Outcome.REFUSED.value: marked("refused"),
    Outcome.UNKNOWN.value: marked("may have been carried out"),
    Outcome.NOT_SENT.value: marked("not sent"),
}


class HistoryEvent(NamedTuple):
    """One fact about a module as a sentence. `content`: as it is kept, of an act with its outcome and of a check
    without the signed document."""

    row: Row
    text: UserMessage
    content: dict[str, Any]


def module_history(archive: Archive, name: str) -> list[HistoryEvent]:
    """The oldest first; empty where no station knows a module of this name. Raises `UserError`."""
    return archive.read(lambda facts: _history(facts, name))


def _history(facts: Facts, name: str) -> list[HistoryEvent]:
    kept: list[Kept[Any]] = [one for type_ in KIND_OF for one in facts.of_module(type_, name)]
    fired = all_fired(facts, name)
    outcomes = {one.content.of: one.content.outcome for one in facts.of_module(ActEnded, name)}
    events = []
    for one in sorted(kept, key=lambda one: one.at):
        content = to_builtins(one.content)
        text: UserMessage | None
        if isinstance(one.content, PreflightCheck):
            del content["document"]
            text = _check(check_line(one).after(fired))
        elif isinstance(one.content, ActIntended):
            content["outcome"] = outcomes.get(one.row.id, Outcome.UNKNOWN.value)
            outcome = message(_OUTCOMES[content["outcome"]])
            text = message(marked("{value}: {why}."), value=_act(one.content), why=outcome)
        elif isinstance(one.content, GuidedTestDone):
            text = _guided_test(one)
        else:
            text = _told(one.content)
        if text is not None:
            events.append(HistoryEvent(one.row, text, content))
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
            judged = message(marked("Judged: {judgement}."), judgement=word)
            return joined((judged, UserMessage(f"“{clean(content.note)}”")), " ") if content.note else judged
        case SettingsSeen():
            settings = joined([setting_message(key, value) for key, value in sorted(content.settings.items())])
            return message(marked("{value}: {why}."), value=message(marked("Settings")), why=settings)
        case MayHaveFired():
            return message(marked("It reported TRIGGERED, or was told to fire before it had this name."))
        case Serviced():
            return service_summary(content)
        case ModuleProvisioned():
            return message(marked("Made in the batch {batch}."), batch=clean(content.batch))
        case _:
            return None


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


def _act(content: ActIntended) -> UserMessage:
    act = next((act for act in Act if act.value == content.act), None)
    if act is None:
        return UserMessage(clean(content.act))  # of a newer version
    if act is Act.WRITE:
        return joined([setting_message(key, value) for key, value in sorted(content.detail.items())])
    if act is Act.CHANGE_BAUD:
        return UserMessage(f"{message(TITLES[act]).in_english()} {content.detail.get('new')}")
    return message(TITLES[act])
