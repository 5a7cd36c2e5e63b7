"""`dps-s archive`: what it prints, keeps and answers; without a server."""

import csv
import io
import json
import sys
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

import app.__main__ as program
from app.archive.archive import Archive
from app.archive.exchange import export_facts
from app.archive.module_names import keep_service, names_of
from app.guided.results import GuidedVerdict
from app.limits.service import Service, ServiceKind
from app.records.check_store import CheckStore
from app.records.filing import service_due
from app.store.facts import FactKind
from app.system.folders import data_folder
from app.text.user_error import UserError
from app.trigger_records.history import Judgement
from tests.app.cli.reference.test_schemas import faults
from tests.support.cli_line import Printed, is_one_sentence
from tests.support.records.archive_stations import ArchiveStation, archive_station

pytestmark = pytest.mark.usefixtures("user_files")


@pytest.fixture
def here(user_files: Path) -> Iterator[ArchiveStation]:
    with archive_station(data_folder()) as one:
        yield one


@pytest.fixture
def other(tmp_path: Path) -> Iterator[ArchiveStation]:
    with archive_station(tmp_path / "other") as one:
        yield one


def say(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> Printed:
    Printed(capsys)
    assert program.main(["archive", *words]) == code
    return Printed(capsys)


def told(capsys: pytest.CaptureFixture[str], schema: str, *words: str, code: int = 0) -> Any:
    found = json.loads(say(capsys, *words, "--json", code=code).out)
    assert faults(f"archive_{schema}", found) == []
    return found


def _carry(capsys: pytest.CaptureFixture[str], other: ArchiveStation, stick: Path) -> None:
    """The other station's facts come here."""
    export_facts(other.archive, stick)
    say(capsys, "import", str(stick))


def _due(report: Any) -> dict[str, list[str]]:
    return {one["module"]: [due["kind"] for due in one["due"]] for one in report["modules"]}


def test_status_export_and_import(
    here: ArchiveStation, other: ArchiveStation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    here.act()
    other.check("M-07")
    stick = tmp_path / "stick"
    status = told(capsys, "status", "status")
    assert (status["facts"], status["not_shared"], status["server"]) == (2, 2, None)
    assert told(capsys, "exchange", "export", str(stick))["sent"] == 2
    _carry(capsys, other, stick)
    assert told(capsys, "status", "status")["facts"] == 4
    text = stick.read_text(encoding="utf-8").replace("M-07", "M-08")
    stick.write_text(text, encoding="utf-8")
    found = told(capsys, "exchange", "import", str(stick), code=4)
    assert (found["refused_count"], {one["why"] for one in found["refused"]}) == (2, {"it was altered"})
    assert "it was altered" in say(capsys, "import", str(stick), code=4).err


def test_what_is_no_file_and_no_server_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str],
                                                      monkeypatch: pytest.MonkeyPatch) -> None:  # fmt: skip
    assert is_one_sentence(say(capsys, "import", str(tmp_path / "none"), code=2).err)
    assert is_one_sentence(say(capsys, "export", str(tmp_path / "none" / "x"), code=1).err)
    assert is_one_sentence(say(capsys, "export", __file__, code=2).err)
    assert is_one_sentence(say(capsys, "sync", code=2).err)
    printed = say(capsys, "sync", "postgresql://li:secret@/x?host=/nowhere/at/all", "--remember", code=3)
    assert "postgresql://li@/x" in printed.err
    assert "secret" not in printed.err
    assert told(capsys, "status", "status")["server"] == "postgresql://li@/x?host=%2Fnowhere%2Fat%2Fall"
    assert all(b"secret" not in path.read_bytes() for path in data_folder().rglob("*") if path.is_file())
    say(capsys, "sync", "--forget")
    assert told(capsys, "status", "status")["server"] is None
    assert "secret" not in say(capsys, "sync", "mysql://li:secret@db/x", code=2).err
    monkeypatch.setitem(sys.modules, "psycopg", None)
    said = say(capsys, "sync", "postgresql://db/x", code=3).err
    assert 'pip install "dps-s-configurator[archive]"' in said


