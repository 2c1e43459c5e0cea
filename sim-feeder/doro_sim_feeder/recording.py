"""Recordings: MCAP files that hold the very messages of the wire.

Each channel is a key with the schema of its message; the data is the payload as it travels,
the log time is the message's ``stamp_ns``. Chunks are zstd-compressed; a file that was cut
off is readable up to its last whole chunk.
"""

from __future__ import annotations

import json
import struct
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import msgspec
import zstandard
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, SeekingReader
from mcap.writer import CompressionType, Writer

from doro_schemas import codec
from doro_schemas.errors import Refused
from doro_schemas.jsonschemas import schema_json
from doro_schemas.messages import DepthFrame
from doro_schemas.messages.base import Message
from doro_schemas.topics import TABLE, Topic, topic_of

PROFILE = "doro"
FORMAT = "1"
METADATA = "doro"
CHUNK_BYTES = 1 << 20
TRUTH = "truth.json"
DEPTH_ENCODING = codec.encoding_of(DepthFrame)
DAMAGE = (McapError, EOFError, ValueError, struct.error, zstandard.ZstdError)
MAGIC = b"\x89MCAP0\r\n"


class Sample(msgspec.Struct, frozen=True):
    """One recorded message: its topic, key, payload, encoding and time."""

    topic: Topic
    key: str
    payload: bytes
    encoding: str
    stamp_ns: int

    def message(self) -> Message:
        """Return the decoded message; raises Refused where it does not fit."""
        return codec.decode(self.payload, self.encoding, self.topic.messages)


class Recorder:
    """Writes a recording; a context manager.

    Args:
        path: the file, overwritten.
        metadata: room, seed, generator version and the like, kept in the file.

    Size and intrinsics of each camera are kept as metadata ``camera <name>`` by itself.
    """

    def __init__(self, path: Path, metadata: dict[str, str] | None = None) -> None:
        self._stream = path.open("wb")
        self._writer = Writer(self._stream, CHUNK_BYTES, CompressionType.ZSTD)
        self._writer.start(profile=PROFILE, library="doro-sim-feeder")
        self._writer.add_metadata(METADATA, {"format": FORMAT, **(metadata or {})})
        self._channels: dict[tuple[str, str], int] = {}
        self._schemas: dict[str, int] = {}
        self._cameras: set[str] = set()
        self.count = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def add(self, message: Message) -> None:
        """Append a message under the key of its topic."""
        kind = type(message)
        key = topic_of(kind).key_for(camera=getattr(message, "camera", ""))
        self.add_raw(key, codec.encode(message), codec.encoding_of(kind), message.stamp_ns)

    def add_raw(self, key: str, payload: bytes, encoding: str, stamp_ns: int) -> None:
        """Append a payload as it came off the bus."""
        if key not in self._cameras and encoding == DEPTH_ENCODING:
            self._note_camera(key, payload)
        channel = self._channel(key, encoding)
        self._writer.add_message(channel, stamp_ns, payload, stamp_ns, self.count)
        # A chunk that is written is in the file, whatever happens to the process. (mcap wraps an
        # unbuffered stream in a buffer of its own that nobody flushes: the file stays empty.)
        self._stream.flush()
        self.count += 1

    def attach(self, name: str, data: bytes) -> None:
        """Keep a file inside the recording, for example the ground truth as JSON."""
        self._writer.add_attachment(0, 0, name, "application/json", data)

    def close(self) -> None:
        """Write index and footer."""
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._stream.close()

    def _note_camera(self, key: str, payload: bytes) -> None:
        """Keep what the first depth frame of a camera says of it."""
        self._cameras.add(key)
        try:
            frame = codec.decode(payload, DEPTH_ENCODING)
        except Refused:
            return  # whoever plays it will be told; the recording keeps what passed
        if isinstance(frame, DepthFrame):
            sizes = {"width_px": frame.width_px, "height_px": frame.height_px}
            values = {**sizes, **msgspec.structs.asdict(frame.intrinsics)}
            fields = {name: f"{value:g}" for name, value in values.items()}
            self._writer.add_metadata(f"camera {frame.camera}", fields)

    def _channel(self, key: str, encoding: str) -> int:
        if (key, encoding) not in self._channels:
            container, _, schema = encoding.partition(";")
            self._channels[key, encoding] = self._writer.register_channel(
                topic=key, message_encoding=container, schema_id=self._schema(schema)
            )
        return self._channels[key, encoding]

    def _schema(self, name: str) -> int:
        if not name:
            return 0
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(
                name=name, encoding="jsonschema", data=schema_json(name).encode()
            )
        return self._schemas[name]


