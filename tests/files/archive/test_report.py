"""Every module today, over all stations; and the history of one."""

import json
from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from app.archive.archive import Archive
from app.archive.report import ModuleToday, report
from app.archive.sync import sync
from app.safety.journal import Act, Outcome
from app.safety.left_active import KnownAs
from app.store.fact_store import Store
from app.store.rows import (
    Content,
    ModuleVisited,
    PreflightCheck,
    Serviced,
    SettingsSeen,
    TriggerRecordJudged,
    TriggerRecordSeen,
)
from tests.cli.test_schemas import faults
from tests.files.records.test_filing import file_one
from tests.support.cli_line import Printed, run_here
from tests.support.patience import PATIENCE_S
from tests.support.records.stored import begin, open_store, settle

NOW = datetime.now(UTC)
RAW = "41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E"


@pytest.fixture
def here(user_files: Path) -> Iterator[Store]:
    """That of the commands, too."""
    with closing(open_store()) as store:
        yield store


@pytest.fixture
def other(tmp_path: Path) -> Iterator[Store]:
    with closing(open_store(tmp_path / "other")) as store:
        yield store


def add(store: Store, content: Content, days_ago: float = 0.0, module: str = "M-07") -> None:
    at = NOW - timedelta(days=days_ago)
    store.write(lambda facts: facts.add(content, module, at=at)).result(PATIENCE_S)


def visit(boots: int) -> ModuleVisited:
    return ModuleVisited(port="p", boot_count=boots, slots=[], is_confirmed=True, known=0)


def today(store: Store) -> ModuleToday:
    (state,) = report(Archive(store), NOW + timedelta(seconds=1))
    return state


def due(store: Store) -> list[str]:
    return [one.kind.value for one in today(store).due]


def checked(verdict: Any = "GO", *, is_simulated: bool = False, is_void: bool = False) -> PreflightCheck:
    return PreflightCheck(verdict=verdict, is_void=is_void, is_simulated=is_simulated, document="{}")


@pytest.mark.parametrize(
    ("checks", "kinds"),
    [
        ([], ["no_check"]),
        ([(checked(), 1)], []),
        ([(checked(), 31)], ["old_check"]),
        ([(checked("NO-GO"), 1)], ["no_go"]),
        ([(checked(is_void=True), 1)], ["no_go"]),
        ([(checked(), 3), (checked("NO-GO"), 2)], ["no_go"]),
        ([(checked("NO-GO"), 3), (checked("READY"), 2)], []),
        ([(checked(), 3), (checked("NO-GO", is_simulated=True), 2)], []),
        ([(checked(is_simulated=True), 2)], ["no_check"]),
    ],
)
def test_what_is_due_of_the_last_check(here: Store, checks: list[tuple[PreflightCheck, int]], kinds: list[str]) -> None:
    add(here, visit(3))
    for check, days_ago in checks:
        add(here, check, days_ago)
    assert due(here) == kinds


@pytest.mark.parametrize(
    ("boots", "is_asked"),
    [
        ([(40, 3), (41, 2)], False),
        ([(40, 3), (39, 2)], True),
        ([(250, 3), (4, 2)], False),
        ([(4, 3), (250, 2)], True),
        ([(40, 200), (39, 190)], False),
    ],
)
def test_two_modules_are_asked_about_where_the_boot_count_went_back(
    here: Store, boots: list[tuple[int, float]], is_asked: bool
) -> None:
    for count, days_ago in boots:
        add(here, visit(count), days_ago)
    assert bool(today(here).two_modules) is is_asked
    assert ("two_modules" in due(here)) is is_asked
    add(here, Serviced(service="firmware", on=NOW.date(), due=None, who="Li"))
    assert today(here).two_modules == []


