"""Set up a fresh checkout and run it:  python3 packaging/bootstrap.py demo | test | ...

Old Pythons must be able to read this file, so that they can print that they are too old. The work is done by
commands.py, which is imported after the check.
"""

import sys

if __name__ == "__main__":
    if sys.version_info < (3, 11):
        found = "%d.%d" % tuple(sys.version_info[:2])
        sys.exit("DPS-S Configurator needs Python 3.11 or later, and this is Python " + found + ": use a newer one.")

    from pathlib import Path

    sys.path.insert(1, str(Path(__file__).resolve().parent.parent))
    from commands import main

    sys.exit(main(sys.argv[1:]))
