"""Exports the trained networks: ``python -m doro_perception.train.export --run DIR --data DIR``.

Checkpoints (their averages) to ONNX, compared with torch, then int8: the proposer with static
ranges taken from training frames (QDQ, per channel), the crop nets with int8 weights. Writes the
two files with their sha256 and prints sizes and the largest deviations.
"""

from __future__ import annotations

import argparse
import hashlib
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import torch
from onnxruntime.quantization.calibrate import CalibrationDataReader, CalibrationMethod
from onnxruntime.quantization.quant_utils import QuantFormat, QuantType
from onnxruntime.quantization.quantize import quantize_static
from onnxruntime.quantization.shape_inference import quant_pre_process
from torch import nn

from doro_perception.crop import cut_out
from doro_perception.sessions import Session
from doro_perception.train import crops, proposer
from doro_perception.train.__main__ import untrained
from doro_perception.train.int8_weights import quantize_weights
from doro_perception.train.shards import Shards, resized

OUTPUTS = {"proposer": ["boxes", "scores", "kinds"], "crops": ["kind", "color", "material"]}
INPUTS = {"proposer": "image", "crops": "crops"}
QUANTIZED = ["Conv", "Clip", "Relu", "Add", "Gemm", "MatMul"]
CALIBRATION_FRAMES, SEED = 120, 7


class _Reader(CalibrationDataReader):  # type: ignore[misc, unused-ignore]
    """Feeds images to the quantizer, one after the other."""

    def __init__(self, name: str, images: Iterator[Any]) -> None:
        self._feeds = ({name: image} for image in images)

    def get_next(self) -> Any:
        return next(self._feeds, None)


def inputs(network: str, shards: Shards) -> Iterator[Any]:
    """Yield inputs of a network from training frames."""
    rng = np.random.default_rng(SEED)
    for k in rng.choice(len(shards.frames), CALIBRATION_FRAMES, replace=False).tolist():
        frame = shards.frames[k]
        image = frame.image()
        if network == "proposer":
            yield resized(image, proposer.SIDE_PX)[None]
            continue
        good = np.flatnonzero(~frame.ignore & (frame.kind >= 0))[:6]
        yield np.stack([cut_out(image, frame.box[number]) for number in good])


def loaded(network: str, run: Path) -> nn.Module:
    """Return the exported form of a network with the averaged weights of its checkpoints.

    ``crops`` is the mean of the nets ``crops`` and ``names``, or one of them where the other was
    not trained.
    """
    names = ["proposer"] if network == "proposer" else ["crops", "names"]
    models = []
    for name in names:
        path = run / f"{name}.pt"
        if path.exists():
            model = untrained(name)
            model.load_state_dict(torch.load(path, weights_only=True)["average"])
            models.append(model)
    exported: nn.Module
    exported = proposer.Exported(models[0]) if network == "proposer" else crops.Exported(models)
    return exported.eval()


def export(network: str, run: Path, shards: Shards, out: Path, *, int8: bool) -> None:
    """Write one network and print how far the file is from torch."""
    model = loaded(network, run)
    examples = [next(inputs(network, shards)) for _ in range(1)]
    example = torch.from_numpy(examples[0])
    path = out / f"{network}.onnx"
    digest_path = path.with_name(path.name + ".sha256")
    digest_path.unlink(missing_ok=True)  # of an earlier export: the new file is not that one
    with tempfile.TemporaryDirectory() as folder:
        plain, ready = Path(folder) / "plain.onnx", Path(folder) / "ready.onnx"
        free = {INPUTS[network]: {0: "n"}} | {name: {0: "n"} for name in OUTPUTS[network]}
        # Without gradients: wide convolutions of tiny maps are told as such, which is faster.
        with torch.no_grad():
            torch.onnx.export(
                model,
                (example,),
                str(plain),
                input_names=[INPUTS[network]],
                output_names=OUTPUTS[network],
                dynamic_axes=free if network == "crops" else None,
                opset_version=17,
                dynamo=False,
            )
        print(
            f"{network}: float32 {plain.stat().st_size / 1e6:.1f} MB,",
            _apart(model, plain, example, INPUTS[network]),
        )
        if int8 and network == "crops":
            # Static ranges would change one name in twenty.
            quantize_weights(plain, path)
        elif int8:
            quant_pre_process(str(plain), str(ready))
            quantize_static(
                str(ready),
                str(path),
                _Reader(INPUTS[network], inputs(network, shards)),
                quant_format=QuantFormat.QDQ,
                per_channel=True,
                activation_type=QuantType.QUInt8,
                weight_type=QuantType.QInt8,
                op_types_to_quantize=QUANTIZED,
                calibrate_method=CalibrationMethod.MinMax,
            )
        else:
            onnx.save(onnx.load(str(plain)), str(path))
    print(
        f"{network}: written {path.stat().st_size / 1e6:.2f} MB,",
        _apart(model, path, example, INPUTS[network]),
    )
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    digest_path.write_text(f"{digest}  {path.name}\n", encoding="utf-8")


def _apart(model: nn.Module, path: Path, example: torch.Tensor, name: str) -> str:
    """Return the largest deviations of a file's outputs from torch's."""
    session = Session(path, 1, "export it again")
    found = session.run([port.name for port in session.outputs], {name: example.numpy()})
    with torch.no_grad():
        wanted = [item.numpy() for item in model(example)]
    parts = [f"{np.abs(a - b).max():.2g}" for a, b in zip(found, wanted, strict=True)]
    return "deviates by " + ", ".join(parts)


def main() -> None:
    """Export both networks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, required=True)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", choices=("proposer", "crops"))
    parser.add_argument("--float32", action="store_true", help="without int8, to compare")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    shards = Shards(arguments.data)
    for network in ("proposer", "crops"):
        if arguments.only in (None, network):
            export(network, arguments.run, shards, arguments.out, int8=not arguments.float32)


if __name__ == "__main__":
    main()
