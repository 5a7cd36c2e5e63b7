"""Set up a fresh checkout and run it:  python3 packaging/bootstrap.py demo | test | ...

This file has to be understood by Pythons that are too old for the program, so that they can say so.  The
work is done by commands.py, which is loaded only after the check.
"""

import subprocess
import sys

OLDEST = (3, 11)


def refusal(version):  # no annotations: old Pythons read this
    """The sentence for a Python that is too old, with what to type instead; None where it will do."""
    if tuple(version[:2]) >= OLDEST:
        return None
    numbers = OLDEST + tuple(version[:2])
    sentence = "DPS-S Configurator needs Python {}.{} or later, and this is Python {}.{}.".format(*numbers)
    newer = _newer_python()
    if newer:
        return " ".join([sentence, "Type:", newer, "packaging/bootstrap.py"] + sys.argv[1:])  # noqa: RUF005
    return sentence + " Install a newer Python, then run this again with it."


def _newer_python():
    """The name of a Python on the search path that is new enough and starts, or None."""
    for minor in range(OLDEST[1], 20):
        name = "python3.{}".format(minor)
        try:
            process = subprocess.Popen([name, "-V"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        except OSError:
            continue
        process.communicate()
        if process.returncode == 0:
            return name
    return None


if __name__ == "__main__":
    sentence = refusal(sys.version_info)
    if sentence:
        sys.exit(sentence)

    from commands import main

    sys.exit(main(sys.argv[1:]))
