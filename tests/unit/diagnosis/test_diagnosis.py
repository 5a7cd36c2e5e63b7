"""The table of causes row by row, the collection of evidence, and causes on a simulated line."""

import sys
from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from app.diagnosis.adapter_facts import AdapterFacts
from app.diagnosis.causes import CAUSES, Cause, diagnose, explain
from app.diagnosis.link_state import LinkState, Phase, link_text
from app.diagnosis.symptoms import EvidenceCollector, PortEvidence
from app.engine.conversation import Interrupted
from app.engine.procedure import Ask, Procedure
from app.engine.reconnect import Absence
from app.engine.session import MAX_NOISE_BYTES
from app.engine.transport import PortError, PortHolder, PortTrouble, _trouble_at_opening
from app.engine.worker import Batch, Connection, PortState
from app.procedures.find import Silence
from app.safety.last_known import keep_away
from protocol.catalogue import BY_NAME
from protocol.events import Counters, Ended, EndReason, Role
from protocol.messages import Reason
from tests.support.line.sim_line import Rig
from tests.support.pseudo_language import in_language

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


def trouble(kind: PortTrouble, holder: PortHolder | None = None) -> PortEvidence:
    return PortEvidence(port=PORT, trouble=PortError(kind, PORT, "driver's words", holder))


def opened(*, bytes_received: int = 0, **values: Any) -> PortEvidence:
    """An open port with three requests and no reply."""
    counters = Counters(sent=3, time_outs=3, bytes_received=bytes_received, **values.pop("counters", {}))
    return PortEvidence(port=PORT, is_open=True, counters=counters, **values)


def online(*, bytes_received: int = 0, **values: Any) -> PortEvidence:
    counters = values.pop("counters", Counters()) + Counters(bytes_received=bytes_received)
    return PortEvidence(port=PORT, is_open=True, is_answering=True, was_online=True, counters=counters, **values)


def rejected(count: int, reason: Reason = Reason.NO_HEADER) -> dict[str, Any]:
    return {"rejected_bytes": Counter({reason: count})}


def with_facts(evidence: PortEvidence, **values: Any) -> PortEvidence:
    return evidence._replace(facts=AdapterFacts(**values))


# As pymavlink packs an ArduCopter's heartbeats.
MAVLINK_1 = bytes.fromhex("fe 09 fe 01 01 00 00 00 00 00 02 03 51 04 03 aa 8a")
MAVLINK_2 = bytes.fromhex("fd 09 00 00 fe 01 01 00 00 00 00 00 00 00 02 03 51 04 03 ee 2a")
ADDRESS = "socket://10.0.0.9:7000"


def unreached(detail: str, port: str = ADDRESS) -> PortEvidence:
    return PortEvidence(port=port, trouble=PortError(_trouble_at_opening(OSError(detail)), port, detail))


def cut_off(kind: PortTrouble) -> PortEvidence:
    return PortEvidence(port=ADDRESS, trouble=PortError(kind, ADDRESS, ""))


