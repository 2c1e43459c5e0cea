"""All services on this host as processes, kept by supervisord."""

from __future__ import annotations

import getpass
import os
import socket
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from doro_console.options import deploy_folder
from doro_schemas.errors import Refused

SERVICES = ("nlu", "perception", "mapper", "dialogue", "viewer")
NEEDED = ("nlu", "perception", "mapper", "dialogue")
STOP_TIMEOUT_S = 30.0


def free_port() -> int:
    """Return a TCP port of the loopback interface that is free now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
    return port


def environment(arguments: Sequence[str], run_folder: Path) -> Mapping[str, str]:
    """Return the environment in which supervisord reads ``deploy/supervisord.conf``."""
    return {
        **os.environ,
        "DORO_BIN": str(Path(sys.executable).parent),
        "DORO_ARGS": " ".join(_quoted(argument) for argument in arguments),
        "DORO_RUN": str(run_folder),
    }


def supervisor_command(config: Path | None = None) -> list[str]:
    """Return the command line of supervisord."""
    command = [sys.executable, "-m", "supervisor.supervisord", "-n", "-c"]
    command.append(str(config or deploy_folder() / "supervisord.conf"))
    # As root supervisord wants to be told so, or it warns.
    return [*command, "-u", getpass.getuser()] if os.geteuid() == 0 else command


class Processes:
    """Router and services as separate processes; a context manager.

    Args:
        arguments: passed to every service (``--config``, ``--set``).
    """

    def __init__(self, arguments: Sequence[str]) -> None:
        self._arguments = list(arguments)
        self._folder = tempfile.TemporaryDirectory(prefix="doro-")
        self.run_folder = Path(self._folder.name)
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    def start(self) -> None:
        """Start supervisord, which starts the services."""
        self._process = subprocess.Popen(
            supervisor_command(),
            env=environment(self._arguments, self.run_folder),
            stdin=subprocess.DEVNULL,
            start_new_session=True,
        )

    def wait(self) -> int:
        """Wait until supervisord ends; return its exit status."""
        if self._process is None:
            raise RuntimeError("not started")
        return self._process.wait()

    def terminate(self) -> None:
        """Tell supervisord to stop (signal handlers included)."""
        if self._process is not None and self._process.poll() is None:
            self._process.terminate()

    def stop(self) -> None:
        """Stop all services cleanly and remove the run folder."""
        self.terminate()
        if self._process is not None:
            try:
                self._process.wait(STOP_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._folder.cleanup()

    def failed(self) -> bool:
        """Tell whether supervisord has given a service up, or has itself ended."""
        log = self.run_folder / "supervisord.log"
        text = log.read_text(encoding="utf-8", errors="replace") if log.exists() else ""
        ended = self._process is not None and self._process.poll() is not None
        return "entered FATAL state" in text or ended

    def logs(self, lines: int = 15) -> str:
        """Return the last lines of each service's log, for a failure's message."""
        parts = []
        for path in sorted(self.run_folder.glob("*.log")):
            if path.stem == "supervisord":
                continue
            text = path.read_text(encoding="utf-8", errors="replace").strip()
            if text:
                tail = "\n".join(text.splitlines()[-lines:])
                parts.append(f"--- {path.stem}\n{tail}")
        return "\n".join(parts)


def _quoted(argument: str) -> str:
    """Quote for supervisord, which splits commands as a shell does and expands ``%``."""
    if "\n" in argument:
        raise Refused(f"an argument of a service may not hold a line break: {argument!r}")
    escaped = argument.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
