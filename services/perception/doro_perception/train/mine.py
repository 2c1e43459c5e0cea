"""Looks for what the proposer takes for things: ``python -m doro_perception.train.mine --models DIR
--data DIR``.

Writes beside each shard ``train-*.npz`` a file ``mined-train-*.npz`` with the proposals of its
frames. The crop nets then learn on the boxes that they get at work, and what is nothing is mostly
what was taken for something (hard negatives; Girshick et al. 2014). Shards that have such a file
are left alone.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from doro_perception.captioner import Captioner
from doro_perception.settings import PerceptionSettings
from doro_perception.train.shards import mined_path, read_frames

CANDIDATE_SCORE, MOST_BOXES = 0.05, 20


def mine(captioner: Captioner, shard: Path) -> int:
    """Write the proposals of a shard's frames; return how many there are."""
    found = [captioner.propose(frame.image()).boxes for frame in read_frames(shard)]
    path = mined_path(shard)
    part = path.with_name(path.stem + ".part.npz")
    counts = np.array([len(boxes) for boxes in found])
    np.savez(part, box=np.concatenate(found).astype(np.float32), ends=np.cumsum(counts))
    part.rename(path)
    return int(counts.sum())


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
