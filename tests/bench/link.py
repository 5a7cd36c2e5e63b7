"""Cost of one exchange in the link."""

from collections.abc import Iterator
from typing import Final

from protocol.catalogue import BY_NAME
from protocol.events import Answered
from protocol.link import Link
from protocol.messages import encode_reply
from tests.bench.kit import Figure, best_s

LINE_EXCHANGES: Final = 11_520 // 12
"""Exchanges of six bytes each way per second at 115200 baud."""
AIM_TIMES: Final = 10
_QUERY: Final = BY_NAME["boot_count"].query()
_REPLY: Final = encode_reply(0x23, 37)


def _exchange(exchanges: int) -> None:
    link, now = Link(0.0), 0.001
    link.tick(0.0)  # the link asks for the boot count itself, with which a conversation begins
    link.receive(_REPLY, now)
    assert link.is_begun
    for _ in range(exchanges):
        link.ask(_QUERY, now)
        link.take_outgoing()
        now += 0.001
        assert any(isinstance(event, Answered) for event in link.receive(_REPLY, now))
        now += 0.001


def figures(exchanges: int = 20_000, rounds: int = 5) -> Iterator[Figure]:
    took_s = best_s(lambda: _exchange(exchanges), rounds) / exchanges
    times = 1 / took_s / LINE_EXCHANGES
    measured = f"{took_s * 1e6:.0f} µs, {times:.0f} x line"
    yield Figure("link, a question and its answer", measured, f">= {AIM_TIMES} x line", times >= AIM_TIMES)
