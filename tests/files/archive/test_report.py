"""Every module today, over all stations; and what happened to one."""

import json
import re
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from app.archive.archive import sync
from app.archive.report import HistoryEvent, as_edits, last_writes, module_history, report, settings_changed
from app.safety.journal import NOTE, Act, Outcome
from app.store.fact_store import Store
from app.store.rows import (
    Content,
    Judgement,
    ModuleVisited,
    PreflightCheck,
    Serviced,
    ServiceKind,
    SettingsSeen,
    TriggerRecordJudged,
    TriggerRecordSeen,
)
from tests.files.records.test_filing import file_one
from tests.support.cli_line import Printed, faults, run_here
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import begin, open_store, settle

NOW = datetime.now(UTC)
RAW = "41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E"
NO_CHECK = "No valid check within the last 30 days."
SETTINGS: dict[str, Any] = {"attitude_threshold_deg": 60, "freefall_time_s": 1.2}


@pytest.fixture
def here(user_files: Path) -> Iterator[Store]:
    """That of the commands, too."""
    with closing(open_store()) as store:
        yield store


@pytest.fixture
def other(tmp_path: Path) -> Iterator[Store]:
    with closing(open_store(tmp_path / "other")) as store:
        yield store


def add(store: Store, content: Content, days_ago: float = 0.0) -> None:
    at = NOW - timedelta(days=days_ago)
    store.write(lambda facts: facts.add(content, "M-07", at=at)).result(PATIENCE_S)


def visit(boots: int) -> ModuleVisited:
    return ModuleVisited(port="p", boot_count=boots, slots=[], is_confirmed=True)


def due(store: Store) -> list[str]:
    (state,) = report(store, NOW + timedelta(seconds=1))
    return [one.in_english() for one in state.due]


def asks(store: Store) -> bool:
    return any("Two modules?" in text for text in due(store))


def checked(verdict: Any = "GO", *, is_simulated: bool = False, is_void: bool = False) -> PreflightCheck:
    return PreflightCheck(verdict=verdict, is_void=is_void, is_simulated=is_simulated, document="{}")


@pytest.mark.parametrize(
    ("checks", "said"),
    [
        ([], [NO_CHECK]),
        ([(checked(), 1)], []),
        ([(checked(), 31)], [NO_CHECK]),
        ([(checked(is_void=True), 1)], [NO_CHECK]),
        ([(checked(), 3), (checked("NO-GO"), 2)], [NO_CHECK]),
        ([(checked("NO-GO"), 3), (checked("READY"), 2)], []),
        ([(checked(), 3), (checked("NO-GO", is_simulated=True), 2)], []),
        ([(checked(is_simulated=True), 2)], [NO_CHECK]),
    ],
)
def test_what_is_due_of_the_last_check(here: Store, checks: list[tuple[PreflightCheck, int]], said: list[str]) -> None:
    add(here, visit(3))
    for check, days_ago in checks:
        add(here, check, days_ago)
    assert due(here) == said


@pytest.mark.parametrize(
    ("boots", "is_asked"),
    [
        ([(40, 3), (41, 2)], False),
        ([(40, 3), (39, 2)], True),
        ([(250, 3), (122, 2)], False),
        ([(250, 3), (123, 2)], True),
        ([(4, 3), (250, 2)], True),
        ([(40, 200), (39, 190)], False),
    ],
)
def test_two_modules_are_asked_about_where_the_boot_count_went_back(
    here: Store, boots: list[tuple[int, float]], is_asked: bool
) -> None:
    for count, days_ago in boots:
        add(here, visit(count), days_ago)
    assert asks(here) is is_asked
    add(here, Serviced(service=ServiceKind.FIRMWARE, on=(NOW - timedelta(days=2)).date(), due=None, who="Li"))
    assert not asks(here), "also on the same day"


def test_two_modules_are_asked_about_where_two_stations_read_it(here: Store, other: Store, tmp_path: Path) -> None:
    add(here, visit(40), 2.0)
    add(other, visit(39), 1.0)
    for store in (other, here):
        sync(store, str(tmp_path / "stick"))
    assert asks(here)


def test_a_trigger_record_that_two_stations_read_is_one_and_judged_by_either(
    here: Store, other: Store, tmp_path: Path
) -> None:
    for store in (here, other):
        add(store, TriggerRecordSeen(place=0, raw=RAW))
    add(here, TriggerRecordSeen(place=1, raw=RAW.replace("6C", "6D")))
    for judgement, unjudged in ((Judgement.BENCH_TEST, 1), (None, 2)):
        add(other, TriggerRecordJudged(place=0, raw=RAW, judgement=judgement))
        for store in (other, here):
            sync(store, str(tmp_path / "stick"))
        assert due(here) == [NO_CHECK, f"Unjudged trigger records: {unjudged}."]


# The history of one: its settings before and after, over a restart, and earlier ones to be written again


def seen(store: Store, boot_count: int, **settings: Any) -> None:
    add(store, SettingsSeen(port="P", boot_count=boot_count, settings=SETTINGS | settings), 1 - boot_count / 1e3)


def write(store: Store, outcome: Outcome, *, note: str = "", **detail: Any) -> None:
    detail |= {NOTE: note} if note else {}
    intent = begin(store, Act.WRITE, b"\x20", detail, port="P", name="M-07")
    settle(store, intent, outcome)


def history(store: Store) -> tuple[list[HistoryEvent], list[str]]:
    events = module_history(store, "M-07")
    return events, [event.text.in_english() for event in events]


