"""``python -m sim.system_libraries``: are the system's graphics libraries there? Debian packages them apart.

Installs them where it may (root on Debian or Ubuntu), otherwise prints the one command to run and exits with 2.
"""

import ctypes
import os
import shutil
import subprocess
import sys

LIBRARIES = ("libEGL.so.1", "libOpenGL.so.0", "libGL.so.1", "libEGL_mesa.so.0")
PACKAGES = ("libegl1", "libegl-mesa0", "libgl1-mesa-dri", "libopengl0", "libgl1")


def missing_libraries() -> tuple[str, ...]:
    """Those of ``LIBRARIES`` that cannot be loaded."""
    return tuple(name for name in LIBRARIES if not _loads(name))


def main() -> int:
    """Make sure that MuJoCo can draw without a display; the exit status."""
    missing = missing_libraries()
    if not missing:
        return 0
    print(f"missing graphics libraries: {', '.join(missing)}", file=sys.stderr)
    apt = shutil.which("apt-get")
    if apt and os.geteuid() == 0:
        quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        subprocess.run([apt, "update", "-q"], env=quiet, check=False)
        subprocess.run([apt, "install", "-y", "-q", "--no-install-recommends", *PACKAGES], env=quiet, check=False)
        missing = missing_libraries()
    if missing:
        print(f"run: sudo apt-get install --no-install-recommends {' '.join(PACKAGES)}", file=sys.stderr)
        return 2
    return 0


def _loads(name: str) -> bool:
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


if __name__ == "__main__":
    sys.exit(main())
