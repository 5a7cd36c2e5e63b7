"""What is kept of a module, and what is said of it later, is kept and said under its own name."""

import threading
from pathlib import Path
from typing import Any

import pytest
from app.engine.identity import Identity, Trust

from app.engine.procedure import Pause, Procedure
from app.engine.worker import Job
from app.guided.results import GuidedKind, GuidedResult
from app.procedures.history import History
from app.settings.profiles import ManualLine, Profile
from app.store.fact_store import Facts
from app.store.trouble import StoreFault, StoreTrouble
from app.trigger_records.filing import PossiblyOther, TriggersReading
from app.trigger_records.history import Judgement, record_of
from app.trigger_records.kept import KeptTriggers
from tests.support.line.link_bench import RECORD
from tests.support.patience import PATIENCE_S
from tests.support.two_modules import NAME_A, PORT_A, PORT_B, A, B, Rig
from tests.support.window.fake_ports import VALUES


def test_what_a_slow_store_did_not_keep_is_said_of_its_module(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise StoreTrouble(StoreFault.FULL, Path("store.db"))

    monkeypatch.setattr("ui.pages.tests.controller.keep_test", fail)
    monkeypatch.setattr("ui.pages.triggers.controller.say_new", fail)
    monkeypatch.setattr("app.trigger_records.kept.KeptTriggers.judge", fail)
    store: Any = rig.assembly.storage.store
    guided, triggers = rig.pages["tests"], rig.pages["triggers"].work
    for act in (
        lambda: guided.work._store_result(GuidedResult(GuidedKind.BAY, ())),
        lambda: triggers.judge(7, Judgement.REVIEWED, ""),
        lambda: triggers._say_new(NAME_A),
    ):
        rig.show_a()
        gate = threading.Event()
        store.write(lambda _facts, gate=gate: gate.wait())
        act()
        rig.connector.connect_to(PORT_B)
        rig.answer(B)
        gate.set()
        store.write(lambda _facts: None).result(PATIENCE_S)
        rig.settle()
        said = [notice.text for notice in (guided._notice(), triggers.notice()) if notice is not None]
        assert [text for text in said if "Not kept." in text and text.startswith(f"{NAME_A}: ")] == said != []


@pytest.mark.parametrize("between", ["nothing", "break", "lost port"])
def test_what_was_read_before_a_break_gets_no_name_that_was_given_after_it(
    rig: Rig, monkeypatch: pytest.MonkeyPatch, between: str
) -> None:
    """A module without a name may be exchanged within a second, and nothing tells; while a port is lost, a name is of
    the one that is plugged in next."""
    filed: list[str] = []

    def file(_facts: Any, name: str, **_: Any) -> PossiblyOther:
        filed.append(name)
        return PossiblyOther()

    def read() -> Procedure[TriggersReading]:
        yield Pause(0.0)
        return TriggersReading(History(is_answered=True, is_confirmed=True), 147)

    monkeypatch.setattr("ui.pages.triggers.controller.file_triggers", file)
    rig.connector.connect_to(PORT_A)
    rig.answer(A)
    job = Job(read())
    job.run.start(0.0)
    job.run.tick(1.0)
    rig.pages["triggers"].work._end(job)
    rig.worker.breaks += between == "break"
    rig.answer(A)
    if between == "lost port":
        rig.worker.unplug()
        rig.settle()
    rig.connector.current.module.choose("BETA")
    rig.settle()
    store: Any = rig.assembly.storage.store
    store.write(lambda _facts: None).result(PATIENCE_S)
    assert filed == (["BETA"] if between == "nothing" else [])
    assert rig.pages["live"]._origin().module == ("" if between == "lost port" else "BETA")


@pytest.mark.promise("l")
def test_records_of_one_module_are_never_filed_under_the_name_of_the_next(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    filed: list[str] = []

    def file(_facts: Any, name: str, **_: Any) -> PossiblyOther:
        filed.append(name)
        return PossiblyOther()

    monkeypatch.setattr("ui.pages.triggers.controller.file_triggers", file)
    rig.show_a()
    work = rig.pages["triggers"].work
    work.reading = TriggersReading(History(is_answered=True, is_confirmed=True), 147)
    work._store_reading()
    second = rig.connector.add(rig.ports.make)
    second.connect_to(PORT_B)
    rig.ports.workers[-1].say(**VALUES | B)
    rig.settle()
    second.module.choose("BETA")
    rig.connector.choose(second)
    rig.connector._switch()
    rig.settle()
    assert rig.connector.current.module.name == "BETA"
    store: Any = rig.assembly.storage.store
    store.write(lambda _facts: None).result(PATIENCE_S)
    assert filed == [NAME_A]


@pytest.mark.parametrize("name", [NAME_A, ""])
def test_what_was_said_in_doubt_is_not_of_a_module_that_came_after_that(rig: Rig, name: str) -> None:
    for is_third, wing in ((False, "Wing 4"), (True, "Wing 6")):
        rig.show_a()
        rig.connector.current.module.choose(name)
        page, flights, compare = rig.pages["preflight"], rig.pages["flights"], rig.pages["settings"].compare
        page.form.profile = Profile(name="Show", manual=(ManualLine("Pin out"),))
        page.form.changed.emit()
        rig.worker.identity = Identity(Trust.UNPROVEN, is_named=bool(name))
        rig.answer(A)
        page.list._tick(1, True)
        compare._is_touched.add("light_threshold_v")
        rig.pages["tests"].work.state_safe(True)
        page.form.aircraft.setEditText(wing)
        page.form.commit_edits()
        rig.assembly.window._services.exchange.tried.emit({"attitude_threshold_deg": 47}, None, bool)
        rig.worker.breaks += is_third
        rig.answer(A)
        rig.worker.identity = Identity(Trust.PROVEN, is_named=bool(name))
        rig.answer(A)
        assert rig.connector.current.module.name == name
        kept = [page.list._ticks != {}, flights._tried_with is not None, page.form.committed[1] == wing]
        kept += [compare._is_touched != set(), rig.pages["tests"].work.is_stated_safe]
        page.form.use_none()
        assert kept == [not is_third] * 5


def test_the_aircraft_that_was_entered_for_a_module_comes_back_with_it(rig: Rig) -> None:
    for change, name in (("another port", "Wing 3"), ("its silence", "Wing 5")):
        rig.show_a()
        form = rig.pages["preflight"].form
        form.aircraft.setEditText(name)
        form.commit_edits()
        if change == "another port":
            rig.connector.connect_to(PORT_B)
            rig.answer(B)
            assert form.aircraft.currentText() == ""
            rig.connector.connect_to(PORT_A)
            rig.answer(A)
            rig.connector.current.module.choose(NAME_A)
        else:
            for trust in (Trust.UNPROVEN, Trust.PROVEN):
                rig.worker.identity = Identity(trust, is_named=True)
                rig.answer(A)
                rig.settle()
        assert (rig.connector.current.module.name, form.committed[1]) == (NAME_A, name), change


def test_a_name_longer_than_its_field_stays_what_it_is(rig: Rig) -> None:
    """A command may have given it, or another station: cut, it would be of a module of which nothing is known."""
    rig.show_a()
    form, long = rig.pages["preflight"].form, "M-07 " * 80
    assert form.module.lineEdit().maxLength() == 60  # a typed one fits on a label
    rig.connector.current.module.choose(long)
    form.aircraft.setEditText(long)
    form.commit_edits()
    assert rig.connector.current.module.name == form.committed[1] == long.strip()


def test_a_record_that_came_once_is_listed_behind_those_that_are_kept_and_as_often_as_it_is_not(rig: Rig) -> None:
    """A line that doubles frames: two came, one of which is known from an earlier visit."""
    rig.show_a()
    work, record = rig.pages["triggers"].work, record_of(RECORD)
    store: Any = rig.assembly.storage.store

    def keep(facts: Facts) -> None:
        KeptTriggers(facts).store_visit(NAME_A, [RECORD], port="", boot_count=147, is_confirmed=True)

    store.write(keep).result(PATIENCE_S)
    work.reading = TriggersReading(History(seen_once=(record, record), is_answered=True), 147)
    work._is_stored = True
    assert [(row.seen.place, row.is_stored) for row in work._rows()] == [(0, True), (1, False)]
