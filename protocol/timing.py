"""The times of the line, in seconds with their sources, and the measured round trips that some of them follow."""

from collections import deque

ANSWER_S = 1.0
""" "若1秒内没有收到模块答复": the vendor gives the module one second."""
HEARTBEAT_EVERY_S = 10.0
""" "建议上位机发送间隔时间10-30秒"."""
BOOT_COUNT_EVERY_S = 1.0
"""While the module streams, only its boot count tells that another one streams now."""
QUIET_S = 0.25
"""Silence that ends a frame; the pieces of a reply come with shorter pauses."""
RECORDS_QUIET_S = 0.5
"""Without a further trigger record for this long there are no more (E6)."""
RECORDS_LONGEST_S = 10.0
LATE_S = 3.0
"""A later reply no longer counts as a reply to its request."""
REPEATED_S = 5.0
"""A bridge that repeats what it passes on has done so within this time."""
DOUBLED_S = 0.02
"""A doubled answer follows within this time; a restart's second heartbeat only after 50 ms."""
RESTART_S = 0.3
"""Two unasked heartbeats within this time are a restart ("间隔50ms", plus the adapter's delay)."""

SHORTEST_SILENCE_S = 0.45
"""So half a second is always noticed."""
LONGEST_SILENCE_S = ANSWER_S
SILENCE_ROUND_TRIPS = 20
ASKS_AFTER = 0.4
"""The link asks after this part of a silence."""
FIRST_GUESS_S = 0.25
"""Until a round trip is measured, a question is repeated so often; doubled while repeated ones are answered."""
SOONEST_REPEAT_S = 0.05
REPEAT_ROUND_TRIPS = 3
TRIES = 6
"""So often a question is sent; then the boot count, to find out whether the module is there."""
FRAMES_IN_A_SILENCE = 9
"""So many frames can be answered within a silence, so that a line that loses some does not look silent."""
SLOW_S = 0.3
"""On a line with longer round trips only questions and LOCK are sent."""
MAX_SAMPLES = 256


class RoundTrips:
    """The last round trips of questions that were sent once, and the times that follow from them.

    A repeated question is not measured, as nobody knows which of them was answered (Karn's rule). Where all of them are
    repeated the first guess is too short for this line: it is doubled until one is answered that was sent once.
    """

    def __init__(self) -> None:
        self._samples: deque[float] = deque(maxlen=MAX_SAMPLES)
        self._ordered: list[float] | None = None
        self._guess_s = FIRST_GUESS_S

    def add(self, round_trip_s: float) -> None:
        self._samples.append(round_trip_s)
        self._ordered = None

    def note_repeated(self) -> None:
        """A question was answered that had been sent several times."""
        self._guess_s = min(2 * self._guess_s, ANSWER_S)

    def quantile_s(self, share: float) -> float | None:
        """The quantile `share` (0 ≤ share < 1) of the samples; None without samples."""
        if not self._samples:
            return None
        if self._ordered is None:
            self._ordered = sorted(self._samples)
        return self._ordered[int(share * len(self._ordered))]

    @property
    def usual_s(self) -> float | None:
        """The median, which a line that loses frames hardly changes; None without samples."""
        return self.quantile_s(0.5)

    @property
    def silence_s(self) -> float:
        """Without a valid frame for so long, although something was asked, another module may have taken its place."""
        usual_s = self.usual_s
        if usual_s is None:
            return LONGEST_SILENCE_S
        return min(LONGEST_SILENCE_S, max(SHORTEST_SILENCE_S, SILENCE_ROUND_TRIPS * usual_s))

    @property
    def asks_after_s(self) -> float:
        """Without a valid frame for so long the link asks for one: early enough for an answer within the silence."""
        usual_s = self.usual_s
        if usual_s is None:
            return SOONEST_REPEAT_S
        return max(0.0, min(ASKS_AFTER * self.silence_s, self.silence_s - SOONEST_REPEAT_S - 1.1 * usual_s))

    @property
    def first_repeat_s(self) -> float:
        """From a question to its first repetition."""
        usual_s = self.usual_s
        if usual_s is None:
            return self._guess_s
        # Early enough for an answer within the silence, but not before an answer can come.
        latest_s = max(ASKS_AFTER * self.silence_s, 1.5 * usual_s)
        return max(SOONEST_REPEAT_S, min(REPEAT_ROUND_TRIPS * usual_s, latest_s))

    @property
    def repeat_s(self) -> float:
        """Between the repetitions that follow."""
        usual_s = self.usual_s
        if usual_s is None:
            return self._guess_s
        left_s = self.silence_s - usual_s - self.first_repeat_s
        return max(SOONEST_REPEAT_S, min(REPEAT_ROUND_TRIPS * usual_s, left_s / (FRAMES_IN_A_SILENCE - 1)))

    @property
    def probe_s(self) -> float:
        """Between the questions for the boot count behind one that is not answered on a slow line."""
        left_s = (1.0 - ASKS_AFTER) * self.silence_s - (self.usual_s or 0.0)
        return max(SOONEST_REPEAT_S, left_s / (FRAMES_IN_A_SILENCE - 1))
