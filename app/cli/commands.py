"""The commands of `dps-s`: names, summaries, examples. A command's module is imported only for that command.

The module of a command has `run(args)`, which returns the exit code, and `add_arguments(parser)` where it has more
arguments than those that most commands share. `args.command` is the command's name.
"""

import argparse
from importlib import import_module
from pathlib import Path
from typing import Any, Final, NamedTuple

from app.terminal import console
from app.text.messages import capitalised

WINDOW: Final = "gui"
# They have commands of their own, with which argparse takes no option between two words.
_WITH_COMMANDS: Final = ("archive", "recordings")


class SubCommand(NamedTuple):
    """`summary`: for the list of commands; `example`: its words after its name; `module`: its file in this folder."""

    name: str
    summary: str
    example: str = ""
    module: str = ""
    has_port: bool = True
    has_json: bool = True

    def load(self) -> Any:
        return import_module(f"app.cli.{self.module or self.name}")

    def describe(self, parser: argparse.ArgumentParser) -> None:
        """Add its arguments, its summary and its example."""
        module = self.load()
        parser.formatter_class = argparse.RawDescriptionHelpFormatter
        parser.description = capitalised(module.__doc__.partition(": ")[2].strip())
        parser.epilog = f"Example: dps-s {self.name} {self.example}".strip()
        if hasattr(module, "add_arguments"):
            module.add_arguments(parser)
        if self.has_port:
            console.add_port(parser)
        if self.has_json:
            console.add_flags(parser, "--json")
        console.add_everywhere(parser)
        parser.set_defaults(command=self.name)

    def parse_words(self, words: list[str]) -> argparse.Namespace:
        """Parse the words of this command. Raises `Refused`; exits after --help."""
        parser = console.Parser(prog=f"dps-s {self.name}")
        self.describe(parser)
        return parser.parse_args(words) if self.name in _WITH_COMMANDS else parser.parse_intermixed_args(words)


ENTRIES: Final = (
    SubCommand("ports", "List serial ports", has_port=False),
    SubCommand("find", "Find the baud rate", "-p /dev/ttyUSB0"),
    SubCommand("read", "Read status and settings", "-p /dev/ttyUSB0 --json"),
    SubCommand("monitor", "Print the status until Ctrl-C", "--seconds 10"),
    SubCommand("serve", "Share the port with readers, read-only", "--tcp 127.0.0.1:7001"),
    SubCommand("history", "Read the trigger records", "--csv records.csv", has_json=False),
    SubCommand("set", "Write and verify settings", "freefall_time_s=1.4"),
    SubCommand("save", "Save the settings as a profile", "M-07.toml"),
    SubCommand("diff", "Compare settings; exit code 1: they differ", "M-07.toml -p /dev/ttyUSB0"),
    SubCommand("activate", "Activate the module", "--yes", "act"),
    SubCommand("lock", "Lock the module, at once"),
    SubCommand("zero", "Zero the sensor", "--yes", "act"),
    SubCommand("shutdown", "Shut the module down", "--yes", "act"),
    SubCommand("preflight", "Pre-flight check: READY, GO or NO-GO", "--module M-07"),
    SubCommand("provision", "Set up a batch of new modules", "--profile p.toml --names M-1"),
    SubCommand("verify", "Verify a pre-flight record", "M-07.pdf", has_port=False),
    SubCommand("archive", "Archive of all stations", "status", has_port=False, has_json=False),
    SubCommand("record", "Record until Ctrl-C", "--seconds 60 session.mcap"),
    SubCommand("recordings", "List, export and delete recordings", "list", has_port=False, has_json=False),
    SubCommand("fired", "Would it have fired? Exit code 4: yes", "flights/ --must-not", has_port=False),
    SubCommand("decode", "Explain captured bytes", "41 75 32 07 0A 00 01 44", has_port=False),
    SubCommand(WINDOW, "Open the window", "--demo", has_port=False, has_json=False),
    SubCommand("simulate", "Run a simulated module until Ctrl-C", "--cell 3.6", has_port=False, has_json=False),
    SubCommand("completion", "Print a shell completion script", "bash", has_port=False, has_json=False),
    SubCommand("schema", "Print the JSON Schema of an output", "read", has_port=False, has_json=False),
)
BY_NAME: Final = {entry.name: entry for entry in ENTRIES}


def is_file_name(word: str) -> bool:
    """Whether `word` names a file, as in `dps-s FILE`, and not a command."""
    # A command wins: a file of its name in the folder must not change what it does.
    return word not in BY_NAME and (bool(Path(word).suffix) or Path(word).exists())


def whole_parser(*, is_complete: bool) -> console.Parser:
    """A parser with all commands. `is_complete`: it knows their options, too, for which it imports them all."""
    parser = console.Parser(prog="dps-s", formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.usage = "dps-s [COMMAND] … | dps-s FILE"  # without a command the window opens
    parser.description = "Configures, tests and watches a DPS-S parachute module."
    parser.epilog = (
        "Help on a command: dps-s COMMAND -h\n"
        "Exit code: 0 done; 1 the answer is no; 2 usage error; 3 no link; 4 done in part; 130, 143 interrupted."
    )
    parser.add_argument("--version", action="store_true")
    console.add_everywhere(parser)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    for entry in ENTRIES:
        command = commands.add_parser(entry.name, help=entry.summary)
        if is_complete:
            entry.describe(command)
    return parser
