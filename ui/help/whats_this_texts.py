""" "What's this?" texts by object name.

Patterns are shell patterns with `|` between alternatives; the first match counts. Other controls use their tooltip or
accessible name; settings, checks and options of the simulated module have texts of their own.
"""

from typing import Final, NamedTuple

from protocol.translatable import marked


class HelpText(NamedTuple):
    """`text` is English, marked."""

    pattern: str
    text: str


ENTRIES: Final[tuple[HelpText, ...]] = tuple(
    HelpText(pattern, text)
    for pattern, text in (
        ("lock_button", marked("Standby at once: always allowed, never asked twice, sent before everything else.")),
        ("live_panel", marked("Dimmed with an age: stale. Hatched: never reported.")),
        ("*_threshold_state|*_trigger_state|freefall_*_state|serial_output_state",
         marked("“Verified” means written, asked for again, and equal.")),
        ("settings_write", marked("Sends each edited row once and reads it back; never to an ACTIVE module.")),
        ("verdict", marked("Void after a restart, a lost link, a change, or fifteen minutes.")),
        ("check_*_trigger_act", marked("After power-up the triggers' state is unknown; only enabling them sets it.")),
        ("tests_made_safe", marked("The test makes the module fire.")),
        ("act_*_ask|tests_*_ask", marked("Asks once more before anything is sent.")),
        ("act_*_go|tests_*_go", marked("Sends it once: never repeated, never kept for later.")),
        ("ritual_choose", marked("Arm, then hold for two seconds. Letting go, Esc or leaving the page sends nothing.")),
        ("ritual_arm", marked("Arms for ten seconds. Nothing is sent yet.")),
        ("ritual_hold", marked("Two seconds, by mouse or space bar. Letting go before sends nothing.")),
        ("flights_map", marked("Shaded: fires, but must not. Hatched: must fire, but is missed.")),
    )
)  # fmt: skip
