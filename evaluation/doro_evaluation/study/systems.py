"""What each system asks in a scene of a study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import numpy as np

from doro_dialogue.decision import Decision, decide, paper_literal
from doro_dialogue.facts import Candidate
from doro_dialogue.question import Question, compose, pick
from doro_evaluation.chain import Language, Room, count_instances, load_room
from doro_evaluation.study.files import Asked, KnownInstance
from doro_evaluation.study.scenes import Scene
from doro_nlu.core import Nlu
from doro_schemas.errors import Refused
from doro_schemas.messages import Instance, Instances
from doro_schemas.messages.talk import Clause
from doro_schemas.vocabulary import name_satisfies
from doro_sim_feeder.rooms.expressions import name_of, true_graph, visible
from doro_sim_feeder.rooms.truth import TrueInstance

SYSTEMS = ("ours", "paper_literal", "reference")
"""The whole chain; the paper's decision and templates on the same map; ours on the truth."""
NEAR_M = 0.5


def check_systems(names: Sequence[str], given: Mapping[tuple[str, str, str], str]) -> list[str]:
    """Return the systems, each once.

    Args:
        given: other systems' queries.

    Raises:
        Refused: there is none of a name, or none at all.
    """
    known = [*SYSTEMS, *dict.fromkeys(system for system, _, _ in given)]
    wanted = list(dict.fromkeys(name.strip() for name in names if name.strip()))
    for name in wanted:
        if name not in known:
            raise Refused(f"there is no system '{name}': use {', '.join(known)}")
    if not wanted:
        raise Refused(f"name a system: {', '.join(known)}")
    return wanted


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
        asked = Asked("", None, [], known, wanted, parsed.graph)
        return self._said(name, decision, question, asked)

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
