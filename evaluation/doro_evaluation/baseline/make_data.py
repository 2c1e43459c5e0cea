"""Write training data: ``python -m doro_evaluation.baseline.make_data --out FILE --count N``."""

from __future__ import annotations

import argparse
import itertools
from collections import Counter
from pathlib import Path

import msgspec

from doro_evaluation.baseline.examples import examples
from doro_evaluation.baseline.rooms import base_rooms, object_types, training_rooms


def main() -> None:
    """Write examples as JSON lines, with their number by configuration and state."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=7)
    arguments = parser.parse_args()
    names = training_rooms()
    bases = list(base_rooms(names))
    made: Counter[str] = Counter()
    encoder = msgspec.json.Encoder()
    with arguments.out.open("wb") as file:
        for one in itertools.islice(
            examples(bases, object_types(names), arguments.seed), arguments.count
        ):
            file.write(encoder.encode(one) + b"\n")
            made[f"{one.configuration}, {one.state}"] += 1
    print(f"{len(bases)} rooms; " + "; ".join(f"{k} {n}" for k, n in sorted(made.items())))


if __name__ == "__main__":
    main()
