"""Cost of one exchange in the link, compared with bytes handled directly."""

import gc
import time
from typing import Final

from protocol.catalogue import BY_NAME
from protocol.events import Answered
from protocol.frame import encode_reply
from protocol.link import Link
from tests.benchmarks.figures import Figure

LINE_EXCHANGES: Final = 11_520 // 12
"""Exchanges of six bytes each way per second at 115200 baud."""
AIM_TIMES: Final = 10
_QUERY: Final = BY_NAME["boot_count"].query()
_REPLY: Final = encode_reply(0x23, 37)
_ROUNDS: Final = 5


def _link_s(exchanges: int) -> float:
    link = Link(0.0)
    now = 1.0
    began = time.perf_counter()
    for _ in range(exchanges):
        link.ask(_QUERY, now)
        link.take_outgoing()
        now += 0.001
        events = link.receive(_REPLY, now)
        if not any(isinstance(event, Answered) for event in events):
            raise AssertionError("not answered")
        now += 0.001
    return time.perf_counter() - began


def _by_hand_s(exchanges: int) -> float:
    began = time.perf_counter()
    for _ in range(exchanges):
        body = bytes((0x23, 0x01, 0x00))
        frame = b"Ba" + body + bytes((sum(body) & 0xFF,))
        reply = _REPLY
        if not (frame and reply[:2] == b"Au" and reply[2] == 0x23 and sum(reply[2:5]) & 0xFF == reply[5]):
            raise AssertionError("not answered")
    return time.perf_counter() - began


def figures(exchanges: int = 20_000, rounds: int = _ROUNDS) -> list[Figure]:
    """One row with the best round of each; slower rounds are due to other load."""
    gc.collect()
    mine = min(_link_s(exchanges) for _ in range(rounds)) / exchanges
    bare = min(_by_hand_s(exchanges) for _ in range(rounds)) / exchanges
    times = 1 / mine / LINE_EXCHANGES
    return [
        Figure(
            "link, a question and its answer",
            f"{mine * 1e6:.0f} µs, {times:.0f} x line; by hand, without matching and retries {bare * 1e6:.1f} µs",
            f">= {AIM_TIMES} x line",
            times >= AIM_TIMES,
        )
    ]
