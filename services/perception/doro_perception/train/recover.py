"""Makes checkpoints of the shipped files: ``python -m doro_perception.train.recover --models DIR
--data DIR --out DIR``.

Whoever has only the repository can teach the networks further with ``--start DIR``: int8 weights
become float32 again (each within half a step of what it was), and the batch norms that the export
folded into convolutions come back with the statistics of training frames.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from onnx import numpy_helper
from torch import Tensor, nn

from doro_perception.captioner import PACKAGED_FOLDER
from doro_perception.train import proposer
from doro_perception.train.__main__ import untrained
from doro_perception.train.backbone import scaled
from doro_perception.train.shards import Shards

PREFIXES = {"proposer": "model.", "crops": "models.0.", "names": "models.1."}
FILES = {"proposer": "proposer.onnx", "crops": "crops.onnx", "names": "crops.onnx"}
STATISTICS_BATCHES, BATCH, SEED = 12, 8, 7
Values = NDArray[np.float32]


class Constants:
    """The constants of a file, int8 ones as the float32 that they stand for."""

    def __init__(self, graph: Any) -> None:
        self._graph = graph
        self._stored = {item.name: numpy_helper.to_array(item) for item in graph.initializer}
        self._makers = {name: node for node in graph.node for name in node.output}

    def __getitem__(self, name: str) -> Values | None:
        """Return a constant; None where the tensor depends on the input."""
        if name in self._stored:
            return np.asarray(self._stored[name], np.float32)
        node = self._makers.get(name)
        if node is None or node.op_type not in ("DequantizeLinear", "Cast", "Mul"):
            return None
        numbers = self[node.input[0]]
        if node.op_type == "Cast":
            return numbers
        scale = self[node.input[1]]
        if numbers is None or scale is None:
            return None
        if scale.ndim == 1 and len(scale) > 1:  # per channel, the first axis
            scale = scale.reshape(-1, *[1] * (numbers.ndim - 1))
        return np.asarray(numbers * scale, np.float32)

    def of_modules(self) -> dict[str, Values]:
        """Return constants by the path of the module that they belong to.

        Those that kept their names have them; of the others the name of the node tells the module.
        """
        found = {}
        for node in self._graph.node:
            if node.op_type not in ("Conv", "Gemm"):
                continue
            for part, name in zip(("weight", "bias"), node.input[1:3], strict=False):
                values = self[name]
                if values is not None:
                    found[f"{module_of(node.name)}.{part}"] = values
        for name in [*self._stored, *self._makers]:
            values = self[name]
            if values is not None:
                found[name.removesuffix("_DequantizeLinear_Output")] = values
        return found


def module_of(node: str) -> str:
    """Return the path of the module that a node was exported from: of
    ``/model/deep5/steps.0/steps.0.3/Conv`` it is ``model.deep5.steps.0.3``.
    """
    parts: list[str] = []
    for word in node.strip("/").split("/")[:-1]:
        if parts and (word == parts[-1] or word.startswith(parts[-1] + ".")):
            parts[-1] = word
        else:
            parts.append(word)
    return ".".join(parts)


def recovered(network: str, models: Path) -> nn.Module:
    """Return a network with the weights of a file; its batch norms only add what they added."""
    constants = Constants(onnx.load(str(models / FILES[network])).graph).of_modules()
    model, prefix = untrained(network), PREFIXES[network]
    norms = {name for name, item in model.named_modules() if isinstance(item, nn.BatchNorm2d)}
    state = model.state_dict()
    for name, value in state.items():
        module, _, part = name.rpartition(".")
        if part == "num_batches_tracked":
            continue
        if module in norms:
            before = f"{module.rpartition('.')[0]}.{int(module.rpartition('.')[2]) - 1}"
            values = _folded(part, constants[f"{prefix}{before}.bias"])
        elif prefix + name in constants:
            values = constants[prefix + name]
        else:
            raise SystemExit(f"{models / FILES[network]} lacks {name}: it is of another network")
        value.copy_(torch.from_numpy(np.array(values)).reshape(value.shape))
    return model.eval()


def _folded(part: str, bias: Values) -> Values:
    """Return a tensor of a batch norm that adds the bias and does nothing else."""
    if part == "bias":
        return bias
    if part == "running_var":
        return np.full_like(bias, 1 - 1e-5)
    return np.full_like(bias, float(part == "weight"))


def measure_norms(model: nn.Module, shards: Shards) -> None:
    """Give the batch norms the statistics of training frames, so that they add and scale to the
    same as before, in training as well.
    """
    norms = [item for item in model.modules() if isinstance(item, nn.BatchNorm2d)]
    sums = {norm: torch.zeros(2, norm.num_features, dtype=torch.float64) for norm in norms}
    counts = dict.fromkeys(norms, 0)

    def note(norm: nn.Module, given: tuple[Tensor, ...]) -> None:
        x = given[0].double()
        sums[norm] += torch.stack([x.sum((0, 2, 3)), (x * x).sum((0, 2, 3))])
        counts[norm] += x.numel() // x.shape[1]

    hooks = [norm.register_forward_pre_hook(note) for norm in norms]
    rng = np.random.default_rng(SEED)
    odds = np.full(len(shards.frames), 1 / len(shards.frames))
    with torch.no_grad():
        for _ in range(STATISTICS_BATCHES):
            images, _, _ = proposer.batch(shards.frames, odds, BATCH, rng)
            model(scaled(images))
    for hook in hooks:
        hook.remove()
    for norm, both in sums.items():
        mean, squares = both / counts[norm]
        spread = squares - mean * mean
        norm.running_mean.copy_(mean)
        norm.running_var.copy_(spread)
        norm.weight.data.copy_((spread + norm.eps).sqrt())
        norm.bias.data.add_(mean)


def main() -> None:
    """Write the checkpoints of the three networks."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", type=Path, default=PACKAGED_FOLDER)
    parser.add_argument("--data", type=Path, required=True, help="training frames")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    for file in sorted(set(FILES.values())):
        if not (arguments.models / file).exists():
            raise SystemExit(f"{arguments.models} has no {file}: give a folder of the captioner")
    shards = Shards(arguments.data)
    if not shards.frames:
        raise SystemExit(f"{arguments.data} has no frames: render some by dressing.frames first")
    arguments.out.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    for network in PREFIXES:
        model = recovered(network, arguments.models)
        if network == "proposer":
            measure_norms(model, shards)
        torch.save({"average": model.state_dict()}, arguments.out / f"{network}.pt")
        print(f"{network}: {sum(p.numel() for p in model.parameters()):,} weights", flush=True)


if __name__ == "__main__":
    main()
