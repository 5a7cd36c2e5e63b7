"""Evidence of a port that does not connect, from the worker's batches and from the system."""

import re
import sys
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from app.engine.ports import is_flight_controller
from app.engine.session import MAX_NOISE_BYTES
from app.engine.target import is_network_address
from app.engine.transport import PortError, PortTrouble
from app.engine.worker import Batch, PortState
from app.procedures.find import Silence, what_came
from protocol.catalogue import BY_NAME
from protocol.events import Began, Counters, Role, Sent
from protocol.messages import Reason

# Of serial ports, on Debian and Ubuntu.
USUAL_GROUP = "dialout"
# Of the rejected bytes: at a wrong rate hardly any reach the checksum.
CHECKSUM_SHARE = 0.25
# Of all bytes while frames arrive: more is a bad line.
REJECTED_SHARE = 0.02
_AT = re.compile(rb"AT(?:[ETIZ+&Q$^]|\r)|\x7e\x00\x78\xf0\x7e")
_LOGIN = re.compile(rb"login:|[Pp]assword:|U-Boot|Linux version|\$ \Z|# \Z")
_PROBERS = {"modemmanager", "mmcli"}
_SHUT_DOWN = BY_NAME["shutdown"].set(True)


class AdapterFacts(NamedTuple):
    # Programs that grab serial ports and are running.
    grabbers: tuple[str, ...] = ()
    # The group that may open the port; None where only root may.
    group: str | None = USUAL_GROUP


def facts_about(port: str, *, root: Path = Path("/")) -> AdapterFacts:
    """What the system knows of a device, on Linux; nothing of a URL. Reads files only, and never raises."""
    if not sys.platform.startswith("linux") or "://" in port:
        return AdapterFacts()
    import grp

    running = set()
    with suppress(OSError):
        for comm in (root / "proc").glob("[0-9]*/comm"):
            with suppress(OSError):  # the process has ended
                running.add(comm.read_text(errors="replace", encoding="utf-8").strip())
    grabbers = tuple(name for name in ("ModemManager", "brltty") if name in running)
    try:
        status = (root / port.lstrip("/")).stat()
        is_of_group = status.st_mode & 0o060 and status.st_gid != 0
        return AdapterFacts(grabbers, grp.getgrgid(status.st_gid).gr_name if is_of_group else None)
    except (OSError, KeyError):  # the device is gone; a group without a name
        return AdapterFacts(grabbers)


class PortEvidence(NamedTuple):
    """Observations of one port since it was opened, or why it was not. Times in seconds."""

    port: str = ""
    baud_rate: int = 115200
    trouble: PortError | None = None
    # What a handshake received instead of an answer, where that is the only evidence.
    silence: Silence | None = None
    is_open: bool = False
    # A module answers requests; one that only sends unasked does not.
    is_answering: bool = False
    # A module has answered since the connection began.
    was_online: bool = False
    # The module was ACTIVE when it was last heard.
    was_active: bool = False
    # Command 12 was sent and nothing was received since.
    was_shut_down: bool = False
    counters: Counters = Counters()
    # The last rejected bytes, up to `MAX_NOISE_BYTES`.
    noise: bytes = b""
    # Its USB identity, where it is known.
    adapter: str = ""
    round_trip_median_s: float | None = None
    facts: AdapterFacts = AdapterFacts()
    # As `sys.platform`.
    platform: str = "linux"

    def has(self, *kinds: PortTrouble, is_address: bool = False) -> bool:
        """Whether the port has one of these troubles; with `is_address` only one that is a network address."""
        is_one = self.trouble is not None and self.trouble.trouble in kinds
        return is_one and (not is_address or is_network_address(self.port))

    @property
    def holder(self) -> str:
        """The program that has the port open; empty where unknown."""
        holder = self.trouble.holder if self.trouble is not None else None
        return "" if holder is None else holder.name

    def is_prober(self) -> bool:
        """Whether a modem prober has the port or has written to it."""
        if self.has(PortTrouble.BUSY):
            is_unnamed = not self.holder and "ModemManager" in self.facts.grabbers
            return is_unnamed or self.holder.lower() in _PROBERS
        return not self.is_answering and _AT.search(self.noise) is not None

    def is_claimed_by_brltty(self) -> bool:
        """Whether brltty takes the adapter for a Braille display."""
        is_gone = self.has(PortTrouble.MISSING, PortTrouble.LOST)
        return self.holder.lower() == "brltty" or (is_gone and "brltty" in self.facts.grabbers)

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
        counters = self.counters
        if not self.is_open or not counters.rejected:
            return False
        if counters.frames > counters.by_role[Role.ECHO]:
            is_much = counters.rejected > REJECTED_SHARE * counters.bytes_received
            return is_much and counters.rejected > MAX_NOISE_BYTES // 8
        begun = sum(counters.rejected_bytes[reason] for reason in (Reason.CHECKSUM, Reason.INCOMPLETE, Reason.VALUE))
        return self.is_silent() and begun >= CHECKSUM_SHARE * counters.rejected

    def is_at_flight_controller(self) -> bool:
        """Whether no module was ever heard on the port of a flight controller, nor anything else."""
        return self.came() is Silence.NOTHING and not self.was_online and is_flight_controller(self.adapter)

    def has_login(self) -> bool:
        """Whether a computer's console boots or asks for a login."""
        return self.is_silent() and _LOGIN.search(self.noise) is not None


class EvidenceCollector:
    """Collects evidence from every batch. Belongs to one thread."""

    def __init__(self) -> None:
        self.begin("")

    def begin(self, port: str) -> None:
        """Discards all evidence: a new connection to `port`."""
        self.seen = PortEvidence(port=port, platform=sys.platform)
        # Evidence of a conversation counts from its beginning, that of a silence from the last answer. Bytes that came
        # at another rate are no evidence.
        self._mark = Counters()

    def on_batch(self, batch: Batch) -> None:
        """Processes one batch; to be called for every batch, in order."""
        connection, seen, link = batch.connection, self.seen, batch.link
        is_open = connection.state is PortState.OPEN
        is_answering = is_open and batch.conversation.is_going
        is_new = connection.baud_rate != seen.baud_rate or is_answering is not seen.is_answering
        if connection.state is PortState.OPENING:
            self._mark = Counters()
        elif link is not None and is_new:
            self._mark = link.counters
        was_shut_down = seen.was_shut_down
        for event in batch.events:
            if isinstance(event, Began):
                was_shut_down = False
            elif isinstance(event, Sent) and event.request == _SHUT_DOWN:
                was_shut_down = True
        self.seen = seen._replace(
            port=connection.port or seen.port,
            baud_rate=connection.baud_rate or seen.baud_rate,
            trouble=connection.trouble,
            is_open=is_open,
            is_answering=is_answering,
            was_online=seen.was_online or is_answering,
            was_shut_down=was_shut_down,
            counters=seen.counters if link is None else link.counters - self._mark,
            round_trip_median_s=seen.round_trip_median_s if link is None else link.round_trip_median_s,
            noise=seen.noise if link is None else link.noise,
        )
