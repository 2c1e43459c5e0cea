"""Model files as onnxruntime sessions: whole, of the right inputs and outputs, or refused."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import onnxruntime as ort
from onnxruntime.capi.onnxruntime_pybind11_state import (
    EPFail,
    Fail,
    InvalidArgument,
    InvalidGraph,
    InvalidProtobuf,
    NoSuchFile,
    RuntimeException,
)
from onnxruntime.capi.onnxruntime_pybind11_state import (
    NotImplemented as OpNotImplemented,
)

from doro_schemas.errors import Refused

ORT_ERRORS = (
    EPFail,
    Fail,
    InvalidArgument,
    InvalidGraph,
    InvalidProtobuf,
    NoSuchFile,
    OpNotImplemented,
    RuntimeException,
)


@dataclass(frozen=True)
class Port:
    """An input or output of a model: name, type as onnxruntime writes it, shape."""

    name: str
    kind: str
    shape: tuple[int | str | None, ...]

    def __str__(self) -> str:
        return f"'{self.name}' {self.kind} {list(self.shape)}"


class Session:
    """A loaded model.

    Args:
        path: the file; where ``<file>.sha256`` lies beside it, the digest must hold.
        threads: of onnxruntime.
        advice: what to do about a file that cannot be used, for the refusals.

    Raises:
        Refused: the file is missing, corrupt or no model that can be run.
    """

    def __init__(self, path: Path, threads: int, advice: str) -> None:
        self.path, self.advice = path, advice
        data = _read(path, advice)
        options = ort.SessionOptions()  # type: ignore[attr-defined]
        options.intra_op_num_threads = threads
        options.inter_op_num_threads = 1
        options.log_severity_level = 4
        # Its threads wait busily for more work, on a core that the next stage needs.
        options.add_session_config_entry("session.force_spinning_stop", "1")
        try:
            self._session: Any = ort.InferenceSession(  # type: ignore[attr-defined]
                data, options, providers=["CPUExecutionProvider"]
            )
        except ORT_ERRORS as error:
            raise Refused(
                f"model file {path} is no ONNX model that can be run ({first_line(error)}):"
                f" {advice}"
            ) from error
        self.inputs = [_port(value) for value in self._session.get_inputs()]
        self.outputs = [_port(value) for value in self._session.get_outputs()]
        self.metadata: dict[str, str] = dict(self._session.get_modelmeta().custom_metadata_map)

    def need(self, inputs: dict[str, str], outputs: dict[str, str]) -> None:
        """Refuse a model without exactly these inputs or without these outputs (name: type)."""
        have = {port.name: port.kind for port in self.inputs}
        give = {port.name: port.kind for port in self.outputs}
        if have != inputs or any(give.get(name) != kind for name, kind in outputs.items()):
            raise Refused(
                f"model file {self.path} takes {_listed(have)} and gives {_listed(give)}, but the"
                f" detector takes {_listed(inputs)} and gives {_listed(outputs)}: {self.advice}"
            )

    def run(self, names: list[str], feed: dict[str, Any]) -> list[Any]:
        """Return the named outputs.

        Raises:
            Refused: the model fails on this input.
        """
        try:
            found: list[Any] = self._session.run(names, feed)
        except ORT_ERRORS as error:
            raise Refused(
                f"model {self.path.name} fails on an image ({first_line(error)}): {self.advice}"
            ) from error
        return found


def _read(path: Path, advice: str) -> bytes:
    if not path.is_file():
        raise Refused(f"model file {path} is missing: {advice}")
    data = path.read_bytes()
    checksum = path.with_name(path.name + ".sha256")
    if checksum.is_file():
        expected = checksum.read_text(encoding="utf-8").split()[:1]
        if [hashlib.sha256(data).hexdigest()] != expected:
            raise Refused(
                f"model file {path} is corrupt: it does not have the sha256 of {checksum.name};"
                " install the package again"
            )
    return data


def _port(value: Any) -> Port:
    return Port(str(value.name), str(value.type), tuple(value.shape))


def _listed(ports: dict[str, str]) -> str:
    return ", ".join(f"{kind} '{name}'" for name, kind in ports.items()) or "nothing"


def first_line(error: Exception) -> str:
    """Return the first line of onnxruntime's message, short."""
    return (str(error).splitlines() or ["no reason given"])[0][:120]
