"""Records and the audit log are chained, also with several processes and after a kill."""

import sys
from collections.abc import Mapping
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest

from app.engine.identity import IdentityEvidence
from app.preflight.findings import CheckResult, Person
from app.procedures.history import History
from app.records.check_store import CheckStore, Visit
from app.records.filing import Filed, file_check
from app.records.record import Record
from app.records.trigger_filing import PossiblyOther, TriggersReading, file_triggers
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.settings.profiles import NO_PROFILE
from app.settings.setting_texts import DEFAULTS
from app.store.database import FILE_NAME, StoreFault, StoreTrouble
from app.store.facts import FactKind, fact_hash
from app.store.store import Store, open_store
from app.trigger_records.history import record_of
from protocol.fields import Value
from protocol.messages import TriggerRecord
from tests.support.processes import running
from tests.support.records.kept_facts import forge, tamper
from tests.support.records.preflight_rig import FAULTS, Fault, check

FRAME = bytes.fromhex("42 61 25 01 00 26")
RECORD = record_of(bytes.fromhex("41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E"))
_FILER = """
import sys
from pathlib import Path
from app import version
from app.safety.acts import Act
from app.store.store import open_store
from tests.app.records.test_filing import FRAME, file_one

store = open_store(Path(sys.argv[1]))
print("ready", flush=True)
sys.stdin.readline()
for _ in range(int(sys.argv[2])):
    store.begin(Act.LOCK, FRAME, {}, port="p", origin="test")
    print(file_one(store, "M-07").record["hash"], flush=True)
"""


def file_one(
    store: Store, module: str | None = None, *faults: Fault, port: str = "sim", adapter: str = "",
    is_same_module: bool = False,
) -> Filed:  # fmt: skip
    checked = check(*faults)
    checked.assessment.case.evidence.port = port
    return file_check(
        checked.assessment.case.evidence, NO_PROFILE, Person(module=module, is_same_module=is_same_module),
        store=store, adapter=adapter,
    )  # fmt: skip


def _chain(store: Store) -> list[Record]:
    """All stored records, oldest first."""
    return [fact.content["record"] for fact in store.facts.select(FactKind.CHECK)]


def test_two_programs_that_file_at_once_make_one_chain(tmp_path: Path) -> None:
    """One is killed: records it reported as stored are stored, and the chain continues."""
    open_store(tmp_path).close()
    filer = sys.executable, "-c", _FILER, tmp_path
    with running(*filer, 6) as one, running(*filer, 1000) as other:
        for program in one, other:
            assert program.out.readline() == "ready\n"
        for program in one, other:
            program.told.write("\n")
            program.told.flush()
        told = [other.out.readline() for _ in range(3)]
        other.process.kill()
        told += [*other.out.readlines(), *one.out.readlines()]
        assert one.process.wait(60) == 0
    with closing(open_store(tmp_path)) as store:
        file_one(store, "M-07")
        records = _chain(store)
        assert {line.strip() for line in told if line.endswith("\n")} <= {record["hash"] for record in records}
        assert [record["number"] for record in records] == list(range(1, len(records) + 1))
        assert [record["previous"] for record in records] == [None, *(one["hash"] for one in records[:-1])]
        assert len(records) >= 10
        assert store.facts.faults() == []


def test_modules_without_a_name_have_a_chain_for_each_adapter(tmp_path: Path) -> None:
    with closing(open_store(tmp_path)) as store:
        for adapter in ("0403:6001:A", "0403:6001:B", "0403:6001:A"):
            file_one(store, adapter=adapter)
        first, second, third = _chain(store)
        assert [one["number"] for one in (first, second, third)] == [1, 1, 2]
        assert third["previous"] == first["hash"]
        assert second["previous"] is None
        assert [one["adapter"] for one in (first, second)] == ["0403:6001:A", "0403:6001:B"]
        # Not on USB: the port is used instead.
        assert file_one(store).record["adapter"] == "sim"


