"""E4: when 16 and 17 may be set, and when what was acknowledged counts."""

import pytest

from protocol.catalogue import Request
from protocol.events import Answered, EndReason, Unanswered
from protocol.messages import encode_reply
from tests.support.line.link_bench import Bench, named

ATTITUDE, FREEFALL = named("attitude_trigger").set(True), named("freefall_trigger").set(True)
LATE_S = 3.0


@pytest.fixture
def bench() -> Bench:
    bench = Bench().begun()
    bench.wait(LATE_S)
    bench.events.clear()
    return bench


def is_sent(bench: Bench, request: Request) -> bool:
    """Whether the link sends it now; else it says that it never left."""
    before = bench.sent(request)
    bench.ask(request)
    bench.wait(0.02)  # behind a fence
    is_out = bench.sent(request) > before
    if not is_out:
        assert bench.taken(Unanswered)[-1]._replace(at=0) == Unanswered(request, 0, 0.0, 0)
    return is_out


def are_known(bench: Bench) -> bool:
    return bench.link.flags.are_known(bench.now)


def test_16_follows_directly_where_17_was_answered_under_17(bench: Bench) -> None:
    assert is_sent(bench, FREEFALL)
    bench.hear(encode_reply(0x17, 0))
    assert is_sent(bench, ATTITUDE)
    bench.hear(encode_reply(0x16, 0))
    assert len(bench.taken(Answered)) == 2


@pytest.mark.promise("f")
def test_the_wait_outlives_the_conversation(bench: Bench) -> None:
    assert is_sent(bench, FREEFALL)
    bench.hear(encode_reply(0x16, 0))
    bench.events += bench.link.end(EndReason.ANOTHER, bench.now)
    bench.wait(1.0)
    assert bench.begins == 1
    assert not is_sent(bench, ATTITUDE)


@pytest.mark.parametrize("after_s", [0.001, 0.05, 0.5, 2.9, 4.0])
def test_where_an_acknowledgement_comes_twice_nothing_counts_in_this_conversation(bench: Bench, after_s: float) -> None:
    assert is_sent(bench, FREEFALL)
    bench.hear(encode_reply(0x17, 0))
    bench.hear(encode_reply(0x17, 0), after_s=after_s)
    bench.wait(60.0)
    assert not are_known(bench)
    assert is_sent(bench, ATTITUDE)
    bench.hear(encode_reply(0x16, 0))
    bench.wait(60.0)
    assert not are_known(bench)
    bench.events += bench.link.end(EndReason.ANOTHER, bench.now)
    bench.wait(LATE_S)
    assert are_known(bench)
