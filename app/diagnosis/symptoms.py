"""Symptoms of a port that does not connect. Pure: no port, no clock."""

import re
from dataclasses import dataclass, field

from app.diagnosis.adapter_facts import SLOW_LATENCY_MS, AdapterFacts
from app.engine.transport import PortError, PortTrouble
from app.procedures.handshake import Silence, what_came
from protocol.events import Counters, Role
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


@dataclass(frozen=True, slots=True, kw_only=True)
class PortEvidence:
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
    counters: Counters = field(default_factory=Counters)
    noise: bytes = b""
    """The last rejected bytes, up to `MAX_NOISE_BYTES`."""
    round_trip_minimum_s: float | None = None
    round_trip_median_s: float | None = None
    short_visits: int = 0
    """See `PortHistory.short_visits`."""
    facts: AdapterFacts = field(default_factory=AdapterFacts)
    platform: str = "linux"
    """As `sys.platform`."""


def trouble_of(evidence: PortEvidence) -> PortTrouble | None:
    return None if evidence.trouble is None else evidence.trouble.trouble


def is_busy(evidence: PortEvidence) -> bool:
    return trouble_of(evidence) is PortTrouble.BUSY


def is_refused(evidence: PortEvidence) -> bool:
    return trouble_of(evidence) is PortTrouble.NOT_ALLOWED


def is_gone(evidence: PortEvidence) -> bool:
    return trouble_of(evidence) in (PortTrouble.MISSING, PortTrouble.LOST)


def holder_name(evidence: PortEvidence) -> str:
    """The program that has the port open; empty where unknown."""
    holder = evidence.trouble.holder if evidence.trouble is not None else None
    return "" if holder is None else holder.name


def is_prober(evidence: PortEvidence) -> bool:
    """Whether a modem prober has the port or has written to it."""
    if is_busy(evidence):
        name = holder_name(evidence).lower()
        return name in _PROBERS or (not name and "ModemManager" in evidence.facts.grabbers)
    return not evidence.is_answering and _AT.search(evidence.noise) is not None


def is_claimed_by_brltty(evidence: PortEvidence) -> bool:
    """Whether brltty takes the adapter for a Braille display."""
    is_snatched = is_gone(evidence) and evidence.short_visits >= 1 and "brltty" in evidence.facts.grabbers
    return is_snatched or holder_name(evidence).lower() in _BRAILLE


def is_silent(evidence: PortEvidence) -> bool:
    """Whether requests were sent on the open port and no module answers."""
    return evidence.is_open and not evidence.is_answering and evidence.counters.time_outs > 0


def came(evidence: PortEvidence) -> Silence | None:
    """What came instead of an answer; None where a module answers or nothing was asked."""
    if evidence.silence is not None:
        return evidence.silence
    return what_came(evidence.counters, evidence.noise) if is_silent(evidence) else None


def is_bad_line(evidence: PortEvidence) -> bool:
    """Whether frames are damaged, rather than bytes of another rate."""
    rejected = evidence.counters.rejected
    if not evidence.is_open or not rejected:
        return False
    if evidence.counters.frames > evidence.counters.by_role[Role.ECHO]:
        return rejected > REJECTED_SHARE * evidence.counters.bytes_received and rejected > MAX_NOISE_BYTES // 8
    begun = sum(
        evidence.counters.rejected_bytes[reason] for reason in (Reason.CHECKSUM, Reason.INCOMPLETE, Reason.VALUE)
    )
    return is_silent(evidence) and begun >= CHECKSUM_SHARE * rejected


def is_slow(evidence: PortEvidence) -> bool:
    """Whether the adapter's latency timer delays every answer."""
    if not evidence.is_answering:
        return False
    latency_ms = evidence.facts.latency_ms
    if latency_ms is not None:
        return latency_ms > SLOW_LATENCY_MS
    quickest, usual = evidence.round_trip_minimum_s, evidence.round_trip_median_s
    return quickest is not None and usual is not None and quickest >= SLOW_MINIMUM_S and usual <= 2.5 * LATENCY_STEP_S


def may_soon(evidence: PortEvidence) -> bool:
    access = evidence.facts.access
    return access is not None and access.is_member and not access.is_effective


def has_login(evidence: PortEvidence) -> bool:
    """Whether a computer's console boots or asks for a login."""
    return is_silent(evidence) and _LOGIN.search(evidence.noise) is not None
