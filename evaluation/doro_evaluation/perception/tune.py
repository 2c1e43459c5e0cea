"""Chooses the thresholds of the map for a detector that errs, on rooms that are no test rooms.

    python -m doro_evaluation.perception.tune --rooms DIR [--models FOLDER] [--recordings 18]

Renders the tuning rooms into DIR (kept), looks at all their views with the models, and prints
F1 by kind of room for each way to make a map of what they say (``chain.WAYS``), each with its own
best thresholds. With ``--without 4,16`` rooms are left out, with ``--render`` frames
are rendered only.
"""

from __future__ import annotations

import argparse
import hashlib
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_evaluation.chain import Room
from doro_evaluation.counting.metrics import summary, tally
from doro_evaluation.outcomes import CLASS_OF_NAME, Outcome, Thing, true_things
from doro_evaluation.perception.chain import WAYS, Way, captions, graphs, kept_or_rendered, taken
from doro_evaluation.perception.tuning_rooms import kind_of, rows
from doro_mapper.area import Area
from doro_mapper.core import COUNTERS
from doro_mapper.existence import enough
from doro_mapper.finder import Found
from doro_mapper.sets import completes
from doro_mapper.settings import MapperSettings
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_perception.captioner import PACKAGED_FOLDER, Captioner
from doro_perception.core import Perception
from doro_perception.settings import PerceptionSettings
from doro_schemas.camera import bev_axes
from doro_schemas.messages import FrameCaptions, FrameGraphs

LOWEST = 0.3
SCORES = (0.3, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7)
LEAST = {"fused": (1.5, 2.0, 2.5, 3.0, 4.0), "votes": (2, 3, 4, 5, 6)}
SHARES = (0.25, 0.33, 0.4, 0.5, 0.6)
FURNITURE_SHARES = (0.25, 0.33, 0.4, 0.5)
"""Of ``fused``; tried where it is at most the share of other things."""
SURE = (0.6, 0.7, 0.8, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99)
"""Scores of single frames."""
SHOWN = 12
Floats = NDArray[np.float64]
Key = tuple[str, float, float, float, float]
"""Way, score, least certain views (others than ``fused``: views), least share of hits, and of
furniture."""


@dataclass(frozen=True)
class Seen:
    """A tuning room and what the detector says of its views."""

    room: Room
    said: list[FrameCaptions]


def seen(
    folder: Path, settings: PerceptionSettings, most: int, without: set[str]
) -> Iterator[Seen]:
    """Yield the tuning rooms with their captions; frames and captions are kept in the folder."""
    models = Path(settings.captioner) if settings.captioner else PACKAGED_FOLDER
    kept = folder / f"captions-{_digest(models, settings)}"
    kept.mkdir(parents=True, exist_ok=True)
    core = Perception(settings, Captioner(settings))
    for row in rows()[:most]:
        if row.room in without:
            continue
        room = kept_or_rendered(row, None, folder)
        path = kept / f"{row.name}.msgpack"
        if not path.exists():
            path.write_bytes(msgspec.msgpack.encode(captions(room, core)))
        yield Seen(room.room, msgspec.msgpack.decode(path.read_bytes(), type=list[FrameCaptions]))


def _digest(models: Path, settings: PerceptionSettings) -> str:
    files = sorted(path for path in models.iterdir() if path.suffix in {".onnx", ".json"})
    all_ = b"".join(hashlib.sha256(path.read_bytes()).digest() for path in files)
    return hashlib.sha256(all_ + msgspec.json.encode(settings)).hexdigest()[:12]


def tallies(one: Seen, nlu: Nlu) -> dict[Key, Floats]:
    """Return the tally of a room under each setting of each system."""
    found: dict[Key, Floats] = {}
    truth = true_things(one.room)
    for name, way in WAYS.items():
        least, shares = LEAST.get(name, (1,)), share_pairs(name)
        for score in SCORES if name in LEAST else SURE:
            said = taken(one.said, Way(score, way.mapper, way.distributions))
            things = _mapped(one.room, graphs(said, nlu), way.mapper)
            for views, (share, furniture) in itertools.product(least, shares):
                use = MapperSettings(
                    min_hits=max(1, int(views)),
                    min_hit_share=share,
                    min_certain=views,
                    min_certain_share=share,
                    min_certain_share_furniture=furniture,
                )
                counted = tuple(_thing(item) for item in _believed(things, one.room, use))
                made = _outcome(one.room, truth, counted, name)
                found[name, score, views, share, furniture] = tally(made)
    return found


def share_pairs(way: str) -> list[tuple[float, float]]:
    """Return the shares of hits that are tried of a way, and those of furniture."""
    if way not in LEAST:
        return [(0.0, 0.0)]
    if way != "fused":
        return [(share, share) for share in SHARES]
    return [pair for pair in itertools.product(SHARES, FURNITURE_SHARES) if pair[1] <= pair[0]]


def _mapped(room: Room, found: Sequence[FrameGraphs], mapper: MapperSettings) -> list[Found]:
    """Return all that a map holds, believed or not, of the evaluated classes."""
    loose = msgspec.structs.replace(mapper, min_hits=1, min_certain=1.0)
    area, counters = Area(loose), dict.fromkeys(COUNTERS, 0)
    for depth, graph in zip(room.depths, found, strict=True):
        area.merge(depth, graph, counters)
    return [item for item in area.find() if item.name in CLASS_OF_NAME and not item.gone]