def test_a_write_is_told_with_the_value_before_and_why(here: Store) -> None:
    seen(here, 4)
    write(here, Outcome.CONFIRMED, note="Li Wei: heavier battery", attitude_threshold_deg=65)
    write(here, Outcome.REFUSED, attitude_threshold_deg=70)
    write(here, Outcome.UNKNOWN, attitude_threshold_deg=75)
    write(here, Outcome.CONFIRMED, attitude_threshold_deg=80, attitude_trigger=True)
    add(here, SettingsSeen(port="P", boot_count=4, settings=SETTINGS | {"attitude_threshold_deg": 80}), -0.01)
    events, told = history(here)
    assert told == [
        "Settings: Attitude threshold 60°, Free-fall time 1.20 s.",
        "Attitude threshold 60° → 65°: confirmed. “Li Wei: heavier battery”",
        "Attitude threshold 65° → 70°: refused.",
        "Attitude threshold 65° → 75°: may have been carried out.",
        "Attitude threshold 80°, Attitude trigger Enabled: confirmed.",
        "Settings: Attitude threshold 80°, Free-fall time 1.20 s.",
    ]
    assert [event.settings.get("attitude_threshold_deg") for event in events] == [60, 65, 65, None, 80, 80]
    assert [event.settings.get("attitude_trigger") for event in events[-2:]] == [True, None], "it cannot be read"
    changed = settings_changed(events[0].settings, events[-1].settings)
    assert [one.in_english() for one in changed] == ["Attitude threshold 60° → 80°"]
    assert as_edits(events[0].settings) == SETTINGS
    assert as_edits({**events[-1].settings, "freefall_time_s": 1e9, "unheard_of": 1}) == {"attitude_threshold_deg": 80}


def test_of_each_setting_it_is_told_who_wrote_it_last(here: Store) -> None:
    seen(here, 4)
    write(here, Outcome.CONFIRMED, note="Li Wei: heavier battery", attitude_threshold_deg=65)
    write(here, Outcome.REFUSED, attitude_threshold_deg=70)
    write(here, Outcome.NOT_SENT, freefall_time_s=2.0)
    told = here.read(lambda facts: last_writes(facts, "M-07") | last_writes(facts, "M-08"))
    assert list(told) == ["attitude_threshold_deg"]
    text = told["attitude_threshold_deg"].in_english()
    assert re.fullmatch(r"Written 20.*: Attitude threshold 60° → 65°: confirmed\. “Li Wei: heavier battery”", text)


def test_over_a_restart_it_is_told_what_was_kept(here: Store) -> None:
    add(here, visit(4), 2)
    for boot_count, settings in ((5, {}), (6, {}), (7, {"freefall_time_s": 1.0}), (19, {})):
        seen(here, boot_count, **settings)
    assert history(here)[1] == [
        "Settings: Attitude threshold 60°, Free-fall time 1.20 s.",
        "Over the restart: settings kept.",
        "Over the restart: Free-fall time 1.20 s → 1.00 s.",
        "Read since: Free-fall time 1.00 s → 1.20 s.",
    ]


# The commands


@pytest.fixture
def say(capsys: pytest.CaptureFixture[str]) -> Callable[..., Printed]:
    return lambda *words, code=0: run_here(capsys, ["archive", *words], code)


def told(say: Callable[..., Printed], schema: str, *words: str) -> Any:
    found = json.loads(say(*words, "--json").out)
    assert faults(schema, found) == []
    return found


def test_the_commands_tell_of_all_stations(
    here: Store, other: Store, tmp_path: Path, say: Callable[..., Printed]
) -> None:
    file_one(other, "M-07", port="/dev/ttyUSB0")
    seen(other, 3)
    write(other, Outcome.CONFIRMED, freefall_time_s=1.4)
    stick = str(tmp_path / "stick")
    sync(other, stick)
    done = told(say, "archive_sync", "sync", stick)
    assert (done["place"], done["left_out"]) == (stick, [])
    assert done["received"] > 3
    assert told(say, "archive_status", "status")["facts"] == done["received"] + 1
    (module,) = told(say, "archive_report", "report")["modules"]
    assert (module["module"], module["checks"], module["last_check"]["verdict"]) == ("M-07", 1, "READY")
    contents = {event["kind"]: event["content"] for event in told(say, "archive_module", "module", "M-07")["events"]}
    assert contents["settings_seen"]["settings"] == SETTINGS
    assert (contents["act"]["detail"], contents["act"]["outcome"]) == ({"freefall_time_s": 1.4}, "confirmed")
    assert contents["preflight_check"]["cell_voltage_v"] == 3.9
    assert "module," in say("report", "--csv").out
    assert "1.40 s" in say("module", "M-07").out
    service = told(say, "archive_service", "service", "M-07", "--what", "repack", "--who", "Li", "--due", "2099-01-01")
    assert service["module"] == "M-07"
    assert "Repack" in say("module", "M-07").out
    assert say("module", "M-99", code=1).err
    assert say("service", "M-99", "--what", "repack", "--who", "Li", code=1).err
    assert say("sync", "postgresql://nobody:secret@127.0.0.1:1/x", code=2).err.count("secret") == 0
    assert say("sync", code=2).err
    here.set_state("server", "postgresql://127.0.0.1:1/x").result()
    assert "127.0.0.1" in say("sync", code=3).err
    with closing(sqlite3.connect(stick)) as altered:
        altered.execute(
            "INSERT INTO facts SELECT ?, kind, module, station, made_at, content FROM facts LIMIT 1", ("f" * 40,)
        )
        altered.commit()
    assert say("sync", stick, code=4).err.count("altered") == 2
