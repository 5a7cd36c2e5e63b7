"""Facts of several stations: what is collected, what a file carries, and that what was altered is named."""

import json
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from itertools import permutations
from pathlib import Path
from typing import Any

import pytest

from app.archive.archive import _TO_SIGN, Archive
from app.archive.chains import chains_in
from app.archive.exchange import Exchanged, export_facts, facts_in, import_facts
from app.archive.facts import Fact, RefusedFact, checked, fact_id, make_fact
from app.archive.module_history import module_history
from app.archive.module_names import ConflictKind, NamedModule, _names, names_of
from app.guided.results import GuidedVerdict
from app.stations.station import Station
from app.store.database import FILE_NAME
from app.store.facts import FactKind, payload_of
from app.store.store import open_store
from app.text.user_error import UserError
from app.trigger_records.history import Judgement
from tests.support.patience import PATIENCE_S
from tests.support.records.archive_stations import NOON, ArchiveStation, archive_station
from tests.support.records.kept_facts import tamper
from tests.support.records.stations_made import station

AT = NOON.isoformat(timespec="milliseconds")


def made(kind: FactKind, content: Mapping[str, object], signer: Station) -> Fact:
    return make_fact(kind.value, AT, payload_of(content), signer)


@pytest.fixture
def stations(tmp_path: Path) -> Iterator[list[ArchiveStation]]:
    with ExitStack() as stack:
        yield [stack.enter_context(archive_station(tmp_path / name)) for name in "ABC"]


def _live(one: ArchiveStation, module: str) -> None:
    one.meet(module)
    one.visit(module, 1, 2)
    one.judge(module, Judgement.REAL)
    one.snapshot(module)
    one.test(module)
    one.act()
    one.check(module)


def _export(one: ArchiveStation, path: Path) -> Exchanged:
    return export_facts(one.archive, path)


def _import(one: ArchiveStation, path: Path) -> Exchanged:
    return import_facts(one.archive, path)


def test_a_store_that_was_restored_from_a_copy_loses_no_later_fact(tmp_path: Path) -> None:
    """What had been exchanged comes again; the chain goes on from the copy, and both are whole."""
    with archive_station(tmp_path / "A") as one:
        one.act()
    copy = (tmp_path / "A" / FILE_NAME).read_bytes()
    with archive_station(tmp_path / "A") as one:
        one.snapshot("M-07")
        one.act()
        _export(one, tmp_path / "stick")
        before = one.ids()
    (tmp_path / "A" / FILE_NAME).write_bytes(copy)
    with archive_station(tmp_path / "A") as one:
        for threshold in (50, 70):  # the facts have the numbers of those that are gone
            one.snapshot("M-09", threshold)
            one.act(is_settled=False)
        one.archive.collect()
        assert not before <= one.ids()
        _import(one, tmp_path / "stick")
        assert before < one.ids()
        found = [fact.content["settings"] for fact in one.archive.of_kind(FactKind.SNAPSHOT, "M-09")]
        assert found == [{"attitude_threshold_deg": 50}, {"attitude_threshold_deg": 70}]
        assert one.store.facts.faults() == []
        assert [chain.missing for chain in chains_in(one.archive)] == [0]


def test_the_history_of_a_module_names_acts_settings_and_what_came_of_them(stations: list[ArchiveStation]) -> None:
    one = stations[0]
    one.snapshot("M-07")
    one.act("M-07")
    one.act("M-07", is_settled=False)
    detail = json.dumps({"module": "M-07"})
    strange: tuple[list[object], ...] = (
        ["", None, "", "", AT, "fly", "zz", detail, AT, "", ""],
        [1, 2, 3, 4, 5, 6, 7, detail, 9, 10, 11],
    )
    links = ({"entry": entry, "previous": "", "hash": ""} for entry in strange)
    one.archive.add([made(FactKind.AUDIT, link, one.station) for link in links])
    settings = {"settings": {"other_v": 3, "freefall_time_s": "long"}, "module": "M-07"}
    one.archive.add([made(FactKind.SNAPSHOT, settings, one.station)])
    one.archive.collect()
    (module,) = names_of(one.archive).modules
    told = [event.text.in_english() for event in module_history(one.archive, module).events]
    assert sorted(told) == [
        "Lock: confirmed.", "Lock: may have been carried out.", "Named M-07.", "Settings: Attitude threshold 60°.",
        "audit_link", "audit_link", "settings_snapshot",
    ]  # fmt: skip


def test_what_was_altered_in_the_audit_log_is_not_shared(stations: list[ArchiveStation]) -> None:
    one = stations[0]
    one.act()
    tamper(one.folder / FILE_NAME, "UPDATE facts SET payload = replace(payload, 'window', 'nowhere')")
    assert one.archive.collect() == 1  # what came of it
    assert one.archive.of_kind(FactKind.ACT) == []
    assert [fault.in_english() for chain in chains_in(one.archive) for fault in chain.faults] == [
        "Entry 1 was altered."
    ]


def test_an_export_that_breaks_off_leaves_the_file_as_it_was(stations: list[ArchiveStation], tmp_path: Path) -> None:
    stick, one = tmp_path / "stick", stations[0]
    _live(one, "M-01")
    _export(one, stick)
    before = stick.read_bytes()
    _live(one, "M-02")
    one.archive.collect()

    def pull_out(_done: Exchanged) -> None:
        raise OSError(5, "Input/output error")

    with pytest.raises(UserError, match="cannot be written"):
        export_facts(one.archive, stick, on_page=pull_out)
    assert stick.read_bytes() == before
    assert list(tmp_path.glob("*.part")) == []


