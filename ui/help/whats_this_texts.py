""" "What's this?" texts by object name.

A pattern is a shell's (`*` stands for anything, `|` is between alternatives); the first one that fits counts. What is
not here says of itself what it is (the settings from the catalogue, the checks, the options of the simulated module).
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
        ("port_button", marked("Which port is open and how the link stands. A click opens the list of ports.")),
        ("lock_button", marked("Puts the module into standby at once. Always allowed, never asked twice, sent "
                               "before everything else. The chips beside it show what the module says afterwards.")),
        ("navigation", marked("The pages of the program. Ctrl and the number of the row goes there from anywhere.")),
        ("notice_dismiss", marked("Closes this message. Nothing is sent.")),
        ("notice_bar|notice_text|notice_icon", marked("What is the matter, and what to do next.")),
        ("notice_*", marked("Does what its words say about the message beside it.")),
        ("*_notice", marked("What happened, and what to do next.")),
        ("*_said", marked("What came of the last act, as the module said it.")),
        ("status_line", marked("Frames a second, usual round trip and rejected bytes at the left; at the right how "
                               "long ago the module was last heard.")),
        # Connecting
        ("connect_panel", marked("Choose a port and connect. The list updates automatically.")),
        ("connect_close", marked("Closes the list of ports. A connection stays as it is.")),
        ("port_list", marked("All serial ports with maker and serial number; new ones are marked. “Simulated module” "
                             "needs no hardware. A double click or Enter connects.")),
        ("rate_box", marked("The module's speed: 115200 as delivered. “Find the rate” tries all that the vendor "
                            "names, one after the other, with questions only.")),
        ("connect_button", marked("Opens the chosen port and reads everything that can be read. That activates "
                                  "nothing.")),
        ("disconnect_button", marked("Closes the port. If the module is ACTIVE, or edits were not written, it asks "
                                     "before.")),
        # Live
        ("live_choose_port", marked("Opens the list of ports. A connection begins only with a second click.")),
        ("live_simulate", marked("Connects a module that exists only in this program. It behaves as the vendor's table "
                                 "says; no parachute is connected to it.")),
        ("live_tour", marked("A guided round on a simulated module: from the first connection to GO, in a few "
                             "minutes. Everything stays as it was.")),
        ("live_gauge", marked("How the aircraft lies. Red: from here on an active module fires. Blue: here it rearms, "
                              "10° below.")),
        ("live_panel", marked("What the module says now. A dimmed number with an age is stale; a hatched “unknown” was "
                              "never said by this module.")),
        ("time-plot-state", marked("Whether the plots follow the present, or stand still.")),
        ("time-plot-clock", marked("Time of day at the time line, instead of seconds before now.")),
        ("time-plot-window-*", marked("How much time the plots show.")),
        ("time-plot-whole", marked("Shows the whole recording again after zooming in.")),
        ("time-plot-pause", marked("Holds the picture still. What the module says goes on being recorded.")),
        ("time-plot*", marked("Tilt, acceleration and cell voltage over time, with the limits at which the module "
                              "fires. Where nothing was heard the line is broken, never filled in.")),
        ("live_note", marked("What came of the last saving.")),
        # Settings
        ("*_less", marked("Decreases the value by one step. Nothing is written yet.")),
        ("*_more", marked("Increases the value by one step. Nothing is written yet.")),
        ("light_threshold_measure", marked("Measures the light with the bay closed and open and proposes a threshold "
                                           "in the middle. That also finds out which way light moves the reading.")),
        ("*_threshold_state|*_trigger_state|freefall_*_state|serial_output_state",
         marked("Unknown, read, edited, writing, verified or failed. “Verified” means: written, asked for again, and "
                "equal.")),
        ("settings_read", marked("Asks the module for every setting that can be read. Changes nothing.")),
        ("settings_undo", marked("Takes the last edit in this form back. The module is not touched.")),
        ("settings_redo", marked("Does the edit again that was taken back. The module is not touched.")),
        ("settings_write", marked("Sends each edited row once, then asks for it. A row is verified only when what "
                                  "comes back is equal. Against the vendor's advice it asks for a second click; an "
                                  "ACTIVE module is not written to.")),
        ("fingerprint_view", marked("One code for all settings that can be read: the same settings give the same code "
                                    "on every module.")),
        ("profile_match_*", marked("Whether the profile and the module agree in this setting.")),
        ("baud_ask", marked("Begins the change of the module's speed; it asks once more. The vendor advises not to "
                            "change it: whoever talks to the module must use the new speed from then on.")),
        ("baud_go", marked("Sends the change once, then looks for the module at the new speed, the old one, and all "
                           "others.")),
        ("baud_cancel", marked("Takes it back. Nothing is sent.")),
        # Triggers
        ("*_module", marked("The module has no serial number. A name, given once, ties its records and checks "
                            "together; it is recognised again by its adapter and its boot count.")),
        ("*_module_edit", marked("Type a new name, or choose a module that was here before.")),
        ("triggers_table", marked("Each record as a sentence: when it fired, why, and what the settings and readings "
                                  "were. What cannot be true is marked, not hidden.")),
        ("triggers_judge_*", marked("What this trigger was, as far as you know. It is kept with the record and "
                                    "pre-flight asks about those that nobody judged.")),
        ("triggers_read", marked("Asks the module for its last nine trigger records, until two readings agree. "
                                 "Nothing is deleted on the module.")),
        # Pre-flight
        ("verdict", marked("READY and GO only if every check holds; GO only while the module reports that it is "
                           "active. Void after a restart, a loss of the link, a change, or fifteen minutes.")),
        ("preflight_who", marked("Who answers for this check. It stands in the record and on the report.")),
        ("preflight_aircraft*", marked("Which aircraft the module sits in. It stands in the record.")),
        ("preflight_profile", marked("What the settings are compared with: the vendor's advice, or a profile of yours, "
                                     "which can also ask a person to look at things.")),
        ("check_trigger_records_act", marked("Says that you looked at the old records on the Triggers page, and checks "
                                             "again. The record says that a person vouched for it.")),
        ("check_boot_count_act", marked("Says that it is the named module although its boot count does not follow, and "
                                        "checks again.")),
        ("check_*_trigger_act", marked("Enables both automatic triggers on the module and checks again. The module "
                                       "cannot be asked how they stand, so after each start only this settles it.")),
        ("check_*_act", marked("Does what its words say, and checks again.")),
        ("check_*_result", marked("How this check came out: pass, look, FAIL, or unknown. Unknown never counts as "
                                  "GO.")),
        ("manual_*", marked("What only a person can look at. It counts for this flight only.")),
        ("profile_limit_*|profile_test_*|profile_editor_*|profile_manual_*",
         marked("Part of the profile. Nothing changes before it is saved.")),
        ("preflight_enable", marked("Enables both automatic triggers on the module, then runs all checks. Needed once "
                                    "after each start of the module: it cannot be asked how they stand.")),
        ("preflight_run", marked("Runs all checks, with questions only: nothing on the module is changed. Takes about "
                                 "six seconds.")),
        ("check_history_table", marked("Every kept check with its verdict. Choose one to print it as it was.")),
        ("trend_*", marked("How this measurement went from check to check, with its limit.")),
        # Commands
        ("commands_activation", marked("ACTIVE: the module fires by its thresholds. LOCKED: it reports standby.")),
        ("commands_trigger", marked("Whether the module says that it has fired.")),
        # Tests
        ("tests_list", marked("The guided tests, with when each was last done on this module, by whom, and what came "
                              "of it.")),
        ("tests_who", marked("Who does the test. It is kept with the result and printed on the report.")),
        ("tests_made_safe", marked("The test makes the module fire: it begins only after you say that nothing can be "
                                   "ejected.")),
        ("tests_run", marked("Starts the test, or confirms the step that you have done. It never activates.")),
        ("tests_cancel", marked("Ends the test at once. A module that was activated for it is locked; nothing is "
                                "kept.")),
        ("tests_table", marked("What was measured, what is allowed, and whether it passed.")),
        ("tests_scroll", marked("The chosen test: what to do now, and what the module says meanwhile.")),
        # Commands
        ("act_*_ask|tests_*_ask", marked("Asks once more before anything is sent. What still stands against it is "
                                         "named in the row.")),
        ("act_*_go|tests_*_go", marked("Sends it once: never repeated, never kept for later. It is in the audit log "
                                       "before it is sent.")),
        ("act_*_cancel|tests_activate_cancel|tests_zero_cancel", marked("Takes it back. Nothing is sent.")),
        ("ritual_choose", marked("Begins the ritual that fires the parachute: arm, then hold for two seconds. Letting "
                                 "go, Esc, or leaving the page ends it and sends nothing.")),
        ("ritual_arm", marked("Arms for ten seconds. Nothing is sent yet.")),
        ("ritual_hold", marked("Held for two seconds, by mouse or space bar, it sends the command once. Letting go "
                               "before sends nothing.")),
        # Diagnosis
        ("diagnosis_tabs", marked("Connection: the most likely cause and its fix. Traffic: every frame. Statistics: "
                                  "lost replies, round trips, invalid bytes. Support: what to send to whoever "
                                  "helps.")),
        ("capture_open", marked("Opens what was saved from a line before, to look at it or to play it through the "
                                "window.")),
        ("capture_save", marked("Saves what went over this line as a text file.")),
        ("bundle_parts", marked("The files of the bundle. What is not listed is not sent.")),
        ("bundle_text", marked("The chosen file, exactly as it will be saved.")),
        ("bundle_save", marked("Saves the bundle as one zip file on this computer. Nothing is sent anywhere.")),
        ("figures_minutes", marked("The last ten minutes, second by second.")),
        ("figures_hours", marked("The last twelve hours, minute by minute.")),
        ("figures_trips", marked("How long answers took, and how often. One narrow peak is a good line.")),
        ("figures_reasons", marked("Why bytes were rejected: a bad checksum points to the line, unknown codes to "
                                   "another device.")),
        ("figures_over_time", marked("Replies, losses and invalid bytes over time.")),
        ("figures_*", marked("Counted since the port was opened.")),
        ("traffic_search_text", marked("Bytes such as 41 75, or words. Enter goes to the next row.")),
        ("traffic_search_*", marked("Goes through the rows in which the searched text stands.")),
        ("traffic_table", marked("Time, direction, bytes and meaning of every frame. Choose a row to see what each "
                                 "byte says.")),
        ("why_act", marked("Does what its words say, where the program can; else it copies the command to type.")),
        ("why_panel", marked("The one most likely cause, the next step, and below it what was seen of the port.")),
        # Recordings
        ("session_sign", marked("Whether this session is being recorded. Everything that comes over the line is, by "
                                "itself, within limits of size and age.")),
        ("recordings_table", marked("Every session that was recorded. Open one to look at it on the Live page.")),
        # Flight logs
        ("flights_map", marked("Which thresholds separate the two lists: shaded where a flight fires that must not, "
                               "hatched where one that must is missed. Click, drag or arrow keys choose "
                               "thresholds; Enter shows the flights that fire there.")),
        ("flights_must_not_table", marked("Flights in which the parachute must stay packed. Enter opens a flight, M "
                                          "moves it to the other list, Del removes it from this page.")),
        ("flights_must_table", marked("Flights in which the parachute should have come. Enter opens a flight, M moves "
                                      "it to the other list, Del removes it from this page.")),
        ("flights_proposal*", marked("The thresholds with the largest margin to both lists, within the vendor's "
                                     "advice, for both readings of his rule.")),
        ("fired_list", marked("When the module would have fired with the thresholds wanted here, and what came near. "
                              "Choose one to see it in the plots.")),
        # A recording that is played, and the simulated module
        ("simulator_dock", marked("What a person could do to a real module on the bench, done to the simulated one.")),
    )
)  # fmt: skip
