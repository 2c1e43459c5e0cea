"""Beliefs and early questions: raised when settled, revised, withdrawn, the last word the same."""

from __future__ import annotations

import random

import pytest

from doro_dialogue.core import Dialogue
from doro_dialogue.settings import DialogueSettings
from doro_schemas.effects import Ask
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Answer, Belief, Instances, Query
from tests.unit.test_dialogue_core import (
    BLUE_CUP,
    RED_CUP,
    delta,
    finished,
    instruction,
    reply,
    started,
)

GREEN_CUP = ObjectGraph("cup", {"color": "green"})
CUP = ObjectGraph("cup")


def early(**settings) -> Dialogue:
    defaults = {"belief_every_frames": 1, "early_beliefs": 2}
    return Dialogue(DialogueSettings(**{**defaults, **settings}))


def watch(core: Dialogue, *seen: list[ObjectGraph], first: int = 0, **fields) -> list:
    """Frames stream; after each the map knows these instances."""
    outputs = []
    for i, graphs in enumerate(seen, first):
        asks = core.grid_delta(delta(i))
        for ask in asks:
            assert isinstance(ask, Ask)
            outputs += core.instances(reply(*graphs, merged=i + 1, **fields))
    return outputs


def exploring(said: ObjectGraph = CUP, **settings) -> Dialogue:
    core = early(**settings)
    core.exploration(started())
    core.instruction_graph(instruction(said))
    return core


def queries(outputs: list) -> list[Query]:
    return [output for output in outputs if isinstance(output, Query)]


def test_a_belief_says_how_stable_and_how_sure_it_is():
    core = exploring(early_beliefs=0)
    seen = [[], [RED_CUP], [RED_CUP, BLUE_CUP], [RED_CUP, BLUE_CUP]]
    beliefs = watch(core, *seen, unseen_share=0.5)
    assert all(isinstance(one, Belief) for one in beliefs)
    assert [(one.state, one.stable_beliefs) for one in beliefs] == [
        ("INFORM-MISSING", 1),
        ("CONFIRM", 1),
        ("INFORM-AMBIGUITY", 1),
        ("INFORM-AMBIGUITY", 2),
    ]
    assert [one.confidence for one in beliefs] == [-1.0, 1.0, 1.0, 1.0]
    assert beliefs[0].unseen_share == 0.5


def test_by_default_nothing_is_asked_before_the_end():
    core = Dialogue(DialogueSettings(belief_every_frames=1))
    core.exploration(started())
    core.instruction_graph(instruction(CUP))
    assert queries(watch(core, *[[RED_CUP, BLUE_CUP]] * 30)) == []


def test_a_settled_belief_is_asked_early_and_stands_at_the_end():
    core = exploring()
    outputs = watch(core, [RED_CUP, BLUE_CUP], [RED_CUP, BLUE_CUP])
    (query,) = queries(outputs)
    assert (query.state, query.early, query.revision) == ("INFORM-AMBIGUITY", True, 0)
    assert (query.stamp_ns, query.frames_merged) == (101, 2)
    (ask,) = core.exploration(finished())
    assert isinstance(ask, Ask)
    assert core.instances(reply(RED_CUP, BLUE_CUP, merged=3)) == []


def test_new_evidence_revises_an_early_question_and_names_what_it_replaces():
    core = exploring()
    two, three = [RED_CUP, BLUE_CUP], [RED_CUP, BLUE_CUP, GREEN_CUP]
    outputs = watch(core, two, two, three, three)
    first, second = queries(outputs)
    assert (second.revision, second.replaces, len(second.clauses)) == (1, first.revision, 3)
    assert second.text.startswith("I have looked further.")


def test_a_question_that_resolves_itself_is_a_confirmation_that_replaces_it():
    core = exploring(RED_CUP)
    two = [RED_CUP, RED_CUP]
    outputs = watch(core, two, two, [RED_CUP], [RED_CUP])
    first, second = queries(outputs)
    assert (first.state, second.state) == ("INFORM-AMBIGUITY", "CONFIRM")
    assert (second.replaces, second.clauses[0].instance_ids) == (0, ["cup-1"])


