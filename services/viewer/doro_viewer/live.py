"""The live viewer: Rerun's own program as a child process that listens on loopback only.

The SDK's own ``serve_grpc`` and ``serve_web_viewer`` listen on all interfaces and take no
address; the program takes ``--bind``.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Self
from urllib.parse import quote

from doro_schemas.errors import Refused
from doro_viewer.settings import ViewerSettings

LOOPBACK = "127.0.0.1"
START_TIMEOUT_S = 20.0
STOP_TIMEOUT_S = 5.0
_POLL_S = 0.05


class LiveViewer:
    """A running ``rerun`` process; a context manager, or :meth:`open` and :meth:`close`.

    Args:
        settings: ``serve`` for the web viewer, ``spawn`` for the window.
    """

    def __init__(self, settings: ViewerSettings) -> None:
        self._settings = settings
        self._process: subprocess.Popen[bytes] | None = None
        self._home: tempfile.TemporaryDirectory[str] | None = None

    @property
    def url(self) -> str:
        """Where the data go."""
        return f"rerun+http://{LOOPBACK}:{self._settings.grpc_port}/proxy"

    @property
    def page(self) -> str:
        """The page to open in a browser."""
        return f"http://{LOOPBACK}:{self._settings.web_port}/?url={quote(self.url, safe='')}"

    def __enter__(self) -> Self:
        self.open()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def open(self) -> None:
        """Start the program and wait until it listens.

        Raises:
            Refused: a port is taken, or the program ended (no screen, for example).
        """
        for port in self._ports():
            if _listens(port):
                raise Refused(
                    f"port {port} on {LOOPBACK} is taken: end the other viewer or set"
                    " viewer.grpc_port and viewer.web_port"
                )
        self._home = tempfile.TemporaryDirectory(prefix="doro-viewer-")
        self._process = subprocess.Popen(
            [sys.executable, "-m", "doro_viewer.guard", *self.arguments()],
            env=_quiet_environment(Path(self._home.name)),
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        deadline_s = time.monotonic() + START_TIMEOUT_S
        while not all(map(_listens, self._ports())):
            ended = self._process.poll() is not None
            if ended or time.monotonic() > deadline_s:
                what = "ended at its start" if ended else f"did not listen in {START_TIMEOUT_S:g} s"
                self.close()
                raise Refused(
                    f"Rerun's viewer {what}: try 'rerun {' '.join(self.arguments())}' by hand,"
                    " or record with viewer.rrd instead"
                )
            time.sleep(_POLL_S)  # sleep-ok: another program's port has no event to wait for

    def close(self) -> None:
        """End the program; the page that shows it keeps what it has."""
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.close()
            try:
                self._process.wait(STOP_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                os.killpg(self._process.pid, signal.SIGKILL)
                self._process.wait()
            # The guard may be gone a moment before the program has let go of its ports.
            deadline_s = time.monotonic() + STOP_TIMEOUT_S
            while any(map(_listens, self._ports())) and time.monotonic() < deadline_s:
                time.sleep(_POLL_S)  # sleep-ok: as above
        self._process = None
        if self._home is not None:
            self._home.cleanup()
            self._home = None

    def arguments(self) -> list[str]:
        """Return the program's arguments."""
        settings = self._settings
        arguments = ["--bind", LOOPBACK]
        arguments += ["--port", str(settings.grpc_port), "--hide-welcome-screen"]
        if settings.serve:
            arguments += ["--serve-web", "--web-viewer-port", str(settings.web_port)]
            arguments += ["--server-memory-limit", settings.memory_limit]
        else:
            arguments += ["--memory-limit", settings.memory_limit]
        return arguments

    def _ports(self) -> list[int]:
        web = [self._settings.web_port] if self._settings.serve else []
        return [self._settings.grpc_port, *web]


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        probe.settimeout(1.0)
        return probe.connect_ex((LOOPBACK, port)) == 0


def _quiet_environment(home: Path) -> dict[str, str]:
    """Return an environment in which the program sends no usage statistics.

    There is no option for that, only its configuration file; the person's own is not touched.
    """
    file = home / "rerun" / "analytics.json"
    file.parent.mkdir()
    quiet = {
        "analytics_enabled": False,
        "analytics_id": "doro",
        "metadata": {},
        "config_file_path": str(file),
        "data_dir_path": str(home),
    }
    file.write_text(json.dumps(quiet), encoding="utf-8")
    return {**os.environ, "XDG_CONFIG_HOME": str(home)}