@pytest.mark.parametrize(("minutes", "is_asked"), [(10, False), (20, True)])
def test_the_clocks_of_two_stations_may_differ_by_minutes(
    here: Store, other: Store, tmp_path: Path, minutes: float, is_asked: bool
) -> None:
    add(here, visit(40), 1.0)
    add(other, visit(39), 1.0 - minutes / 24 / 60)
    for store in (other, here):
        sync(Archive(store), str(tmp_path / "stick"))
    assert bool(today(here).two_modules) is is_asked


def test_a_trigger_record_that_two_stations_read_is_one_and_judged_by_either(
    here: Store, other: Store, tmp_path: Path
) -> None:
    for store in (here, other):
        add(store, TriggerRecordSeen(place=0, raw=RAW))
    add(here, TriggerRecordSeen(place=1, raw=RAW.replace("6C", "6D")))
    add(other, TriggerRecordJudged(place=0, raw=RAW, judgement="bench test"))
    for store in (other, here):
        sync(Archive(store), str(tmp_path / "stick"))
    assert (today(here).trigger_records, today(here).unjudged) == (2, 1)
    add(other, TriggerRecordJudged(place=0, raw=RAW, judgement=None))
    for store in (other, here):
        sync(Archive(store), str(tmp_path / "stick"))
    assert today(here).unjudged == 2


# The commands


@pytest.fixture
def say(capsys: pytest.CaptureFixture[str]) -> Callable[..., Printed]:
    def run(*words: str, code: int = 0) -> Printed:
        return run_here(capsys, ["archive", *words], code)

    return run


def told(say: Callable[..., Printed], schema: str, *words: str) -> Any:
    found = json.loads(say(*words, "--json").out)
    assert faults(schema, found) == []
    return found


def test_the_commands_tell_of_all_stations(
    here: Store, other: Store, tmp_path: Path, say: Callable[..., Printed]
) -> None:
    file_one(other, "M-07", port="/dev/ttyUSB0")
    add(other, SettingsSeen(port="p", boot_count=3, settings={"freefall_time_s": 1.6}))
    intent = begin(other, Act.WRITE, b"\x42", {"freefall_time_s": 1.4}, port="p", known_as=KnownAs("M-07"))
    settle(other, intent, Act.WRITE, Outcome.CONFIRMED, port="p", known_as=KnownAs("M-07"))
    stick = str(tmp_path / "stick")
    sync(Archive(other), stick)
    done = told(say, "archive_sync", "sync", stick)
    assert (done["place"], done["left_out"]) == (stick, [])
    assert done["received"] > 3
    assert told(say, "archive_status", "status")["facts"] == done["received"] + 1
    (module,) = told(say, "archive_report", "report")["modules"]
    assert (module["module"], module["checks"], module["last_check"]["verdict"]) == ("M-07", 1, "READY")
    history = told(say, "archive_module", "module", "M-07")
    kinds = [event["kind"] for event in history["events"]]
    assert {"module", "preflight_check"} <= set(kinds)
    assert history["events"][kinds.index("settings_seen")]["content"]["settings"] == {"freefall_time_s": 1.6}
    written = history["events"][kinds.index("act")]["content"]
    assert (written["detail"], written["outcome"]) == ({"freefall_time_s": 1.4}, "confirmed")
    assert history["events"][kinds.index("preflight_check")]["content"]["cell_voltage_v"] == 3.9
    assert say("report", "--csv").out.startswith("\ufeffmodule,") or "module," in say("report", "--csv").out
    assert "1.40 s" in say("module", "M-07").out
    service = told(say, "archive_service", "service", "M-07", "--what", "repack", "--who", "Li", "--due", "2099-01-01")
    assert service["module"] == "M-07"
    assert "Repack" in say("module", "M-07").out
    assert say("module", "M-99", code=1).err
    assert say("service", "M-99", "--what", "repack", "--who", "Li", code=1).err
    assert say("sync", "postgresql://nobody:secret@127.0.0.1:1/x", code=3).err.count("secret") == 0
    assert say("sync", code=2).err
