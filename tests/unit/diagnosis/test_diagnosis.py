"""The table of causes row by row, the collection of evidence, causes on a simulated line."""

from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from app.diagnosis.causes import PortEvidence, diagnose, explain
from app.diagnosis.link_state import Phase, link_state
from app.diagnosis.silence import Silence
from app.engine.conversation import ConversationView, Interrupted
from app.engine.reconnect import Absence
from app.engine.transport import PortError, PortErrorKind, _trouble_at_opening
from app.engine.worker import Batch, Connection, PortState
from app.safety.last_known import keep_away
from app.text.i18n import set_language
from protocol.events import Counters, Ended, EndReason, Role
from protocol.messages import Reason
from tests.support.line.frames import at_each_frame
from tests.support.line.sim_line import Rig

PORT = "/dev/ttyUSB0"
AT_THE_MODULE = (
    "2 s",
    "2 秒",
    "wire",
    "wiring",
    "shorter cable",
    "power and cable",
    "closer",
    "TX",
    "its power",
    "接线",
    "线缆",
    "供电",
    "电源",
)
"""What would bring a hand near the module."""


def trouble(kind: PortErrorKind) -> PortEvidence:
    return PortEvidence(port=PORT, trouble=PortError(kind, PORT, "driver's words"), platform="linux")


def opened(*, bytes_received: int = 0, **values: Any) -> PortEvidence:
    """An open port with three requests and no reply."""
    counters = Counters(sent=3, time_outs=3, bytes_received=bytes_received, **values.pop("counters", {}))
    return PortEvidence(port=PORT, is_open=True, counters=counters, **values)


def online(*, bytes_received: int = 0, **values: Any) -> PortEvidence:
    counters = values.pop("counters", Counters()) + Counters(bytes_received=bytes_received)
    return PortEvidence(port=PORT, is_open=True, is_answering=True, was_online=True, counters=counters, **values)


def rejected(count: int, reason: Reason = Reason.NO_HEADER) -> dict[str, Any]:
    return {"rejected_bytes": Counter({reason: count})}


# As pymavlink packs an ArduCopter's heartbeats.
MAVLINK = bytes.fromhex("fd 09 00 00 fe 01 01 00 00 00 00 00 00 00 02 03 51 04 03 ee 2a")
ADDRESS = "socket://10.0.0.9:7000"


def unreached(detail: str, port: str = ADDRESS) -> PortEvidence:
    return PortEvidence(port=port, trouble=PortError(_trouble_at_opening(OSError(detail)), port, detail))


TABLE: tuple[tuple[str, PortEvidence, str], ...] = (
    ("no bytes at all", opened(), "nothing"),
    ("echo only", opened(bytes_received=18, counters={"frames": 3, "by_role": Counter({Role.ECHO: 3})}), "echo"),
    ("garbage", opened(bytes_received=200, counters=rejected(200)), "wrong rate"),
    ("checksum errors and no frame", opened(bytes_received=60, counters=rejected(60, Reason.CHECKSUM)), "bad line"),
    ("checksum errors among frames", online(
        bytes_received=4000, counters=Counters(frames=400, **rejected(400, Reason.CHECKSUM))
    ), "bad line"),
    ("held", trouble(PortErrorKind.BUSY), "held"),
    ("held, on Windows", trouble(PortErrorKind.BUSY)._replace(platform="win32"), "held"),
    ("no permission", trouble(PortErrorKind.NOT_ALLOWED), "no permission"),
    ("no such port", trouble(PortErrorKind.MISSING), "missing"),
    ("nobody listens", unreached("Could not open port: [Errno 111] Connection refused"), "unreachable"),
    ("the other end closes", PortEvidence(port=ADDRESS, trouble=PortError(PortErrorKind.LOST, ADDRESS, "")),
     "unreachable"),
    ("unplugged", trouble(PortErrorKind.LOST), "unplugged"),
    ("no serial port", trouble(PortErrorKind.UNUSABLE), "unusable"),
    ("heartbeats of MAVLink, after passthrough ended", opened(
        was_online=True, bytes_received=40, noise=2 * MAVLINK, counters=rejected(40)
    ), "flight controller"),
    ("silence at a flight controller", opened(adapter="1209:5741:2B00"), "flight controller"),
    ("a module behind a flight controller fell silent", opened(was_online=True, adapter="26ac:0011:0"),
     "fell silent"),
    ("it sends and does not answer", opened(
        bytes_received=80, counters={"frames": 10, "by_role": Counter({Role.STREAMED: 10})}
    ), "deaf"),
    ("it answers too late", opened(
        bytes_received=80, counters={"frames": 10, "by_role": Counter({Role.LATE: 10})}
    ), "too slow"),
    ("greeted: nothing at an address", PortEvidence(port=ADDRESS, silence=Silence.NOTHING), "nothing"),
    ("greeted: garbage at an address", PortEvidence(port=ADDRESS, silence=Silence.GARBAGE), "wrong rate"),
)  # fmt: skip