TABLE: tuple[tuple[str, PortEvidence, Cause], ...] = (
    ("no bytes at all", opened(), Cause.NOTHING),
    ("echo only", opened(bytes_received=18, counters={"frames": 3, "by_role": Counter({Role.ECHO: 3})}), Cause.ECHO),
    ("echo and hiss", opened(bytes_received=20, noise=b"\x00Ba\x01", counters=rejected(4)), Cause.ECHO),
    ("garbage", opened(bytes_received=200, counters=rejected(200)), Cause.WRONG_RATE),
    ("checksum errors and no frame", opened(bytes_received=60, counters=rejected(60, Reason.CHECKSUM)), Cause.BAD_LINE),
    ("checksum errors among frames", online(
        bytes_received=4000, counters=Counters(frames=400, **rejected(400, Reason.CHECKSUM))
    ), Cause.BAD_LINE),
    ("held by a named program", trouble(PortTrouble.BUSY, PortHolder("minicom", 4711)), Cause.HELD),
    ("held by nobody knows whom", trouble(PortTrouble.BUSY), Cause.HELD),
    ("held by ModemManager", trouble(PortTrouble.BUSY, PortHolder("ModemManager", 600)), Cause.MODEM_PROBER),
    ("held, and ModemManager runs", with_facts(trouble(PortTrouble.BUSY), grabbers=("ModemManager",)),
     Cause.MODEM_PROBER),
    ("held by another, and ModemManager runs",
     with_facts(trouble(PortTrouble.BUSY, PortHolder("minicom", 1)), grabbers=("ModemManager",)), Cause.HELD),
    ("AT in the noise", opened(bytes_received=30, noise=b"AT\rAT\rATE0\r", counters=rejected(30)), Cause.MODEM_PROBER),
    ("a modem's other question", opened(bytes_received=5, noise=b"\x7e\x00\x78\xf0\x7e", counters=rejected(5)),
     Cause.MODEM_PROBER),
    ("held by brltty", trouble(PortTrouble.BUSY, PortHolder("brltty", 33)), Cause.BRAILLE),
    ("gone, and brltty runs", with_facts(trouble(PortTrouble.MISSING), grabbers=("brltty",)), Cause.BRAILLE),
    ("no permission", trouble(PortTrouble.NOT_ALLOWED), Cause.NO_PERMISSION),
    ("no permission, no group has it", with_facts(trouble(PortTrouble.NOT_ALLOWED), group=None),
     Cause.NO_PERMISSION),
    ("no such port", trouble(PortTrouble.MISSING), Cause.MISSING),
    ("nobody listens", unreached("Could not open port: [Errno 111] Connection refused"), Cause.UNREACHABLE),
    ("no such host", unreached("Could not open port: [Errno -2] Name or service not known"), Cause.UNREACHABLE),
    ("another server", unreached("Remote does not seem to support RFC2217", "rfc2217://10.0.0.9:7000"),
     Cause.OTHER_SERVER),
    ("the other end closes", cut_off(PortTrouble.LOST), Cause.UNREACHABLE),
    ("the other end takes nothing", cut_off(PortTrouble.STUCK), Cause.UNREACHABLE),
    ("unplugged", trouble(PortTrouble.LOST), Cause.UNPLUGGED),
    ("stuck", trouble(PortTrouble.STUCK), Cause.STUCK),
    ("no serial port", trouble(PortTrouble.UNUSABLE), Cause.UNUSABLE),
    ("a console", opened(bytes_received=40, noise=b"\r\nraspberrypi login: ", counters=rejected(40)), Cause.LOGIN),
    ("heartbeats of MAVLink 1", opened(bytes_received=34, noise=2 * MAVLINK_1, counters=rejected(34)),
     Cause.FLIGHT_CONTROLLER),
    ("heartbeats of MAVLink 2, after passthrough ended", opened(
        was_online=True, bytes_received=40, noise=2 * MAVLINK_2, counters=rejected(40)
    ), Cause.FLIGHT_CONTROLLER),
    ("silence at a flight controller", opened(adapter="1209:5741:2B00"), Cause.FLIGHT_CONTROLLER),
    ("greeted: silence at a flight controller",
     PortEvidence(port=PORT, silence=Silence.NOTHING, adapter="2dae:1016@1-2"), Cause.FLIGHT_CONTROLLER),
    ("a module behind a flight controller fell silent", opened(was_online=True, adapter="26ac:0011:0"),
     Cause.FELL_SILENT),
    ("we shut it down", opened(was_online=True, was_shut_down=True), Cause.SHUT_DOWN),
    ("it sends and does not answer", opened(
        bytes_received=80, counters={"frames": 10, "by_role": Counter({Role.STREAMED: 10})}
    ), Cause.DEAF),
    ("it answers too late", opened(
        bytes_received=80, counters={"frames": 10, "by_role": Counter({Role.LATE: 10})}
    ), Cause.TOO_SLOW),
    ("it was there before", opened(was_online=True), Cause.FELL_SILENT),
    ("its rate was changed", opened(was_online=True, bytes_received=50, counters=rejected(50)), Cause.WRONG_RATE),
    ("greeted: nothing", PortEvidence(port=PORT, silence=Silence.NOTHING), Cause.NOTHING),
    ("greeted: nothing at an address", PortEvidence(port=ADDRESS, silence=Silence.NOTHING), Cause.NOTHING),
    ("greeted: garbage at an address", PortEvidence(port=ADDRESS, silence=Silence.GARBAGE), Cause.WRONG_RATE),
    ("greeted: garbage", PortEvidence(port=PORT, silence=Silence.GARBAGE), Cause.WRONG_RATE),
    ("greeted: an echo", PortEvidence(port=PORT, silence=Silence.ECHO), Cause.ECHO),
    ("greeted: other frames", PortEvidence(port=PORT, silence=Silence.OTHER_FRAMES), Cause.DEAF),
)  # fmt: skip

