""" "What's this?" texts by object name.

A pattern is a shell's (`*` stands for anything, `|` is between alternatives); the first one that fits counts. What is
not here says what its tooltip or its accessible name says; settings, checks and the options of the simulated module
have texts of their own.
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
        # Always in sight
        ("lock_button", marked("Puts the module into standby at once. Always allowed, never asked twice, sent "
                               "before everything else. The chips beside it show what the module says afterwards.")),
        # Live
        ("live_gauge", marked("How the aircraft lies. Red: from here on an active module fires. Blue: here it rearms, "
                              "10° below.")),
        ("live_panel", marked("What the module says now. A dimmed number with an age is stale; a hatched “unknown” was "
                              "never said by this module.")),
        # Settings
        ("light_threshold_measure", marked("Measures the light with the bay closed and open and proposes a threshold "
                                           "in the middle. That also finds out which way light moves the reading.")),
        ("*_threshold_state|*_trigger_state|freefall_*_state|serial_output_state",
         marked("Unknown, read, edited, writing, verified or failed. “Verified” means: written, asked for again, and "
                "equal.")),
        ("settings_write", marked("Sends each edited row once, then asks for it. A row is verified only when what "
                                  "comes back is equal. Against the vendor's advice it asks for a second click; an "
                                  "ACTIVE module is not written to.")),
        ("fingerprint_view", marked("One code for all settings that can be read: the same settings give the same code "
                                    "on every module.")),
        # Triggers
        ("*_module", marked("The module has no serial number. A name, given once, ties its records and checks "
                            "together; it is recognised again by its adapter and its boot count.")),
        ("triggers_table", marked("Each record as a sentence: when it fired, why, and what the settings and readings "
                                  "were. What cannot be true is marked, not hidden.")),
        # Pre-flight
        ("verdict", marked("READY and GO only if every check holds; GO only while the module reports that it is "
                           "active. Void after a restart, a loss of the link, a change, or fifteen minutes.")),
        ("check_*_trigger_act", marked("Enables both automatic triggers on the module and checks again. The module "
                                       "cannot be asked how they stand, so after each start only this settles it.")),
        ("manual_*", marked("What only a person can look at. It counts for this flight only.")),
        # Commands
        ("commands_activation", marked("ACTIVE: the module fires by its thresholds. LOCKED: it reports standby.")),
        # Tests
        ("tests_made_safe", marked("The test makes the module fire: it begins only after you say that nothing can be "
                                   "ejected.")),
        # Commands
        ("act_*_ask|tests_*_ask", marked("Asks once more before anything is sent. What still stands against it is "
                                         "named in the row.")),
        ("act_*_go|tests_*_go", marked("Sends it once: never repeated, never kept for later. It is in the audit log "
                                       "before it is sent.")),
        ("ritual_choose", marked("Begins the ritual that fires the parachute: arm, then hold for two seconds. Letting "
                                 "go, Esc, or leaving the page ends it and sends nothing.")),
        ("ritual_arm", marked("Arms for ten seconds. Nothing is sent yet.")),
        ("ritual_hold", marked("Held for two seconds, by mouse or space bar, it sends the command once. Letting go "
                               "before sends nothing.")),
        # Flight logs
        ("flights_map", marked("Which thresholds separate the two lists: shaded where a flight fires that must not, "
                               "hatched where one that must is missed. Click, drag or arrow keys choose "
                               "thresholds; Enter shows the flights that fire there.")),
        # A recording that is played, and the simulated module
        ("simulator_dock", marked("What a person could do to a real module on the bench, done to the simulated one.")),
    )
)  # fmt: skip