FINE: tuple[tuple[str, PortEvidence], ...] = (
    ("nothing was asked yet", PortEvidence(port=PORT, is_open=True)),
    ("answering", online()),
    ("a few damaged bytes of many", online(bytes_received=100_000, counters=Counters(frames=9000, **rejected(90)))),
)  # fmt: skip


@pytest.mark.parametrize(("evidence", "cause"), [row[1:] for row in TABLE], ids=[row[0] for row in TABLE])
def test_evidence_has_its_cause(evidence: PortEvidence, cause: str) -> None:
    found = diagnose(evidence)
    assert found is not None
    assert found.cause == cause
    assert found.what.strip()
    assert found.next_step.strip()
    assert "{" not in found.what + found.next_step
    assert "driver's words" not in found.what
    assert found.command in found.next_step


@pytest.mark.parametrize("evidence", [row[1] for row in FINE], ids=[row[0] for row in FINE])
def test_nothing_is_wrong(evidence: PortEvidence) -> None:
    assert diagnose(evidence) is None


@pytest.mark.parametrize("language", ["en", "zh_CN"])
@pytest.mark.promise("l")
def test_nobody_is_sent_to_a_silent_module_that_was_active(language: str) -> None:
    """Whatever is wrong: keep away, LOCK, restore the link; its switch and its wires come after that, or not at all."""
    set_language(language)
    for name, evidence, _ in TABLE:
        usual, armed = (diagnose(evidence._replace(was_active=one)) for one in (False, True))
        assert usual is not None
        assert armed is not None
        if evidence.is_answering:
            assert armed == usual
        else:
            assert armed.next_step.startswith(keep_away()), name
            assert not any(word in armed.next_step for word in AT_THE_MODULE), name


OPEN = Connection(PortState.OPEN, PORT, 115200)
LOST = OPEN._replace(state=PortState.CLOSED, trouble=PortError(PortErrorKind.LOST, PORT, ""))
NONE, GOING = ConversationView(), ConversationView(number=1)
ENDED = ConversationView(number=1, ended=Ended(EndReason.SILENT, 0.0))
LINKS: dict[Phase, tuple[Connection, ConversationView, Silence | None, dict[str, Any]]] = {
    Phase.CLOSED: (Connection(), ENDED, None, {}),
    Phase.OPENING: (OPEN._replace(state=PortState.OPENING), ENDED, None, {}),
    Phase.FINDING: (OPEN, ENDED, None, {"is_finding": True}),
    Phase.ASKING: (OPEN, NONE, None, {}),
    Phase.SILENT: (OPEN, NONE, Silence.NOTHING, {}),
    Phase.ONLINE: (OPEN, GOING, None, {}),
    Phase.LATE: (OPEN, GOING._replace(lag_s=0.9), None, {}),
    Phase.OFFLINE: (OPEN, ENDED, None, {}),
    Phase.LOST: (LOST, ENDED, None, {"absence": Absence.AWAY}),
    Phase.FAILED: (LOST, ENDED, None, {}),
    Phase.SWITCHED_OFF: (OPEN, ENDED, None, {"switched_off_at": 0.0}),
}


