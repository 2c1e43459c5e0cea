"""The one codec: msgpack maps, with raw segments behind them where arrays are bulky.

Plain message: the payload is one msgpack map. Message with segments (images, depth,
cells)::

    0    u32 little endian   length h of the header
    4    h bytes             msgpack map: the fields, and "segments": [[name, dtype, shape], ...]
    pad to 16                zero bytes up to the next multiple of 16 from the payload's start
    ...                      the arrays, C order, little endian, each padded to 16 likewise

The Zenoh encoding names the schema: ``application/msgpack;doro.Query.v1`` or
``application/vnd.doro.segments;doro.DepthFrame.v1``. Readers skip unknown fields.
"""

from __future__ import annotations

import math
import re
import struct
from functools import lru_cache
from typing import Any

import msgpack
import msgspec
import numpy as np

from doro_schemas.errors import Refused
from doro_schemas.messages.base import Message
from doro_schemas.topics import TYPES

PLAIN = "application/msgpack"
SEGMENTED = "application/vnd.doro.segments"
MAX_PAYLOAD_BYTES = 256 << 20
ALIGN = 16
DTYPES = {"u1": np.uint8, "u2": np.uint16, "i4": np.int32, "f4": np.float32}
_DTYPE_NAMES = {np.dtype(kind): name for name, kind in DTYPES.items()}
_SCHEMA = re.compile(r"doro\.(\w+)\.v(\d+)")


@lru_cache(maxsize=256)
def schema_name(kind: type[Message]) -> str:
    """Return the schema's name, for example ``doro.Query.v1``."""
    return f"doro.{kind.__name__}.v{kind.VERSION}"


@lru_cache(maxsize=256)
def encoding_of(kind: type[Message]) -> str:
    """Return the Zenoh encoding of a message type."""
    return f"{SEGMENTED if kind.SEGMENTS else PLAIN};{schema_name(kind)}"


@lru_cache(maxsize=256)
def type_of(encoding: str) -> type[Message]:
    """Return the message type that an encoding names.

    Raises:
        Refused: no schema, an unknown one, or a version that this build does not read.
    """
    container, _, schema = encoding.partition(";")
    match = _SCHEMA.fullmatch(schema.strip())
    if match is None:
        raise Refused(
            f"encoding '{encoding[:80]}' names no schema: put with an encoding such as"
            f" '{PLAIN};doro.FrameCaptions.v1'"
        )
    kind = TYPES.get(match[1])
    if kind is None:
        raise Refused(f"schema '{schema}' is unknown; the wire spec lists the schemas")
    if int(match[2]) != kind.VERSION:
        raise Refused(
            f"schema version '{schema}' is not read here: this build reads {schema_name(kind)},"
            " update the older side"
        )
    if encoding_of(kind) != f"{container};{schema.strip()}":
        raise Refused(f"'{schema}' travels as '{encoding_of(kind)}', not '{container[:60]}'")
    return kind


def encode(message: Message) -> bytes:
    """Return the payload of a message."""
    kind = type(message)
    if not kind.SEGMENTS:
        plain: dict[str, Any] = msgspec.to_builtins(message)
        for name, default in kind.ADDED.items():
            if plain[name] == default:
                del plain[name]
        return bytes(msgpack.packb(plain))
    fields = {
        name: msgspec.to_builtins(getattr(message, name))
        for name in kind.__struct_fields__
        if name not in kind.SEGMENTS
    }
    for name, default in kind.ADDED.items():
        if name in fields and fields[name] == default:
            del fields[name]
    table, parts = [], []
    for name in kind.SEGMENTS:
        array = np.ascontiguousarray(getattr(message, name))
        if name in kind.ADDED and not array.size:
            continue
        table.append([name, _DTYPE_NAMES[array.dtype], list(array.shape)])
        parts += [array.data.cast("B") if array.size else b"", _padding(array.nbytes)]
    header = msgpack.packb({**fields, "segments": table})
    return b"".join([struct.pack("<I", len(header)), header, _padding(4 + len(header)), *parts])


