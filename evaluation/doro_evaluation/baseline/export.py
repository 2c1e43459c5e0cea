"""A trained baseline as ONNX: ``python -m doro_evaluation.baseline.export --run DIR --out DIR``.

Writes the encoder and one step of the decoder, weights in int8 (``--float`` keeps float32), with
vocabulary, digests, loss curve and a card; then compares with torch on examples.
"""

from __future__ import annotations

import argparse
import hashlib
import shutil
import tempfile
from pathlib import Path

import msgspec
import numpy as np
import onnxruntime as ort
import torch
from onnxruntime import quantization
from torch import Tensor, nn
from torch.nn import functional

from doro_evaluation.baseline.model import DECODER, ENCODER, VOCABULARY
from doro_evaluation.baseline.network import EncoderDecoder
from doro_evaluation.baseline.text import BEGIN, INPUT_PIECES, VocabularyFile
from doro_evaluation.baseline.train import CHECKPOINT, LOG, SETTINGS, Settings
from doro_nlu.train.encoder_model import HEADS

OPSET = 18


class EncoderPart(nn.Module):  # type: ignore[misc, unused-ignore]
    """Pieces (1, p) to keys and values of the decoder's layers (layers, 2, heads, p, width)."""

    def __init__(self, model: EncoderDecoder) -> None:
        super().__init__()
        self.model = model

    def forward(self, pieces: Tensor) -> Tensor:
        states = self.model.encoder.states(pieces, torch.ones_like(pieces, dtype=torch.float32))
        return torch.stack([layer.seen(states)[:, 0] for layer in self.model.layers])


class DecoderPart(nn.Module):  # type: ignore[misc, unused-ignore]
    """One step: last piece (1, 1), its place (1,), past and seen to logits (pieces,) and past."""

    def __init__(self, model: EncoderDecoder) -> None:
        super().__init__()
        self.model = model

    def forward(
        self, piece: Tensor, place: Tensor, past: Tensor, seen: Tensor
    ) -> tuple[Tensor, Tensor]:
        x = self.model.embedded(piece, self.model.encoder.positions[place])
        grown = []
        for number, layer in enumerate(self.model.layers):
            query, key, value = layer.own(x)
            key = torch.cat([past[number, 0][None], key], dim=2)
            value = torch.cat([past[number, 1][None], value], dim=2)
            grown.append(torch.stack([key[0], value[0]]))
            x = layer.after_own(x, _attention(query, key, value))
            asked = layer.ask(x).view(1, 1, HEADS, -1).transpose(1, 2)
            mixed = _attention(asked, seen[number, 0][None], seen[number, 1][None])
            found = layer.take(mixed.transpose(1, 2).reshape(1, 1, -1))
            x = layer.norm_seen(x + found)
            x = layer.norm2(x + layer.down(functional.gelu(layer.up(x))))
        return self.model.logits(x)[0, 0], torch.stack(grown)


def _attention(query: Tensor, key: Tensor, value: Tensor) -> Tensor:
    scores = query @ key.transpose(-1, -2) / query.shape[-1] ** 0.5
    return torch.softmax(scores, dim=-1) @ value


def restored(run: Path) -> tuple[EncoderDecoder, Settings, str]:
    """Return the model of a run's last checkpoint, the run's settings and its loss curve."""
    settings = msgspec.json.decode((run / SETTINGS).read_bytes(), type=Settings)
    model = EncoderDecoder(
        len(settings.pieces), INPUT_PIECES, layers=settings.layers, hidden=settings.hidden
    )
    state = torch.load(run / CHECKPOINT, weights_only=True)
    model.load_state_dict(state["model"])
    model.eval()
    return model, settings, state["log"]


def export(model: EncoderDecoder, out: Path) -> None:
    """Write both parts in float32."""
    width = model.norm.normalized_shape[0] // HEADS
    layers = len(model.layers)
    pieces = torch.tensor([[BEGIN, 5, 6, 7, 8]])
    length, places = torch.export.Dim("length", max=INPUT_PIECES), torch.export.Dim("places")
    torch.onnx.export(
        EncoderPart(model),
        (pieces,),
        out / ENCODER,
        input_names=["pieces"],
        output_names=["seen"],
        dynamic_shapes=({1: length},),
        opset_version=OPSET,
        dynamo=True,
        external_data=False,
    )
    seen = torch.zeros(layers, 2, HEADS, 5, width)
    past = torch.zeros(layers, 2, HEADS, 3, width)
    torch.onnx.export(
        DecoderPart(model),
        (torch.tensor([[BEGIN]]), torch.tensor([3]), past, seen),
        out / DECODER,
        input_names=["piece", "place", "past", "seen"],
        output_names=["logits", "grown"],
        dynamic_shapes=(None, None, {3: places}, {3: length}),
        opset_version=OPSET,
        dynamo=True,
        external_data=False,
    )


def quantized(source: Path, out: Path) -> None:
    """Write a file with its matrices in int8, 7 bits so that no processor overflows."""
    kind = quantization.QuantType.QInt8  # type: ignore[attr-defined]
    quantization.quantize_dynamic(  # type: ignore[attr-defined]
        source, out, per_channel=True, reduce_range=True, weight_type=kind
    )


def parity(model: EncoderDecoder, directory: Path, vocabulary: int) -> float:
    """Return the largest difference of logits between torch and the files, on random pieces."""
    encoder, decoder = (
        ort.InferenceSession(  # type: ignore[attr-defined]
            str(directory / name), providers=["CPUExecutionProvider"]
        )
        for name in (ENCODER, DECODER)
    )
    rng = np.random.default_rng(0)
    pieces = rng.integers(4, vocabulary, (1, 60))
    written = np.concatenate([[[BEGIN]], rng.integers(4, vocabulary, (1, 20))], axis=1)
    with torch.no_grad():
        mask = torch.ones(pieces.shape)
        theirs = model(torch.from_numpy(pieces), mask, torch.from_numpy(written)).numpy()[0]
    seen = np.asarray(encoder.run(None, {"pieces": pieces})[0])
    past = np.zeros((seen.shape[0], 2, HEADS, 0, seen.shape[-1]), np.float32)
    worst = 0.0
    for place, piece in enumerate(written[0]):
        given = {"piece": np.array([[piece]]), "place": np.array([place])}
        found = decoder.run(None, {**given, "past": past, "seen": seen})
        logits, past = (np.asarray(array) for array in found)
        worst = max(worst, float(np.abs(logits - theirs[place]).max()))
    return worst


def main() -> None:
    """Export, quantise, check, and write vocabulary and loss curve."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--float", action="store_true", help="keep float32")
    arguments = parser.parse_args()
    model, settings, log = restored(arguments.run)
    arguments.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as name:
        full = Path(name)
        export(model, full)
        print(f"parity float32 {parity(model, full, len(settings.pieces)):.2e}")
        for file in (ENCODER, DECODER):
            write = shutil.copyfile if arguments.float else quantized
            write(full / file, arguments.out / file)
    digests = {
        file: hashlib.sha256((arguments.out / file).read_bytes()).hexdigest()
        for file in (ENCODER, DECODER)
    }
    found = VocabularyFile(settings.pieces, digests)
    (arguments.out / VOCABULARY).write_bytes(msgspec.json.encode(found) + b"\n")
    (arguments.out / LOG).write_text(log + "\n", encoding="utf-8")
    print(f"parity as written {parity(model, arguments.out, len(settings.pieces)):.2e}")


if __name__ == "__main__":
    main()
