"""Set up a fresh checkout and run it:  python3 packaging/bootstrap.py demo | test | ...

Old Pythons must be able to read this file, so that they can print that they are too old.  The work is done by
commands.py, which is imported after the check.
"""

import sys

OLDEST = (3, 11)


def refusal(version):  # no annotations: old Pythons read this
    """A sentence for a Python that is too old, or None."""
    if tuple(version[:2]) >= OLDEST:
        return None
    numbers = OLDEST + tuple(version[:2])
    sentence = "DPS-S Configurator needs Python {}.{} or later, and this is Python {}.{}: run this with a newer one."
    return sentence.format(*numbers)


if __name__ == "__main__":
    sentence = refusal(sys.version_info)
    if sentence:
        sys.exit(sentence)

    from commands import main

    sys.exit(main(sys.argv[1:]))
