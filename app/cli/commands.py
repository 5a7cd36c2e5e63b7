"""The commands of dps-s: their groups, summaries and examples. Their modules are imported only when they are called."""

from typing import NamedTuple

from app.terminal import console
from app.text.i18n import tr
from protocol.translatable import marked


class SubCommand(NamedTuple):
    """A sub-command: `add_parser` of `module` describes it. `example`: its words after `dps-s`."""

    name: str
    module: str
    summary: str
    example: str


WINDOW = "gui"
GROUPS = {
    marked("Module"): (
        SubCommand("ports", "app.cli.ports", marked("List serial ports"), "ports"),
        SubCommand("find", "app.cli.find", marked("Find the baud rate"), "find -p /dev/ttyUSB0"),
        SubCommand("read", "app.cli.read", marked("Read status and settings"), "read -p /dev/ttyUSB0 --json"),
        SubCommand("monitor", "app.cli.monitor", marked("Print the status until Ctrl-C"), "monitor --seconds 10"),
        SubCommand("history", "app.cli.history", marked("Trigger records"), "history --csv records.csv"),
    ),
    marked("Settings"): (
        SubCommand("set", "app.cli.settings.set", marked("Write and verify settings"), "set freefall_time_s=1.4"),
        SubCommand("save", "app.cli.settings.save", marked("Save the settings as a profile"), "save M-07.toml"),
        SubCommand("diff", "app.cli.settings.diff", marked("Compare settings; exit code 1: they differ"),
                   "diff M-07.toml -p /dev/ttyUSB0"),
    ),
    marked("Commands"): (
        SubCommand("activate", "app.cli.act", marked("Activate"), "activate --yes"),
        SubCommand("lock", "app.cli.act", marked("Lock"), "lock --yes"),
        SubCommand("zero", "app.cli.act", marked("Zero the sensor"), "zero --yes"),
        SubCommand("shutdown", "app.cli.act", marked("Shut down"), "shutdown --yes"),
    ),
    marked("Checks and records"): (
        SubCommand("preflight", "app.cli.preflight", marked("Pre-flight check"),
                   "preflight --module M-07 --enable-triggers --report M-07.pdf"),
        SubCommand("verify", "app.cli.verify", marked("Verify a pre-flight record"), "verify M-07.pdf"),
        SubCommand("archive", "app.cli.archive.commands", marked("Share records between stations"), "archive status"),
    ),
    marked("Recordings and flights"): (
        SubCommand("record", "app.cli.record", marked("Record until Ctrl-C"), "record --seconds 60 session.mcap"),
        SubCommand("recordings", "app.cli.recordings", marked("Recordings"), "recordings export latest session.csv"),
        SubCommand("fired", "app.cli.fired", marked("Would it have fired in these flight logs? Exit code 4: yes"),
                   "fired flights/ --thresholds freefall_time_s=1.2"),
        SubCommand("decode", "app.cli.decode", marked("Explain captured bytes"), "decode 41 75 32 07 0A 00 01 44"),
    ),
    marked("Program"): (
        SubCommand(WINDOW, "app.cli.gui", marked("Open the window"), "gui --demo"),
        SubCommand("simulate", "app.cli.simulate", marked("Simulated module"), "simulate --tcp 127.0.0.1:7000"),
        SubCommand("completion", "app.cli.reference.completion", marked("Shell completion script"), "completion bash"),
        SubCommand("schema", "app.cli.reference.schema", marked("JSON Schema of an output"), "schema read"),
    ),
}  # fmt: skip
ENTRIES = tuple(entry for entries in GROUPS.values() for entry in entries)


def grouped_summaries() -> str:
    """All commands with their summaries, under the titles of their groups."""
    rows = console.columns([(entry.name, tr(entry.summary)) for entry in ENTRIES], indent=2)
    lines: list[str] = []
    for title, entries in GROUPS.items():
        lines += [f"{tr(title)}:", *rows[: len(entries)], ""]
        del rows[: len(entries)]
    return "\n".join(lines).rstrip()
