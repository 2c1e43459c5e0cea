"""Scenes of a study: recordings with instructions, and what each system asks there."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import numpy as np

from doro_dialogue.decision import Decision, decide, paper_literal
from doro_dialogue.facts import Candidate, graph_key
from doro_dialogue.question import Question, compose, pick
from doro_evaluation.chain import Language, Room, count_instances, load_room, truth_of
from doro_evaluation.study import Asked, KnownInstance
from doro_nlu.core import Nlu
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Instance, Instances
from doro_schemas.messages.talk import Clause, State
from doro_schemas.vocabulary import name_satisfies
from doro_sim_feeder.recording import Recording
from doro_sim_feeder.rooms.expressions import expressions, name_of, true_graph, visible
from doro_sim_feeder.rooms.truth import TrueInstance

SYSTEMS = ("ours", "paper_literal", "reference")
MOST_CANDIDATES = 6
"""More marks than this make a picture that nobody reads."""
NEAR_M = 0.5
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


@dataclass
class Asker:
    """Runs the systems on scenes; keeps the map of the recording that was last asked for."""

    systems: Sequence[str]
    seed: int
    nlu: Nlu
    given: Mapping[tuple[str, str, str], str] = field(default_factory=dict)
    _path: Path | None = None
    _room: Room | None = None
    _map: Instances | None = None
    _language: Language = field(default_factory=Language)

    def room(self, scene: Scene) -> Room:
        """Return the recording of a scene, in memory."""
        if self._room is None or self._path != scene.path:
            self._path, self._room, self._map = scene.path, load_room(scene.path), None
        return self._room

    def ask(self, scene: Scene, name: str) -> dict[str, Asked]:
        """Return what each system says in a scene.

        Args:
            name: chooses the wording, together with the seed.

        Raises:
            Refused: a system of its own has no query for this scene.
        """
        return {system: self._ask(scene, name, system) for system in self.systems}

    def _ask(self, scene: Scene, name: str, system: str) -> Asked:
        if system == "reference":
            true = visible(self.room(scene).truth)
            known = [KnownInstance(item.object_id, true_graph(item)) for item in true]
            wanted = [item.object_id for item in scene.wanted]
            decision = decide(scene.graph, [Candidate(one.id, one.graph) for one in known])
            question = compose(decision, task=scene.task)
            return self._said(name, decision, question, Asked("", None, [], known, wanted))
        found = self._instances(scene)
        known = [KnownInstance(one.instance_id, one.graph) for one in found.instances]
        wanted = _same_place(scene, self.room(scene).truth, found.instances)
        if system not in SYSTEMS:
            key = (system, scene.path.stem, scene.instruction)
            if key not in self.given:
                raise Refused(
                    f"system '{system}' has no query for '{scene.instruction}' in"
                    f" {scene.path.name}: add a line for it"
                )
            return Asked(self.given[key], None, [], known, wanted)
        parsed = self.nlu.parse_text(scene.instruction)
        if parsed.graph is None:
            return Asked("Sorry, I did not understand that.", None, [], known, wanted)
        rule = paper_literal if system == "paper_literal" else decide
        decision = rule(parsed.graph, [Candidate(one.id, one.graph) for one in known])
        question = compose(decision, task=parsed.task, unseen_share=found.unseen_share)
        return self._said(name, decision, question, Asked("", None, [], known, wanted))

    def _said(self, name: str, decision: Decision, question: Question, asked: Asked) -> Asked:
        clauses = [Clause(part.instance_ids, part.text, part.graph) for part in question.parts]
        text = pick(question.wordings, self.seed, name)
        return msgspec.structs.replace(asked, text=text, state=decision.state, clauses=clauses)

    def _instances(self, scene: Scene) -> Instances:
        room = self.room(scene)
        if self._map is None:
            self._map = count_instances(room, self._language.graphs(room))
        return self._map


def _same_place(
    scene: Scene, truth: Sequence[TrueInstance], found: Sequence[Instance]
) -> list[str]:
    """Return the map's instances that are the wanted objects: nearest of the class, 0.5 m.

    All visible objects of the class take part, so that no instance stands for two.
    """
    said = scene.graph.name
    of_class = [one for one in visible(truth) if name_satisfies(said, name_of(one.object_type))]
    pairs = sorted(
        (float(np.linalg.norm(np.subtract(item.center_m, one.position_m))), k, one.instance_id)
        for k, item in enumerate(of_class)
        for one in found
        if name_satisfies(said, one.graph.name)
    )
    taken: dict[int, str] = {}
    for gap_m, k, name in pairs:
        if gap_m <= NEAR_M and k not in taken and name not in taken.values():
            taken[k] = name
    wanted = {item.object_id for item in scene.wanted}
    return [taken[k] for k, item in enumerate(of_class) if item.object_id in wanted and k in taken]


def read_queries(paths: Sequence[Path]) -> dict[tuple[str, str, str], str]:
    """Return other systems' queries by (system, recording, instruction), from JSON lines.

    Raises:
        Refused: a file cannot be read, or a line does not fit.
    """
    found: dict[tuple[str, str, str], str] = {}
    for path in paths:
        try:
            lines = path.read_bytes().splitlines()
        except OSError as error:
            raise Refused(f"{path} cannot be read: {error.strerror}") from error
        for number, line in enumerate(lines, 1):
            if not line.strip():
                continue
            try:
                one = msgspec.json.decode(line, type=_Line)
            except (msgspec.DecodeError, RecursionError) as error:
                raise Refused(
                    f"line {number} of {path} does not fit: {error}; a line looks like"
                    ' {"system": "baseline", "recording": "...", "instruction": "...",'
                    ' "text": "..."}'
                ) from error
            found[one.system, one.recording, one.instruction] = one.text
    return found


class _Line(msgspec.Struct):
    system: str
    recording: str
    instruction: str
    text: str


def _number(text: str) -> int:
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big")
