"""Scenes of a study: recordings with instructions, and what is true and wanted there."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from doro_dialogue.decision import decide
from doro_dialogue.facts import Candidate, graph_key
from doro_evaluation.chain import truth_of
from doro_nlu.core import Nlu
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.talk import State
from doro_sim_feeder.recording import Recording
from doro_sim_feeder.rooms.expressions import expressions, true_graph, visible
from doro_sim_feeder.rooms.truth import TrueInstance

MOST_CANDIDATES = 6
"""More marks than this make a picture that nobody reads."""
STATE_TURNS: tuple[State, ...] = (
    "INFORM-AMBIGUITY",
    "INFORM-MISMATCH",
    "INFORM-AMBIGUITY",
    "CONFIRM",
    "INFORM-AMBIGUITY",
    "INFORM-MISSING",
)
"""Which state is taken next: half of the scenes are ambiguous."""


@dataclass(frozen=True)
class Scene:
    """A recording, what is said there and what is true of it.

    Attributes:
        candidates: the visible instances of the class (n).
        wanted: those that the person wants: one, and what nothing tells from it.
    """

    path: Path
    object_type: str
    instruction: str
    task: str
    graph: ObjectGraph
    state: State
    candidates: tuple[TrueInstance, ...]
    wanted: tuple[TrueInstance, ...]


def recordings_of(folder: Path) -> list[Path]:
    """Return the recordings of a set, by name.

    Raises:
        Refused: there is none.
    """
    found = sorted(folder.glob("*.mcap"))
    if not found:
        raise Refused(f"{folder} has no recordings (*.mcap): make a set with 'doro rooms set'")
    return found


def possible_scenes(path: Path, seed: int) -> list[Scene]:
    """Return the scenes of a recording with the evaluation's instructions (paper, V-A)."""
    recording = Recording(path)
    truth = truth_of(recording)
    made = [
        _scene(path, one.object_type, (one.text, one.task, one.graph), truth, seed)
        for one in expressions(path.stem, truth)
    ]
    return [one for one in made if len(one.candidates) <= MOST_CANDIDATES]


def own_scenes(path: Path, instructions: Sequence[str], nlu: Nlu, seed: int) -> list[Scene]:
    """Return the scenes of a recording with given instructions.

    Raises:
        Refused: an instruction is not understood, or is about more things than can be marked.
    """
    truth = truth_of(Recording(path))
    made = []
    for text in instructions:
        parsed = nlu.parse_text(text)
        if parsed.graph is None:
            raise Refused(f"the instruction '{text}' is not understood: {parsed.reason}")
        said = (text, parsed.task, parsed.graph)
        scene = _scene(path, parsed.graph.name, said, truth, seed)
        if len(scene.candidates) > MOST_CANDIDATES:
            raise Refused(
                f"'{text}' is about {len(scene.candidates)} things in {path.name}, at most"
                f" {MOST_CANDIDATES} can be marked: ask for something else"
            )
        made.append(scene)
    return made


def scenes_of(
    folder: Path | None,
    recordings: Sequence[Path],
    instructions: Sequence[str],
    nlu: Nlu,
    *,
    count: int,
    seed: int,
) -> list[Scene]:
    """Return the scenes of a study: ``count`` chosen ones, or all with given instructions.

    Raises:
        Refused: no recordings, or too few scenes.
    """
    paths = [*(recordings_of(folder) if folder else []), *recordings]
    if not paths:
        raise Refused("name recordings: --set FOLDER or --recording FILE")
    if instructions:
        return [one for path in paths for one in own_scenes(path, instructions, nlu, seed)]
    return choose((one for path in paths for one in possible_scenes(path, seed)), count, seed)


def _scene(
    path: Path,
    object_type: str,
    said: tuple[str, str, ObjectGraph],
    truth: Sequence[TrueInstance],
    seed: int,
) -> Scene:
    text, task, graph = said
    by_id = {item.object_id: item for item in visible(truth)}
    decision = decide(graph, [Candidate(key, true_graph(item)) for key, item in by_id.items()])
    offered = decision.matches or decision.instances
    wanted: list[str] = []
    if offered:
        rng = np.random.default_rng([seed, _number(f"{path.stem}|{text}")])
        chosen = true_graph(by_id[offered[int(rng.integers(len(offered)))]])
        same = graph_key(chosen)
        wanted = [one for one in offered if graph_key(true_graph(by_id[one])) == same]
    return Scene(
        path=path,
        object_type=object_type,
        instruction=text,
        task=task,
        graph=graph,
        state=decision.state,
        candidates=tuple(by_id[one] for one in decision.instances),
        wanted=tuple(by_id[one] for one in wanted),
    )


def choose(pool: Iterable[Scene], count: int, seed: int) -> list[Scene]:
    """Return ``count`` scenes: states in turns, recordings and classes as seldom as can be.

    Raises:
        Refused: the pool has fewer.
    """
    scenes = list(pool)
    if len(scenes) < count:
        raise Refused(
            f"the recordings give {len(scenes)} scenes, {count} are asked for: name more"
            " recordings or fewer --items"
        )
    order = np.random.default_rng([seed, 11]).permutation(len(scenes)).tolist()
    left = [scenes[number] for number in order]
    used: Counter[str] = Counter()
    chosen: list[Scene] = []
    turn = 0
    while len(chosen) < count:
        state = STATE_TURNS[turn % len(STATE_TURNS)]
        turn += 1
        fitting = [one for one in left if one.state == state]
        if not fitting:
            continue
        best = min(fitting, key=lambda one: (used[one.path.name], used[one.object_type]))
        used.update([best.path.name, best.object_type])
        left.remove(best)
        chosen.append(best)
    return chosen


def _number(text: str) -> int:
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big")