class Recording:
    """A recording that is open for reading.

    Args:
        path: the file.
        salvage: read a file that was cut off up to its last whole chunk.

    Raises:
        Refused: missing, no MCAP, another format, or cut off and not ``salvage``.
    """

    def __init__(self, path: Path, *, salvage: bool = False) -> None:
        self.path = path
        self.cut_off = False
        self.metadata: dict[str, str] = {}
        self.cameras: dict[str, dict[str, str]] = {}
        self.counts: Counter[str] = Counter()
        try:
            with path.open("rb") as stream:
                if stream.read(len(MAGIC)) != MAGIC:
                    raise Refused(f"{path} is no MCAP recording: its first bytes are others")
                self.cut_off = not self._read_summary()
        except OSError as error:
            raise Refused(f"recording {path} cannot be read: {error.strerror}") from error
        if self.cut_off and not salvage:
            raise Refused(
                f"recording {path.name} is cut off or damaged: it has no valid footer; what is"
                " whole in it can be played with --salvage"
            )
        if self.metadata and self.metadata.get("format") != FORMAT:
            raise Refused(
                f"recording {path.name} has format {self.metadata.get('format')}, this version"
                f" reads {FORMAT}"
            )

    def _read_summary(self) -> bool:
        """Fill counts and metadata from the index; False where there is none."""
        with self.path.open("rb") as stream:
            try:
                reader = SeekingReader(stream)
                summary = reader.get_summary()
                if summary is None or summary.statistics is None:
                    return False
                for item in reader.iter_metadata():
                    if item.name == METADATA:
                        self.metadata = dict(item.metadata)
                    elif item.name.startswith("camera "):
                        self.cameras[item.name.removeprefix("camera ")] = dict(item.metadata)
                for number, count in summary.statistics.channel_message_counts.items():
                    self.counts[summary.channels[number].topic] += count
            except (*DAMAGE, OSError, KeyError):
                return False
        return True

    def attachment(self, name: str) -> bytes | None:
        """Return a file that is kept inside the recording, None where there is none."""
        with self.path.open("rb") as stream:
            for item in SeekingReader(stream).iter_attachments():
                if item.name == name:
                    return bytes(item.data)
        return None

    def samples(self) -> Iterator[Sample]:
        """Yield the samples in the order in which they were written.

        Raises:
            Refused: a sample on a key that the topic table does not have, or damaged data.
        """
        with self.path.open("rb") as stream:
            reader = NonSeekingReader(stream, validate_crcs=True)
            try:
                for schema, channel, message in reader.iter_messages(log_time_order=False):
                    name = "" if schema is None else schema.name
                    yield Sample(
                        topic=_topic_of_key(channel.topic, self.path),
                        key=channel.topic,
                        payload=message.data,
                        encoding=f"{channel.message_encoding};{name}".rstrip(";"),
                        stamp_ns=message.log_time,
                    )
            except Refused:
                raise
            except DAMAGE as error:
                if self.cut_off:
                    return
                raise Refused(f"recording {self.path.name} is damaged: {error}") from error


def write_recording(
    path: Path,
    messages: Iterable[Message],
    metadata: dict[str, str] | None = None,
    attachments: Callable[[], dict[str, bytes]] = dict,
) -> int:
    """Write messages to a recording; return their number.

    Args:
        attachments: files to keep inside, by name; asked for after the last message.

    The file takes its name when it is whole: a source that fails midway leaves none.
    """
    unfinished = path.with_name(f".{path.name}.part")
    try:
        with Recorder(unfinished, metadata) as recorder:
            for message in messages:
                recorder.add(message)
            for name, data in attachments().items():
                recorder.attach(name, data)
        unfinished.replace(path)
    finally:
        unfinished.unlink(missing_ok=True)
    return recorder.count


def describe(recording: Recording) -> dict[str, Any]:
    """Return what a recording holds, for people and programs."""
    stamps = [sample.stamp_ns for sample in recording.samples()]
    return {
        "file": recording.path.name,
        "metadata": json.loads(json.dumps(recording.metadata, sort_keys=True)),
        "cameras": recording.cameras,
        "messages": dict(sorted(recording.counts.items())),
        "duration_s": (max(stamps) - min(stamps)) / 1e9 if stamps else 0.0,
        "cut_off": recording.cut_off,
    }


def _topic_of_key(key: str, path: Path) -> Topic:
    for topic in TABLE:
        if _matches(topic.pattern, key):
            return topic
    raise Refused(f"recording {path.name} holds the key '{key}', which no topic has")


def _matches(pattern: str, key: str) -> bool:
    parts, chunks = pattern.split("/"), key.split("/")
    return len(parts) == len(chunks) and all(
        part in ("*", chunk) for part, chunk in zip(parts, chunks, strict=True)
    )