FINE: tuple[tuple[str, PortEvidence], ...] = (
    ("nothing was asked yet", PortEvidence(port=PORT, is_open=True)),
    ("closed, as somebody wanted", PortEvidence(port=PORT)),
    ("answering", online()),
    ("a few damaged bytes of many", online(bytes_received=100_000, counters=Counters(frames=9000, **rejected(90)))),
    ("AT in a stream that works", online(
        noise=b"AT\r", bytes_received=9000, counters=Counters(frames=999, **rejected(3))
    )),
)  # fmt: skip


@pytest.mark.parametrize(("evidence", "cause"), [row[1:] for row in TABLE], ids=[row[0] for row in TABLE])
def test_evidence_has_its_cause(evidence: PortEvidence, cause: Cause) -> None:
    found = diagnose(evidence)
    assert found is not None
    assert found.cause is cause
    assert found.what.strip()
    assert found.next_step.strip()
    assert "{" not in found.what + found.next_step
    assert "driver's words" not in found.what
    assert (found.command is None) or found.command in found.next_step


@pytest.mark.parametrize("evidence", [row[1] for row in FINE], ids=[row[0] for row in FINE])
def test_nothing_is_wrong(evidence: PortEvidence) -> None:
    assert diagnose(evidence) is None


@pytest.mark.parametrize("language", ["en", "zh_CN"])
@pytest.mark.parametrize("evidence", [row[1] for row in TABLE], ids=[row[0] for row in TABLE])
@pytest.mark.promise("l")
def test_nobody_is_sent_to_a_silent_module_that_was_active(evidence: PortEvidence, language: str) -> None:
    """Whatever is wrong: keep away, LOCK, restore the link; its switch and its wires come after that, or not at all."""
    with in_language(language):
        usual, armed = (diagnose(evidence._replace(was_active=one)) for one in (False, True))
        assert usual is not None
        assert armed is not None
        if evidence.is_answering:
            assert armed == usual
            return
        assert armed.next_step.startswith(keep_away())
        assert not any(word in armed.next_step for word in AT_THE_MODULE)


@pytest.mark.parametrize("language", ["en", "zh_CN"])
@pytest.mark.parametrize("phase", Phase)
@pytest.mark.promise("l")
def test_what_the_window_advises_about_a_silent_module_that_was_active(phase: Phase, language: str) -> None:
    state = LinkState(
        phase,
        PORT,
        115200,
        ended=Ended(EndReason.SILENT, 0.0),
        off_at=0.0,
        silence=Silence.NOTHING,
        absence=Absence.AWAY,
        was_active=True,
    )
    with in_language(language):
        said = link_text(state, 9.0)
        assert said.next_step.startswith(keep_away()) is not (state.is_fine or phase is Phase.CLOSED)
        assert not any(word in said.next_step for word in AT_THE_MODULE)


def test_every_cause_is_in_this_test() -> None:
    assert {row.cause for row in CAUSES} == set(Cause) == {cause for _, _, cause in TABLE}


@pytest.mark.parametrize("evidence", [seen for _, seen, _ in TABLE if "://" in seen.port])
def test_of_an_address_nothing_is_said_of_adapters(evidence: PortEvidence) -> None:
    said = explain(evidence)
    for word in ("plug", "adapter", "driver", "cable", "find the baud rate"):
        assert word not in f"{said.what} {said.next_step}".lower()


@pytest.mark.parametrize(
    ("evidence", "command"),
    [
        (with_facts(trouble(PortTrouble.NOT_ALLOWED), group="uucp"), "sudo usermod -aG uucp $USER"),
        (trouble(PortTrouble.NOT_ALLOWED), "sudo usermod -aG dialout $USER"),
        (with_facts(trouble(PortTrouble.NOT_ALLOWED), group=None), None),
        (trouble(PortTrouble.NOT_ALLOWED)._replace(platform="win32"), None),
        (trouble(PortTrouble.BUSY, PortHolder("ModemManager", 600)), "sudo systemctl stop ModemManager"),
    ],
)
def test_the_commands_are_exact(evidence: PortEvidence, command: str | None) -> None:
    found = diagnose(evidence)
    assert found is not None
    assert found.command == command


