"""Evidence of a port that does not connect, collected from the worker's batches, and its symptoms."""

import re
import sys
from typing import NamedTuple

from app.diagnosis.adapter_facts import SLOW_LATENCY_MS, AdapterFacts
from app.engine.procedure import LinkView
from app.engine.transport import PortError, PortTrouble
from app.engine.worker import Batch, PortState
from app.procedures.handshake import Silence, what_came
from protocol.catalogue import BY_NAME
from protocol.events import Counters, Received, Rejected, Role, Sent
from protocol.frame import Reason
from protocol.link_states import Presence

MAX_NOISE_BYTES = 512
SLOW_MINIMUM_S = 0.008
"""Round trips below this are not delayed by a latency timer; a module at 115200 baud answers within 3 ms."""
LATENCY_STEP_S = 0.016
CHECKSUM_SHARE = 0.25
"""Of the rejected bytes: at a wrong rate hardly any reach the checksum."""
REJECTED_SHARE = 0.02
"""Of all bytes while frames arrive: more is a bad line."""
_AT = re.compile(rb"AT(?:[ETIZ+&Q$^]|\r)|\x7e\x00\x78\xf0\x7e")
_LOGIN = re.compile(rb"login:|[Pp]assword:|U-Boot|Linux version|\$ \Z|# \Z")
_PROBERS = {"modemmanager", "mmcli"}
_BRAILLE = {"brltty"}


class PortEvidence(NamedTuple):
    """Observations of one port since it was opened, or why it was not. Times in seconds."""

    port: str = ""
    baud_rate: int = 115200
    trouble: PortError | None = None
    silence: Silence | None = None
    """What a handshake received instead of an answer, where that is the only evidence."""
    is_open: bool = False
    is_answering: bool = False
    """A module answers requests; one that only sends unasked does not."""
    was_online: bool = False
    """A module has answered since the connection began."""
    was_active: bool = False
    """The module was ACTIVE when it was last heard."""
    was_shut_down: bool = False
    """Command 12 was sent and nothing was received since."""
    counters: Counters = Counters()
    noise: bytes = b""
    """The last rejected bytes, up to `MAX_NOISE_BYTES`."""
    round_trip_minimum_s: float | None = None
    round_trip_median_s: float | None = None
    short_visits: int = 0
    facts: AdapterFacts = AdapterFacts()
    platform: str = "linux"
    """As `sys.platform`."""

    def trouble_kind(self) -> PortTrouble | None:
        return None if self.trouble is None else self.trouble.trouble

    def is_busy(self) -> bool:
        return self.trouble_kind() is PortTrouble.BUSY

    def is_refused(self) -> bool:
        return self.trouble_kind() is PortTrouble.NOT_ALLOWED

    def is_gone(self) -> bool:
        return self.trouble_kind() in (PortTrouble.MISSING, PortTrouble.LOST)

    def holder_name(self) -> str:
        """The program that has the port open; empty where unknown."""
        holder = self.trouble.holder if self.trouble is not None else None
        return "" if holder is None else holder.name

    def is_prober(self) -> bool:
        """Whether a modem prober has the port or has written to it."""
        if self.is_busy():
            name = self.holder_name().lower()
            return name in _PROBERS or (not name and "ModemManager" in self.facts.grabbers)
        return not self.is_answering and _AT.search(self.noise) is not None

    def is_claimed_by_brltty(self) -> bool:
        """Whether brltty takes the adapter for a Braille display."""
        is_snatched = self.is_gone() and self.short_visits >= 1 and "brltty" in self.facts.grabbers
        return is_snatched or self.holder_name().lower() in _BRAILLE

    def is_silent(self) -> bool:
        """Whether requests were sent on the open port and no module answers."""
        return self.is_open and not self.is_answering and self.counters.time_outs > 0

    def came(self) -> Silence | None:
        """What came instead of an answer; None where a module answers or nothing was asked."""
        if self.silence is not None:
            return self.silence
        return what_came(self.counters, self.noise) if self.is_silent() else None

    def is_bad_line(self) -> bool:
        """Whether frames are damaged, rather than bytes of another rate."""
        rejected = self.counters.rejected
        if not self.is_open or not rejected:
            return False
        if self.counters.frames > self.counters.by_role[Role.ECHO]:
            return rejected > REJECTED_SHARE * self.counters.bytes_received and rejected > MAX_NOISE_BYTES // 8
        begun = sum(
            self.counters.rejected_bytes[reason] for reason in (Reason.CHECKSUM, Reason.INCOMPLETE, Reason.VALUE)
        )
        return self.is_silent() and begun >= CHECKSUM_SHARE * rejected

    def is_slow(self) -> bool:
        """Whether the adapter's latency timer delays every answer."""
        if not self.is_answering:
            return False
        latency_ms = self.facts.latency_ms
        if latency_ms is not None:
            return latency_ms > SLOW_LATENCY_MS
        quickest, usual = self.round_trip_minimum_s, self.round_trip_median_s
        return (
            quickest is not None and usual is not None and quickest >= SLOW_MINIMUM_S and usual <= 2.5 * LATENCY_STEP_S
        )

    def may_soon(self) -> bool:
        access = self.facts.access
        return access is not None and access.is_member and not access.is_effective

    def has_login(self) -> bool:
        """Whether a computer's console boots or asks for a login."""
        return self.is_silent() and _LOGIN.search(self.noise) is not None


MISSES_OF_A_DEAF_MODULE = 2
"""Consecutive requests without an answer from a module that sends unasked."""
_SHUT_DOWN = BY_NAME["shutdown"].set(True)


class EvidenceCollector:
    """Collects evidence from every batch. Belongs to one thread; `begin` starts a connection."""

    def __init__(self) -> None:
        self.begin("")

    def begin(self, port: str) -> None:
        """Discards all evidence: a new connection to `port`, or another module there."""
        self._seen = PortEvidence(port=port, platform=sys.platform)
        self._count_from(Counters())

    def _count_from(self, totals: Counters) -> None:
        self._mark = totals
        """Totals when a module last answered or restarted; evidence counts from there."""
        self._base = totals
        """Those when the port was opened or its rate set; bytes at another rate are no evidence."""
        self._noise = bytearray()

    def on_batch(self, batch: Batch) -> None:
        """Processes one batch; to be called for every batch, in order."""
        connection = batch.connection
        if connection.state is PortState.OPENING:
            self._count_from(Counters())
        elif connection.baud_rate != self._seen.baud_rate and batch.link is not None:
            self._count_from(batch.link.counters)
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
        self._seen = self._seen._replace(
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
        return self._seen._replace(noise=bytes(self._noise), facts=facts or AdapterFacts(), short_visits=short_visits)

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
        self._seen = self._seen._replace(
            is_answering=is_answering,
            was_online=self._seen.was_online or has_answered,
            counters=counters,
            round_trip_minimum_s=link.round_trip_minimum_s,
            round_trip_median_s=link.round_trip_median_s,
        )
