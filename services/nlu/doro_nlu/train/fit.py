"""The training loop of both networks: cosine rate, checkpoints, a line of log per 100 steps."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import torch
from torch import Tensor, nn

from doro_nlu.train.encoder_data import Target

CHECKPOINT = "checkpoint.pt"
Run = Callable[[list[Target]], tuple[Tensor, Tensor]]
"""A batch to logits and wanted probabilities, (b, t, labels) each."""
_LOG_EVERY = 100


class Plan(msgspec.Struct, frozen=True):
    """How to train.

    Attributes:
        steps, rate: number of batches, and highest learning rate (warm-up of 100, then cosine).
        head_boost: factor on the rate of the label head (for labels that it begins with).
        bf16: compute in bfloat16 (the weights stay float32); twice as fast where the processor
            has it.
        save_every: steps between checkpoints; 0 = none.
    """

    steps: int
    rate: float
    bf16: bool = False
    head_boost: float = 1.0
    save_every: int = 300


def soft_loss(logits: Tensor, wanted: Tensor) -> Tensor:
    """Return the cross entropy against probabilities (..., labels); all-zero rows do not count."""
    losses = -(wanted * torch.log_softmax(logits.float(), dim=-1)).sum(dim=-1)
    return losses.sum() / wanted.sum().clamp(min=1.0)


def fit(
    model: nn.Module,
    run: Run,
    source: Iterator[list[Target]],
    plan: Plan,
    *,
    out: Path,
    log: list[str],
) -> None:
    """Train the model on batches of ``source``, going on from a checkpoint in ``out``."""
    trained = [parameter for parameter in model.parameters() if parameter.requires_grad]
    head = {id(parameter) for parameter in getattr(model, "head", nn.Identity()).parameters()}
    body = [parameter for parameter in trained if id(parameter) not in head]
    top = [parameter for parameter in trained if id(parameter) in head]
    groups = [{"params": body, "boost": 1.0}, {"params": top, "boost": plan.head_boost}]
    optimizer = torch.optim.AdamW(groups, lr=plan.rate, weight_decay=0.01)
    first = _resume(out / CHECKPOINT, model, optimizer, source, log)
    began, running = time.monotonic(), 0.0
    model.train()
    for step in range(first, plan.steps):
        for group in optimizer.param_groups:
            warm = min(1.0, (step + 1) / min(100, 1 + plan.steps // 4))
            share = warm * 0.5 * (1 + math.cos(math.pi * step / plan.steps))
            group["lr"] = plan.rate * group["boost"] * share
        batch = next(source)
        with torch.autocast("cpu", torch.bfloat16, enabled=plan.bf16):
            logits, wanted = run(batch)
        loss = soft_loss(logits, wanted)
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(trained, 1.0)
        optimizer.step()
        running += float(loss.detach())
        if (step + 1) % _LOG_EVERY == 0:
            elapsed_s = time.monotonic() - began
            log.append(f"step {step + 1} of {plan.steps} loss {running / _LOG_EVERY:.4f}"
                       f" ({elapsed_s:.0f} s)")  # fmt: skip
            print(log[-1], flush=True)
            running = 0.0
        if plan.save_every and ((step + 1) % plan.save_every == 0 or step + 1 == plan.steps):
            torch.save({"model": model.state_dict(), "optimizer": optimizer.state_dict(),
                        "step": step + 1, "log": log, "random": torch.get_rng_state()},
                       out / CHECKPOINT)  # fmt: skip
    model.eval()


def _resume(
    path: Path,
    model: nn.Module,
    optimizer: torch.optim.Optimizer,
    source: Iterator[list[Target]],
    log: list[str],
) -> int:
    """Load a checkpoint if there is one; return the step to go on with, the data brought there."""
    if not path.is_file():
        return 0
    state = torch.load(path, weights_only=True)
    model.load_state_dict(state["model"])
    optimizer.load_state_dict(state["optimizer"])
    torch.set_rng_state(state["random"])
    log[:] = [*state["log"], f"resumed at step {state['step']}"]
    for _ in range(state["step"]):
        next(source)
    return int(state["step"])
