"""A teacher's label probabilities on human sentences, for a smaller model to learn from.

``python -m doro_nlu.train.teach --checkpoint RUN/checkpoint.pt --base DIR --texts FILE...
--out SOFT.npz``. Kept are English sentences of which the parser can use every relation label, and
which do not leave open whether a device is the target.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch

from doro_nlu.decode import Decoder
from doro_nlu.labels import LABELS
from doro_nlu.onnx_files import Tagged
from doro_nlu.tagger import load_tagger
from doro_nlu.tokens import tokenize
from doro_nlu.train.annotate import Example
from doro_nlu.train.encoder_data import Target, arrays, hard, read_pieces, write_soft
from doro_nlu.train.encoder_model import Encoder
from doro_nlu.train.weak import MAX_TOKENS, read_texts, usable
from doro_nlu.train.weights import PIECES_FILE
from doro_nlu.wordpiece import ROW_PIECES

_BATCH = 32
_DEVICE_VERBS = frozenset(("open", "close", "shut", "switch", "unlock", "on", "off", "press"))


def load_teacher(checkpoint: Path, base: Path) -> tuple[Encoder, dict[str, int]]:
    """Return the model of a training run, and its pieces."""
    names, _ = read_pieces(base / PIECES_FILE)
    state = torch.load(checkpoint, weights_only=True)["model"]
    layers = 1 + max(int(name.split(".")[1]) for name in state if name.startswith("layers."))
    model = Encoder(len(names), ROW_PIECES, len(LABELS), layers=layers,
                    hidden=state["words.weight"].shape[1],
                    inner=state["layers.0.up.bias"].shape[0])  # fmt: skip
    model.load_state_dict(state)
    return model.eval(), {piece: index for index, piece in enumerate(names)}


def probabilities(
    model: Encoder, pieces: dict[str, int], sentences: Sequence[list[str]]
) -> list[Target]:
    """Return the sentences with the model's label probabilities, in their order."""
    found: dict[int, Target] = {}
    order = sorted(range(len(sentences)), key=lambda at: len(sentences[at]))
    for start in range(0, len(order), _BATCH):
        batch = order[start : start + _BATCH]
        plain = [hard(Example(sentences[at], ["O"] * len(sentences[at]))) for at in batch]
        ids, mask, wanted = arrays(plain, pieces)
        with torch.no_grad(), torch.autocast("cpu", torch.bfloat16):
            logits = model(ids, mask)
        shares = torch.softmax(logits.float(), dim=-1).numpy()
        places = wanted.sum(dim=-1).numpy() > 0
        for row, at in enumerate(batch):
            found[at] = Target(sentences[at], shares[row][places[row]])
    return [found[at] for at in range(len(sentences))]


def unsettled(target: Target, labels: Sequence[str]) -> bool:
    """Tell whether a sentence opens or switches something and the teacher finds no object in it.

    Whether "open the drawer" is the request or a side action hangs on what the sentence is a step
    of, which is not in the text; the generator settles it.
    """
    verbs = {token.lower() for token in target.tokens} & _DEVICE_VERBS
    return bool(verbs) and "B-object" not in labels


def main() -> None:
    """Write the teacher's probabilities."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--checkpoint", type=Path, required=True)
    parser.add_argument("--base", type=Path, required=True)
    parser.add_argument("--texts", type=Path, nargs="+", required=True)
    parser.add_argument("--most", type=int, default=0, help="sentences, evenly spread; 0 = all")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    model, pieces = load_teacher(arguments.checkpoint, arguments.base)
    tokens = [tokenize(text) for text in read_texts(arguments.texts)]
    tokens = [item for item in tokens if 0 < len(item) <= MAX_TOKENS]
    if arguments.most:
        tokens = [tokens[at * len(tokens) // arguments.most] for at in range(arguments.most)]
    decoder, words = Decoder(LABELS), load_tagger()
    kept = []
    for target in probabilities(model, pieces, tokens):
        labels, sure = decoder.decode(np.log(target.wanted + 1e-9))
        if usable(Tagged(target.tokens, labels, sure), words) and not unsettled(target, labels):
            kept.append(target)
    write_soft(arguments.out, kept)
    print(f"{len(kept)} of {len(tokens)} sentences kept")


if __name__ == "__main__":
    main()
