"""Folders that can be made into a recording: frames with poses, or dumped AI2-THOR events."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from doro_schemas.errors import Refused
from doro_schemas.messages.base import Message
from doro_sim_feeder.events import METADATA_ENDINGS, EventFolder
from doro_sim_feeder.folder import FrameFolder


class Folder(Protocol):
    """A folder that is checked and ready to be read."""

    @property
    def tasks(self) -> list[str]:
        """Names of the walks or episodes in it."""
        ...

    def metadata(self, tasks: list[str]) -> dict[str, str]:
        """Return what a recording of these walks says about itself."""
        ...

    def messages(self, tasks: list[str] | None = None, episode: str = "") -> Iterator[Message]:
        """Yield the walks as one episode of messages."""
        ...


def open_folder(path: Path) -> Folder:
    """Return the reader of a folder, by what lies in it.

    Raises:
        Refused: it is no folder that can be imported.
    """
    if not path.is_dir():
        raise Refused(f"{path} is no folder: give one with frames.json or with AI2-THOR events")
    if (path / "frames.json").exists():
        return FrameFolder(path)
    if any(
        next(path.glob(f"{deep}*{end}"), None) for deep in ("", "*/") for end in METADATA_ENDINGS
    ):
        return EventFolder(path)
    raise Refused(
        f"{path} holds neither frames.json (colour, depth and poses) nor AI2-THOR events"
        " (<name>.metadata.json.gz beside <name>.rgb.png)"
    )