def _believed(things: Sequence[Found], room: Room, use: MapperSettings) -> list[Found]:
    """Return what counts under some settings: by itself, or beside others of its class."""
    alone: list[Found] = []
    doubted: list[Found] = []
    for item in things:
        (alone if _counts(item, room, use) else doubted).append(item)
    kept = list(alone)
    for item in doubted:
        if not _counts(item, room, use, of_set=True):
            continue
        others = [(other.low_m, other.high_m) for other in alone if other.name == item.name]
        if completes((item.low_m, item.high_m), others, use):
            kept.append(item)
    return kept


def _counts(item: Found, room: Room, use: MapperSettings, *, of_set: bool = False) -> bool:
    longest_m = float((item.high_m - item.low_m).max())
    counted, views, doubt = (item.hits, item.misses), len(room.depths), item.votes.doubt
    return enough(counted, views, use, doubt, longest_m=longest_m, of_set=of_set)


def _thing(item: Found) -> Thing:
    where, size = [0.0] * 3, [0.0] * 3
    for k, axis in enumerate(bev_axes("unity")):
        where[axis] = float(item.center_m[k])
        size[axis] = float(item.high_m[k] - item.low_m[k])
    center_m, size_m = (where[0], where[1], where[2]), (size[0], size[1], size[2])
    return Thing(CLASS_OF_NAME[item.name], center_m, size_m, item.hits)


def _outcome(
    room: Room, truth: tuple[Thing, ...], found: tuple[Thing, ...], system: str
) -> Outcome:
    return Outcome(
        recording=room.name,
        room=room.room,
        part="tune",
        system=system,
        errors="captioner",
        frames=len(room.depths),
        truth=truth,
        found=found,
    )


def by_kind(rooms: Sequence[tuple[str, dict[Key, Floats]]], key: Key) -> dict[str, float]:
    """Return the average F1 of each kind of room under a setting."""
    sums: dict[str, Floats] = {}
    for room, own in rooms:
        sums[kind_of(room)] = sums.get(kind_of(room), np.zeros_like(own[key])) + own[key]
    return {kind: summary(total)["average/f1"] for kind, total in sorted(sums.items())}


def means(rooms: Sequence[tuple[str, dict[Key, Floats]]], keys: Sequence[Key]) -> dict[Key, float]:
    """Return the F1 of settings; each kind of room weighs the same."""
    return {key: float(np.mean(list(by_kind(rooms, key).values()))) for key in keys}


def around(table: Mapping[Key, float]) -> dict[Key, float]:
    """Return for each setting of a grid the mean of itself and of those at most one step away in
    each direction: what a good setting among bad ones owes to chance is averaged out.
    """
    axes = [sorted({key[axis] for key in table}) for axis in range(1, 5)]
    steps = {key: [axis.index(x) for axis, x in zip(axes, key[1:], strict=True)] for key in table}
    places = np.array(list(steps.values()))
    values = np.array(list(table.values()))
    near = (np.abs(places[:, None] - places[None]) <= 1).all(axis=2)
    found = (near * values).sum(axis=1) / near.sum(axis=1)
    return dict(zip(table, found.tolist(), strict=True))


def print_best(rooms: Sequence[tuple[str, dict[Key, Floats]]]) -> None:
    """Print the best settings of each system, judged with those around them."""
    kinds = sorted({kind_of(room) for room, _ in rooms})
    print(f"{len(rooms)} recordings; " + ", ".join(kinds) + " | mean, with the settings around it")
    for system in WAYS:
        keys = [key for key in rooms[0][1] if key[0] == system]
        table = means(rooms, keys)
        wide = around(table)
        for key in sorted(keys, key=lambda key: -wide[key])[:SHOWN]:
            f1 = by_kind(rooms, key)
            pooled = summary(sum((own[key] for _, own in rooms), np.zeros(1)))
            more = f"all {pooled['average/f1']:.3f} placed {pooled['matched_f1_0.5m']:.3f}"
            shown = " ".join(f"{f1[kind]:.3f}" for kind in kinds)
            setting = f"{key[1]:.2f} {key[2]:.1f} {key[3]:.2f} {key[4]:.2f}"
            print(f"{system:14s} {setting} | {shown} | {table[key]:.3f} {wide[key]:.3f} {more}")
        print_left_out(rooms, system, keys)


def print_left_out(
    rooms: Sequence[tuple[str, dict[Key, Floats]]], system: str, keys: Sequence[Key]
) -> None:
    """Print the F1 of rooms under the settings that the other rooms choose."""
    total = np.zeros(1)
    for left in sorted({room for room, _ in rooms}):
        scores = around(means([pair for pair in rooms if pair[0] != left], keys))
        best = max(scores, key=lambda key: (scores[key], key))
        total = sum((own[best] for room, own in rooms if room == left), total)
    print(f"{system:14s} each room by the others' choice: {summary(total)['average/f1']:.3f}")


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rooms", type=Path, required=True)
    parser.add_argument("--models", default="")
    parser.add_argument("--recordings", type=int, default=len(rows()))
    parser.add_argument("--without", default="")
    parser.add_argument("--render", action="store_true")
    args = parser.parse_args()
    if args.render:
        for row in rows()[: args.recordings]:
            print(row.name, len(kept_or_rendered(row, None, args.rooms).colors), flush=True)
        return
    settings = PerceptionSettings(
        backend="captioner", captioner=args.models, captioner_threshold=LOWEST
    )
    nlu = Nlu(msgspec.structs.replace(NluSettings(), cache_size=1_000_000))
    without = {f"FloorPlan{number}" for number in args.without.split(",") if number}
    done = []
    for one in seen(args.rooms, settings, args.recordings, without):
        done.append((one.room.room, tallies(one, nlu)))
        print(f"{one.room.name}: {len(one.room.depths)} views", flush=True)
    print_best(done)


if __name__ == "__main__":
    main()
