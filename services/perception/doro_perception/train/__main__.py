"""Trains one network: ``python -m doro_perception.train NETWORK --data DIR --out DIR``.

The networks: ``proposer``, and two that name crops, ``crops`` (from COCO's boxes) and ``names``
(from ImageNet's names), which one file joins.

Resumable: a checkpoint is written every two minutes and taken up again; the learning rate falls
with the processor time trained (``--minutes`` in total over all runs). The log says seed, command
and loss.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TextIO

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from doro_perception.train import crops, proposer
from doro_perception.train.backbone import COCO, read_weights, scaled
from doro_perception.train.shards import Frame, Shards, prefetched

NETWORKS = ("proposer", "crops", "names")
SAVE_S, REFRESH_STEPS, LOG_STEPS = 120.0, 150, 25
# Half of the time the proposer looks at windows of 288 px, twice as many.
WINDOW_PX, WINDOW_SHARE = 288, 0.5
WARM_STEPS, LAST_SHARE = 60, 0.02
RESTYLED_SHARE, PLAIN_SHARE = 0.3, 0.6
BACKBONE_RATE, USUAL_WEIGHT = 0.3, 0.03
ATTRIBUTE_WEIGHTS = (0.5, 1.0)
"""Of the losses of colour and material, beside the class."""


@dataclass
class State:
    """What a checkpoint holds besides the networks."""

    steps: int = 0
    trained_s: float = 0.0
    recent: list[tuple[float, ...]] = field(default_factory=list)


class Trainer:
    """One network, its average (EMA), its optimiser and its checkpoint."""

    def __init__(self, model: nn.Module, arguments: argparse.Namespace) -> None:
        self.model = model.to(memory_format=torch.channels_last)
        self.total_s = arguments.minutes * 60
        self.path = arguments.out / f"{arguments.network}.pt"
        named = list(model.named_parameters())
        self.rates = [arguments.rate * pace(name, values) for name, values in named]
        self.optimizer = torch.optim.AdamW(
            [{"params": [values]} for _, values in named],
            lr=arguments.rate,
            weight_decay=arguments.decay,
        )
        self.average = {k: v.clone() for k, v in model.state_dict().items()}
        self.state, self.new_weights = State(), 0
        if self.path.exists():
            self._load()
        elif arguments.start is not None:
            # The average of an earlier run; its optimiser and its steps are not taken.
            saved = torch.load(arguments.start / self.path.name, weights_only=True)["average"]
            lacking, strange = model.load_state_dict(saved, strict=False)
            if strange:
                raise SystemExit(f"{arguments.start} has weights of another network: {strange[0]}")
            self.new_weights = len(lacking)
            self.average = {k: v.clone() for k, v in model.state_dict().items()}

    @property
    def share(self) -> float:
        """How much of the time is used up."""
        return min(1.0, self.state.trained_s / float(self.total_s))

    def _load(self) -> None:
        saved = torch.load(self.path, weights_only=True)
        self.model.load_state_dict(saved["model"])
        self.optimizer.load_state_dict(saved["optimizer"])
        self.average = saved["average"]
        self.state = State(saved["steps"], saved["trained_s"])

    def save(self) -> None:
        saved = {
            "model": self.model.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "average": self.average,
            "steps": self.state.steps,
            "trained_s": self.state.trained_s,
        }
        partial = self.path.with_suffix(".part")
        torch.save(saved, partial)
        partial.rename(self.path)

    def step(self, loss: Tensor) -> None:
        falling = LAST_SHARE + (1 - LAST_SHARE) * 0.5 * (1 + math.cos(math.pi * self.share))
        warm = min(1.0, (self.state.steps + 1) / WARM_STEPS)
        for group, rate in zip(self.optimizer.param_groups, self.rates, strict=True):
            group["lr"] = rate * warm * falling
        self.optimizer.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(self.model.parameters(), 10.0)
        self.optimizer.step()
        self.state.steps += 1
        keep = min(0.998, (1 + self.state.steps) / (10 + self.state.steps))
        with torch.no_grad():
            for name, value in self.model.state_dict().items():
                if value.dtype.is_floating_point:
                    self.average[name].mul_(keep).add_(value, alpha=1 - keep)
                else:
                    self.average[name].copy_(value)


def pace(name: str, values: Tensor) -> float:
    """Return the share of the rate at which one tensor learns.

    The backbones' batch norms are folded into their convolutions, so that some have weights of
    0.03 and others of 0.4; equal steps would leave the latter nearly as they are. The sizes are
    those that the backbone begins with, so that a resumed run goes on in the same steps.
    """
    if not name.startswith("backbone."):
        return 1.0
    if name.endswith("bias"):
        return BACKBONE_RATE
    size = float(values.detach().square().mean().sqrt())
    return BACKBONE_RATE * math.sqrt(size / USUAL_WEIGHT)


def untrained(network: str) -> nn.Module:
    """Return a network with the backbone it begins from."""
    if network == "proposer":
        return proposer.Proposer(read_weights(COCO))
    return crops.names_net() if network == "names" else crops.boxes_net()


def propose_losses(model: nn.Module, given: Any) -> tuple[Tensor, tuple[float, ...]]:
    images, wanted, plain = given
    x = scaled(images).contiguous(memory_format=torch.channels_last)
    with torch.autocast("cpu", torch.bfloat16):
        heads = model(x, (torch.rand(len(x)) < RESTYLED_SHARE) & ~plain)
    total, parts = torch.zeros(()), []
    for (heat, edges), target, stride in zip(heads, wanted, proposer.STRIDES, strict=True):
        names, boxes = proposer.losses(heat, edges, target, stride)
        total = total + names + 2 * boxes
        parts += [names.item(), boxes.item()]
    return total, tuple(parts)


def crop_losses(model: nn.Module, given: Any) -> tuple[Tensor, tuple[float, ...]]:
    images, labels, plain = given
    x = scaled(images).contiguous(memory_format=torch.channels_last)
    restyled = (torch.rand(len(x)) < RESTYLED_SHARE) & ~plain
    with torch.autocast("cpu", torch.bfloat16):
        found = [item.float() for item in model(x, restyled)]
    # Another style changes colours and how a surface shines.
    labels[restyled, 1:] = -1
    wanted = labels.T
    total = functional.cross_entropy(found[0], wanted[0], label_smoothing=0.05)
    parts = [total.item(), (found[0].argmax(1) == wanted[0]).float().mean().item()]
    for logit, want, weight in zip(found[1:], wanted[1:], ATTRIBUTE_WEIGHTS, strict=True):
        total = total + weight * functional.cross_entropy(logit, want, ignore_index=-1)
        known = want >= 0
        parts.append((logit.argmax(1) == want)[known].float().mean().item())
    return total, tuple(parts)


def counted(shards: Shards) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return how many boxes each class has, the nameless last."""
    kinds = np.concatenate([f.kind[~f.ignore & (f.kind >= 0)] for f in shards.frames])
    return np.bincount(kinds, minlength=crops.KINDS - 1).astype(np.float64)


