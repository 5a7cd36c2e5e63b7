"""Values that the state machine of `tests.scenarios.desk_machine` draws from."""

from hypothesis import strategies as st

from app.safety.acts import Act
from tests.scenarios.desk_judge import KEYS

FORGETFUL = {"light_threshold": 0x12, "attitude_threshold": 60, "freefall_acceleration": 5, "freefall_time": 160}
"""What a module holds after a power cycle if it does not keep its settings."""

DIALECTS = st.fixed_dictionaries(
    {
        "ack": st.sampled_from(["echo", "one"]),
        "freefall_ack": st.sampled_from(["16", "17"]),
        "baud_ack": st.sampled_from(["old", "new", "restart"]),
        "clamps": st.booleans(),
        "refuses": st.sampled_from([False, False, False, True]),
        "keeps": st.sampled_from([True, True, True, False]),
        "remembers": st.booleans(),
        "seed": st.integers(0, 10_000),
        "uptime": st.sampled_from([0, 60]),
        "rate": st.sampled_from([2, 10]),
    }
)
FAULTS = st.fixed_dictionaries(
    {"direction": st.sampled_from(["to-host", "to-module", "both"])},
    optional={
        "drop": st.sampled_from([0.1, 0.4, 1.0]),
        "double": st.sampled_from([0.3, 1.0]),
        "delay_ms": st.sampled_from([30.0, 250.0, 1300.0]),
        "jitter_ms": st.sampled_from([50.0, 500.0]),
        "mute": st.booleans(),
    },
)
ACTS = (Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY)
RAWS = st.dictionaries(st.sampled_from(sorted(KEYS)), st.sampled_from([0, 1, 5, 54, 60, 130, 255]), min_size=1)
CLICKS = st.sampled_from([1, 1, 2, 5])
"""Clicks: once, a double click, or a repeating key."""
THEN = st.sampled_from(["", "again", "lock", "unplug", "restart", "silence"])
SHORT_S = st.sampled_from([0.02, 0.1, 0.3])
