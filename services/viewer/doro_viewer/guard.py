"""Runs Rerun's program and ends it when the viewer goes, killed included.

Started as ``python -m doro_viewer.guard ARGUMENTS...`` in a session of its own; standard
input is a pipe that the viewer holds open and never writes to.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading


def _end_with_parent() -> None:
    sys.stdin.buffer.read()
    os.killpg(os.getpgrp(), signal.SIGTERM)


def main() -> int:
    """Return the program's exit status."""
    program = subprocess.Popen(
        [sys.executable, "-m", "rerun_cli", *sys.argv[1:]], stdin=subprocess.DEVNULL
    )
    threading.Thread(target=_end_with_parent, daemon=True).start()
    return program.wait()


if __name__ == "__main__":
    sys.exit(main())
