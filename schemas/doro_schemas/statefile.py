"""A service's state on disk: one small file, replaced whole, checked when it is read.

The file is a msgpack map ``{"schema", "v", "sha256", "state"}``; ``state`` are the bytes that
the service gave. It is written beside its place and moved there, so that a reader sees the
old file or the new one, never half of one.
"""

from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path

import msgpack

from doro_schemas.errors import Refused

VERSION = 1
KEPT_ASIDE = ".damaged"


def default_folder() -> Path:
    """Return the folder for states: ``$XDG_STATE_HOME/doro``, or ``~/.local/state/doro``."""
    base = os.environ.get("XDG_STATE_HOME", "")
    return (Path(base) if base else Path.home() / ".local" / "state") / "doro"


def file_name(service: str, namespace: str, endpoint: str) -> str:
    """Return the name of a service's file: one for each namespace on each router."""
    parts = [service, namespace or "no-namespace", endpoint]
    return "-".join(re.sub(r"[^A-Za-z0-9.]+", "_", part) for part in parts) + ".state"


class StateFile:
    """One state on disk.

    Args:
        path: the file; its folder is made at the first use.
        schema: name of what the bytes are; another name or version is not read.
    """

    def __init__(self, path: Path, schema: str) -> None:
        self.path = path
        self._schema = schema
        self._written = b""
        self._synced = True

    def load(self) -> bytes | None:
        """Return the state, or None where there is no file.

        Raises:
            Refused: the file is damaged or of another version; it is kept aside under another
                name, so that the next :meth:`save` starts afresh.
        """
        try:
            content = self.path.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise Refused(f"the state file {self.path} cannot be read: {error}") from error
        try:
            state = self._checked(content)
        except ValueError as error:
            raise self.set_aside(str(error)) from error
        self._written = state
        return state

    def set_aside(self, why: str) -> Refused:
        """Move a file that is of no use out of the way; return the sentence that says so."""
        aside = self.path.with_name(self.path.name + KEPT_ASIDE)
        try:
            self.path.replace(aside)
            kept = f"it is kept as {aside}"
        except OSError as error:
            kept = f"and it cannot be moved away: {error}"
        return Refused(f"the state file {self.path} is not used: {why}; starting afresh, {kept}")

    def save(self, state: bytes) -> bool:
        """Replace the file; return False where it holds these very bytes already.

        It outlives a kill of the process from now on, and a loss of power after :meth:`sync`.

        Raises:
            Refused: the disk does not take it.
        """
        if state == self._written:
            return False
        content = msgpack.packb(
            {"schema": self._schema, "v": VERSION, "sha256": _digest(state), "state": state}
        )
        beside = self.path.with_name(f"{self.path.name}.{os.getpid()}.new")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            beside.write_bytes(content)
            beside.replace(self.path)
        except OSError as error:
            raise self._refused(error) from error
        self._written, self._synced = state, False
        return True

    def sync(self) -> None:
        """Wait until the disk has what was saved; nothing to do where it has it already.

        Raises:
            Refused: the disk does not take it.
        """
        if self._synced:
            return
        self._synced = True
        try:
            with self.path.open("rb") as file:
                os.fsync(file.fileno())
        except OSError as error:
            raise self._refused(error) from error

    def _refused(self, error: OSError) -> Refused:
        return Refused(
            f"the state cannot be kept in {self.path}: {error}; a restart would lose it,"
            " choose another folder with the setting state_dir"
        )

    def _checked(self, content: bytes) -> bytes:
        """Return the state of a file's content; ValueError says what is wrong with it."""
        try:
            fields = msgpack.unpackb(content, raw=False)
        except (ValueError, msgpack.UnpackException) as error:
            raise ValueError(f"its {len(content)} bytes are no complete msgpack map") from error
        state = fields.get("state") if isinstance(fields, dict) else None
        if not isinstance(state, bytes):
            raise ValueError("it holds no state")
        if (fields.get("schema"), fields.get("v")) != (self._schema, VERSION):
            raise ValueError(
                f"it is '{fields.get('schema')}' version {fields.get('v')}, and this build reads"
                f" '{self._schema}' version {VERSION}"
            )
        if fields.get("sha256") != _digest(state):
            raise ValueError("its checksum does not fit its content")
        return state


def _digest(state: bytes) -> str:
    return hashlib.sha256(state).hexdigest()