def shared_out(
    frames: list[Frame], worth: np.ndarray[Any, np.dtype[np.float64]]
) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return how likely each frame is taken: a share are plain ones, where there are both."""
    plain = np.array([frame.plain for frame in frames])
    if plain.any() and not plain.all():
        shares = PLAIN_SHARE / worth[plain].sum(), (1 - PLAIN_SHARE) / worth[~plain].sum()
        worth = worth * np.where(plain, *shares)
    odds: np.ndarray[Any, np.dtype[np.float64]] = worth / worth.sum()
    return odds


def batches(network: str, shards: Shards, size: int, seed: int, trainer: Trainer) -> Iterator[Any]:
    """Yield endless batches; new shards are taken in as they come."""
    numbers = {"made": 0}
    odds: dict[str, Any] = {}

    def weigh() -> None:
        rare = 1 / np.sqrt(counted(shards) + 30)
        odds["kinds"] = rare
        worth = [
            1 + 8 * float(rare[f.kind[~f.ignore & (f.kind >= 0)]].sum()) for f in shards.frames
        ]
        odds["frames"] = shared_out(shards.frames, np.minimum(worth, 6.0))
        odds["any"] = shared_out(shards.frames, np.ones(len(worth)))

    def make(rng: np.random.Generator) -> Any:
        if numbers["made"] % REFRESH_STEPS == 0:
            shards.refresh()
            weigh()
        numbers["made"] += 1
        if network == "proposer":
            side_px = WINDOW_PX if trainer.share < WINDOW_SHARE else proposer.SIDE_PX
            return proposer.batch(shards.frames, odds["frames"], size, rng, side_px)
        return crops.batch(shards.frames, odds["any"], odds["kinds"], size, rng)

    return prefetched(make, seed)


def opened_log(arguments: argparse.Namespace, frames: int, trainer: Trainer) -> TextIO:
    """Return the log of a network, with what repeats the run at its end."""
    path: Path = arguments.out / f"{arguments.network}.log"
    log = path.open("a", buffering=1)
    log.write(f"# {' '.join(sys.argv)}\n# seed {arguments.seed}, {frames} frames\n")
    if trainer.new_weights:
        log.write(f"# {arguments.start} lacks {trainer.new_weights} tensors: begun untrained\n")
    return log


def main() -> None:
    """Train until the minutes are used up."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("network", choices=NETWORKS)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--minutes", type=float, default=40)
    parser.add_argument("--start", type=Path, help="folder of an earlier run to begin from")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--batch", type=int, default=0)
    parser.add_argument("--log-steps", type=int, default=LOG_STEPS)
    parser.add_argument("--rate", type=float, default=1.5e-3)
    parser.add_argument("--decay", type=float, default=1e-4)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    torch.manual_seed(arguments.seed)
    shards = Shards(arguments.data)
    proposing = arguments.network == "proposer"
    model = untrained(arguments.network)
    trainer = Trainer(model, arguments)
    trainer.model.train()
    log = opened_log(arguments, len(shards.frames), trainer)
    size = arguments.batch or (16 if proposing else 64)
    compute = propose_losses if proposing else crop_losses
    # A resumed run sees other batches than the first: the seed goes on with the steps.
    seed = arguments.seed + trainer.state.steps
    source = batches(arguments.network, shards, size, seed, trainer)
    # Time of the processor: on a shared core the rate falls with what was done, not with waiting.
    last = saved = time.process_time()
    while trainer.state.trained_s < trainer.total_s:
        loss, parts = compute(trainer.model, next(source))
        trainer.step(loss)
        now = time.process_time()
        trainer.state.trained_s += now - last
        last = now
        trainer.state.recent.append(parts)
        if trainer.state.steps % arguments.log_steps == 0:
            mean = np.nanmean(np.array(trainer.state.recent), axis=0).round(3).tolist()
            trainer.state.recent.clear()
            rate = trainer.state.steps * size / max(trainer.state.trained_s, 1e-6)
            log.write(
                f"{trainer.state.trained_s:.0f} s, step {trainer.state.steps},"
                f" {len(shards.frames)} frames, {rate:.1f} samples/s: {mean}\n"
            )
        if now - saved > SAVE_S:
            trainer.save()
            saved = now
    trainer.save()
    log.write(f"# done after {trainer.state.steps} steps\n")


if __name__ == "__main__":
    main()
