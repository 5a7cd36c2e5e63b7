"""All modules of all stations today: the last check, trigger records, guided tests, and what is due; and the history of
one as sentences.

For people: it warns and shows. No verdict and no condition of an act rests on it, as others may have written anything.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from datetime import datetime, timedelta
from itertools import pairwise, takewhile
from typing import Any, NamedTuple

from msgspec import Struct, to_builtins

from app.archive.archive import all_facts
from app.guided import results as guided
from app.modules.names import COUNTS_FOR
from app.modules.service import RESETS_BOOT_COUNT, service_due, service_summary
from app.records.filing import CheckLine, check_line
from app.safety.journal import TITLES, Act, Outcome
from app.settings.values import field_of, fitting, kept_value_message, setting_message
from app.store import rows
from app.store.acts import all_fired
from app.store.fact_store import Facts, Kept, Store
from app.system.clock import local_time
from app.text.messages import UserError, UserMessage, clean, join_sentences, joined, message
from app.trigger_records.history import record_of, sentence
from protocol.catalogue import BOOTS, READABLE_SETTINGS
from protocol.fields import Value
from protocol.translatable import marked

CHECK_DAYS = 30
_OUTCOMES: Mapping[Outcome, str] = {
    Outcome.CONFIRMED: marked("{what}: confirmed."),
    Outcome.REFUSED: marked("{what}: refused."),
    Outcome.UNKNOWN: marked("{what}: may have been carried out."),
    Outcome.NOT_SENT: marked("{what}: not sent."),
}


class ModuleToday(Struct, kw_only=True):
    """`checks`: how many. `unjudged`: trigger records without a judgement."""

    name: str
    last_at: str
    checks: int
    last_check: CheckLine | None
    trigger_records: int
    unjudged: int
    due: list[UserMessage]

    @property
    def due_words(self) -> str:
        """In the language in use."""
        return join_sentences(due.translated() for due in self.due)


def report(store: Store, now: datetime) -> list[ModuleToday]:
    """Return all modules by name. It takes up to two seconds. Raises `UserError`."""
    last_at: dict[str, str] = {}
    latest = rows.time_text(now + rows.AHEAD)
    with all_facts(store) as facts:
        for file in ("main", "own"):  # each by its index: of both together the whole would be read
            # What is about no module has NULL there.
            query = f"SELECT module, max(made_at) FROM {file}.facts WHERE module > '' AND made_at <= ? GROUP BY module"  # noqa: S608
            for name, at in facts.connection.execute(query, (latest,)):
                last_at[name] = max(at, last_at.get(name, ""))
        return [_today(facts, name, last_at[name], now) for name in sorted(last_at)]


def _today(facts: Facts, name: str, last_at: str, now: datetime) -> ModuleToday:
    # None of the checks but the last is read: they are large. A simulated one counts only if there is no other.
    query = "SELECT count(*) FROM facts WHERE kind = ? AND module = ?"
    count = facts.connection.execute(query, (rows.KIND_OF[rows.PreflightCheck], name)).fetchone()[0]
    checks = facts.back_from_newest(rows.PreflightCheck, name)
    last = next((check for check in checks if not check.content.is_simulated), None)
    last = last or facts.newest(rows.PreflightCheck, name)
    check = None if last is None else check_line(last, all_fired(facts, name))
    # What two stations read of one module is the same record. The last word about it counts, whose it ever is.
    seen = {kept.content.raw for kept in facts.of_module(rows.TriggerRecordSeen, name)}
    last_word = {kept.content.raw: kept.content.judgement for kept in facts.of_module(rows.TriggerRecordJudged, name)}
    unjudged = sum(last_word.get(raw) is None for raw in seen)
    due = []
    since = rows.time_text(now - timedelta(days=CHECK_DAYS))
    if check is None or check.is_simulated or not check.holds or check.at < since:
        due.append(message(marked("No valid check within the last {days} days."), days=CHECK_DAYS))
    if unjudged:
        due.append(message(marked("Unjudged trigger records: {count}."), count=unjudged))
    tests = sorted(guided.last_tests(facts, name, counts_simulated=False).values(), key=lambda test: test.kind.value)
    due += [_guided_test(test) for test in tests if test.verdict is not guided.GuidedVerdict.PASSED]
    due += [service.text for service in service_due(facts, name, now.astimezone())]
    due += two_modules(facts, name, now)
    return ModuleToday(
        name=name,
        last_at=last_at,
        checks=count,
        last_check=check,
        trigger_records=len(seen),
        unjudged=unjudged,
        due=due,
    )


def _guided_test(test: guided.StoredTest) -> UserMessage:
    word = message(guided.VERDICT_WORDS[test.verdict])
    if test.is_simulated:
        word = message(marked("{verdict} (simulated)"), verdict=word)
    return message(marked("Guided test {test}: {verdict}."), test=message(guided.TITLES[test.kind]), verdict=word)


def two_modules(facts: Facts, name: str, now: datetime) -> list[UserMessage]:
    """The last contradiction, if any, as if two modules had this name: the boot count went back within half a year."""
    services = [kept.content for kept in facts.of_module(rows.Serviced, name)]
    # An exchange of parts that a person entered later has explained it.
    explained = max((one.on.isoformat() for one in services if one.service in RESETS_BOOT_COUNT), default="")
    since = rows.time_text(now - COUNTS_FOR)
    recent = takewhile(lambda visit: visit.at >= since, facts.back_from_newest(rows.ModuleVisited, name))
    counted = ((one.at, one.content.boot_count) for one in recent if one.content.boot_count is not None)
    for (at, count), (at_before, before) in pairwise(counted):
        if (count - before) % BOOTS > BOOTS // 2 and at[:10] > explained:
            text = marked("Two modules? Boot count {before} on {then}, {now} on {day}.")
            return [message(text, before=before, then=at_before[:10], now=count, day=at[:10])]
    return []


# The history of one module


class HistoryEvent(NamedTuple):
    """One fact about a module as a sentence. `content` is as it is kept, of an act with its outcome and of a check
    without the signed document; `settings` are as they were known then."""

    row: rows.Row
    text: UserMessage
    content: dict[str, Any]
    settings: Mapping[str, Value]


def module_history(store: Store, name: str) -> list[HistoryEvent]:
    """The oldest first; empty where no station knows a module of this name. Raises `UserError`."""
    with all_facts(store) as facts:
        return list(_events(facts, name, rows.KIND_OF))


def last_writes(facts: Facts, module: str) -> dict[str, UserMessage]:
    """When each setting was last written here under this name, from what to what, and the note of who did it."""
    told: dict[str, UserMessage] = {}
    for event in _events(facts, module, (rows.SettingsSeen, rows.ActIntended, rows.ActEnded)):
        content = event.content
        # What was refused or never left changed nothing.
        may_have_changed = content.get("outcome") in (Outcome.CONFIRMED.value, Outcome.UNKNOWN.value)
        if may_have_changed and content["act"] == Act.WRITE.value:
            when = local_time(event.row.made_at)
            text = message(marked("Written {when}: {what}"), when=when, what=event.text)
            told |= dict.fromkeys(content["detail"], text)
    return told


def _events(facts: Facts, name: str, types: Iterable[type[rows.Content]]) -> Iterator[HistoryEvent]:
    """Return the facts of these types about a module, the oldest first."""
    kept: list[Kept[Any]] = [one for type_ in types for one in facts.of_module(type_, name)]
    outcomes = {one.content.of: one.content.outcome for one in kept if isinstance(one.content, rows.ActEnded)}
    fired = all_fired(facts, name)
    # As far as the facts tell it, from the oldest on.
    settings: dict[str, Value] = {}
    boot_count: int | None = None
    for one in sorted(kept, key=lambda one: one.at):
        content, plain = one.content, to_builtins(one.content)
        text: UserMessage | None = None
        match content:
            case rows.ModuleVisited():
                boot_count = content.boot_count
            case rows.SettingsSeen():
                has_restarted = boot_count is not None and (boot_count + 1) % BOOTS == content.boot_count
                boot_count = content.boot_count
                if content.settings:
                    text = _settings_seen(settings, content.settings, has_restarted=has_restarted)
                    settings = dict(content.settings)
            case rows.ActIntended():
                outcome = outcomes.get(one.row.id, Outcome.UNKNOWN)
                what = _act(content, outcome, settings)
                text = _with_note(message(_OUTCOMES[outcome], what=what), content.note)
                plain["outcome"] = outcome.value
            case rows.PreflightCheck():
                del plain["document"]
                line = check_line(one, fired)
                who = UserMessage(line.who) if line.who else message(marked("not named"))
                text = message(marked("Pre-flight check: {verdict}, checked by: {who}."), verdict=line.words, who=who)
            case rows.GuidedTestDone():
                test = guided.read_test(one)
                # One of a newer version is told by its word.
                text = UserMessage(clean(content.test)) if test is None else _guided_test(test)
            case rows.ModuleNamed():
                text = message(marked("Named."))
            case rows.TriggerRecordSeen():
                what = UserMessage(content.raw)
                with suppress(ValueError):  # of another station it may be anything
                    what = sentence(record_of(bytes.fromhex(content.raw)))
                text = message(marked("Trigger record: {what}"), what=what)
            case rows.TriggerRecordJudged():
                word = marked("none") if content.judgement is None else content.judgement.value
                text = _with_note(message(marked("Judged: {judgement}."), judgement=message(word)), content.note)
            case rows.MayHaveFired():
                text = message(marked("It reported TRIGGERED, or was told to fire before it had this name."))
            case rows.Serviced():
                text = service_summary(content)
            case rows.ModuleProvisioned():
                text = message(marked("Made in the batch {batch}."), batch=clean(content.batch))
        if text is not None:
            yield HistoryEvent(one.row, text, plain, dict(settings))


def _with_note(text: UserMessage, note: str) -> UserMessage:
    return joined((text, UserMessage(f"“{clean(note)}”")), " ") if note else text


def _settings_seen(before: Mapping[str, Value], now: Mapping[str, Value], *, has_restarted: bool) -> UserMessage:
    """Say what a reading tells beside the one before: whether settings outlived a restart; else all of them."""
    changes = settings_changed(before, now)
    if before and has_restarted:
        what = joined(changes) if changes else message(marked("settings kept"))
        return message(marked("Over the restart: {what}."), what=what)
    if changes:
        return message(marked("Read since: {what}."), what=joined(changes))
    every = joined([setting_message(key, value) for key, value in sorted(now.items())])
    return message(marked("Settings: {settings}."), settings=every)


def _act(intent: rows.ActIntended, outcome: Outcome, settings: dict[str, Value]) -> UserMessage:
    """Say what was done; of a write each value with the one before. `settings` are as they are known, kept up to
    date."""
    act = next((act for act in Act if act.value == intent.act), None)
    if act is None:
        return UserMessage(clean(intent.act))  # of a newer version
    if act is Act.CHANGE_BAUD:
        return UserMessage(f"{message(TITLES[act]).in_english()} {intent.detail.get('new')}")
    if act is not Act.WRITE:
        return message(TITLES[act])
    told = []
    for key, value in sorted(intent.detail.items()):
        told += settings_changed(settings, {key: value}) or [setting_message(key, value)]
        if outcome is Outcome.CONFIRMED:
            settings[key] = value  # type: ignore[assignment]
        elif outcome is Outcome.UNKNOWN:
            settings.pop(key, None)
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
    """Return the settings that can be written again. Another station may have kept any number."""
    edits = {}
    for command in READABLE_SETTINGS:
        with suppress(KeyError, UserError):
            edits[command.key] = fitting(field_of(command), settings[command.key])
    return edits