def test_what_is_no_longer_there_withdraws_the_question_until_the_end():
    core = exploring()
    two = [RED_CUP, BLUE_CUP]
    asked, withdrawn = queries(watch(core, two, two, [], []))
    assert (withdrawn.reason, withdrawn.replaces, withdrawn.clauses) == ("withdrawn", 0, [])
    with pytest.raises(Refused, match="was withdrawn: wait for its next query"):
        core.answer(Answer(text="the red one", dialogue_id=asked.dialogue_id))
    with pytest.raises(Refused, match="nothing was asked"):
        core.answer(Answer(text="the red one"))
    core.exploration(finished())
    (last,) = core.instances(reply(merged=5))
    assert (last.state, last.revision, last.replaces) == ("INFORM-MISSING", 2, 1)


@pytest.mark.parametrize(
    ("said", "seen"),
    [(CUP, []), (RED_CUP, [BLUE_CUP]), (RED_CUP, [BLUE_CUP, GREEN_CUP]), (RED_CUP, [CUP])],
)
def test_what_may_still_come_into_view_is_never_asked_early(said, seen):
    assert queries(watch(exploring(said), *[seen] * 20)) == []


def test_one_frame_that_differs_starts_the_count_anew():
    core = exploring(early_beliefs=3)
    two, one = [RED_CUP, BLUE_CUP], [RED_CUP]
    assert queries(watch(core, two, two, one, two, two)) == []
    assert len(queries(watch(core, two, first=5))) == 1


def test_unseen_area_and_doubtful_instances_keep_it_waiting():
    core = exploring(early_unseen_share=0.2)
    assert queries(watch(core, *[[RED_CUP, BLUE_CUP]] * 5, unseen_share=0.3)) == []
    assert len(queries(watch(core, [RED_CUP, BLUE_CUP], first=5, unseen_share=0.2))) == 1
    sure = exploring(early_confidence=1.0)
    assert len(queries(watch(sure, *[[RED_CUP, BLUE_CUP]] * 2))) == 1
    doubtful = reply(RED_CUP, BLUE_CUP)
    doubtful.instances = [
        type(one)(**{f: getattr(one, f) for f in one.__struct_fields__} | {"confidence": 0.5})
        for one in doubtful.instances
    ]
    unsure = exploring(early_confidence=0.8)
    for i in range(5):
        unsure.grid_delta(delta(i))
        assert queries(unsure.instances(doubtful)) == []


def test_an_early_answer_ends_the_dialogue_and_the_rest_of_the_exploration_is_silent():
    core = exploring()
    two = [RED_CUP, BLUE_CUP]
    watch(core, two, two)
    said, target = core.answer(Answer(text="the second", stamp_ns=9))
    assert (said.ended, target.instance_id) == ("resolved", "cup-2")
    assert watch(core, two, [RED_CUP], first=2) == []
    assert core.exploration(finished()) == []


def test_the_last_word_is_the_same_however_the_processes_are_scheduled():
    """Replies lag behind the deltas by chance; at the end the substance is one and the same."""
    last = set()
    texts = set()
    for seed in range(40):
        rng = random.Random(seed)
        core = exploring()
        said: list[Query] = []
        waiting: list[Instances] = []
        for i in range(12):
            graphs = [RED_CUP, BLUE_CUP, GREEN_CUP][: 1 + i // 4]
            for _ in core.grid_delta(delta(i)):
                waiting.append(reply(*graphs, merged=i + 1))
            while waiting and rng.random() < 0.6:
                said += queries(core.instances(waiting.pop(0)))
        for one in waiting:
            said += queries(core.instances(one))
        outputs = core.exploration(finished())
        while outputs:
            said += queries(outputs)
            asks = [one for one in outputs if isinstance(one, Ask)]
            outputs = [
                one
                for _ in asks
                for one in core.instances(reply(RED_CUP, BLUE_CUP, GREEN_CUP, merged=12))
            ]
        final = said[-1]
        assert [q.revision for q in said] == list(range(len(said)))
        last.add((final.state, final.reason, tuple(final.matches), final.map_digest))
        texts.add(final.text.removeprefix("I have looked further. "))
    assert len(last) == len(texts) == 1