@pytest.mark.parametrize("language", ["en", "zh_CN"])
@pytest.mark.parametrize("phase", Phase)
@pytest.mark.promise("l")
def test_what_the_window_advises_about_a_silent_module_that_was_active(phase: Phase, language: str) -> None:
    set_language(language)
    connection, conversation, silence, known = LINKS[phase]
    said = link_state(connection, conversation, silence, **{"is_finding": False, "was_active": True} | known)
    assert said.phase is phase
    assert said.next_step.startswith(keep_away()) is not (said.is_fine or phase is Phase.CLOSED)
    assert not any(word in said.next_step for word in AT_THE_MODULE)


@pytest.mark.parametrize("evidence", [seen for _, seen, _ in TABLE if "://" in seen.port])
def test_of_an_address_nothing_is_said_of_adapters(evidence: PortEvidence) -> None:
    said = explain(evidence)
    for word in ("plug", "adapter", "driver", "cable", "find the baud rate"):
        assert word not in f"{said.what} {said.next_step}".lower()


@pytest.mark.parametrize(
    ("evidence", "command"),
    [
        (trouble(PortErrorKind.NOT_ALLOWED), "sudo usermod -aG dialout $USER"),
        (trouble(PortErrorKind.NOT_ALLOWED)._replace(platform="win32"), ""),
        (trouble(PortErrorKind.BUSY), "sudo systemctl stop ModemManager"),
    ],
)
def test_the_commands_are_exact(evidence: PortEvidence, command: str) -> None:
    found = diagnose(evidence)
    assert found is not None
    assert found.command == command


# From the line to the cause


class Watched:
    """A session with the evidence that it gives."""

    def __init__(self, seconds: float = 3.0, spoil: Callable[[Rig], object] = bool, **options: object) -> None:
        self.rig = Rig(options)
        spoil(self.rig)
        self.evidence = PortEvidence(PORT)
        self.wait(seconds)

    def tell(self, connection: Connection | None = None) -> None:
        session, now = self.rig.session, self.rig.clock.now_s
        counters = session.counters if connection is None else None
        connection = connection or Connection(PortState.OPEN, PORT, 115200)
        events, session.events = tuple(session.events), []
        view = session.conversation_view(now)
        batch = Batch(now, connection, view, counters, events=events, noise=session.noise)
        self.evidence = self.evidence.after(batch)

    def wait(self, seconds: float) -> None:
        end_s = self.rig.clock.now_s + seconds
        while self.rig.clock.now_s < end_s:
            self.rig.session.step()
            self.tell()

    def cause(self) -> str | None:
        found = diagnose(self.evidence)
        return None if found is None else found.cause


def rate_changed_later() -> Watched:
    watched = Watched()
    watched.rig.bench.module.baud_rate = 19200
    watched.rig.bench.module.start_stream(watched.rig.clock.now_s)
    watched.wait(20)
    return watched


def pulled_from_the_adapter() -> Watched:
    watched = Watched()
    watched.rig.bench.change(mute=True)
    watched.wait(20)
    return watched


def hears_nothing(rig: Rig) -> None:
    at_each_frame(rig.bench, lambda _request: False)
    rig.bench.module.start_stream(rig.clock())


@pytest.mark.parametrize(
    ("make", "cause"),
    [
        (rate_changed_later, "wrong rate"),
        (pulled_from_the_adapter, "fell silent"),
        (partial(Watched, 6.0, lag_ms=1400.0), "too slow"),
        (partial(Watched, 4.0, hears_nothing, rate=50.0), "deaf"),
    ],
)
def test_what_happens_on_the_line_is_recognised(make: Callable[[], Watched], cause: str) -> None:
    assert make().cause() == cause


@pytest.mark.parametrize("reason", EndReason)
def test_an_end_of_a_conversation_is_said_with_what_to_do(reason: EndReason) -> None:
    said = explain(Interrupted(reason))
    assert said.what == Interrupted(reason).sentence
    assert said.next_step.endswith("again.")
