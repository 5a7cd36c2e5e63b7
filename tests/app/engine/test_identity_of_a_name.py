"""A name that a person gave is compared with what was last read under it: a session without a window."""

import pytest

from app.engine.identity import NO_EXPECTATION, UNKNOWN, Identity, IdentityEvidence, Trust
from protocol.catalogue import STATUS
from tests.app.engine.test_identity import FOUND, OPTIONS, ask
from tests.support.line.sim_line import Rig, watched

OF_ANOTHER = FOUND._replace(boot_count=90)


def named(before: IdentityEvidence = UNKNOWN) -> Rig:
    rig = Rig(OPTIONS)
    rig.session.identity.confirm(NO_EXPECTATION, is_named=True, before=before)
    watched(rig)
    rig.step_for(5)
    return rig


def identity(rig: Rig) -> Identity:
    return rig.session.identity.identity


def test_a_name_does_not_count_for_a_module_that_came_meanwhile() -> None:
    rig = named()
    rig.bench.restart()
    rig.step_for(5)
    rig.session.identity.confirm(NO_EXPECTATION, is_named=True)
    assert identity(rig).trust is Trust.UNPROVEN


@pytest.mark.promise("a")
def test_what_refutes_a_name_does_so_until_it_is_read_again() -> None:
    """A restart makes all values stale, which is no answer to the question."""
    rig = named(OF_ANOTHER)
    rig.bench.restart()

    def is_read_again() -> bool:
        assert (identity(rig).trust, identity(rig).before) == (Trust.REFUTED, OF_ANOTHER)
        return identity(rig).now.boot_count == 38

    rig.step_until(is_read_again)


def test_a_name_is_asked_about_where_what_may_refute_it_is_not_read_yet() -> None:
    """A procedure has the line meanwhile."""
    rig = Rig(OPTIONS)
    rig.session.identity.confirm(NO_EXPECTATION, is_named=True, before=OF_ANOTHER)
    rig.run(ask(STATUS.query()))
    rig.step_for(5)
    assert identity(rig).trust is Trust.UNPROVEN
    watched(rig)
    rig.step_for(5)
    assert identity(rig).trust is Trust.REFUTED
