"""History of one module over all stations: its events as sentences, and its measured values over time."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from msgspec import to_builtins

from app.archive.archive import Archive
from app.guided.guided_store import told_test
from app.guided.results import TITLES as TEST_TITLES
from app.guided.results import VERDICT_WORDS
from app.modules.service import service_summary
from app.records.checks import check_line, measuring, noted
from app.safety.acts import TITLES, Act
from app.safety.journal import Outcome
from app.settings.profiles import SETTINGS_BY_KEY
from app.settings.setting_texts import value_message
from app.settings.values import field_of, fitting
from app.store.fact_store import Facts, Kept
from app.store.fired import Fired, all_fired
from app.store.kinds import (
    ActEnded,
    ActIntended,
    Content,
    DeployIntended,
    GuidedTestDone,
    MayHaveFired,
    ModuleNamed,
    ModuleProvisioned,
    PreflightCheck,
    Serviced,
    SettingsApproved,
    SettingsSeen,
    SettingsWritten,
    TriggerRecordJudged,
    TriggerRecordSeen,
)
from app.store.rows import Row
from app.text.messages import UserMessage, clean, joined, message
from app.text.user_error import UserError
from app.trigger_records.history import JUDGEMENT_WORDS, Judgement, record_of, sentence
from protocol.translatable import marked

_KINDS: tuple[type[Content], ...] = (
    ModuleNamed,
    TriggerRecordSeen,
    TriggerRecordJudged,
    SettingsSeen,
    SettingsWritten,
    SettingsApproved,
    PreflightCheck,
    GuidedTestDone,
    ActIntended,
    DeployIntended,
    MayHaveFired,
    Serviced,
    ModuleProvisioned,
)
"""In the order in which what was recorded at once is shown."""
RECORD_BYTES = 16
_OUTCOMES: Mapping[str, str] = {
    Outcome.CONFIRMED.value: marked("confirmed"),
    Outcome.REFUSED.value: marked("refused"),
    Outcome.UNKNOWN.value: marked("may have been carried out"),
    Outcome.NOT_SENT.value: marked("not sent"),
}


class HistoryEvent(NamedTuple):
    """One fact about a module as a sentence."""

    row: Row
    text: UserMessage
    content: dict[str, Any]


class ValuePoint(NamedTuple):
    """A value that a check measured."""

    at: str
    station: str
    value: float


class ModuleHistory(NamedTuple):
    """Oldest event first."""

    name: str
    events: tuple[HistoryEvent, ...]
    values: Mapping[str, tuple[ValuePoint, ...]]


def module_history(archive: Archive, name: str) -> ModuleHistory | None:
    """None where no station knows a module of this name. Raises `UserError`."""
    return archive.read(lambda facts: _history(facts, name))


def _history(facts: Facts, name: str) -> ModuleHistory | None:
    kept = [one for kind in _KINDS for one in facts.of_module(kind, name)]
    if not kept:
        return None
    kept.sort(key=lambda one: one.at)
    fired = all_fired(facts, name)
    ends = {one.content.of: one.content.outcome for one in facts.of_module(ActEnded, name)}
    events = []
    for one in kept:
        content = to_builtins(one.content)
        content.pop("document", None)  # as large as all the rest, and for `dps-s verify`
        if isinstance(one.content, ActIntended):
            content["outcome"] = ends.get(one.row.id, Outcome.UNKNOWN.value)
        events.append(HistoryEvent(one.row, _told(one, ends, fired), content))
    return ModuleHistory(name, tuple(events), _values(facts.of_module(PreflightCheck, name)))


def _values(checks: Sequence[Kept[PreflightCheck]]) -> dict[str, tuple[ValuePoint, ...]]:
    values: dict[str, list[ValuePoint]] = {}
    for line in measuring([check_line(check) for check in checks]):
        for name, value in line.measured.items():
            values.setdefault(name, []).append(ValuePoint(line.at, line.station, value))
    return {name: tuple(values[name]) for name in sorted(values)}


def _told(one: Kept[Any], ends: Mapping[str, str], fired: Iterable[Fired]) -> UserMessage:
    content = one.content
    if isinstance(content, ActIntended):
        outcome = message(_OUTCOMES[ends.get(one.row.id, Outcome.UNKNOWN.value)])
        return message(marked("{value}: {why}."), value=_act(content), why=outcome)
    if isinstance(content, PreflightCheck):
        line = check_line(one).after(fired)
        who = UserMessage(clean(line.who)) if line.who else message(marked("not named"))
        return message(marked("Pre-flight check: {verdict}, checked by: {who}."), verdict=line.words, who=who)
    if isinstance(content, GuidedTestDone):
        return _guided_test(one)
    return _SENTENCES[type(content)](content)


def _named(_content: ModuleNamed) -> UserMessage:
    return message(marked("Named, or met at another adapter."))


def _trigger_record(content: TriggerRecordSeen) -> UserMessage:
    raw = bytes.fromhex(content.raw)
    what = sentence(record_of(raw)) if len(raw) == RECORD_BYTES else UserMessage(content.raw)
    return message(marked("Trigger record: {what}"), what=what)


def _judgement(content: TriggerRecordJudged) -> UserMessage:
    if content.judgement is None:
        return message(marked("Judgement taken back."))
    word = message(JUDGEMENT_WORDS[Judgement(content.judgement)])
    judged = message(marked("Judged: {judgement}."), judgement=word)
    return joined((judged, UserMessage(f"“{clean(content.note)}”")), " ") if content.note else judged


def _seen(content: SettingsSeen) -> UserMessage:
    return message(marked("{value}: {why}."), value=message(marked("Settings")), why=_settings(content.settings))


def _written(content: SettingsWritten) -> UserMessage:
    changed = {key: value for key, value in content.after.items() if content.before.get(key) != value}
    before = {key: value for key, value in content.before.items() if key in changed}
    text = marked("Settings written: {after}; before: {before}.")
    return message(text, after=_settings(changed), before=_settings(before))


def _approved(content: SettingsApproved) -> UserMessage:
    return message(marked("Settings approved: {settings}."), settings=_settings(content.settings))


def _fired(_content: MayHaveFired) -> UserMessage:
    return message(marked("It reported TRIGGERED, or was told to fire before it had this name."))


def _serviced(content: Serviced) -> UserMessage:
    return service_summary(content)


def _provisioned(content: ModuleProvisioned) -> UserMessage:
    return message(marked("Made in the batch {batch}."), batch=clean(content.batch))


_SENTENCES: Mapping[type[Content], Callable[[Any], UserMessage]] = {
    ModuleNamed: _named,
    TriggerRecordSeen: _trigger_record,
    TriggerRecordJudged: _judgement,
    SettingsSeen: _seen,
    SettingsWritten: _written,
    SettingsApproved: _approved,
    MayHaveFired: _fired,
    Serviced: _serviced,
    ModuleProvisioned: _provisioned,
}


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
        return joined([_setting(key, value) for key, value in sorted(content.detail.items())])
    if act is Act.CHANGE_BAUD:
        return UserMessage(f"{message(TITLES[act]).in_english()} {content.detail.get('new')}")
    return message(TITLES[act])


def _settings(settings: Mapping[str, Any]) -> UserMessage:
    return joined([_setting(key, settings[key]) for key in sorted(settings)])


def _setting(key: str, value: object) -> UserMessage:
    """A setting with its value and unit; one that this version does not know by its key."""
    command = SETTINGS_BY_KEY.get(key)
    if command is None:
        return UserMessage(clean(f"{key} {value}"))
    try:
        shown = value_message(command, fitting(field_of(command), value))
    except UserError:  # another station may have written any number
        shown = UserMessage(clean(str(value)))
    return message("{name} {value}", name=message(command.title), value=shown)
