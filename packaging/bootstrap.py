"""Set up a fresh checkout and run it:  python3 packaging/bootstrap.py demo | test | ...

Old Pythons must be able to read this file, so that they can print that they are too old.  The work is done by
commands.py, which is imported after the check.
"""

import subprocess
import sys

OLDEST = (3, 11)


def refusal(version):  # no annotations: old Pythons read this
    """A sentence for a Python that is too old, with what to type instead, or None."""
    if tuple(version[:2]) >= OLDEST:
        return None
    numbers = OLDEST + tuple(version[:2])
    sentence = "DPS-S Configurator needs Python {}.{} or later, and this is Python {}.{}.".format(*numbers)
    newer = _newer_python()
    if newer:
        return " ".join([sentence, "Type:", newer, "packaging/bootstrap.py"] + sys.argv[1:])  # noqa: RUF005
    return sentence + " Install a newer Python, then run this again with it."


def _newer_python():
    """The name of a Python in PATH that is new enough and starts, or None."""
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
