"""Averages the weights of one network over several runs that began at the same place:
``python -m doro_perception.train.soup NETWORK --runs DIR DIR ... --out DIR``.

Runs from one network end around the same valley, and their middle lies deeper in it than each of
them (model soups, Wortsman et al. 2022). It costs nothing at work: the result is one network.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import torch
from torch import Tensor

from doro_perception.train.__main__ import NETWORKS

Values = dict[str, Tensor]


def mixed(averages: list[Values], shares: list[float]) -> Values:
    """Return the weighted mean of the weights of runs.

    Args:
        averages: of each run, tensors by name.
        shares: weights of the runs; only their ratios count.

    Raises:
        SystemExit: the runs are not of one network, or there are not as many shares.
    """
    if len(averages) != len(shares):
        raise SystemExit(f"{len(averages)} runs, but {len(shares)} shares: give one for each")
    names = averages[0].keys()
    for number, one in enumerate(averages):
        if one.keys() != names:
            strange = sorted(one.keys() ^ names)[0]
            raise SystemExit(f"run {number + 1} is of another network than the first: {strange}")
    total = sum(shares)
    found: Values = {}
    for name, first in averages[0].items():
        if first.dtype.is_floating_point:
            parts = [one[name] * (s / total) for one, s in zip(averages, shares, strict=True)]
            found[name] = torch.stack(parts).sum(0)
        else:
            found[name] = first
    return found


def main() -> None:
    """Write the mean of the runs as a run of its own."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("network", choices=NETWORKS)
    parser.add_argument("--runs", type=Path, nargs="+", required=True)
    parser.add_argument("--shares", type=float, nargs="+", help="one for each run; else equal")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    file = f"{arguments.network}.pt"
    for run in arguments.runs:
        if not (run / file).exists():
            raise SystemExit(f"{run} has no {file}: train {arguments.network} with --out {run}")
    averages = [torch.load(run / file, weights_only=True)["average"] for run in arguments.runs]
    shares = arguments.shares or [1.0] * len(averages)
    arguments.out.mkdir(parents=True, exist_ok=True)
    torch.save({"average": mixed(averages, shares)}, arguments.out / file)


if __name__ == "__main__":
    main()
