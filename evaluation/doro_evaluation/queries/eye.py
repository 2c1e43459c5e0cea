"""Cases to check the rule of QA by eye: what is true and what was said, the verdict apart.

``python -m doro_evaluation.queries.eye --set DIR --out FOLDER`` draws cases by a seed, evenly over
true states and automatic verdicts, from our system on all views and on one, and from
``paper_literal``. ``cases.md`` has no verdicts and is for the eye, ``cases.jsonl`` has them.
"""

from __future__ import annotations

import argparse
import hashlib
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path

import msgspec

from doro_dialogue.facts import Candidate
from doro_evaluation.context import Context, Recorded, code_digest, make_pool, recordings_of, spread
from doro_evaluation.maps import MappedRoom
from doro_evaluation.outcomes import reported_in, reported_views
from doro_evaluation.queries.judge import Truth
from doro_evaluation.queries.pairs import select_pairs
from doro_evaluation.queries.runs import jobs_of, run_queries
from doro_evaluation.queries.systems import FINDERS, QueryOutcome, Speaker, best_view, of_view
from doro_evaluation.runs import prepare, speak
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Instance
from doro_schemas.vocabulary import name_satisfies

CASES = 50
ERRORS = "cs+sd+fn"
FROM = (("ours", "multi-view"), ("ours", "one-view"), ("paper_literal", "multi-view"))


class Case(msgspec.Struct, frozen=True):
    """A case: what was asked, what is true, what was said, and the automatic verdict.

    Attributes:
        truth: the true instances of the class; found: what the system offers and stands on.
    """

    number: int
    id: str
    system: str
    view: str
    instruction: str
    truth: list[str]
    found: list[str]
    said: str
    right: bool
    why: str


def drawn(outcomes: Iterable[QueryOutcome], seed: int, count: int = CASES) -> list[QueryOutcome]:
    """Return cases evenly over (true state, verdict), each stratum in an order by seed."""
    strata: dict[tuple[str, bool], list[QueryOutcome]] = defaultdict(list)
    for one in outcomes:
        if (one.system, one.view) in FROM:
            strata[one.verdict.true, one.verdict.right].append(one)
    for own in strata.values():
        own.sort(key=lambda one: _draw(seed, one))
    chosen: list[QueryOutcome] = []
    while len(chosen) < count and any(strata.values()):
        for key in sorted(strata):
            if strata[key] and len(chosen) < count:
                chosen.append(strata[key].pop(0))
    return sorted(chosen, key=lambda one: _draw(seed + 1, one))


def _draw(seed: int, one: QueryOutcome) -> bytes:
    text = f"{seed}|{one.system}|{one.view}|{one.pair.id}"
    return hashlib.sha256(text.encode()).digest()


def told(mapped: MappedRoom, one: QueryOutcome, nlu: Nlu, number: int) -> Case:
    """Return a case with the truth and the system's instances as text."""
    room, pair = mapped.room, one.pair
    views = reported_views(room)
    truth = Truth.of(room.truth, views)
    name = pair.graph.name
    lines = [
        f"{item.object_id}: {described(truth.graphs[item.object_id])},"
        f" at {_place(item.center_m)}, in {views[item.object_id]} views"
        for item in truth.items
        if name_satisfies(name, truth.graphs[item.object_id].name)
    ]
    if one.view == "multi-view":
        found = mapped.found(FINDERS[one.system], ERRORS)
        things = {item.instance_id: item for item in found.instances}
        candidates = [Candidate(item.instance_id, item.graph) for item in found.instances]
        share = found.unseen_share
    else:
        view = best_view(room.detections, pair)
        candidates, identity = of_view(mapped.graphs(ERRORS)[view], room.detections[view])
        things, share = {}, 0.0  # boxes of one image have no place
        shown = ", ".join(key for key in reported_in(room, [view]) if key in truth.graphs)
        lines.append(f"(the view shows: {shown})")
    said = Speaker(nlu, one.system).say(pair, candidates, share)
    offered = said[0].offered if said else []
    own = [
        f"{item.candidate.id}: {described(item.candidate.graph)}"
        + (
            _where(things[item.candidate.id])
            if item.candidate.id in things
            else f", is {identity.get(item.candidate.id, 'nothing')}"
        )
        for item in offered
    ]
    verdict = one.verdict
    return Case(
        number, pair.id, one.system, one.view, pair.instruction, lines, own, verdict.text,
        verdict.right, f"{verdict.fault}: {verdict.why}" if verdict.fault else "",
    )  # fmt: skip


def described(graph: ObjectGraph) -> str:
    """Return a graph in one line."""
    words = [*graph.attributes.values(), graph.name]
    own = " ".join(words)
    related = [
        f"{'with ' if one.inverse else ''}{one.type} {described(one.target)}"
        for one in graph.relations
    ]
    return "; ".join([own, *related])


def _where(found: Instance) -> str:
    return f", at {_place(found.position_m)}"


def _place(position_m: Sequence[float]) -> str:
    return "(" + ", ".join(f"{value:.2f}" for value in position_m) + ")"


def blind(cases: Sequence[Case]) -> str:
    """Return the cases as text without their verdicts."""
    parts = []
    for one in cases:
        parts += [
            f"## {one.number}. {one.id} ({one.system}, {one.view})",
            f"asked: {one.instruction}",
            *(f"  true: {line}" for line in one.truth or ["nothing of the class"]),
            *(f"  offers: {line}" for line in one.found),
            f"said: {one.said}",
            "",
        ]
    return "\n".join(parts)


def main() -> None:
    """Draw the cases and write both files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--set", type=Path, required=True, dest="folder")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--rooms", type=int, default=40, help="recordings, evenly spread")
    arguments = parser.parse_args()
    cache = arguments.out / "cache"
    every = recordings_of(arguments.folder, "paper")
    recordings = {one.name: one for one in spread(every, arguments.rooms)}
    context = Context(
        pool=str(make_pool(every, "test", cache)),
        cache=str(cache),
        code=code_digest(),
    )
    pairs = select_pairs(arguments.folder, "test", 7)
    jobs = jobs_of(
        list(recordings.values()), pairs, errors=ERRORS, systems=("ours", "paper_literal")
    )
    chosen = drawn([one for some in run_queries(jobs, context, 1) for one in some], arguments.seed)
    prepare(context)
    nlu = Nlu(NluSettings())
    cases = [
        told(MappedRoom(_of(recordings, one), context, speak), one, nlu, number)
        for number, one in enumerate(chosen, 1)
    ]
    (arguments.out / "cases.md").write_text(blind(cases), encoding="utf-8")
    lines = b"\n".join(msgspec.json.encode(one) for one in cases)
    (arguments.out / "cases.jsonl").write_bytes(lines + b"\n")


def _of(recordings: dict[str, Recorded], one: QueryOutcome) -> Recorded:
    return recordings[one.pair.episode]


if __name__ == "__main__":
    main()