def _alterations(line: dict[str, str]) -> Iterator[dict[str, str]]:
    """Whatever a person could do to a line: change one part, also with a new id, or sign it with another key."""
    payload = line["payload"].replace("M-01", "M-02")
    yield {**line, "payload": payload}
    yield {**line, "payload": payload, "id": fact_id(line["kind"], line["station"], line["made_at"], payload)}
    yield {**line, "made_at": "2020-01-01T00:00:00.000+00:00"}
    yield {**line, "kind": "settlement"}
    yield {**line, "signature": line["signature"][::-1]}
    other = made(FactKind.MODULE, {"module": "M-02"}, station("stranger"))
    yield dict(zip(line, other.row, strict=True)) | {"station": line["station"]}
    yield {key: value for key, value in line.items() if key != "kind"}
    yield {**line, "payload": "[" * 100_000}
    yield {**line, "id": "../../etc/passwd\x1b[2J"}


def test_whatever_was_altered_is_named_and_not_taken_over(stations: list[ArchiveStation], tmp_path: Path) -> None:
    one, other, stick = stations[0], stations[1], tmp_path / "stick"
    one.meet("M-01")
    _export(one, stick)
    head, text = stick.read_text(encoding="utf-8").splitlines()
    line = json.loads(text)
    bad = list(_alterations(line))
    for altered in bad:
        refused = checked(tuple(altered.get(name) for name in line))
        assert isinstance(refused, RefusedFact)
        assert "\x1b" not in refused.sentence().translated()
    stick.write_text("\n".join((head, *map(json.dumps, bad), "no JSON", "{}", "[]", text[:50])), encoding="utf-8")
    assert sum(isinstance(fact, RefusedFact) for fact in facts_in(stick)) == len(bad) + 4
    assert _import(other, stick).received == 0
    assert _export(one, stick).sent == 1  # the true one is added to it again
    assert _import(other, stick).received == 1
    assert other.ids() == one.ids()


def test_a_damaged_fact_of_this_computer_is_not_sent(stations: list[ArchiveStation], tmp_path: Path) -> None:
    one = stations[0]
    one.meet("M-01")
    one.archive.collect()
    tamper(one.folder / FILE_NAME, 'UPDATE facts SET payload = \'{"module":"M-99"}\'')
    done = _export(one, tmp_path / "stick")
    assert (done.sent, len(done.damaged), done.is_whole) == (0, 1, False)


def test_a_fact_of_a_newer_version_is_kept_and_passed_on(stations: list[ArchiveStation], tmp_path: Path) -> None:
    one, other, stick = stations[0], stations[1], tmp_path / "stick"
    fact = make_fact("parachute_repack", AT, payload_of({"module": "M-01", "by": "Li"}), one.station)
    one.archive.add([fact])
    _export(one, stick)
    assert _import(other, stick).received == 1
    assert other.ids() == {fact.id}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "unknown kind of file"),
        ("PK\x03\x04", "unknown kind of file"),
        ('{"format": "dps-s archive", "version": 2}\n', "newer version"),
        ("[" * 100_000, "unknown kind of file"),
    ],
)
def test_another_file_is_refused_in_a_sentence(
    stations: list[ArchiveStation], tmp_path: Path, text: str, said: str
) -> None:
    path = tmp_path / "other"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UserError, match=said):
        import_facts(stations[0].archive, path)
    assert path.read_text(encoding="utf-8") == text


def test_a_result_says_what_it_was(stations: list[ArchiveStation]) -> None:
    one = stations[0]
    one.test("M-01", GuidedVerdict.FAILED)
    one.archive.collect()
    (fact,) = one.archive.of_kind(FactKind.GUIDED_TEST, "M-01")
    assert (fact.content["verdict"], fact.content["who"], fact.made_at) == ("failed", "Li", AT)


def test_two_programs_may_sign_at_once(stations: list[ArchiveStation]) -> None:
    one = stations[0]
    one.act()
    seen = one.archive.own.database.read(_TO_SIGN, (0, 9))
    rows = iter([seen, []])
    with closing(open_store(one.folder)) as store, closing(Archive(store)) as other:
        assert other.collect() == 2
    one.archive.own.database.read = lambda *_: next(rows)  # type: ignore[method-assign]
    one.archive.collect()
    del one.archive.own.database.read
    assert len(one.ids()) == 2


def test_who_looks_at_the_archive_keeps_no_reader_of_the_store_waiting(stations: list[ArchiveStation]) -> None:
    one = stations[0]
    one.act()
    one.archive.collect()
    with ThreadPoolExecutor(1) as pool, one.store.database._reading_lock:
        assert len(pool.submit(one.archive.of_kind, None).result(PATIENCE_S)) == 2


def test_what_is_recorded_during_an_exchange_is_not_called_shared(stations: list[ArchiveStation]) -> None:
    one = stations[0]
    one.meet("M-07")
    one.archive.collect()
    one.act()  # after the facts were signed that are exchanged now
    one.archive.note_exchange("server", one.archive.last_number())
    one.archive.collect()
    assert one.archive.not_shared("server")[0] == 2


def test_all_stations_ask_the_same_questions_in_the_same_order() -> None:
    """Whatever order the sets of records have in memory."""
    members = [NamedModule("a", "M-1"), NamedModule("b", "M-2"), NamedModule("c", "M-3")]

    def asked(order: Any) -> list[tuple[ConflictKind, Any]]:
        records: Any = {members[0]: order, members[1]: ("x",), members[2]: ("y",)}
        return [(conflict.kind, conflict.pair) for conflict in _names(members, {}, records).conflicts]

    questions = [asked(order) for order in permutations(("x", "y"))]
    assert len(questions[0]) == 2
    assert questions[0] == questions[1]