def decode(payload: bytes, encoding: str, expected: tuple[type[Message], ...] = ()) -> Message:
    """Return the validated message of a payload; arrays are views into it.

    Args:
        payload: the bytes.
        encoding: the Zenoh encoding, which names the schema.
        expected: types that may travel here; empty means any.

    Raises:
        Refused: one sentence: what, where, what to do.
    """
    kind = type_of(encoding)
    if expected and kind not in expected:
        names = " or ".join(schema_name(item) for item in expected)
        raise Refused(f"{schema_name(kind)} does not travel on this key: {names} does")
    if len(payload) > MAX_PAYLOAD_BYTES:
        raise Refused(f"payload of {len(payload)} bytes is over the limit of {MAX_PAYLOAD_BYTES}")
    fields = _unpack_segments(payload, kind) if kind.SEGMENTS else _unpack(payload, kind)
    try:
        return msgspec.convert(fields, kind, strict=True, dec_hook=_take_array)
    except (msgspec.ValidationError, RecursionError) as error:
        raise Refused(f"{schema_name(kind)}: {error}", **_where(fields)) from error


def decode_text(payload: bytes, kind: type[Message]) -> Message:
    """Return the message that plain UTF-8 text stands for.

    Raises:
        Refused: no UTF-8, or text that the message refuses (empty, too long).
    """
    try:
        text = bytes(payload).decode("utf-8")
    except UnicodeDecodeError as error:
        raise Refused(f"plain text must be UTF-8: {error}; or send {encoding_of(kind)}") from error
    try:
        return msgspec.convert({"text": text}, kind)
    except msgspec.ValidationError as error:
        raise Refused(f"{schema_name(kind)}: {error}") from error


def _unpack(payload: bytes | memoryview, kind: type[Message]) -> dict[str, Any]:
    try:
        fields = msgpack.unpackb(payload, raw=False, strict_map_key=True)
    except (ValueError, msgpack.UnpackException, RecursionError, MemoryError) as error:
        what = str(error) or type(error).__name__
        raise Refused(
            f"{schema_name(kind)}: {len(payload)} bytes are no complete msgpack map ({what})"
        ) from error
    if not isinstance(fields, dict):
        raise Refused(f"{schema_name(kind)}: a msgpack map is needed, got {type(fields).__name__}")
    return fields


def _unpack_segments(payload: bytes, kind: type[Message]) -> dict[str, Any]:
    """Read header and segments; every declared segment must be there and fit exactly."""
    name = schema_name(kind)
    if len(payload) < 4:
        raise Refused(f"{name}: {len(payload)} bytes are too short for a header")
    (length,) = struct.unpack_from("<I", payload)
    if 4 + length > len(payload):
        raise Refused(f"{name}: header of {length} bytes is longer than the payload, cut off?")
    view = memoryview(payload)
    fields = _unpack(view[4 : 4 + length], kind)
    offset = 4 + length
    for entry in _segment_table(fields, kind):
        offset += len(_padding(offset))
        segment, dtype, shape = entry
        size = math.prod(shape) * np.dtype(DTYPES[dtype]).itemsize
        if offset + size > len(payload):
            raise Refused(
                f"{name}: segment '{segment}' needs {size} bytes, {max(0, len(payload) - offset)}"
                " are there, cut off?",
                **_where(fields),
            )
        count = math.prod(shape)
        fields[segment] = np.frombuffer(payload, f"<{dtype}", count, offset).reshape(shape)
        offset += size
    return fields


def _segment_table(fields: dict[str, Any], kind: type[Message]) -> list[tuple[str, str, list[int]]]:
    """Return the checked table of segments, in the order of the payload."""
    table = fields.pop("segments", None)
    try:
        entries = msgspec.convert(table, list[tuple[str, str, list[int]]])
    except msgspec.ValidationError as error:
        raise Refused(f"{schema_name(kind)}: segments: {error}", **_where(fields)) from error
    missing = set(kind.SEGMENTS) - set(kind.ADDED) - {name for name, _, _ in entries}
    if missing:
        raise Refused(f"{schema_name(kind)}: segment '{min(missing)}' is missing", **_where(fields))
    for name, dtype, shape in entries:
        if dtype not in DTYPES or any(side < 0 for side in shape) or len(shape) > 4:
            raise Refused(
                f"{schema_name(kind)}: segment '{name}' has dtype '{dtype}' and shape {shape};"
                f" known dtypes are {', '.join(DTYPES)}",
                **_where(fields),
            )
    return entries


def _where(fields: dict[str, Any]) -> dict[str, Any]:
    """Return episode and frame of a message that is being refused, as far as it has them."""
    episode, frame = fields.get("episode"), fields.get("frame")
    return {
        "episode": episode if isinstance(episode, str) else "",
        "frame": frame if isinstance(frame, int) else -1,
    }


def _padding(length: int) -> bytes:
    return bytes(-length % ALIGN)


def _take_array(_kind: type, value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value
    raise ValueError(f"an array is needed as a segment, got {type(value).__name__}")
