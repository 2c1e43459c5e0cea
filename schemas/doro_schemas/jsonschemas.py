"""JSON Schemas of all messages, for other languages: ``python -m doro_schemas.jsonschemas DIR``."""

from __future__ import annotations

import json
import sys
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from doro_schemas import codec
from doro_schemas.topics import TYPES


def _hook(kind: type) -> dict[str, Any]:
    if issubclass(kind, np.ndarray):
        return {"description": "raw segment behind the header: see the wire spec"}
    # What msgspec asks of a hook for a type that it does not know.
    raise NotImplementedError(f"no JSON Schema for {kind}")


@cache
def schema_json(name: str) -> str:
    """Return the JSON Schema of ``doro.<Type>.v<n>`` as text, empty for an unknown name."""
    for kind in TYPES.values():
        if codec.schema_name(kind) == name:
            schema = msgspec.json.schema(kind, schema_hook=_hook)
            schema["x-encoding"] = codec.encoding_of(kind)
            schema["x-segments"] = list(kind.SEGMENTS)
            return json.dumps(schema, indent=2, sort_keys=True) + "\n"
    return ""


def write_all(folder: Path) -> list[Path]:
    """Write one file per message type; return them."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for kind in TYPES.values():
        path = folder / f"{codec.schema_name(kind)}.json"
        path.write_text(schema_json(codec.schema_name(kind)), encoding="utf-8")
        written.append(path)
    return written


if __name__ == "__main__":
    write_all(Path(sys.argv[1]))
