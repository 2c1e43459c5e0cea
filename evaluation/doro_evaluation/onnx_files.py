"""ONNX files of the evaluation: read, checked against their digest, opened on one thread."""

from __future__ import annotations

import hashlib
from pathlib import Path

import onnxruntime as ort

from doro_schemas.errors import Refused


def open_model(path: Path, sha256: str, whose: str) -> ort.InferenceSession:  # type: ignore[name-defined]
    """Return a session of one thread, so that equal inputs give equal bytes.

    Args:
        sha256: of the file, as the vocabulary beside it says.
        whose: what the file is of, for the sentence of a refusal.

    Raises:
        Refused: the file is missing, damaged, or not the one with this digest.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise Refused(
            f"{whose} {path} cannot be read: restore it, or name a folder that the export wrote"
        ) from error
    if hashlib.sha256(content).hexdigest() != sha256:
        raise Refused(
            f"{whose} {path} is not the file that the vocabulary beside it was written for:"
            " restore both, or export them again"
        )
    options = ort.SessionOptions()  # type: ignore[attr-defined]
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4
    try:
        return ort.InferenceSession(  # type: ignore[attr-defined]
            content, sess_options=options, providers=["CPUExecutionProvider"]
        )
    except Exception as error:  # onnxruntime has no public base class of its errors
        first_line = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise Refused(
            f"{whose} {path} is no usable ONNX file ({first_line}): export it again"
        ) from error
