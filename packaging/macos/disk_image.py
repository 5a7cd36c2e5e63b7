"""Not run here: written for macOS, never executed by us. The disk image that people drag the program out of."""

import subprocess
import tempfile
from pathlib import Path

from environment import SetupError
from release import TITLE


def sign_again(app: Path) -> None:
    """Sign ad hoc, as PyInstaller did before the licences were put into the .app and broke its seal."""
    subprocess.run(["codesign", "--force", "--deep", "--sign", "-", str(app)], check=True)


def make_disk_image(app: Path, target: Path) -> Path:
    """A compressed image with the .app and a link to the Applications folder; raises SetupError where that fails.

    The program is signed ad hoc. To have Gatekeeper open it without a question it has to be signed with
    a Developer ID (`codesign --deep --options runtime --sign ID`) and notarised (`xcrun notarytool submit`), which
    needs an account of Apple's.
    """
    with tempfile.TemporaryDirectory() as folder:
        content = Path(folder)
        subprocess.run(["ditto", str(app), str(content / app.name)], check=True)  # keeps links and signatures
        (content / "Applications").symlink_to("/Applications")
        command = ["hdiutil", "create", "-volname", TITLE, "-srcfolder", str(content), "-format", "UDZO", "-ov"]
        done = subprocess.run([*command, str(target)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SetupError(f"{done.stderr}\nhdiutil could not make {target.name}; it says why above.", exit_code=4)
    return target
