"""The times of the line, in seconds with their sources; the measured round trips that some of them follow; and the
pause that some modules need before a request."""

from collections import deque
from math import inf

from protocol.catalogue import LOCK, Request

ANSWER_S = 1.0  # "若1秒内没有收到模块答复": the vendor gives the module one second
HEARTBEAT_EVERY_S = 10.0  # "建议上位机发送间隔时间10-30秒"
BOOT_COUNT_EVERY_S = 1.0  # while the module streams, only its boot count tells that another one streams now
QUIET_S = 0.25  # silence that ends a frame; the pieces of a reply come with shorter pauses
RECORDS_QUIET_S = 0.5  # without a further trigger record for this long there are no more (E6)
RECORDS_LONGEST_S = 10.0
LATE_S = 3.0  # a later reply no longer counts as a reply to its request
REPEATED_S = 5.0  # a bridge that repeats what it passes on has done so within this time
DOUBLED_S = 0.02  # a doubled answer follows within this time; a restart's second heartbeat only after 50 ms
RESTART_S = 0.3  # two unasked heartbeats within this time are a restart ("间隔50ms", plus the adapter's delay)

SLEPT_S = 5.0  # after a longer turn of its owner the computer slept, or the program stood still
SHORTEST_SILENCE_S = 0.45  # so half a second is always noticed
LONGEST_SILENCE_S = ANSWER_S
SILENCE_ROUND_TRIPS = 20
ASKS_AFTER = 0.4  # the link asks after this part of a silence
# Until a round trip is measured, a question is repeated so often; doubled while repeated ones are answered.
FIRST_GUESS_S = 0.25
# Out of step with a stream of 50 reports a second: on a half-duplex line every second repetition met one at 0.05.
SOONEST_REPEAT_S = 0.053
SOONEST_PROBE_S = 0.033  # late in a silence, so that as many frames fit into it
REPEAT_ROUND_TRIPS = 3
TRIES = 6  # so often a question is sent; then the boot count, to find out whether the module is there
# So many frames can be answered within a silence, so that a line that loses some does not look silent.
FRAMES_IN_A_SILENCE = 9
SLOW_S = 0.3  # on a line with longer round trips only questions and LOCK are sent
MAX_SAMPLES = 256

ONCE_S = 0.05  # before a set or an act
QUESTION_S = 0.032  # before a question, once `LOST_IN_A_ROW` quick ones were answered only when repeated
LOST_IN_A_ROW = 3
MAX_S = 0.2  # the longest time for which a request is delayed


class RoundTrips:
    """The last round trips of questions that were sent once, and the times that follow from them.

    A repeated question is not measured, as nobody knows which of them was answered (Karn's rule). Where all of them are
    repeated the first guess is too short for this line: it is doubled until one is answered that was sent once.
    """

    def __init__(self, shortest_silence_s: float = SHORTEST_SILENCE_S) -> None:
        self._shortest_silence_s = shortest_silence_s
        self._samples: deque[float] = deque(maxlen=MAX_SAMPLES)
        # The median, which a line that loses frames hardly changes; None until one is measured.
        self.usual_s: float | None = None
        # Without a valid frame for so long, although something was asked, another module may have taken its place.
        self.silence_s = LONGEST_SILENCE_S
        # Without one for so long the link asks for one: early enough for an answer within the silence.
        self.asks_after_s = SOONEST_REPEAT_S
        # From a question to its first repetition, and between those that follow.
        self.first_repeat_s = self.repeat_s = FIRST_GUESS_S
        # Between the questions for the boot count behind one that is not answered on a slow line.
        self.probe_s = (1.0 - ASKS_AFTER) * LONGEST_SILENCE_S / (FRAMES_IN_A_SILENCE - 1)

    def note_repeated(self) -> None:
        """A question was answered that had been sent several times."""
        if self.usual_s is None:
            self.first_repeat_s = self.repeat_s = min(2 * self.repeat_s, ANSWER_S)

    def add(self, round_trip_s: float) -> None:
        self._samples.append(round_trip_s)
        usual_s = self.usual_s = sorted(self._samples)[len(self._samples) // 2]
        silence_s = max(self._shortest_silence_s, SILENCE_ROUND_TRIPS * usual_s)
        silence_s = self.silence_s = min(LONGEST_SILENCE_S, silence_s)
        asked_at = ASKS_AFTER * silence_s
        self.asks_after_s = max(0.0, min(asked_at, silence_s - SOONEST_REPEAT_S - 1.1 * usual_s))
        # Early enough for an answer within the silence, but not before an answer can come.
        first_s = min(REPEAT_ROUND_TRIPS * usual_s, max(asked_at, 1.5 * usual_s))
        self.first_repeat_s = max(SOONEST_REPEAT_S, first_s)
        repeat_s = (silence_s - usual_s - self.first_repeat_s) / (FRAMES_IN_A_SILENCE - 1)
        self.repeat_s = max(SOONEST_REPEAT_S, min(REPEAT_ROUND_TRIPS * usual_s, repeat_s))
        probe_s = (silence_s - asked_at - usual_s) / (FRAMES_IN_A_SILENCE - 1)
        self.probe_s = max(SOONEST_PROBE_S, probe_s)


class Gap:
    """Quiet time before a request: some modules need a pause after a reply before they listen again. Quiet means that
    neither side sends; streamed reports do not count.

    Questions start without a pause, as a lost one is repeated; where quick ones are lost one after the other, those of
    this connection wait from then on. Sets and acts are sent only once, so they always wait. LOCK never does. Times are
    the link's `now`.
    """

    def __init__(self) -> None:
        self._spoken_at = -inf
        self._lost_in_a_row = 0
        self.question_s = 0.0  # the pause before a question, once it was learnt

    def due(self, request: Request, since: float) -> float:
        """When `request` may be sent: at `since`, or at most `MAX_S` later."""
        if request == LOCK:
            return since
        ready_at = self._spoken_at + (self.question_s if request.is_repeatable else ONCE_S)
        return max(since, min(ready_at, since + MAX_S))

    def on_spoken(self, now: float) -> None:
        """Note a frame of either side that is not a streamed report."""
        self._spoken_at = now

    def on_answered(self, attempts: int) -> None:
        """Note that a request was answered, which had been sent so often. Nothing is learnt from unanswered ones: the
        module may not know them, or may be absent."""
        self._lost_in_a_row = self._lost_in_a_row + 1 if attempts > 1 else 0
        if self._lost_in_a_row == LOST_IN_A_ROW:
            self.question_s = QUESTION_S
