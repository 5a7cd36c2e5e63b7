"""What was counted."""

from collections import Counter

from protocol.events import Counters, Role
from protocol.frame import Reason


def test_counts_are_added_and_what_was_counted_since_is_their_difference() -> None:
    before = Counters(1, 2, Counter({Role.ANSWER: 2}), Counter({Reason.CHECKSUM: 6}), 3, 4, 5)
    since = Counters(10, 20, Counter({Role.ANSWER: 19, Role.ECHO: 1}), Counter({Reason.CHECKSUM: 60}), 30, 40, 50)
    total = Counters(11, 22, Counter({Role.ANSWER: 21, Role.ECHO: 1}), Counter({Reason.CHECKSUM: 66}), 33, 44, 55)
    assert before + since == total
    assert total - before == since
    assert total.rejected == 66
