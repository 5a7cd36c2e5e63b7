"""E4 on the independent module: acknowledgements of 16 and 17 that come again, later, and sets that are lost."""

import itertools
from collections.abc import Iterator

import pytest

from app.procedures.write import SettingChange, WriteContext, WriteFault, WriteReport, write_all
from protocol.catalogue import BY_NAME
from tests.module.options import Options
from tests.support.journals import FakeJournal
from tests.support.line.module_line import ModuleRig
from tests.support.thorough import some

ATTITUDE, FREEFALL = 0x16, 0x17
KEYS = {ATTITUDE: "attitude_trigger", FREEFALL: "freefall_trigger"}
# A copy comes within three seconds, or is taken for something else (docs/safety.md).
DELAYS_S = (0.05, 0.25, 0.3, 0.5, 0.8, 1.0, 1.5, 2.0, 2.5, 2.9)
LOST = ((ATTITUDE,), (FREEFALL,), (ATTITUDE, FREEFALL))


def options(delay_s: float, lost: tuple[int, ...], code: int) -> Options:
    """A line that repeats both acknowledgements, on which sets are lost."""
    copies = {ATTITUDE: [delay_s], FREEFALL: [delay_s]}
    return Options(freefall_code=code, copies=copies, lost_sets=dict.fromkeys(lost, -1))


def cases(one_in: int) -> Iterator[tuple[float, tuple[int, ...], int]]:
    yield from some(itertools.product(DELAYS_S, LOST, (0x16, 0x17)), one_in=one_in)


def disabled(rig: ModuleRig) -> ModuleRig:
    """Its triggers are off, so that a set that did not arrive shows."""
    rig.module.settings |= {ATTITUDE: 1, FREEFALL: 1}
    return rig.begin()


def enable(rig: ModuleRig, *codes: int) -> WriteReport:
    changes = [SettingChange(BY_NAME[KEYS[code]], True) for code in codes]
    return rig.run(write_all(changes, WriteContext(journal=FakeJournal())))


@pytest.mark.parametrize("order", [(ATTITUDE, FREEFALL), (FREEFALL, ATTITUDE)])
@pytest.mark.promise("f")
def test_never_acknowledged_in_one_command(order: tuple[int, int]) -> None:
    for delay_s, lost, code in cases(one_in=3):
        rig = disabled(ModuleRig(options(delay_s, lost, code)))
        report = enable(rig, *order)
        where = (delay_s, [f"{one:02X}" for one in lost], f"{code:02X}")
        said = {one.command.code: one for one in report.results}
        for one in lost:
            assert not said[one].is_acknowledged, where
            assert said[one].fault is not None, where
        assert not report.is_fine, where


@pytest.mark.parametrize("order", [(ATTITUDE, FREEFALL), (FREEFALL, ATTITUDE)])
@pytest.mark.promise("f")
def test_never_acknowledged_across_two_commands(order: tuple[int, int]) -> None:
    """The second one is lost; a copy of the first one's acknowledgement comes while it waits."""
    first, second = order
    for delay_s, code in some(itertools.product(DELAYS_S, (0x16, 0x17)), one_in=2):
        rig = disabled(ModuleRig(options(delay_s, (second,), code)))
        enable(rig, first)
        rig.reopen()
        rig.begin()
        (written,) = enable(rig, second).results
        assert written.fault is not None, (delay_s, code)
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
            rig.begin()
        sets = [entry for entry in rig.module.log.sets() if entry.code in KEYS]
        assert sets[0].at_s - opened_s >= 3.0
        for before, after in itertools.pairwise(sets):
            is_exception = (before.code, after.code, code) == (FREEFALL, ATTITUDE, FREEFALL)
            assert is_exception or after.at_s - before.at_s >= 3.0
