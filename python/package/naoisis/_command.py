"""The command ``naoisis``."""

from __future__ import annotations

import signal
import sys

from naoisis import _naoisis


def main() -> int:
    """Runs the command line, like the program of the same name. Returns its exit status."""
    # The command closes its files itself when it is interrupted.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _naoisis.command(["naoisis", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
