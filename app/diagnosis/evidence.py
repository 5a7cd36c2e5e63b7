"""Collects evidence for `app.diagnosis.causes` from the worker's batches."""

import sys
from dataclasses import replace

from app.diagnosis.adapter_facts import AdapterFacts
from app.diagnosis.symptoms import MAX_NOISE_BYTES, PortEvidence
from app.engine.procedure import LinkView
from app.engine.worker import Batch, PortState
from protocol.catalogue import BY_NAME
from protocol.events import Counters, Received, Rejected, Role, Sent
from protocol.link_states import Presence

MISSES_OF_A_DEAF_MODULE = 2
"""Consecutive requests without an answer from a module that sends unasked."""
_SHUT_DOWN = BY_NAME["shutdown"].set(True)


class EvidenceCollector:
    """Collects evidence from every batch. Belongs to one thread; `begin` starts a connection."""

    def __init__(self) -> None:
        self._seen = PortEvidence(platform=sys.platform)
        self._mark = Counters()
        """Totals when a module last answered or restarted; evidence counts from there."""
        self._base = self._mark
        """Those when the port was opened or its rate set; bytes at another rate are no evidence."""
        self._noise = bytearray()

    def begin(self, port: str) -> None:
        """Discards all evidence: a new connection to `port`."""
        self._seen = PortEvidence(port=port, platform=sys.platform)
        self._mark = self._base = Counters()
        self._noise.clear()

    def on_batch(self, batch: Batch) -> None:
        """Processes one batch; to be called for every batch, in order."""
        connection = batch.connection
        if connection.state is PortState.OPENING:
            self._mark = self._base = Counters()
            self._noise.clear()
        elif connection.baud_rate != self._seen.baud_rate and self._seen.is_open and batch.link is not None:
            self._mark = self._base = batch.link.counters
            self._noise.clear()
        was_shut_down = self._seen.was_shut_down
        for event in batch.events:
            match event:
                case Sent(request=request) if request == _SHUT_DOWN:
                    was_shut_down = True
                case Received(role=role) if role not in (Role.ANSWER, Role.ECHO, Role.LATE):
                    was_shut_down = False  # the acknowledgement comes before the shutdown, anything else after
                case Rejected(noise=noise):
                    self._noise += noise.raw
                case _:
                    pass
        del self._noise[:-MAX_NOISE_BYTES]
        is_open = connection.state is PortState.OPEN
        self._seen = replace(
            self._seen,
            port=connection.port or self._seen.port,
            baud_rate=connection.baud_rate or self._seen.baud_rate,
            trouble=connection.trouble,
            is_open=is_open,
            is_answering=self._seen.is_answering and is_open,
            was_shut_down=was_shut_down,
        )
        if batch.link is not None:
            self._on_link(batch.link, is_online=batch.device.presence is Presence.ONLINE)

    def evidence(self, *, facts: AdapterFacts | None = None, short_visits: int = 0) -> PortEvidence:
        """The evidence so far, with that of the system (`facts_about`, `PortHistory.short_visits`)."""
        return replace(self._seen, noise=bytes(self._noise), facts=facts or AdapterFacts(), short_visits=short_visits)

    def _on_link(self, link: LinkView, *, is_online: bool) -> None:
        totals = link.counters
        has_news = totals.restarts > self._mark.restarts
        if has_news or totals.by_role[Role.ANSWER] > self._mark.by_role[Role.ANSWER]:
            self._mark = totals
        has_answered = totals.by_role[Role.ANSWER] > 0
        misses = totals.time_outs - self._mark.time_outs
        is_answering = is_online and has_answered and misses < MISSES_OF_A_DEAF_MODULE
        counters = totals - (self._base if is_answering else self._mark)
        # A request that was pending at the mark may have timed out since.
        counters.sent = max(counters.sent, counters.time_outs)
        self._seen = replace(
            self._seen,
            is_answering=is_answering,
            was_online=self._seen.was_online or has_answered,
            counters=counters,
            round_trip_minimum_s=link.round_trip_minimum_s,
            round_trip_median_s=link.round_trip_median_s,
        )