def test_a_record_that_could_not_be_kept_has_no_number(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(open_store(tmp_path)) as store:
        file_one(store, "M-07")

        def full(*_: object) -> int:
            raise StoreTrouble(StoreFault.FULL, tmp_path)

        monkeypatch.setattr(store.facts.database, "write", full)
        filed = file_one(store, "M-07")
        assert filed.trouble is not None
        assert (filed.record["number"], filed.record["previous"]) == (0, None)
        assert len(_chain(store)) == 1


# Trigger records


@pytest.mark.parametrize(
    ("boot_count", "more", "records", "is_filed"),
    [
        (9, {}, (RECORD,), True),
        (8, {}, (RECORD,), False),
        (9, {"attitude_threshold_deg": 45}, (RECORD,), False),
        (9, {}, (), False),
    ],
)
def test_records_of_what_may_be_another_module_are_filed_only_if_a_person_says_so(
    tmp_path: Path, boot_count: int, more: dict[str, Value], records: tuple[TriggerRecord, ...], is_filed: bool
) -> None:
    settings = {**DEFAULTS, "light_threshold_v": 1.0}

    def reading(boots: int, settings: Mapping[str, Value], *found: TriggerRecord) -> TriggersReading:
        return TriggersReading(History(found, is_confirmed=True, is_answered=True), boots, settings)

    with closing(open_store(tmp_path)) as store:
        file = partial(file_triggers, store, name="M-07", port="p")
        for before in (reading(7, settings, RECORD), reading(9, {}, RECORD)):  # the settings were not read last time
            assert isinstance(file(before, is_same_module=False), Visit)
        now = reading(boot_count, {**settings, **more}, *records)
        assert isinstance(file(now, is_same_module=False), Visit if is_filed else PossiblyOther)
        assert isinstance(file(now, is_same_module=True), Visit)


def test_the_next_check_knows_what_a_person_said_of_the_one_before(tmp_path: Path) -> None:
    def boot_count(filed: Filed) -> CheckResult:
        return filed.assessment.result("boot_count")

    with closing(open_store(tmp_path)) as store:
        store.store_evidence("M-07", IdentityEvidence(36, file_one(store, "M-07").assessment.case.evidence.values))
        changed = partial(file_one, store, "M-07", FAULTS["free-fall time"])
        assert boot_count(changed()) is CheckResult.FAIL, "other settings than last read"
        assert boot_count(changed()) is CheckResult.FAIL, "what may be another one is not what was last read"
        assert boot_count(changed(is_same_module=True)) is CheckResult.PASS
        assert boot_count(changed()) is CheckResult.PASS
        assert store.evidence("M-07").settings["freefall_time_s"] == 0.2


def test_records_of_a_simulated_module_are_kept_with_those_of_no_real_one(tmp_path: Path) -> None:
    reading = TriggersReading(History((RECORD,), is_confirmed=True, is_answered=True), 7, DEFAULTS)
    with closing(open_store(tmp_path)) as store:
        file = partial(file_triggers, store, reading, is_same_module=False)
        for name, first, other in (("M-07", "sim://", "/dev/ttyUSB0"), ("M-08", "/dev/ttyUSB0", "sim://x?seed=1")):
            assert isinstance(file(name, port=first), Visit)
            assert file(name, port=other) == PossiblyOther(("simulated",))
            assert isinstance(file(name, port=first), Visit)
        for module in ("M-07", "M-08"):
            visits = len(store.facts.select(FactKind.VISIT, "AND module = ?", (module,)))
            file_one(store, module, port="/dev/ttyUSB0" if module == "M-07" else "sim://", is_same_module=True)
            assert len(store.facts.select(FactKind.VISIT, "AND module = ?", (module,))) == visits


@pytest.mark.parametrize(("boots", "result"), [(36, CheckResult.PASS), (50, CheckResult.FAIL)])
def test_a_check_knows_the_boot_count_that_was_read_last(tmp_path: Path, boots: int, result: CheckResult) -> None:
    """By the window, or with the trigger records: it is newer than that of the last visit."""
    with closing(open_store(tmp_path)) as store:
        assert file_one(store, "M-07").assessment.result("boot_count") is CheckResult.WARN, "no earlier visit"
        store.store_evidence("M-07", IdentityEvidence(boots))
        assert file_one(store, "M-07").assessment.result("boot_count") is result


def test_settings_that_a_simulated_module_passed_with_are_approved_for_none_that_is_real(tmp_path: Path) -> None:
    with closing(open_store(tmp_path)) as store:
        simulated, real = (partial(file_one, store, "M-07", port=port) for port in ("sim://", "/dev/ttyUSB0"))
        assert [simulated().assessment.result("fingerprint") for _ in range(2)] == [CheckResult.WARN, CheckResult.PASS]
        assert [real().assessment.result("fingerprint") for _ in range(2)] == [CheckResult.WARN, CheckResult.PASS]


# The audit log


def _logged(folder: Path) -> None:
    with closing(open_store(folder)) as store:
        for act in (Act.ZERO, Act.LOCK, Act.ACTIVATE):
            entry = store.begin(act, FRAME, {"tilt_deg": 3, "zh": "激活"}, port="p", origin="window")
            if act is not Act.ACTIVATE:
                store.settle(entry, Outcome.CONFIRMED, {"active": False})


_COPY = "INSERT INTO facts (kind, made_at, payload, hash)"


@pytest.mark.parametrize(
    ("tampering", "expected"),
    [
        ("UPDATE facts SET payload = replace(payload, 'zero', 'lock') WHERE number = 1", [(1, "ALTERED")]),
        ("UPDATE facts SET made_at = 'x' WHERE number = 5", [(5, "ALTERED")]),
        ("UPDATE facts SET kind = 'x' WHERE number = 4", [(4, "ALTERED")]),
        ("DELETE FROM facts WHERE number = 2", [(2, "MISSING")]),
        ("DELETE FROM facts WHERE number = 5", [(5, "MISSING")]),
        ("UPDATE facts SET number = 6 WHERE number = 2", [(2, "MISSING"), (6, "BROKEN")]),
        ("UPDATE facts SET payload = '{}', hash = '7' WHERE number = 5", [(5, "ALTERED")]),
        (f"{_COPY} SELECT kind, made_at, payload, hash FROM facts WHERE number = 2", [(6, "BROKEN")]),
        (f"{_COPY} VALUES ('act', 't', '{{}}', '{fact_hash('act', 't', '{}')}')", [(6, "FOREIGN")]),
    ],
)
def test_every_alteration_of_the_log_is_found(tmp_path: Path, tampering: str, expected: list[tuple[int, str]]) -> None:
    _logged(tmp_path)
    tamper(tmp_path / FILE_NAME, tampering)
    with closing(open_store(tmp_path)) as store:
        assert [(fault.entry, fault.fault.name) for fault in store.facts.faults()] == expected


def test_a_replaced_entry_breaks_the_chain(tmp_path: Path) -> None:
    """Also where whoever replaced it made its hash again."""
    _logged(tmp_path)
    forge(tmp_path / FILE_NAME, 3, lambda payload: payload.replace("lock", "zero"))
    with closing(open_store(tmp_path)) as store:
        assert [fault.entry for fault in store.facts.faults()] == [4]


def test_aircraft_are_listed_once_the_last_checked_first(tmp_path: Path) -> None:
    with closing(open_store(tmp_path)) as store:
        checked = check()
        named = ("A", "H6"), ("B", ""), ("A", "X8"), ("B", "H6"), (None, "Q4"), ("A", "X8"), ("B", "")
        for module, aircraft in named:
            file_check(
                checked.assessment.case.evidence, NO_PROFILE, Person(module=module, aircraft=aircraft),
                store=store,
            )  # fmt: skip
        checks = CheckStore(store.database)
        assert checks.aircraft() == ("X8", "Q4", "H6")
        assert [checks.aircraft_of(module) for module in ("A", "B", "C")] == ["X8", "H6", ""]
