"""Not run here: written for macOS, never executed. The disk image that people drag the program out of."""

import subprocess
import tempfile
from pathlib import Path

from environment import SetupError
from release import TITLE


def sign_again(app: Path) -> None:
    """Sign ad hoc: PyInstaller's signature is invalid after the licences were added."""
    subprocess.run(["codesign", "--force", "--deep", "--sign", "-", str(app)], check=True)


def make_disk_image(app: Path, target: Path) -> None:
    """A compressed image with the .app and a link to the Applications folder. Raises SetupError if that fails.

    The program is signed ad hoc. Without a warning Gatekeeper opens only programs that are signed with a Developer ID
    (`codesign --deep --options runtime --sign ID`) and notarised (`xcrun notarytool submit`), which needs an account.
    """
    with tempfile.TemporaryDirectory() as folder:
        content = Path(folder)
        subprocess.run(["ditto", str(app), str(content / app.name)], check=True)  # keeps links and signatures
        (content / "Applications").symlink_to("/Applications")
        command = ["hdiutil", "create", "-volname", TITLE, "-srcfolder", str(content), "-format", "UDZO", "-ov"]
        done = subprocess.run([*command, str(target)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SetupError(f"{done.stderr}\nhdiutil could not make {target.name}; it says why above.", exit_code=4)
