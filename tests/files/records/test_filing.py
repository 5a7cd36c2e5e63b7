"""Records are kept, also by several processes and after a kill."""

import sys
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest

from app.modules.names import remember
from app.preflight.checks import CheckResult, Person
from app.preflight.verdict import Verdict
from app.procedures.history import History
from app.records.filing import Filed, aircraft_of, file_check
from app.records.record import read_document
from app.records.verification import RecordState, StationNames, verify
from app.settings.profiles import NO_PROFILE
from app.settings.values import DEFAULTS
from app.store.fact_store import Facts, Store, StoreFault, StoreTrouble
from app.store.rows import ModuleVisited, PreflightCheck
from app.store.station import KEY_FILE
from app.text.messages import UserError, UserMessage
from app.trigger_records.history import PossiblyOther, TriggersReading, Visit, file_triggers, record_of
from tests.support.processes import running
from tests.support.records.preflight_rig import Fault, check
from tests.support.records.stored import checks_of, open_store, remembered_in

FRAME = bytes.fromhex("42 61 25 01 00 26")
RECORD = record_of(bytes.fromhex("41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E"))
_FILER = """
import sys
from pathlib import Path
from app.safety.journal import Act
from tests.files.records.test_filing import FRAME, file_one
from tests.support.records.stored import begin, open_store

store = open_store(Path(sys.argv[1]))
print("ready", flush=True)
sys.stdin.readline()
for _ in range(int(sys.argv[2])):
    begin(store, Act.LOCK, FRAME, {}, port="p", origin="test")
    print(file_one(store, "M-07").record.at.isoformat(), flush=True)
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


@pytest.mark.promise("f")
def test_two_programs_that_file_at_once_lose_nothing(tmp_path: Path) -> None:
    """One is killed: what it reported as kept is kept."""
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
        texts = [check.content.document for check in store.read(lambda facts: facts.of_module(PreflightCheck, "M-07"))]
        documents = [read_document(text.encode()) for text in texts]
        kept = [verify(document, StationNames(None)) for document in documents]
        assert {found.state for found in kept} == {RecordState.INTACT}
        assert len(kept) >= len([line for line in told if line.endswith("\n")]) >= 9


def test_a_record_that_could_not_be_kept_is_still_signed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(open_store(tmp_path)) as store:
        file_one(store, "M-07")

        def full(*_: object, **__: object) -> int:
            raise StoreTrouble(StoreFault.FULL, tmp_path)

        with monkeypatch.context() as patch:
            patch.setattr("app.store.fact_store.Facts.add", full)
            filed = file_one(store, "M-07")
        assert filed.trouble is not None
        assert verify(read_document(filed.exported.text.encode()), StationNames(None)).state is RecordState.INTACT
        assert len(checks_of(store, "M-07")) == 1


@pytest.mark.parametrize("content", [b"", b"no key", b"-----BEGIN PRIVATE KEY-----\nAAAA\n-----END PRIVATE KEY-----\n"])
def test_a_damaged_key_is_never_replaced_and_what_it_would_sign_is_not_kept(tmp_path: Path, content: bytes) -> None:
    with closing(open_store(tmp_path)) as store:
        (tmp_path / KEY_FILE).write_bytes(content)
        filed = file_one(store, "M-07")
        assert filed.assessment.verdict is Verdict.READY
        assert filed.signed is None
        with pytest.raises(UserError, match="key of this station"):
            _ = filed.exported
        assert checks_of(store, "M-07") == ()
    assert (tmp_path / KEY_FILE).read_bytes() == content


# Trigger records


def remember_boots(store: Store, boot_count: int) -> None:
    store.write(lambda facts: remember(facts, "M-07", boot_count=boot_count)).result()


def test_what_may_be_another_module_becomes_no_part_of_this_ones_history(tmp_path: Path) -> None:
    with closing(open_store(tmp_path)) as store:
        remember_boots(store, 50)
        for is_same_module, result, boot_count, visits in (
            (False, CheckResult.FAIL, 50, 0),
            (True, CheckResult.PASS, 37, 1),
            (False, CheckResult.PASS, 37, 2),
        ):
            filed = file_one(store, "M-07", is_same_module=is_same_module)
            assert filed.assessment.result("boot_count") is result
            known = remembered_in(store, "M-07")
            assert known is not None
            assert (known.boot_count, "freefall_time_s" in known.settings) == (boot_count, visits > 0)
            assert len(store.read(lambda facts: facts.of_module(ModuleVisited, "M-07"))) == visits


def test_records_of_a_simulated_module_are_kept_with_those_of_no_real_one(tmp_path: Path) -> None:
    reading = TriggersReading(History((RECORD,), is_confirmed=True, is_answered=True), 1, 7, DEFAULTS)
    with closing(open_store(tmp_path)) as store:

        def file(name: str, *, port: str) -> Visit | PossiblyOther:
            return store.write(
                partial(file_triggers, reading=reading, name=name, port=port, is_same_module=False)
            ).result()

        for name, first, other in (("M-07", "sim://", "/dev/ttyUSB0"), ("M-08", "/dev/ttyUSB0", "sim://x?seed=1")):
            assert isinstance(file(name, port=first), Visit)
            assert file(name, port=other) == PossiblyOther(UserMessage("simulated"))
            assert isinstance(file(name, port=first), Visit)
        for module in ("M-07", "M-08"):
            visits = len(store.read(partial(Facts.of_module, type_=ModuleVisited, module=module)))
            file_one(store, module, port="/dev/ttyUSB0" if module == "M-07" else "sim://", is_same_module=True)
            assert len(store.read(partial(Facts.of_module, type_=ModuleVisited, module=module))) == visits


def test_settings_that_a_simulated_module_passed_with_are_approved_for_none_that_is_real(tmp_path: Path) -> None:
    with closing(open_store(tmp_path)) as store:
        simulated, real = (partial(file_one, store, "M-07", port=port) for port in ("sim://", "/dev/ttyUSB0"))
        assert [simulated().assessment.result("fingerprint") for _ in range(2)] == [CheckResult.WARN, CheckResult.PASS]
        assert [real().assessment.result("fingerprint") for _ in range(2)] == [CheckResult.WARN, CheckResult.PASS]


# Lists


def test_the_aircraft_of_a_module_is_that_of_its_last_check_that_names_one(tmp_path: Path) -> None:
    with closing(open_store(tmp_path)) as store:
        checked = check()
        named = ("A", "H6"), ("B", ""), ("A", "X8"), ("B", "H6"), (None, "Q4"), ("A", "X8"), ("B", "")
        for module, aircraft in named:
            file_check(
                checked.assessment.case.evidence, NO_PROFILE, Person(module=module, aircraft=aircraft),
                store=store,
            )  # fmt: skip
        of = store.read(lambda facts: [aircraft_of(facts, module) for module in ("A", "B", "C")])
        assert of == ["X8", "H6", ""]
