"""Looks for what the networks err on: ``python -m doro_perception.train.mine --models DIR
--data DIR``.

Writes beside each shard ``train-*.npz`` a file ``mined-train-*.npz`` with the proposals of its
frames, and how much the crop nets doubt the right name of each thing. They then learn on the boxes
that they get at work, what is nothing is mostly what was taken for something (hard negatives;
Girshick et al. 2014), and what they know already is shown less often. Shards that have such a
file are left alone.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from doro_perception.captioner import Captioner
from doro_perception.settings import PerceptionSettings
from doro_perception.train.shards import Frame, mined_path, read_frames

CANDIDATE_SCORE, MOST_BOXES = 0.05, 20


def mine(captioner: Captioner, shard: Path) -> int:
    """Write the proposals of a shard's frames; return how many there are."""
    frames = read_frames(shard)
    found = [captioner.propose(frame.image()).boxes for frame in frames]
    doubts = [doubt(captioner, frame) for frame in frames]
    path = mined_path(shard)
    part = path.with_name(path.stem + ".part.npz")
    counts = np.array([len(boxes) for boxes in found])
    boxes = np.concatenate(found).astype(np.float32)
    np.savez(part, box=boxes, ends=np.cumsum(counts), doubt=np.concatenate(doubts))
    part.rename(path)
    return int(counts.sum())


def doubt(captioner: Captioner, frame: Frame) -> NDArray[np.float32]:
    """Return by thing of a frame what the crop nets give to wrong names, (n,) in 0..1; 1 for what
    has no class to learn.
    """
    found = np.ones(len(frame.box), np.float32)
    known = np.flatnonzero(frame.kind >= 0)
    if len(known):
        kinds = captioner.read(frame.image(), frame.box[known].astype(np.float64)).kinds
        found[known] = 1 - kinds[np.arange(len(known)), frame.kind[known]]
    return found


def main() -> None:
    """Mine all shards of a folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", type=Path, required=True)
    parser.add_argument("--data", type=Path, required=True)
    arguments = parser.parse_args()
    captioner = Captioner(
        PerceptionSettings(
            captioner=str(arguments.models),
            candidate_score=CANDIDATE_SCORE,
            max_boxes=MOST_BOXES,
        )
    )
    shards = sorted(arguments.data.glob("train-*.npz"))
    shards = [path for path in shards if not path.name.endswith(".part.npz")]
    for number, shard in enumerate(shards, start=1):
        if not mined_path(shard).exists():
            count = mine(captioner, shard)
            print(f"{number} of {len(shards)}, {shard.name}: {count} proposals", flush=True)


if __name__ == "__main__":
    main()