def test_two_modules_by_one_name_are_settled_by_a_person(
    here: ArchiveStation, other: ArchiveStation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    here.check("M-07")
    other.check("m-07 ", "NO-GO")
    _carry(capsys, other, tmp_path / "stick")
    assert {one["module"] for one in told(capsys, "report", "report")["modules"]} == {"M-07", "m-07 "}
    (conflict,) = told(capsys, "conflicts", "conflicts")["conflicts"]
    assert conflict["kind"] == "same_name"
    one, two = (f"{module['station']}/{module['name']}" for module in conflict["modules"])
    assert one in say(capsys, "conflicts").out
    say(capsys, "settle", one, "nobody/x", "--same", "--who", "Li", code=2)
    assert "one module, “Seven”." in say(capsys, "settle", one, two, "--same", "--name", "Seven", "--who", "Li").out
    assert told(capsys, "conflicts", "conflicts")["conflicts"] == []
    (module,) = told(capsys, "report", "report")["modules"]
    assert (module["module"], module["checks"], len(module["members"])) == ("Seven", 2, 2)
    say(capsys, "settle", two, one, "--different", "--who", "Li")
    assert len(told(capsys, "report", "report")["modules"]) == 2


def test_one_module_by_two_names_is_asked_about_and_a_contradiction_shown(
    here: ArchiveStation, other: ArchiveStation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    here.visit("A", 1, 2, 3)
    other.visit("B", 2, 3, 4)
    other.visit("C", 7)
    _carry(capsys, other, tmp_path / "stick")
    (conflict,) = told(capsys, "conflicts", "conflicts")["conflicts"]
    assert conflict["kind"] == "same_records"
    a, b = sorted((f"{module['station']}/{module['name']}" for module in conflict["modules"]), key=lambda one: one[-1])
    c = f"{b[:-1]}C"
    say(capsys, "settle", a, b, "--different", "--who", "Li")
    say(capsys, "settle", a, c, "--same", "--who", "Li")
    assert told(capsys, "conflicts", "conflicts")["conflicts"] == []
    say(capsys, "settle", b, c, "--same", "--who", "Li")
    (conflict,) = told(capsys, "conflicts", "conflicts")["conflicts"]
    assert (conflict["kind"], [module["name"] for module in conflict["modules"]]) in (
        ("contradiction", ["A", "B"]), ("contradiction", ["B", "A"])
    )  # fmt: skip


def test_the_report_says_what_is_due_and_the_whole_life_of_a_module(
    here: ArchiveStation, other: ArchiveStation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    here.check("M-07", cell_v=3.9)
    here.visit("M-07", 1, 2)
    here.snapshot("M-07")
    other.check("M-08", "NO-GO")
    other.test("M-08", GuidedVerdict.FAILED)
    other.test("M-08", is_simulated=True)
    other.meet("=HYPERLINK(1)")
    _carry(capsys, other, tmp_path / "stick")
    days = ("--check-days", "90000", "--test-days", "90000")
    due = {
        one["module"]: [due["kind"] for due in one["due"]] for one in told(capsys, "report", "report", *days)["modules"]
    }
    assert due["M-07"] == ["trigger_records"]
    assert due["M-08"] == ["no_go", "test"]
    assert next(iter(due.values())) == ["no_check"]
    here.judge("M-07", Judgement.REAL)
    assert _due(told(capsys, "report", "report"))["M-07"] == ["old_check"]
    (life,) = told(capsys, "report", "report", "--module", "m-07")["lives"]
    kinds = [event["kind"] for event in life["events"]]
    assert sorted(set(kinds)) == ["judgement", "module", "preflight_check", "settings_snapshot", "trigger_record"]
    assert [point["value"] for point in life["values"]["cell_voltage_v"]] == [3.9]
    text = say(capsys, "report").out + say(capsys, "report", "--module", "M-07").out
    assert "M-08" in text
    tests = [line for line in say(capsys, "report", "--module", "M-08").out.splitlines() if "Guided test" in line]
    assert {line.rpartition(": ")[2].strip() for line in tests} == {"FAILED.", "passed (simulated)."}
    assert "Pre-flight check: GO, checked by: Li." in text
    assert "\x1b" not in text
    fleet = list(csv.DictReader(io.StringIO(say(capsys, "report", "--csv").out)))
    assert [row["verdict"] for row in fleet] == ["", "GO", "NO-GO"]
    assert fleet[0]["module"].startswith("'=")
    rows = list(csv.DictReader(io.StringIO(say(capsys, "report", "--module", "M-07", "--csv").out)))
    assert {"value": "3.9", "value_name": "cell_voltage_v"}.items() <= next(
        row for row in rows if row["value_name"] == "cell_voltage_v"
    ).items()
    say(capsys, "report", "--module", "nobody", code=1)


@pytest.mark.parametrize("is_here", [True, False])
def test_what_a_station_recorded_last_counts_though_its_clock_was_set_back(
    is_here: bool, here: ArchiveStation, other: ArchiveStation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = iter(datetime.now(UTC) - timedelta(hours=hours) for hours in range(1000))
    station = here if is_here else other
    station.store.database._clock = lambda: next(clock)
    station.visit("M-07", 1, 2, 3)
    station.judge("M-07", Judgement.REAL)
    station.test("M-07", GuidedVerdict.PASSED)
    station.check("M-07", "GO")
    for record in CheckStore(station.store.database).records("M-07"):
        CheckStore(station.store.database).judge(record.id, None, "")
    station.test("M-07", GuidedVerdict.FAILED)
    station.check("M-07", "NO-GO")
    if not is_here:
        _carry(capsys, other, tmp_path / "stick")
    report = told(capsys, "report", "report")
    assert _due(report)["M-07"] == ["no_go", "trigger_records", "test"]
    assert report["modules"][0]["not_judged"] == 3


def test_what_a_person_did_to_a_module_is_kept_and_what_is_due_is_listed(
    here: ArchiveStation, capsys: pytest.CaptureFixture[str]
) -> None:
    here.meet("M-07")
    say(capsys, "service", "M-08", "--what", "repack", "--who", "Li Wei", code=1)
    words = ("service", "M-07", "--what", "repack", "--who", "Li Wei", "--on", "2020-01-01")
    say(capsys, *words, "--due", "2019-12-31", code=2)
    assert _due(told(capsys, "report", "report")) == {"M-07": ["no_check"]}
    said = say(capsys, *words, "--due", "2020-06-01").out
    assert said == "Repack on 2020-01-01 by Li Wei, due again: 2020-06-01.\n"
    assert _due(told(capsys, "report", "report")) == {"M-07": ["no_check", "service"]}
    assert "Repack overdue since 2020-06-01." in say(capsys, "report").out
    assert "Repack on 2020-01-01 by Li Wei" in say(capsys, "report", "--module", "M-07").out
    here.serve("M-07", date(2998, 1, 1))
    assert _due(told(capsys, "report", "report")) == {"M-07": ["no_check", "service"]}
    assert "later than today" in say(capsys, *words[:-1], "2998-01-01", code=2).err
    say(capsys, *words, "--due", "2999-01-01")
    assert _due(told(capsys, "report", "report")) == {"M-07": ["no_check"]}


def test_what_was_done_is_of_the_module_that_is_meant_whatever_name_it_has_there(
    here: ArchiveStation, other: ArchiveStation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    here.meet("M-7")
    other.meet("M-07")
    _carry(capsys, other, tmp_path / "stick")
    words = ("--what", "repack", "--who", "Li Wei", "--on", "2020-01-01", "--due", "2020-06-01")
    say(capsys, "service", "m-7", *words)
    assert _due(told(capsys, "report", "report")) == {"M-07": ["no_check"], "M-7": ["no_check", "service"]}
    pair = [f"{one['members'][0]['station']}/{one['module']}" for one in told(capsys, "report", "report")["modules"]]
    say(capsys, "settle", *pair, "--same", "--name", "M-07", "--who", "Li Wei")
    say(capsys, "service", "M-07", *words[:-1], "2999-01-01")
    assert _due(told(capsys, "report", "report")) == {"M-07": ["no_check"]}
    assert [module.name for module in here.store.modules()] == ["M-7"]


def test_what_was_done_to_a_module_that_is_known_elsewhere_only_is_of_that_module(
    here: ArchiveStation, other: ArchiveStation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other.meet("M-07")
    _carry(capsys, other, tmp_path / "stick")
    say(capsys, "service", "M-07", "--what", "repack", "--who", "Li Wei", "--on", "2020-01-01", "--due", "2020-06-01")
    (module,) = told(capsys, "report", "report")["modules"]
    assert [due["kind"] for due in module["due"]] == ["no_check", "service"]
    assert len(module["members"]) == 2
    assert told(capsys, "conflicts", "conflicts")["conflicts"] == []


def test_what_another_station_did_to_a_module_counts_in_its_preflight_check_here(
    here: ArchiveStation, other: ArchiveStation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Once a person has said that it is the same module, and as `report` says it."""

    def repacked(on: date, due: date) -> None:
        other.serve("M-7", on, due)
        _carry(capsys, other, tmp_path / "stick")

    def overdue() -> list[bool]:
        return [due.is_overdue for due in service_due(here.store, "M-07", datetime.now(UTC))]

    here.visit("M-07", 1)
    other.visit("M-7", 1)
    repacked(date(2020, 1, 1), date(2020, 6, 1))
    assert overdue() == []
    (conflict,) = told(capsys, "conflicts", "conflicts")["conflicts"]
    pair = [f"{one['station']}/{one['name']}" for one in conflict["modules"]]
    say(capsys, "settle", *pair, "--same", "--who", "Li")
    assert overdue() == [True]
    repacked(date(2021, 1, 1), date(2999, 6, 1))
    assert overdue() == []
    say(capsys, "service", "M-07", "--what", "repack", "--who", "Li", "--on", "2020-01-01", "--due", "2020-06-01")
    assert overdue() == []
    say(capsys, "settle", *pair, "--different", "--who", "Li")
    assert overdue() == [True]
    say(capsys, "settle", *pair, "--same", "--who", "Li")
    assert overdue() == []


def test_nothing_is_kept_under_a_name_that_another_module_has_here(
    here: ArchiveStation, other: ArchiveStation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    here.meet("M-07")
    other.meet("M-07")
    _carry(capsys, other, tmp_path / "stick")
    with closing(Archive(here.store)) as archive:
        own, others = sorted(names_of(archive).modules, key=lambda one: one.members[0].station != archive.public)
        service = Service(kind=ServiceKind.REPACK, on=date(2020, 1, 1), due=date(2020, 6, 1), who="Li Wei")
        with pytest.raises(UserError, match="settle first"):
            keep_service(archive, others, service)
        keep_service(archive, own, service)
    assert len(here.store.facts.select(FactKind.SERVICE)) == 1


def test_people_read_the_time_of_their_own_computer(
    in_china: None, here: ArchiveStation, capsys: pytest.CaptureFixture[str]
) -> None:
    here.check("M-07")
    assert "2026-01-02 20:00" in say(capsys, "report").out
    assert "2026-01-02 20:00:00" in say(capsys, "report", "--module", "M-07").out
    assert told(capsys, "report", "report")["modules"][0]["last_at"].startswith("2026-01-02T12:00:00")


def test_two_triggers_of_equal_bytes_are_two_and_one_that_two_stations_read_is_one(
    here: ArchiveStation, other: ArchiveStation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    here.visit("M-07", 1, 2, 2, 2)
    other.visit("M-07", 2, 2)
    _carry(capsys, other, tmp_path / "stick")
    (conflict,) = told(capsys, "conflicts", "conflicts")["conflicts"]
    say(capsys, "settle", *(f"{one['station']}/{one['name']}" for one in conflict["modules"]), "--same", "--who", "Li")
    checks = CheckStore(here.store.database)
    checks.judge(checks.records("M-07")[1].id, Judgement.REAL, "")
    say(capsys, "service", "M-07", "--what", "repack", "--who", "Li", "--on", "2020-01-01")
    (module,) = told(capsys, "report", "report")["modules"]
    assert (module["trigger_records"], module["not_judged"], module["since_repack"]) == (4, 3, 4)


def test_trigger_records_are_counted_from_the_last_repack(
    here: ArchiveStation, capsys: pytest.CaptureFixture[str]
) -> None:
    here.visit("M-07", 1, 2)
    here.archive.collect()
    (read,) = {fact.made_at for fact in here.archive.of_kind(FactKind.TRIGGER_RECORD)}
    read_on = datetime.fromisoformat(read).astimezone().date()

    def since() -> object:
        return told(capsys, "report", "report")["modules"][0]["since_repack"]

    assert since() is None

    def serve(days: int) -> object:
        on = (read_on + timedelta(days=days)).isoformat()
        for what in ("repack", "cell"):
            say(capsys, "service", "M-07", "--what", what, "--who", "Li Wei", "--on", on)
        return since()

    assert serve(-1) == 2
    here.serve("M-07", date(2998, 1, 1))
    assert since() == 2  # nothing was done yet on a later day
    here.serve("M-07", read_on)
    assert since() == 0  # entered after they were read
    assert serve(0) == 2  # entered on a later day: they may have come after it
    assert serve(1) == 0
    assert "2, first read since the repack: 0" in say(capsys, "report").out
    (row,) = csv.DictReader(io.StringIO(say(capsys, "report", "--csv").out))
    assert row["since_repack"] == "0"
