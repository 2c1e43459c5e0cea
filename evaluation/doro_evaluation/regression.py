"""A slice of five rooms with frozen figures: does it still count and ask as well as it did?

Two validation bedrooms, two kitchens and a living room that no test uses, 40 views each, rendered
when needed. ``make test`` compares with ``data/frozen.json``; ``python -m
doro_evaluation.regression`` prints the figures, ``--write`` freezes them anew, which is right only
when they got better, or the slice itself changed.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec

from doro_evaluation.context import Context, Recorded, code_digest, make_pool, recordings_of
from doro_evaluation.counting.report import figures_of as counting_figures
from doro_evaluation.counting.report import grouped
from doro_evaluation.maps import MappedRoom
from doro_evaluation.outcomes import Outcome
from doro_evaluation.queries.pairs import Pair
from doro_evaluation.queries.systems import QueryOutcome, run_system
from doro_evaluation.queries.tables import figures_of as query_figures
from doro_evaluation.queries.tables import score_all
from doro_evaluation.runs import prepare, speak
from doro_mapper.settings import MapperSettings
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_sim_feeder.recording import TRUTH, write_recording
from doro_sim_feeder.rooms.copies import CopySpec
from doro_sim_feeder.rooms.episode import RoomEpisode, truth_json
from doro_sim_feeder.rooms.expressions import expressions

FROZEN = Path(__file__).parent / "data" / "frozen.json"
VIEWS, SEED = 40, 5
ROOMS = (
    ("FloorPlan301", "Book", 3),
    ("FloorPlan312", "Pillow", 4),
    ("FloorPlan3", "Cup", 4),
    ("FloorPlan7", "Bowl", 3),
    ("FloorPlan204", "Chair", 4),
)
"""Room, class of the copies, and how many."""
PART = "slice"
ERRORS = ("gt", "cs+sd+fn", "all")
QUERY_ERRORS = "cs+sd+fn"
KEPT = (
    *(f"counting/ours/{errors}/average/f1" for errors in ERRORS),
    *(f"counting/ours/{errors}/accuracy" for errors in ERRORS),
    "counting/ours/gt/matched_f1_0.5m",
    "counting/ours/gt/average/items",
    "multi-view/ours/qa",
    "multi-view/ours/aa",
    "multi-view/ours/bleu",
    "multi-view/ours/pairs",
    "single-view/ours/qa",
    "single-view/ours/aa",
)


class Frozen(msgspec.Struct, frozen=True):
    """A figure, and by how much it may fall; counts of items and pairs have to stay."""

    value: float
    tolerance: float


def make_slice(folder: Path) -> list[Recorded]:
    """Render the five rooms into a folder; needs the extra ``doro-sim-feeder[render]``."""
    folder.mkdir(parents=True, exist_ok=True)
    for room, kind, count in ROOMS:
        name = f"{PART}-{room}"
        copies = CopySpec(kind, count)
        episode = RoomEpisode(
            room, seed=SEED, views=VIEWS, color=False, copies=copies, name=name, allow_missing=True
        )
        write_recording(
            folder / f"{name}.mcap",
            episode.messages(),
            {"room": room},
            lambda own=episode: {TRUTH: truth_json(own)},  # type: ignore[misc]
        )
    return recordings_of(folder, PART)


def measure_slice(
    recordings: Sequence[Recorded], cache: Path, mapper: MapperSettings | None = None
) -> dict[str, float]:
    """Return the figures of :data:`KEPT` on the slice."""
    context = Context(
        mapper=mapper or MapperSettings(),
        pool=str(make_pool(recordings, PART, cache)),
        cache=str(cache),
        code=code_digest(),
    )
    prepare(context)
    nlu = Nlu(NluSettings())
    counted: list[Outcome] = []
    asked: list[QueryOutcome] = []
    for one in recordings:
        mapped = MappedRoom(one, context, speak)
        counted += [mapped.outcome("tracks", errors) for errors in ERRORS]
        asked += run_system(mapped, pairs_of(mapped), nlu, errors=QUERY_ERRORS, system="ours")
    figures = counting_figures(grouped(counted)) | query_figures(score_all(asked))
    return {name: float(figures[name]) for name in KEPT}


def pairs_of(mapped: MappedRoom) -> list[Pair]:
    """Return all instructions of a room."""
    room = mapped.room
    return [
        Pair(one.id, room.name, one.kind, one.variant, one.text, one.task, one.graph)
        for one in expressions(room.name, room.truth)
    ]


def read_frozen(path: Path = FROZEN) -> dict[str, Frozen]:
    """Return the frozen figures."""
    return msgspec.json.decode(path.read_bytes(), type=dict[str, Frozen])


def fallen(figures: Mapping[str, float], frozen: Mapping[str, Frozen]) -> list[str]:
    """Return a sentence for each figure that fell by more than its tolerance, or is gone."""
    told = []
    for name, kept in frozen.items():
        now = figures.get(name)
        if now is None or now < kept.value - kept.tolerance:
            told.append(f"{name} is {now}, was {kept.value} (tolerance {kept.tolerance})")
        elif name.endswith(("items", "pairs")) and now != kept.value:
            told.append(f"{name} is {now}, was {kept.value}: the slice is another one")
    return told


def main() -> None:
    """Measure the slice and print the figures; with ``--write`` freeze them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        figures = measure_slice(make_slice(Path(folder)), Path(folder) / "cache")
    frozen = {name: Frozen(round(value, 4), _tolerance(name)) for name, value in figures.items()}
    text = json.dumps(msgspec.to_builtins(frozen), indent=1) + "\n"
    print(text, end="")
    if arguments.write:
        FROZEN.write_text(text, encoding="utf-8")


def _tolerance(name: str) -> float:
    """Return about two items of the slice; a worse mapper or dialogue costs more."""
    return 0.0 if name.endswith(("items", "pairs")) else 0.03


if __name__ == "__main__":
    main()
