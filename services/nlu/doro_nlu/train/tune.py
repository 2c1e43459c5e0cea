"""Fine-tune a shipped encoder on own labels: ``python -m doro_nlu.train.tune DATA --out DIR``.

Goes on from the weights inside the int8 model, so that nothing has to be fetched; half of the
batches are generated sentences, against forgetting. Needs the extra ``train`` (torch, onnx).
Writes ``model.onnx``, ``vocabulary.json``, ``README.md`` (the table before and after) and
``training.log``; the service takes the directory as ``nlu.model_dir``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from doro_nlu.encoder import EncoderTagger, Pieces
from doro_nlu.onnx_files import VOCABULARY_FILE, read_vocabulary
from doro_nlu.tagger import SHIPPED
from doro_nlu.train.annotate import Example
from doro_nlu.train.evaluate import LabelScore, Report, evaluate, held_out_examples
from doro_nlu.train.tune_data import Split, extended, read_annotations, split
from doro_nlu.train.tune_job import Job
from doro_schemas.errors import Refused

GENERATED_SENTENCES = 1000
Reports = dict[str, tuple[Report, Report]]
"""Test set to the reports before and after."""


def tune(job: Job) -> Reports:
    """Train, write the model and return the reports before and after.

    Raises:
        Refused: the data or the model does not fit, or torch is not installed.
    """
    model = job.model or SHIPPED["default"]
    vocabulary = read_vocabulary(model / VOCABULARY_FILE, Pieces)
    examples = read_annotations(job.data, vocabulary.labels, extend=job.extend)
    if job.out.exists() and not job.out.is_dir():
        raise Refused(f"{job.out} is a file: name a directory to write")
    if job.out.resolve() == model.resolve():
        raise Refused(f"{job.out} holds the model to start from: name another directory")
    try:
        import doro_nlu.train.tune_fit as trainer  # noqa: PLC0415 - torch is an extra
    except ImportError as error:
        raise Refused(
            f"fine-tuning needs torch and onnx ({error}): pip install 'doro-nlu[train]'"
        ) from error
    before = EncoderTagger(model)
    labels = extended(vocabulary.labels, examples)
    parts = split(examples, job.seed)
    job.out.mkdir(parents=True, exist_ok=True)
    log = trainer.train(job, model, vocabulary, labels, parts)
    reports = compare(before, EncoderTagger(job.out), parts.test, job.seed)
    text = card(job, reports, parts)
    (job.out / "README.md").write_text(text, encoding="utf-8")
    (job.out / "training.log").write_text("\n".join(log) + "\n", encoding="utf-8")
    return reports


def compare(before: EncoderTagger, after: EncoderTagger, own: list[Example], seed: int) -> Reports:
    """Return the reports of two taggers on the user's held-out share and on generated ones."""
    sets = {
        "own sentences, held out": own,
        "generated, templates never trained on": held_out_examples(seed)[:GENERATED_SENTENCES],
    }
    return {
        name: (evaluate(before, examples), evaluate(after, examples))
        for name, examples in sets.items()
    }


def table(reports: Reports) -> str:
    """Return the reports before and after as a Markdown table; labels that occur only."""
    heads = "".join(f" {name}, before | after |" for name in reports)
    rows = [f"| F1 of |{heads}", "|---|" + "---|---|" * len(reports)]
    labels = dict.fromkeys(label for _, after in reports.values() for label in after.labels)
    for label in labels:
        pairs = [(before.labels.get(label), after.labels.get(label))
                 for before, after in reports.values()]  # fmt: skip
        if any(score and score.support for pair in pairs for score in pair):
            rows.append(f"| {label} |" + "".join(_cells(pair) for pair in pairs))
    for title, metric in (("weighted without O", "weighted_f1"), ("entities", "entity_f1"),
                          ("sentences all right", "sentence_accuracy"),
                          ("sentences", "sentences")):  # fmt: skip
        cells = [f" {getattr(before, metric):.4g} | {getattr(after, metric):.4g} |"
                 for before, after in reports.values()]  # fmt: skip
        rows.append(f"| {title} |" + "".join(cells))
    return "\n".join(rows)


def _cells(scores: Sequence[LabelScore | None]) -> str:
    shown = (f"{score.f1:.3f}" if score and score.support else "-" for score in scores)
    return "".join(f" {text} |" for text in shown)


def card(job: Job, reports: Reports, parts: Split) -> str:
    """Return the model card: data, settings and the table."""
    start = "the shipped default" if job.model is None else job.model.name
    return (
        f"# Fine-tuned tagger\n\nFrom {start}, on {len(parts.train)} sentences of"
        f" {job.data.name}; {len(parts.test)} were held out. {job.steps} steps of {job.batch},"
        f" half of them generated; rate {job.rate}, seed {job.seed}.\n\n{table(reports)}\n"
    )


def main() -> None:
    """Tune and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--model", type=Path, help="an encoder's directory; default: the shipped")
    parser.add_argument("--extend", action="store_true", help="learn types not known yet")
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--batch", type=int, default=16)
    parser.add_argument("--rate", type=float, default=1e-4)
    parser.add_argument("--seed", type=int, default=7)
    try:
        print(table(tune(Job(**vars(parser.parse_args())))))
    except Refused as refused:
        sys.exit(f"tune: {refused.reason}")


if __name__ == "__main__":
    main()
