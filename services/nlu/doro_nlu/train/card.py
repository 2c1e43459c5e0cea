"""The model card beside the model."""

from __future__ import annotations

import argparse
from pathlib import Path

from doro_nlu.train.evaluate import Report, table
from doro_nlu.train.frames import FRAMES, frames_of

_CARD = """# Bi-LSTM tagger

Word embedding (48) + character CNN (96) -> two Bi-LSTM layers (96 per direction) -> 15 BIO labels.
{parameters} parameters; ONNX opset 17, dynamic batch and length; {bytes} bytes.

- Licence: Apache-2.0. No pretrained weights, no third-party text.
- Data: sentences of the seeded generator in `doro_nlu/train` (word lists and {frames} frames written
  for this project), fresh for every step: {sentences} sentences. {held_out} frames are held out.
- Command: `OMP_NUM_THREADS=1 python -m doro_nlu.train --seed {seed} --steps {steps} --batch {batch} --rate {rate} --out DIR`
- Largest difference between torch's and ONNX's logits: {parity:.1e}
- sha256 of model.onnx: `{sha256}`
- Limits: English only; labels are those of seven types; what it was not built for is labelled O or wrong.
"""  # noqa: E501


def write_card(
    out: Path,
    arguments: argparse.Namespace,
    reports: dict[str, Report],
    *,
    parameters: int,
    parity: float,
    sha256: str,
) -> None:
    """Write ``README.md``: data, seed, command, figures per label, licence, digest."""
    text = _CARD.format(
        parameters=parameters,
        bytes=(out / "model.onnx").stat().st_size,
        frames=sum(len(frames) for frames in FRAMES.values()),
        held_out=sum(len(frames_of(kind, True)) for kind in FRAMES),
        sentences=arguments.steps * arguments.batch,
        seed=arguments.seed,
        steps=arguments.steps,
        batch=arguments.batch,
        rate=arguments.rate,
        parity=parity,
        sha256=sha256,
    )
    for name, report in reports.items():
        text += f"\n## Figures: {name}\n\n{table(report)}\n"
    (out / "README.md").write_text(text, encoding="utf-8")
