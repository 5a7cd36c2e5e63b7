"""Builds the bundle from a wheel, in dist/; run by the Python for Windows."""

import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from bundle import BILL, make_bundle, pack
from environment import ROOT
from release import read_release


def main(wheel: Path) -> int:
    dist, work = ROOT / "dist", ROOT / "build" / "package"
    for folder in (dist, work):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    release = read_release()
    bundle = make_bundle(release, wheel, work=work, dist=dist)
    pack(bundle, release)
    shutil.copyfile(bundle / BILL, dist / f"{release.bundle_name}.cdx.json")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
