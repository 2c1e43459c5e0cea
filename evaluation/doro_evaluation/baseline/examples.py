"""Training examples of the baseline: captions and instruction -> what is to be said.

The data source is the one of our own system: instructions by ``rooms.expressions``, captions by
perception's surface form, the query by the dialogue's templates (the plainest wording) from the
decision on what the captions describe. Rooms: :mod:`doro_evaluation.baseline.rooms`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Literal

import msgspec
import numpy as np

from doro_dialogue.decision import decide
from doro_dialogue.facts import Candidate
from doro_dialogue.question import compose
from doro_evaluation.baseline.rooms import BaseRoom, seen_from_somewhere, varied
from doro_evaluation.baseline.text import about, noun_of
from doro_perception.caption import caption
from doro_perception.settings import PerceptionSettings
from doro_schemas.detector_errors import ErrorModels
from doro_schemas.graph import ObjectGraph, Relation
from doro_sim_feeder.rooms.expressions import Expression, expressions, name_of, true_graph
from doro_sim_feeder.rooms.truth import TrueInstance

Configuration = Literal["one view", "captions joined", "our aggregator"]
CONFIGURATIONS: tuple[Configuration, ...] = ("one view", "captions joined", "our aggregator")
"""The paper's three configurations of the baseline (Table IV)."""
SHARES = (0.5, 0.2, 0.3)
PER_ROOM = 10
OF_COPIES = 0.6
VIEWS = (8, 40)
KEEP_CONFIRM = 0.5
"""Share of the CONFIRM examples that is kept: without it they would be most of all."""
MORE_LANDMARKS = 2
JOINER = PerceptionSettings().relation_joiner


class Example(msgspec.Struct, frozen=True):
    """One example; ``captions`` are those of each view that the baseline reads."""

    configuration: Configuration
    room: str
    state: str
    instruction: str
    captions: list[list[str]]
    target: str


def caption_of(graph: ObjectGraph) -> str:
    """Return the caption of an object as perception's oracle words it."""
    return caption(graph, JOINER)


def examples(bases: Sequence[BaseRoom], types: Sequence[str], seed: int) -> Iterator[Example]:
    """Yield examples without end, the same for the same rooms and seed."""
    rng = np.random.default_rng(seed)
    number = 0
    while True:
        base = bases[int(rng.integers(len(bases)))]
        items, kinds = varied(base, types, rng)
        number += 1
        said = expressions(f"{seed}/{number}", items)
        for one in _drawn(said, kinds, rng):
            made = _example(base.name, items, one, rng)
            if made.state != "CONFIRM" or rng.random() < KEEP_CONFIRM:
                yield made


def _drawn(
    said: Sequence[Expression], kinds: set[str], rng: np.random.Generator
) -> Iterator[Expression]:
    """Yield some instructions of a room, more of them about what it has copies of."""
    about_copies = [one for one in said if one.object_type in kinds]
    for _ in range(min(PER_ROOM, len(said))):
        among = about_copies if about_copies and rng.random() < OF_COPIES else said
        yield among[int(rng.integers(len(among)))]


def _example(
    room: str, items: list[TrueInstance], said: Expression, rng: np.random.Generator
) -> Example:
    configuration = CONFIGURATIONS[int(rng.choice(len(CONFIGURATIONS), p=SHARES))]
    views = _VIEWS[configuration](items, said, rng)
    noun = noun_of(said.text)
    seen = {item.object_id: item for view in views for item in view if _noun(item) == noun}
    graphs = {name: true_graph(item) for name, item in seen.items()}
    if configuration == "our aggregator":
        graphs = {name: _aggregated(graph, items, rng) for name, graph in graphs.items()}
    texts = {name: caption_of(graph) for name, graph in graphs.items()}
    captions = [
        about([texts[item.object_id] for item in view if item.object_id in texts], said.text)
        for view in views
    ]
    candidates = [Candidate(f"{n:03d}", graph) for n, graph in enumerate(graphs.values())]
    decision = decide(said.graph, candidates)
    target = compose(decision, task=said.task).wordings[0]
    kept = [view for view in captions if view]
    return Example(configuration, room, decision.state, said.text, kept, target)


def _noun(item: TrueInstance) -> str:
    return name_of(item.object_type).rsplit(" ", maxsplit=1)[-1]


def _one_view(
    items: list[TrueInstance], said: Expression, rng: np.random.Generator
) -> list[list[TrueInstance]]:
    """Return one view, mostly one that looks at a thing of the class, with misses."""
    of_class = [item for item in items if item.object_type == said.object_type]
    towards = of_class[int(rng.integers(len(of_class)))] if of_class else None
    tries = [seen_from_somewhere(items, towards, rng) for _ in range(4)]
    best = max(tries, key=lambda view: sum(i.object_type == said.object_type for i in view))
    return [_missed(best, rng)]


def _many_views(
    items: list[TrueInstance], _: Expression, rng: np.random.Generator
) -> list[list[TrueInstance]]:
    count = int(rng.integers(*VIEWS))
    return [_missed(seen_from_somewhere(items, None, rng), rng) for _ in range(count)]


def _whole_room(
    items: list[TrueInstance], _: Expression, rng: np.random.Generator
) -> list[list[TrueInstance]]:
    return [[items[k] for k in rng.permutation(len(items))]]


_VIEWS: dict[
    Configuration,
    Callable[
        [list[TrueInstance], Expression, np.random.Generator],
        list[list[TrueInstance]],
    ],
] = {"one view": _one_view, "captions joined": _many_views, "our aggregator": _whole_room}


def _missed(view: list[TrueInstance], rng: np.random.Generator) -> list[TrueInstance]:
    """Return what a detector with false negatives reports; shifted boxes change no caption."""
    missed = ErrorModels().miss_probability
    return [item for item in view if rng.random() >= missed]


def _aggregated(
    graph: ObjectGraph, items: Sequence[TrueInstance], rng: np.random.Generator
) -> ObjectGraph:
    """Return a graph as the map gives it: some landmarks fewer, some small ones more."""
    relations = [one for one in graph.relations if one.type != "is-near" or rng.random() < 0.8]
    for _ in range(int(rng.integers(MORE_LANDMARKS + 1))):
        other = items[int(rng.integers(len(items)))]
        if name_of(other.object_type) != graph.name:
            target = ObjectGraph(name_of(other.object_type), other.attributes)
            relations.append(Relation("is-near", target))
    return ObjectGraph(graph.name, graph.attributes, relations)
