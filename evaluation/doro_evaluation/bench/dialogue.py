"""Speed of the dialogue's core: decision with question, and answers, on one thread.

CPU time of the thread, so that other work on the machine does not count. Scenes look like
what the mapper gives: cups with a color, a material, a place and two things near, each with its
color and material.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from doro_dialogue.core import Dialogue
from doro_dialogue.decision import decide
from doro_dialogue.facts import Candidate
from doro_dialogue.question import compose, pick
from doro_dialogue.settings import DialogueSettings
from doro_evaluation.figures import Figure
from doro_schemas.effects import Ask
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import (
    Answer,
    Exploration,
    Instance,
    Instances,
    InstructionGraph,
    ParseReply,
    ParseRequest,
    Query,
)

COLORS = ("red", "blue", "green", "yellow", "white", "black")
MATERIALS = ("plastic", "glass", "ceramic")
HOLDERS = ("table", "counter top", "shelf", "desk", "dining table")
NEAR = ("sink", "microwave", "toaster", "lamp", "coffee machine", "garbage can")
SAID = (
    ObjectGraph("cup"),
    ObjectGraph("cup", {"color": "red"}),
    ObjectGraph("cup", {"color": "red"}, [Relation("is-on", ObjectGraph("table"))]),
)
SCENES = 300
WARM_UP = 30
SIZES = (5, 100)
TARGETS_MS = {"decide_5": 0.2, "decide_100": 5.0}


class Scene:
    """An input graph and the candidates that it is decided on."""

    def __init__(self, said: ObjectGraph, candidates: list[Candidate]) -> None:
        self.said, self.candidates = said, candidates


def scenes(candidates: int, count: int, seed: int) -> list[Scene]:
    """Return ``count`` seeded scenes of ``candidates`` cups each."""
    rng = np.random.default_rng([seed, candidates])

    def one_of(words: Sequence[str]) -> str:
        return words[int(rng.integers(len(words)))]

    def thing(name: str) -> ObjectGraph:
        return ObjectGraph(name, {"color": one_of(COLORS), "material": one_of(MATERIALS)})

    def cup() -> ObjectGraph:
        near = [Relation("is-near", thing(one_of(NEAR))) for _ in range(2)]
        place = Relation("is-on", thing(one_of(HOLDERS)))
        return ObjectGraph("cup", thing("cup").attributes, [place, *near])

    return [
        Scene(SAID[k % len(SAID)], [Candidate(f"cup-{i + 1}", cup()) for i in range(candidates)])
        for k in range(count)
    ]


def run_core_bench(count: int = SCENES, seed: int = 0) -> dict[str, Figure]:
    """Return p50 and p99 in milliseconds of a decision with its question, and of an answer.

    ``all_offered`` are the scenes in which only the class is said, so that the question is about
    every candidate: the most work.
    """
    figures: dict[str, Figure] = {}
    for size in SIZES:
        made = scenes(size, count + WARM_UP, seed)
        times_ms = [_timed_ms(partial(_decide, one)) for one in made]
        figures |= _quantiles(f"decide_{size}", times_ms[WARM_UP:])
        whole = [t for t, one in zip(times_ms, made, strict=True) if one.said == SAID[0]]
        figures |= _quantiles(f"decide_{size}_all_offered", whole[WARM_UP // len(SAID) :])
    answered = [_answer_ms(one) for one in scenes(SIZES[0], count + WARM_UP, seed + 1)][WARM_UP:]
    figures |= _quantiles(f"answer_{SIZES[0]}", [one for one in answered if one is not None])
    return {f"speed/dialogue/{name}": value for name, value in figures.items()}


def _decide(scene: Scene) -> str:
    question = compose(decide(scene.said, scene.candidates), task="bring")
    return pick(question.wordings, 0, "bench/1")


def _timed_ms(work: Callable[[], object]) -> float:
    started_ns = time.thread_time_ns()
    work()
    return (time.thread_time_ns() - started_ns) / 1e6


def _answer_ms(scene: Scene) -> float | None:
    """Return the time from the answer to what it comes to; None where nothing is asked.

    The answer names the last clause of the question; the parser's part, which is nlu's, is
    handed in ready.
    """
    core, query = _asked(scene)
    if query.state != "INFORM-AMBIGUITY" or len(query.clauses) < 2:
        return None
    meant = query.clauses[-1]
    words = " ".join(["the", *meant.text.split(" ")[1:]])
    answer = Answer(text=words, dialogue_id=query.dialogue_id)

    def work() -> None:
        for output in core.answer(answer):
            if isinstance(output, Ask) and isinstance(output.request, ParseRequest):
                core.parse_reply(ParseReply(text=output.request.text, graph=meant.graph))

    return _timed_ms(work)


def _asked(scene: Scene) -> tuple[Dialogue, Query]:
    """Return a dialogue that has asked its question."""
    core = Dialogue(DialogueSettings())
    core.exploration(Exploration(episode="bench", state="started"))
    core.exploration(Exploration(episode="bench", state="finished"))
    core.instruction_graph(
        InstructionGraph(episode="bench", text="bring me the cup", task="bring", graph=scene.said)
    )
    return core, _query_of(core, _instances(scene))


def _instances(scene: Scene) -> Instances:
    found = [
        Instance(one.id, one.graph, [float(k), 0.9, 0.0], [0.1, 0.1, 0.1])
        for k, one in enumerate(scene.candidates)
    ]
    return Instances(episode="bench", name="cup", frames_merged=1, last_frame=0, instances=found)


def _query_of(core: Dialogue, reply: Instances) -> Query:
    return next(one for one in core.instances(reply) if isinstance(one, Query))


def instructions(count: int) -> list[str]:
    """Return different instructions about things of the sample room, no two the same.

    Raises:
        ValueError: more than there are.
    """
    verbs = ("bring me", "fetch", "pick up", "get me", "take", "give me")
    tails = ("", " on the counter top", " near the sink", " on the table")
    said = [
        f"{verb} the {color} {name}{tail}"
        for tail in tails
        for name in ("cup", "mug", "bowl", "apple")
        for color in COLORS
        for verb in verbs
    ]
    if count > len(said):
        raise ValueError(f"there are {len(said)} instructions, {count} are asked for")
    step = 77  # prime to their number: neighbours differ in everything
    return [said[(k * step) % len(said)] for k in range(count)]


def core_times_ms(replies: Sequence[tuple[InstructionGraph, Instances]]) -> list[float]:
    """Return what the dialogue service's core takes from each instruction to its query.

    Args:
        replies: instructions as nlu understood them, with the map's reply to each.
    """
    core = Dialogue(DialogueSettings())
    episode = replies[0][1].episode if replies else ""
    core.exploration(Exploration(episode=episode, state="started"))
    core.exploration(Exploration(episode=episode, state="finished"))
    return [
        _timed_ms(partial(core.instruction_graph, instruction))
        + _timed_ms(partial(core.instances, reply))
        for instruction, reply in replies
    ]


def _quantiles(name: str, times_ms: Sequence[float]) -> dict[str, Figure]:
    """Return ``<name>_p50_ms`` and ``<name>_p99_ms``."""
    p50, p99 = np.percentile(times_ms, [50, 99])
    return {f"{name}_p50_ms": round(float(p50), 4), f"{name}_p99_ms": round(float(p99), 4)}
