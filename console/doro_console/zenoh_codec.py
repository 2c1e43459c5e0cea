"""A decoder for zenoh-cli: prints msgpack payloads as JSON (``--decoder msgpack``)."""

from __future__ import annotations

import json
import struct
from typing import Any

import msgpack


def decode(_key: str, value: bytes) -> str:
    """Return a payload as one line of JSON; of a message with segments, its header.

    Raises:
        ValueError: the payload is neither a msgpack map nor a message with segments.
    """
    payload = bytes(value)
    for start, length in ((0, len(payload)), (4, _header_length(payload))):
        fields = _unpack(payload[start : start + length])
        if isinstance(fields, dict):
            return json.dumps(fields, ensure_ascii=False, default=repr)
    raise ValueError(f"{len(payload)} bytes are no message of the wire")


def _header_length(payload: bytes) -> int:
    return int(struct.unpack_from("<I", payload)[0]) if len(payload) >= 4 else 0


def _unpack(payload: bytes) -> Any:
    try:
        return msgpack.unpackb(payload)
    except (ValueError, msgpack.UnpackException):
        return None