# From the line to the cause


class Watched:
    """A session with an evidence collector."""

    def __init__(self, options: dict[str, str]) -> None:
        self.rig = Rig(options)
        self.evidence_collector = EvidenceCollector()
        self.evidence_collector.begin(PORT)

    def tell(self, connection: Connection | None = None) -> None:
        session, now = self.rig.session, self.rig.clock.now_s
        self.evidence_collector.on_batch(
            Batch(
                now,
                connection or Connection(PortState.OPEN, PORT, 115200),
                session.conversation_view(now),
                session.link_view() if connection is None else None,
                events=tuple(session.take_events()),
            )
        )

    def wait(self, seconds: float) -> None:
        end_s = self.rig.clock.now_s + seconds
        while self.rig.clock.now_s < end_s:
            self.rig.session.step()
            self.tell()

    def cause(self) -> Cause | None:
        found = diagnose(self.evidence_collector.evidence())
        return None if found is None else found.cause


def opened_for(seconds: float, **options: str) -> Watched:
    watched = Watched(options)
    watched.wait(seconds)
    return watched


def rate_changed_later() -> Watched:
    watched = opened_for(3.0)
    watched.rig.bench.module.baud_rate = 19200
    watched.rig.bench.module.start_stream(watched.rig.clock.now_s)
    watched.wait(20)
    return watched


def pulled_from_the_adapter() -> Watched:
    watched = opened_for(3.0)
    watched.rig.bench.change(mute=True)
    watched.wait(20)
    return watched


def shut_down() -> Watched:
    watched = opened_for(3.0)

    def act() -> Procedure[None]:
        yield Ask(BY_NAME["shutdown"].set(True), is_deliberate=True)

    watched.rig.job(act())
    watched.wait(20)
    return watched


@pytest.mark.parametrize(
    ("make", "cause"),
    [
        (rate_changed_later, Cause.WRONG_RATE),
        (pulled_from_the_adapter, Cause.FELL_SILENT),
        (shut_down, Cause.SHUT_DOWN),
        (partial(opened_for, 6.0, delay_ms="1400"), Cause.TOO_SLOW),
        (partial(opened_for, 4.0, direction="to-module", drop="1", rate="50", stream_at_boot="yes"), Cause.DEAF),
    ],
)
def test_what_happens_on_the_line_is_recognised(make: Callable[[], Watched], cause: Cause) -> None:
    assert make().cause() is cause


def test_a_module_that_returns_after_a_shutdown_is_not_shut_down() -> None:
    watched = shut_down()
    watched.rig.bench.press_switch()
    watched.wait(5)
    assert watched.cause() is None
    assert not watched.evidence_collector.evidence().was_shut_down


@pytest.mark.parametrize("make", [partial(opened_for, 3.0), pulled_from_the_adapter])
def test_a_lost_port_is_the_cause_and_a_new_connection_resets_it(make: Callable[[], Watched]) -> None:
    watched = make()
    watched.tell(Connection(PortState.CLOSED, PORT, 115200, PortError(PortTrouble.LOST, PORT, "")))
    assert watched.cause() is Cause.UNPLUGGED
    assert not watched.evidence_collector.evidence().is_answering
    watched.evidence_collector.begin("/dev/ttyUSB1")
    assert watched.cause() is None
    assert watched.evidence_collector.evidence() == PortEvidence(port="/dev/ttyUSB1", platform=sys.platform)


@pytest.mark.parametrize("reason", EndReason)
def test_an_end_of_a_conversation_is_said_with_what_to_do(reason: EndReason) -> None:
    said = explain(Interrupted(reason))
    assert said.what == Interrupted(reason).sentence
    assert said.next_step.endswith("again.")


def test_stored_noise_is_bounded() -> None:
    watched = Watched({"garbage": "1", "rate": "1000", "stream_at_boot": "yes", "uptime": "60"})
    watched.wait(2)
    assert 0 < len(watched.evidence_collector.evidence().noise) <= MAX_NOISE_BYTES
