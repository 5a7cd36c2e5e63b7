"""The commands of dps-s: groups, summaries, arguments. A command's module is imported only when it is run."""

import argparse
import re
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Final, NamedTuple

from app.terminal import console
from app.terminal.arguments import (
    JSON,
    PORT,
    PORTS,
    RATES,
    SAME_MODULE,
    SECONDS,
    VERBOSITY,
    YES,
    Describe,
    Parser,
    any_name,
    batch_names,
    day,
    flag,
    module_name,
    module_of,
    one_of,
    option,
    rate_of,
    seconds,
    whole_days,
)
from app.terminal.export_file import export_path
from app.text.i18n import LANGUAGES, tr
from protocol.translatable import marked

WINDOW: Final = "gui"
SERVER: Final = "postgresql://USER@HOST/DATABASE"
THRESHOLDS: Final = (
    "attitude_threshold_deg", "freefall_acceleration_g", "freefall_time_s", "attitude_trigger", "freefall_trigger",
)  # fmt: skip
_SUFFIX = re.compile(r"\.[A-Za-z0-9]{1,8}")


class SubCommand(NamedTuple):
    """`function`: gets the parsed arguments and returns the exit code, by its module's path in this folder; `example`:
    its words after `dps-s`; `description`: instead of the summary in its own help; `acts`: what stands behind its
    name. The last of the names is `args.act`."""

    name: str
    function: str
    summary: str
    example: str
    arguments: tuple[Describe, ...] = ()
    acts: tuple["SubCommand", ...] = ()
    description: str = ""

    def parser(self) -> Parser:
        parser = Parser(prog=f"dps-s {self.name}")
        self.describe(parser)
        return parser

    def describe(self, parser: Parser) -> None:
        for add in self.arguments + VERBOSITY:
            add(parser)
        if self.acts:
            acts = parser.add_subparsers(metavar="COMMAND", required=True, dest="act")
            for act in self.acts:
                act.describe(acts.add_parser(act.name, help=tr(act.summary)))
        parser.description = parser.description or tr(self.description) or tr(self.summary)
        example = tr("Example: {command}", command=f"dps-s {self.example}")
        parser.epilog = f"{parser.epilog}\n\n{example}" if parser.epilog else example
        parser.set_defaults(act=self.name, function=self.function)


# What is not loaded for the help of other commands


def _asked(parser: Parser) -> None:
    from protocol.catalogue import BY_NAME

    parser.add_argument("--asked", metavar="NAME", choices=sorted(BY_NAME), help=", ".join(BY_NAME))


def _settings(parser: Parser) -> None:
    from app.preflight.reading_object import SETTING_KEYS

    parser.add_argument("wishes", nargs="*", metavar="NAME=VALUE", help=", ".join(SETTING_KEYS) + "; true|false")


def _effect(parser: Parser) -> None:
    from app.safety.acts import EFFECTS, Act

    parser.description = tr(EFFECTS[Act(parser.prog.split()[-1])])


def _due(parser: Parser) -> None:
    from app.archive.fleet_state import CHECK_DAYS, TEST_DAYS

    for name, days in (("--check-days", CHECK_DAYS), ("--test-days", TEST_DAYS)):
        parser.add_argument(name, type=whole_days, default=days, metavar="N",
                            help=tr("due after N days [{days}]", days=days))  # fmt: skip


def _own(module: str) -> Describe:
    """What the command's module adds."""
    return lambda parser: import_module(module).add_arguments(parser)


def _schemas(parser: Parser) -> None:
    from app.cli.results import NAMES

    parser.add_argument("name", choices=NAMES)


_FILE = option("file", type=Path, metavar="FILE")
_FORCE = flag("--force", marked("replace the file"))
_RECORDING = option("name", metavar="NAME", text=marked("beginning of the name, or latest"))
_EXPORT: Final = (
    one_of(flag("--append", marked("add to the file (only .csv)")), _FORCE),
    option("file", type=export_path, metavar="FILE", text=marked(".mcap, .csv, or - for standard output")),
)


