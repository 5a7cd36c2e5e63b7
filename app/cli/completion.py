"""`dps-s completion bash|zsh`: prints a completion script, which shtab writes from the parsers.

The script is static: pressing Tab starts no program. It offers commands, options, files, and the ports that are there.

bash   dps-s completion bash > ~/.local/share/bash-completion/completions/dps-s
zsh    dps-s completion zsh > ~/.zfunc/_dps-s    (~/.zfunc in $fpath before compinit)
"""

import argparse

from app.cli.commands import whole_parser
from app.terminal import console

_PREAMBLES = {
    "bash": """\
_dps_s_ports() {
    compgen -W "$(ls -d DEVICES 2>/dev/null)" -- "$1"
    _shtab_compgen_files "$1"
}""",
    "zsh": """\
_dps_s_ports() {
    compadd -- ${(f)"$(ls -d DEVICES 2>/dev/null)"}
    _files
}""",
}
_DEVICES = "/dev/serial/by-id/* /dev/ttyUSB* /dev/ttyACM* /dev/cu.usb*"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("shell", choices=tuple(_PREAMBLES))


def run(args: argparse.Namespace) -> int:
    import shtab

    preamble = _PREAMBLES[args.shell].replace("DEVICES", _DEVICES)
    console.write(shtab.complete(whole_parser(is_complete=True), args.shell, preamble=preamble) + "\n")
    return console.SUCCESS
