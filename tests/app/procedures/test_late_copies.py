"""E4 on the independent module: acknowledgements of 16 and 17 that come again, later, and sets that are lost."""

import itertools
from collections.abc import Iterator

import pytest
from app.procedures.write_all import SettingChange, WriteContext, WriteReport, write_all

from app.limits.past import Past
from app.preflight.evidence import Evidence
from app.preflight.findings import Case, CheckResult, Person
from app.preflight.run import run_preflight
from app.preflight.verdict import Assessment, Verdict, assess
from app.procedures.write import WriteFault
from app.settings.profiles import Profile
from protocol.catalogue import BY_NAME
from tests.module.options import Options
from tests.support.journals import FakeJournal
from tests.support.line.module_line import ModuleRig
from tests.support.thorough import some

ATTITUDE, FREEFALL = 0x16, 0x17
KEYS = {ATTITUDE: "attitude_trigger", FREEFALL: "freefall_trigger"}
DELAYS_S = (0.05, 0.25, 0.3, 0.5, 0.8, 1.0, 1.5, 2.0, 2.9, 3.0, 3.1, 3.5, 3.9, 4.0, 4.5, 5.0)
LOST = ((ATTITUDE,), (FREEFALL,), (ATTITUDE, FREEFALL))


def options(delay_s: float, lost: tuple[int, ...], code: int, how: str) -> Options:
    """A line that repeats both acknowledgements, on which sets are lost or ignored without a word."""
    faults = dict.fromkeys(lost, -1)
    return Options(
        freefall_code=code,
        copies={ATTITUDE: [delay_s], FREEFALL: [delay_s]},
        lost_sets=dict(faults) if how == "lost" else {},
        lost_answers=dict(faults) if how == "unanswered" else {},
    )


def cases(one_in: int) -> Iterator[tuple[float, tuple[int, ...], int]]:
    yield from some(itertools.product(DELAYS_S, LOST, (0x16, 0x17)), one_in=one_in)


def disabled(rig: ModuleRig) -> ModuleRig:
    """Its triggers are off, so that a set that did not arrive shows."""
    rig.module.settings |= {ATTITUDE: 1, FREEFALL: 1}
    return rig


def enable(rig: ModuleRig, *codes: int) -> WriteReport:
    changes = [SettingChange(BY_NAME[KEYS[code]], True) for code in codes]
    return rig.run(write_all(changes, WriteContext(journal=FakeJournal())))


def checked(rig: ModuleRig) -> Assessment:
    evidence = Evidence(port="sim")
    rig.run(run_preflight(evidence, is_enabling=True, journal=FakeJournal()))
    person = Person(who="R. Tanaka", module="M-07", are_records_reviewed=True, are_settings_approved=True)
    past = Past(module="M-07", boot_count=1, has_check=True, is_said_new=True)
    return assess(
        Case(evidence=evidence, profile=Profile(settings={"light_threshold_v": 1.8}), past=past, person=person)
    )


@pytest.mark.parametrize("code", [0x16, 0x17])
def test_on_a_good_line_both_are_enabled_and_it_is_ready(code: int) -> None:
    rig = disabled(ModuleRig(Options(freefall_code=code)))
    assessment = checked(rig)
    assert [one.check.id for one in assessment.checks if one.blocks_go] == []
    assert assessment.verdict is Verdict.READY
    assert (rig.module.settings[ATTITUDE], rig.module.settings[FREEFALL]) == (0, 0)
    times = [entry.at_s for entry in rig.module.log.sets() if entry.code in KEYS]
    assert (times[1] - times[0] < 1.0) is (code == 0x17), "16 directly after a 17 that was answered under 17"


@pytest.mark.parametrize("how", ["lost", "unanswered"])
@pytest.mark.promise("f")
def test_never_ready_with_a_trigger_that_the_module_did_not_take(how: str) -> None:
    for delay_s, lost, code in cases(one_in=6):
        rig = disabled(ModuleRig(options(delay_s, lost, code, how)))
        assessment = checked(rig)
        where = (delay_s, [f"{one:02X}" for one in lost], f"{code:02X}")
        for one in lost:
            assert assessment.result(KEYS[one]) is not CheckResult.PASS, where
        assert assessment.verdict is Verdict.NO_GO, where


@pytest.mark.parametrize("order", [(ATTITUDE, FREEFALL), (FREEFALL, ATTITUDE)])
@pytest.mark.promise("f")
def test_never_acknowledged_in_one_command(order: tuple[int, int]) -> None:
    for delay_s, lost, code in cases(one_in=6):
        rig = disabled(ModuleRig(options(delay_s, lost, code, "lost")))
        report = enable(rig, *order)
        where = (delay_s, [f"{one:02X}" for one in lost], f"{code:02X}")
        said = {one.command.code: one for one in report.results}
        for one in lost:
            assert not said[one].is_acknowledged, where
            assert not said[one].is_fine, where
        assert not report.is_fine, where


@pytest.mark.parametrize("order", [(ATTITUDE, FREEFALL), (FREEFALL, ATTITUDE)])
@pytest.mark.promise("f")
def test_never_acknowledged_across_two_commands(order: tuple[int, int]) -> None:
    """The second one is lost; a copy of the first one's acknowledgement comes while it waits."""
    first, second = order
    for delay_s, code in some(itertools.product(DELAYS_S, (0x16, 0x17)), one_in=2):
        rig = disabled(ModuleRig(options(delay_s, (second,), code, "lost")))
        enable(rig, first)
        rig.reopen()
        (written,) = enable(rig, second).results
        assert not written.is_fine, (delay_s, code)
        assert not written.is_acknowledged, (delay_s, code)


def test_it_is_said_that_the_line_repeats_answers() -> None:
    rig = disabled(ModuleRig(Options(copies={FREEFALL: [0.5]})))
    (written,) = enable(rig, FREEFALL).results
    assert written.fault is WriteFault.REPEATED
    assert rig.module.settings[FREEFALL] == 0, "it was taken, but nobody can know"


@pytest.mark.promise("f")
def test_between_two_sets_there_are_three_seconds_also_after_opening() -> None:
    for code, delay_s in itertools.product((0x16, 0x17), (None, 0.8)):
        rig = disabled(ModuleRig(Options(freefall_code=code, copies={} if delay_s is None else {FREEFALL: [delay_s]})))
        opened_s = rig.clock.now_s - 1000.0
        for _ in range(2):
            enable(rig, ATTITUDE, FREEFALL)
            rig.reopen()
        sets = [entry for entry in rig.module.log.sets() if entry.code in KEYS]
        assert sets[0].at_s - opened_s >= 3.0
        for before, after in itertools.pairwise(sets):
            is_exception = (before.code, after.code, code) == (FREEFALL, ATTITUDE, FREEFALL)
            assert is_exception or after.at_s - before.at_s >= 3.0
