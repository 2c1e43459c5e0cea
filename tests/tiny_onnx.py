"""Tiny ONNX models, written without the package ``onnx``: a few fields of its protobuf."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

FLOAT, UINT8, INT64 = 1, 2, 7
NUMBERS = {"float32": FLOAT, "uint8": UINT8, "int64": INT64}
IR_VERSION, OPSET = 8, 13


def _varint(value: int) -> bytes:
    out = bytearray()
    value &= (1 << 64) - 1
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*out, value])


def _number(field: int, value: int) -> bytes:
    return _varint(field << 3) + _varint(value)


def _bytes(field: int, value: bytes | str) -> bytes:
    data = value.encode() if isinstance(value, str) else value
    return _varint(field << 3 | 2) + _varint(len(data)) + data


def tensor(name: str, values: NDArray[Any]) -> bytes:
    dims = b"".join(_number(1, side) for side in values.shape)
    kind = _number(2, NUMBERS[str(values.dtype)])
    return dims + kind + _bytes(8, name) + _bytes(9, np.ascontiguousarray(values).tobytes())


def attribute(name: str, value: int | float | list[int]) -> bytes:
    if isinstance(value, float):
        return _bytes(1, name) + _varint(2 << 3 | 5) + struct.pack("<f", value) + _number(20, 1)
    if isinstance(value, int):
        return _bytes(1, name) + _number(3, value) + _number(20, 2)
    return _bytes(1, name) + b"".join(_number(8, one) for one in value) + _number(20, 7)


def node(op: str, inputs: Sequence[str], outputs: Sequence[str], **attributes: Any) -> bytes:
    named = b"".join(_bytes(1, name) for name in inputs)
    named += b"".join(_bytes(2, name) for name in outputs) + _bytes(4, op)
    return named + b"".join(_bytes(5, attribute(key, value)) for key, value in attributes.items())


def port(name: str, kind: int, shape: Sequence[int | str]) -> bytes:
    sides = b"".join(
        _bytes(1, _bytes(2, side) if isinstance(side, str) else _number(1, side)) for side in shape
    )
    return _bytes(1, name) + _bytes(2, _bytes(1, _number(1, kind) + _bytes(2, sides)))


def model(
    nodes: Sequence[bytes],
    constants: dict[str, NDArray[Any]],
    inputs: Sequence[bytes],
    outputs: Sequence[bytes],
) -> bytes:
    """Return the bytes of a model file."""
    graph = b"".join(_bytes(1, one) for one in nodes) + _bytes(2, "tiny")
    graph += b"".join(_bytes(5, tensor(name, value)) for name, value in constants.items())
    graph += b"".join(_bytes(11, one) for one in inputs)
    graph += b"".join(_bytes(12, one) for one in outputs)
    return _number(1, IR_VERSION) + _bytes(7, graph) + _bytes(8, _bytes(1, "") + _number(2, OPSET))
