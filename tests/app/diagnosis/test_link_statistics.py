"""Link statistics are complete, bounded and continue over reconnections."""

from collections import Counter

from app.captures.entries import Way
from app.captures.explained import Explained
from app.diagnosis.link_statistics import BOUNDS_MS, MAX_SECONDS, LinkStatistics
from app.engine.device import DeviceView
from app.engine.procedure import LinkView
from app.engine.session import Run
from app.engine.transport import PortError, PortTrouble
from app.engine.worker import Batch, Connection, PortState
from app.procedures.read import read_everything
from protocol.catalogue import STATUS
from protocol.events import Answered, Counters, Event, Rejected, Role, Sent
from protocol.frame import Direction, Fault, Frame, Noise, Reason
from tests.support.line.sim_line import Rig

OPEN = Connection(PortState.OPEN, "x", 115200)
LOST = Connection(PortState.CLOSED, "x", 115200, PortError(PortTrouble.LOST, "x", ""))
QUERY = STATUS.query()


def batch(at: float, link: LinkView | None = None, *events: Event, connection: Connection = OPEN) -> Batch:
    return Batch(at, connection, DeviceView(), link, events=events)


def view(byte_count: int = 0, **counted: int) -> LinkView:
    return LinkView(Counters(**counted), None, None, byte_count)  # type: ignore[arg-type]


def answered(trip_s: float | None) -> Answered:
    return Answered(QUERY, (), 1, trip_s, 0.0)


def test_events_are_counted_in_their_second() -> None:
    figures = LinkStatistics()
    figures.on_batch(batch(10.2, view(100, sent=4, frames=3, time_outs=1)))
    figures.on_batch(batch(10.9, view(150, sent=6, frames=5, time_outs=2, retries=1)))
    figures.on_batch(batch(12.5, view(150, sent=6, frames=5, time_outs=2, retries=1, restarts=1)))
    first, second = figures.seconds
    assert (first.begins_s, first.sent, first.frames, first.time_outs, first.retries) == (10.0, 6, 5, 2, 1)
    assert first.bytes_received == 150
    assert (second.begins_s, second.sent, second.restarts) == (12.0, 0, 1)
    assert figures.totals.sent == 6


def test_rejected_bytes_are_listed_by_reason_most_first() -> None:
    figures = LinkStatistics()
    counters = Counters(rejected_bytes=Counter({Reason.NO_HEADER: 2, Reason.CHECKSUM: 9}))
    figures.on_batch(batch(1.0, LinkView(counters, None, None, 11)))
    assert figures.seconds[0].rejected == ((Reason.CHECKSUM, 9), (Reason.NO_HEADER, 2))
    assert figures.seconds[0].rejected_bytes == 11


def test_round_trips_fall_into_classes() -> None:
    figures = LinkStatistics()
    trips = (0.0005, 0.001, 0.0011, 0.016, 0.0161, 0.9, 1.0, 1.5, None)
    figures.on_batch(batch(1.0, view(), *(answered(trip) for trip in trips)))
    classes = {one.up_to_ms: one.count for one in figures.round_trips() if one.count}
    assert classes == {1: 2, 2: 1, 16: 1, 24: 1, 1000: 2, None: 1}
    assert len(figures.round_trips()) == len(BOUNDS_MS) + 1
    assert figures.quantile_s(0.5) == 0.0161
    assert figures.seconds[0].slowest_s == 1.5
    assert LinkStatistics().quantile_s(0.5) is None


def test_a_lost_port_counts_as_a_loss_and_counting_continues() -> None:
    figures = LinkStatistics()
    figures.on_batch(batch(1.0, view(100, sent=10)))
    noise = Noise(b"\x00\x01", Fault(Reason.NO_HEADER, ""), 0)
    figures.on_batch(batch(1.5, None, Sent(b"", QUERY, 1, 1.5), Rejected(noise, 1.5), connection=LOST))
    figures.on_batch(batch(1.6, None, connection=LOST))
    figures.on_batch(batch(2.0, None, connection=Connection(PortState.OPENING, "x", 115200)))
    figures.on_batch(batch(2.1, view(7, sent=3)))
    assert figures.losses == 1
    assert figures.totals.sent == 14
    assert figures.bytes_received == 109
    assert sum(one.losses for one in figures.seconds) == 1


def test_a_reopened_port_without_a_batch_does_not_count_backwards() -> None:
    figures = LinkStatistics()
    figures.on_batch(batch(1.0, view(100, sent=10)))
    figures.on_batch(batch(2.0, view(5, sent=2)))
    assert figures.totals.sent == 12
    assert figures.bytes_received == 105


def test_the_seconds_are_bounded_even_when_the_clock_jumps() -> None:
    figures = LinkStatistics()
    for number in range(2 * MAX_SECONDS):
        figures.on_batch(batch(1e6 + number, view(number, sent=number)))
    figures.on_batch(batch(5.0, view(99_999, sent=99_999)))
    assert len(figures.seconds) == MAX_SECONDS
    assert figures.seconds[-1].begins_s > 1e6
    assert figures.totals.sent == 99_999


def test_statistics_equal_the_links_totals_on_a_bad_line() -> None:
    rig = Rig({"corrupt": "0.02", "drop": "0.05", "seed": "5"})
    run = Run(read_everything())
    rig.session.run(run)
    figures = LinkStatistics()
    while not run.is_done:
        rig.session.step()
        figures.on_batch(batch(rig.clock.now_s, rig.session.link_view(), *rig.session.take_events()))
    counted = rig.session.link_view().counters
    assert figures.totals == counted
    assert figures.totals.by_role[Role.ANSWER] > 0
    assert figures.bytes_received == rig.session.bytes_received
    assert sum(one.count for one in figures.round_trips()) > 5


def test_reading_properties_does_not_change_the_statistics() -> None:
    watched, alone = LinkStatistics(), LinkStatistics()
    for number in range(1, 400):
        at, opened = number * 0.033, number % 150  # reopened every 5 s without a batch
        link = view(opened * 8, sent=opened, frames=opened, time_outs=opened // 40)
        events = (answered(0.004),) if number % 30 == 0 else ()
        connection = Connection(PortState.CLOSED) if number == 225 else OPEN
        for statistics in (watched, alone):
            statistics.on_batch(batch(at, None if number == 225 else link, *events, connection=connection))
        watched.seconds  # noqa: B018  looking is what is tried
    assert alone.seconds == watched.seconds
    assert (alone.totals, alone.bytes_received) == (watched.totals, watched.bytes_received)
    assert alone.totals.sent == 149 + 74 + 149 + 99  # the last before each end


def test_what_was_recorded_is_counted_in_its_second() -> None:
    rows = (
        Explained(0.2, Way.OUT, Frame(Direction.HOST_TO_MODULE, QUERY.encode()), None),
        Explained(0.9, Way.IN, Frame(Direction.MODULE_TO_HOST, bytes(8)), QUERY),
        Explained(3.5, Way.IN, Noise(bytes(3), Fault(Reason.NO_HEADER, ""), 8), None),
    )
    figures = LinkStatistics()
    figures.count(rows)
    assert [
        (one.begins_s, one.sent, one.frames, one.bytes_received, one.rejected_bytes) for one in figures.seconds
    ] == [
        (0.0, 1, 1, 8, 0),
        (3.0, 0, 0, 3, 3),
    ]
    assert (figures.totals.sent, figures.totals.rejected, figures.quantile_s(0.5)) == (1, 3, None)
