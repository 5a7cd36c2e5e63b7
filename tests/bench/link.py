"""Cost of one exchange in the link, compared with bytes handled directly."""

import gc
import time
from collections.abc import Callable
from typing import Final

from protocol.catalogue import BY_NAME
from protocol.events import Answered
from protocol.frame import encode_reply
from protocol.link import Link
from tests.bench.figures import Figure

LINE_EXCHANGES: Final = 11_520 // 12
"""Exchanges of six bytes each way per second at 115200 baud."""
AIM_TIMES: Final = 10
_QUERY: Final = BY_NAME["boot_count"].query()
_REPLY: Final = encode_reply(0x23, 37)


def _by_link(exchanges: int) -> None:
    link, now = Link(0.0), 0.001
    link.tick(0.0)  # the link asks for the boot count itself, with which a conversation begins
    link.receive(_REPLY, now)
    assert link.is_begun
    for _ in range(exchanges):
        link.ask(_QUERY, now)
        link.take_outgoing()
        now += 0.001
        events = link.receive(_REPLY, now)
        assert any(isinstance(event, Answered) for event in events)
        now += 0.001


def _by_hand(exchanges: int) -> None:
    for _ in range(exchanges):
        body = bytes((0x23, 0x01, 0x00))
        frame = b"Ba" + body + bytes((sum(body) & 0xFF,))
        reply = _REPLY
        assert frame
        assert reply[:2] == b"Au"
        assert reply[2] == 0x23
        assert sum(reply[2:5]) & 0xFF == reply[5]


def _seconds(act: Callable[[int], None], exchanges: int, rounds: int) -> float:
    """Of one exchange in the best round; slower rounds are due to other load."""
    took = []
    gc.collect()
    for _ in range(rounds):
        began = time.perf_counter()
        act(exchanges)
        took.append(time.perf_counter() - began)
    return min(took) / exchanges


def figures(exchanges: int = 20_000, rounds: int = 5) -> list[Figure]:
    mine, bare = (_seconds(act, exchanges, rounds) for act in (_by_link, _by_hand))
    times = 1 / mine / LINE_EXCHANGES
    return [
        Figure(
            "link, a question and its answer",
            f"{mine * 1e6:.0f} µs, {times:.0f} x line; by hand, without matching and retries {bare * 1e6:.1f} µs",
            f">= {AIM_TIMES} x line",
            times >= AIM_TIMES,
        )
    ]
