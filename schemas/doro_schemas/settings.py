"""Settings: one TOML file with a table per service, and overrides from the command line."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from doro_schemas.errors import Refused

T = TypeVar("T")


def load_settings(table: str, kind: type[T], path: Path | None, overrides: Sequence[str] = ()) -> T:
    """Return the settings of one table.

    Args:
        table: name of the table in the file ("mapper"); missing means defaults.
        kind: a msgspec Struct with defaults.
        path: the TOML file, or None for defaults.
        overrides: ``table.key=value`` texts; those of other tables are ignored.

    Raises:
        Refused: unreadable file, unknown key or a value of another type.
    """
    values: dict[str, Any] = {}
    if path is not None:
        try:
            values = dict(tomllib.loads(path.read_text(encoding="utf-8")).get(table, {}))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise Refused(f"settings file {path} cannot be read: {error}") from error
    for override in overrides:
        where, _, text = override.partition("=")
        owner, _, key = where.partition(".")
        if owner == table:
            values[key] = _toml_value(text)
    known = {field.name for field in msgspec.structs.fields(kind)}  # type: ignore[arg-type]
    for key in values:
        if key not in known:
            raise Refused(f"setting {table}.{key} is unknown; known are {', '.join(sorted(known))}")
    try:
        return msgspec.convert(values, kind, strict=True)
    except msgspec.ValidationError as error:
        raise Refused(f"settings of [{table}]: {error}") from error


def _toml_value(text: str) -> Any:
    """Read ``text`` as a TOML value; what is none is a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
