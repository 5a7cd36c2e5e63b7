"""Evidence of a port that does not connect, collected from the worker's batches, and its symptoms."""

import re
import sys
from typing import NamedTuple

from app.diagnosis.adapter_facts import SLOW_LATENCY_MS, AdapterFacts
from app.engine.transport import PortError, PortTrouble
from app.engine.worker import Batch, PortState
from app.procedures.find import Silence, what_came
from protocol.catalogue import BY_NAME
from protocol.events import Began, Counters, Rejected, Role, Sent
from protocol.frame import Reason

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


_SHUT_DOWN = BY_NAME["shutdown"].set(True)


class EvidenceCollector:
    """Collects evidence from every batch. Belongs to one thread; `begin` starts a connection."""

    def __init__(self) -> None:
        self.begin("")

    def begin(self, port: str) -> None:
        """Discards all evidence: a new connection to `port`."""
        self._seen = PortEvidence(port=port, platform=sys.platform)
        self._noise = bytearray()
        # Evidence of a conversation counts from its beginning, that of a silence from the last answer. Bytes that came
        # at another rate are no evidence.
        self._mark = Counters()

    def on_batch(self, batch: Batch) -> None:
        """Processes one batch; to be called for every batch, in order."""
        connection, seen = batch.connection, self._seen
        if connection.state is PortState.OPENING:
            self._mark = Counters()
        elif batch.link is not None and connection.baud_rate != seen.baud_rate:
            self._mark = batch.link.counters
        was_shut_down = seen.was_shut_down
        for event in batch.events:
            match event:
                case Sent(request=request) if request == _SHUT_DOWN:
                    was_shut_down = True
                case Began():
                    was_shut_down = False
                case Rejected(noise=noise):
                    self._noise += noise.raw
                case _:
                    pass
        del self._noise[:-MAX_NOISE_BYTES]
        is_open = connection.state is PortState.OPEN
        is_answering = is_open and batch.conversation.is_going
        if batch.link is not None and is_answering is not seen.is_answering:
            self._mark = batch.link.counters
        self._seen = seen._replace(
            port=connection.port or seen.port,
            baud_rate=connection.baud_rate or seen.baud_rate,
            trouble=connection.trouble,
            is_open=is_open,
            is_answering=is_answering,
            was_online=seen.was_online or is_answering,
            was_shut_down=was_shut_down,
        )
        if batch.link is not None:
            self._seen = self._seen._replace(
                counters=batch.link.counters - self._mark,
                round_trip_minimum_s=batch.link.round_trip_minimum_s,
                round_trip_median_s=batch.link.round_trip_median_s,
            )

    def evidence(self, *, facts: AdapterFacts | None = None, short_visits: int = 0) -> PortEvidence:
        """The evidence so far, with that of the system (`facts_about`, `PortHistory.short_visits`)."""
        return self._seen._replace(noise=bytes(self._noise), facts=facts or AdapterFacts(), short_visits=short_visits)