def _under(command: str, name: str, summary: str, example: str, *arguments: Describe) -> SubCommand:
    return SubCommand(name, f"{command}.run_{name}", summary, f"{command} {name} {example}".rstrip(), arguments)


_archive, _recordings = partial(_under, "archive"), partial(_under, "recordings")


def _act(name: str, summary: str, *more: Describe) -> SubCommand:
    return SubCommand(name, "act.run", summary, f"{name} --yes", (*PORT, YES, JSON, *more, _effect))


def _needs_no_yes(parser: Parser) -> None:
    """It is accepted: whoever is in a hurry must not be told to type more."""
    parser.set_defaults(yes=True)


GROUPS: Final = {
    marked("Module"): (
        SubCommand("ports", "ports.run", marked("List serial ports"), "ports", (
            # `app.engine.ports` starts this very command, with a limit of time, where listing can hang.
            JSON, option("--list-here", text=argparse.SUPPRESS, action="store_true"),
        )),
        SubCommand("find", "find.run", marked("Find the baud rate"), "find -p /dev/ttyUSB0", (*PORT, JSON)),
        SubCommand("read", "read.run", marked("Read status and settings"), "read -p /dev/ttyUSB0 --json",
                   (*PORT, JSON)),
        SubCommand("monitor", "monitor.run", marked("Print the status until Ctrl-C"), "monitor --seconds 10",
                   (*PORT, SECONDS, JSON)),
        SubCommand("history", "history.run", marked("Trigger records"), "history --csv records.csv", (
            *PORT, one_of(JSON, option("--csv", type=Path, metavar="FILE", text=".csv, -")),
            module_of(marked("store the records under this name")), SAME_MODULE,
        )),
    ),
    marked("Settings"): (
        SubCommand("set", "settings.set.run", marked("Write and verify settings"), "set freefall_time_s=1.4", (
            _settings, option("--profile", type=Path, metavar="FILE", text=marked("all settings of this profile")),
            flag("--accept-risk", marked("write values that take protection away")),
            flag("--dry-run", marked("only show what would change")),
            flag("--unlock", marked("write although the module may fire")), *PORT, JSON,
        )),
        SubCommand("save", "settings.save.run", marked("Save as profile"), "save M-07.toml", (
            option("file", type=Path, metavar="FILE.toml", text=marked("profile, or - for standard output")),
            module_of(marked("name of the profile")), _FORCE, *PORT, JSON,
        )),
        SubCommand("diff", "settings.save.run_diff", marked("Compare settings; exit code 1: they differ"),
                   "diff M-07.toml -p /dev/ttyUSB0", (
            option("file", type=Path, metavar="FILE", text=marked("profile")),
            option("other", type=Path, nargs="?", metavar="FILE", text=marked("profile; without it the module")),
            *PORT, JSON,
        )),
    ),
    marked("Commands"): (
        _act("activate", marked("Activate")),
        SubCommand("lock", "act.run_lock", marked("Lock"), "lock", (
            *PORT, YES, JSON, module_of(marked("Module")),
            flag("--same-module", marked("it is the module that was left ACTIVE here")), _effect, _needs_no_yes,
        )),
        _act("zero", marked("Zero the sensor")),
        _act("shutdown", marked("Shut down")),
    ),
    marked("Checks and records"): (
        SubCommand("preflight", "preflight.run", marked("Pre-flight check"),
                   "preflight --module M-07 --enable-triggers --report M-07.pdf", (
            *PORTS, option("--profile", type=Path, metavar="FILE", text=marked("profile")),
            flag("--enable-triggers", marked("enable both automatic triggers first")),
            flag("--activate", marked("enable, check, activate if READY, read again: GO")), YES,
            option("--report", type=Path, metavar="FILE.pdf", text="PDF, JSON"), module_of(marked("Module")),
            option("--aircraft", type=any_name, default="", metavar="NAME", text=marked("Aircraft")),
            option("--who", type=any_name, default="", metavar="NAME", text=marked("Checked by")),
            option("--done", type=int, action="append", default=[], metavar="N",
                   text=marked("manual item N of the profile is OK")),
            flag("--records-reviewed", marked("trigger records reviewed; without an answer: a new module")),
            SAME_MODULE, JSON,
        ), description=marked("READY: passed and locked. GO: passed and active.")),
        SubCommand("provision", "settings.provision.run", marked("Batch of new modules"),
                   "provision --profile survey.toml --names M-001..M-050 --yes", (
            option("--profile", type=Path, required=True, metavar="FILE", text=marked("all settings of this profile")),
            option("--names", type=batch_names, required=True, metavar="M-001..M-050", text=marked("Names")),
            flag("--enable-triggers", marked("enable both automatic triggers first")), YES,
            flag("--accept-risk", marked("write values that take protection away")),
            flag("--records-reviewed", marked("trigger records reviewed; without an answer: a new module")),
            flag("--all-new", marked("all are new, also those that resemble a known module")),
            option("--who", type=any_name, default="", metavar="NAME", text=marked("Checked by")),
            option("--list", type=Path, metavar="FILE.pdf", text=marked("the list of the batch, and FILE.csv")),
            option("--labels", type=Path, metavar="FILE.pdf", text=marked("Print labels")),
            option("--tape", choices=("62", "24", "A4"), default="A4",
                   text=marked("paper: width in mm, or sheets")),
            *PORT, JSON,
        )),
        SubCommand("verify", "verify.run", marked("Verify a pre-flight record"), "verify M-07.pdf", (
            option("file", type=Path, nargs="?", metavar="FILE", text=".json, .pdf"),
            option("--trust", metavar="FINGERPRINT", text=marked("trust the station that signed FILE")),
            option("--name", default="", metavar="NAME", text=marked("Name")),
            option("--forget", metavar="FINGERPRINT", text=marked("stop trusting this station")),
            option("--revoke", metavar="FINGERPRINT", text=marked("its key is lost or was copied: never trust it")),
            flag("--stations", marked("Known stations")), flag("--log", marked("verify the audit log")),
        )),
        SubCommand("archive", "", marked("Archive of all stations"), "archive status", acts=(
            _archive("sync", marked("exchange with a server"), f"{SERVER} --remember",
                     option("url", nargs="?", metavar="URL", text=SERVER),
                     flag("--remember", marked("remember this server, without its password")),
                     flag("--forget", marked("forget the server")), JSON),
            _archive("export", marked("add to an archive file"), "/media/stick/dps-s.archive", _FILE, JSON),
            _archive("import", marked("import an archive file"), "/media/stick/dps-s.archive", _FILE, JSON),
            _archive("status", marked("Status"), "--json", JSON),
            _archive("conflicts", marked("list possible duplicates"), "", JSON),
            _archive("settle", marked("settle whether two modules are one"),
                     "4868-86AB/M-07 1F2A-90C3/M-7 --same --who Li",
                     option("one", metavar="STATION/NAME"), option("other", metavar="STATION/NAME"),
                     one_of(flag("--same"), flag("--different"), is_required=True),
                     option("--name", default="", metavar="NAME", text=marked("Name")),
                     option("--who", required=True, metavar="WHO", text=marked("decided by"))),
            _archive("service", marked("record service of a module"),
                     "M-07 --what repack --due 2027-05-01 --who Ann",
                     option("module", type=module_name, metavar="NAME"),
                     option("--what", choices=("repack", "ejector", "cell", "firmware"), required=True),
                     option("--on", type=day, metavar="YYYY-MM-DD", text=marked("day on which it was done [today]")),
                     option("--due", type=day, metavar="YYYY-MM-DD", text=marked("due again on")),
                     option("--who", required=True, type=any_name, metavar="WHO", text=marked("done by")),
                     option("--note", default="", type=any_name, metavar="TEXT", text=marked("Note"))),
            _archive("report", marked("print all modules, or one"), "--csv",
                     module_of(marked("Module")), _due, one_of(JSON, flag("--csv", "CSV"))),
        )),
    ),
    marked("Recordings and flights"): (
        SubCommand("record", "record.run", marked("Record until Ctrl-C"), "record --seconds 60 session.mcap", (
            *PORT, SECONDS, *_EXPORT, JSON,
        )),
        SubCommand("recordings", "", marked("Recordings"), "recordings export latest session.csv", acts=(
            _recordings("list", marked("Recordings"), "", JSON),
            _recordings("export", marked("write one to a file"), "latest session.csv", _RECORDING, *_EXPORT, JSON),
            _recordings("convert", marked("of earlier versions, into session files"), "old.dpscap",
                        option("files", nargs="*", type=Path, metavar="FILE")),
            _recordings("delete", marked("delete one permanently"), "latest --yes", _RECORDING, YES, JSON),
        )),
        SubCommand("fired", "fired.run", marked("Would it have fired? Exit code 4: yes"),
                   "fired flights/ --thresholds freefall_time_s=1.2", (
            option("logs", nargs="*", metavar="LOG", text=marked("log, recording or folder")),
            option("--thresholds", nargs="+", action="extend", default=[], metavar="NAME=VALUE",
                   text=", ".join(THRESHOLDS)),
            option("--column", action="append", default=[], metavar="ROLE=COLUMN", text="CSV: roll_deg=ATT.Roll"),
            one_of(flag("--must-not", marked("do the vendor's defaults fire in none?")),
                   flag("--must", marked("do the vendor's defaults fire in all, in time?"))), JSON,
        )),
        SubCommand("decode", "decode.run", marked("Explain captured bytes"), "decode 41 75 32 07 0A 00 01 44", (
            option("hex", nargs="*", metavar="HEX", text=marked("hex bytes, a capture, or - for standard input")),
            _asked, JSON,
        )),
    ),
    marked("Program"): (
        SubCommand(WINDOW, "", marked("Open the window"), "gui --demo", (
            option("file", type=Path, nargs="?", metavar="FILE", text=marked("profile, capture, recording or check")),
            flag("--demo", marked("Simulated module")), option("-p", "--port", metavar="P", text=marked("Port")),
            rate_of(RATES, type=int, choices=RATES),
            option("--lang", choices=LANGUAGES, metavar="L", text="|".join(LANGUAGES)),
            option("--offscreen-seconds", type=seconds, metavar="S", text=marked("end after S seconds")),
            option("--evidence", type=Path, metavar="DIR", text=marked("save a screenshot and the values there")),
        )),
        SubCommand("simulate", "simulate.run", marked("Simulated module"), "simulate --tcp 127.0.0.1:7000",
                   (_own("app.cli.simulate"),)),
        SubCommand("completion", "reference.completion.run", marked("Shell completion script"), "completion bash",
                   (_own("app.cli.reference.completion"),)),
        SubCommand("schema", "reference.completion.run_schema", marked("JSON Schema of an output"), "schema read",
                   (_schemas,)),
    ),
}  # fmt: skip
ENTRIES: Final = tuple(entry for entries in GROUPS.values() for entry in entries)
BY_NAME: Final = {entry.name: entry for entry in ENTRIES}


def is_file_name(word: str) -> bool:
    """Whether `word` names a file, as in `dps-s FILE`, and not a command."""
    return word not in BY_NAME and (bool(_SUFFIX.fullmatch(Path(word).suffix)) or Path(word).is_file())


def grouped_summaries() -> str:
    """All commands with their summaries, under the titles of their groups."""
    rows = console.columns([(entry.name, tr(entry.summary)) for entry in ENTRIES], indent=2)
    lines: list[str] = []
    for title, entries in GROUPS.items():
        lines += [f"{tr(title)}:", *rows[: len(entries)], ""]
        del rows[: len(entries)]
    return "\n".join(lines).rstrip()


def complete_parser() -> Parser:
    """A parser that knows every command with all its options."""
    parser = Parser(prog="dps-s")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    for entry in ENTRIES:
        entry.describe(commands.add_parser(entry.name))
    for add in VERBOSITY:
        add(parser)
    parser.add_argument("--version", action="store_true")
    return parser
