"""Not run here: written for macOS, never executed. The disk image that people drag the program out of."""

import tempfile
from pathlib import Path

from environment import run
from release import TITLE


def sign_again(app: Path) -> None:
    """Sign ad hoc: PyInstaller's signature is invalid after the licences were added."""
    run(["codesign", "--force", "--deep", "--sign", "-", str(app)], "codesign failed")


def make_disk_image(app: Path, target: Path) -> None:
    """A compressed image with the .app and a link to the Applications folder. Raises SetupError if that fails.

    The program is signed ad hoc. Without a warning Gatekeeper opens only programs that are signed with a Developer ID
    (`codesign --deep --options runtime --sign ID`) and notarised (`xcrun notarytool submit`), which needs an account.
    """
    with tempfile.TemporaryDirectory() as folder:
        content = Path(folder)
        run(["ditto", str(app), str(content / app.name)], "ditto failed")  # keeps links and signatures
        (content / "Applications").symlink_to("/Applications")
        command = ["hdiutil", "create", "-volname", TITLE, "-srcfolder", str(content), "-format", "UDZO", "-ov"]
        run([*command, str(target)], f"hdiutil could not make {target.name}")
