"""The dialogue over messages: when it asks, what it publishes, how it recovers."""

from __future__ import annotations

import numpy as np
import pytest

from doro_dialogue.core import Dialogue
from doro_dialogue.settings import DialogueSettings
from doro_schemas.effects import Ask, Unanswered
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import (
    Belief,
    Evidence,
    Exploration,
    GridDelta,
    Instance,
    Instances,
    InstructionGraph,
    Query,
)

RED_CUP = ObjectGraph("cup", {"color": "red"})
BLUE_CUP = ObjectGraph("cup", {"color": "blue"})
ON_TABLE = ObjectGraph("cup", {"color": "red"}, [Relation("is-on", ObjectGraph("table"))])


def dialogue(**settings) -> Dialogue:
    return Dialogue(DialogueSettings(**settings))


def instruction(graph=RED_CUP, *, episode="", stamp_ns=5, text="bring me the red cup"):
    return InstructionGraph(
        text=text, task="bring", graph=graph, episode=episode, stamp_ns=stamp_ns
    )


def started(episode="room"):
    return Exploration(state="started", episode=episode, stamp_ns=10)


def finished(episode="room", frames=-1):
    return Exploration(state="finished", episode=episode, stamp_ns=90, frames=frames)


def delta(frame, episode="room", reset=False):
    return GridDelta(
        seq=frame,
        reset=reset,
        frame=frame,
        frames_merged=frame + 1,
        cell_m=0.1,
        band_m=0.2,
        episode=episode,
        stamp_ns=100 + frame,
        cells=np.zeros((0, 6), np.int32),
        weights=np.zeros(0, np.float32),
    )


def reply(*graphs, name="cup", merged=10, **fields):
    found = [
        Instance(
            instance_id=f"cup-{i + 1}",
            graph=graph,
            position_m=[0.0, 1.0, 2.0],
            extent_m=[0.1, 0.1, 0.1],
            evidence=[
                Evidence(camera="cam0", frame=10 * i + k, box_px=[0, 0, 5, 5]) for k in range(4)
            ],
            cells=[[i, i, 0]],
        )
        for i, graph in enumerate(graphs)
    ]
    return Instances(
        name=name,
        episode="room",
        frames_merged=merged,
        last_frame=merged - 1,
        instances=found,
        digest="d1",
        **fields,
    )


def asked(outputs) -> list[str]:
    assert all(isinstance(output, Ask) for output in outputs)
    return [output.request.name for output in outputs]


def test_an_instruction_waits_for_the_end_of_the_exploration_and_is_then_decided():
    core = dialogue()
    assert core.exploration(started()) == []
    assert core.instruction_graph(instruction()) == []
    asks = core.exploration(finished())
    assert asked(asks) == ["cup"]
    assert (asks[0].request.episode, asks[0].request.stamp_ns) == ("room", 90)
    query, _ = core.instances(reply(ON_TABLE, BLUE_CUP, unseen_share=0.25))
    assert isinstance(query, Query)
    assert (query.dialogue_id, query.revision, query.stamp_ns) == ("room/1", 0, 90)
    assert (query.state, query.reason) == ("CONFIRM", "unique_match")
    assert (query.matches, query.instances) == (["cup-1"], ["cup-1", "cup-2"])
    assert query.instruction == "bring me the red cup"
    assert (query.input_graph, query.map_digest) == (RED_CUP, "d1")
    assert query.unseen_share == 0.25
    assert "the red cup on top of the table" in query.text


def test_an_instruction_after_the_end_is_decided_at_once():
    core = dialogue()
    core.exploration(started())
    core.exploration(finished())
    assert asked(core.instruction_graph(instruction(stamp_ns=95))) == ["cup"]
    (query,) = core.instances(reply())
    assert (query.state, query.dialogue_id) == ("INFORM-MISSING", "room/1")


def test_an_instruction_before_any_exploration_is_kept():
    core = dialogue()
    assert core.instruction_graph(instruction()) == []
    assert core.exploration(started()) == []
    assert asked(core.exploration(finished())) == ["cup"]


def test_a_service_that_missed_the_start_takes_the_end():
    core = dialogue()
    core.instruction_graph(instruction())
    assert asked(core.exploration(finished("kitchen"))) == ["cup"]
    query, _ = core.instances(reply(RED_CUP))
    assert query.dialogue_id == "kitchen/1"


def test_an_instruction_for_another_episode_waits_for_it():
    core = dialogue()
    core.exploration(started("a"))
    core.instruction_graph(instruction(episode="b"))
    assert core.exploration(finished("a")) == []
    core.exploration(started("b"))
    assert asked(core.exploration(finished("b"))) == ["cup"]


def test_clauses_carry_ids_graph_cells_and_at_most_three_views():
    core = dialogue()
    core.exploration(finished())
    core.instruction_graph(instruction(ObjectGraph("cup")))
    (query,) = core.instances(reply(RED_CUP, RED_CUP, BLUE_CUP))
    twins, blue = query.clauses
    assert (twins.instance_ids, twins.text) == (["cup-1", "cup-2"], "two identical red cups")
    assert twins.graph == RED_CUP
    assert [view.frame for view in twins.evidence] == [0, 10, 1]
    assert twins.cells == [[0, 0, 0], [1, 1, 0]]
    assert (blue.text, [view.frame for view in blue.evidence]) == ("one blue cup", [20, 21, 22])
    assert twins.text in query.text
    assert blue.text in query.text


def test_several_instructions_are_several_dialogues_matched_by_class_and_order():
    core = dialogue()
    core.exploration(started())
    core.instruction_graph(instruction(RED_CUP))
    core.instruction_graph(instruction(ObjectGraph("bowl")))
    core.instruction_graph(instruction(BLUE_CUP))
    assert asked(core.exploration(finished())) == ["cup", "bowl", "cup"]
    (bowl,) = core.instances(reply(name="bowl"))
    red, target = core.instances(reply(RED_CUP, name="cup"))
    assert target.dialogue_id == "room/1"
    (blue,) = core.instances(reply(RED_CUP, name="cup"))
    assert (bowl.dialogue_id, bowl.state) == ("room/2", "INFORM-MISSING")
    assert (red.dialogue_id, red.state) == ("room/1", "CONFIRM")
    assert (blue.dialogue_id, blue.state) == ("room/3", "INFORM-MISMATCH")


def test_a_late_delta_revises_a_changed_decision_and_only_that():
    core = dialogue()
    core.instruction_graph(instruction())
    core.exploration(finished())
    core.instances(reply(RED_CUP))
    assert asked(core.grid_delta(delta(7))) == ["cup"]
    assert core.instances(reply(RED_CUP, unseen_share=0.1)) == []
    core.grid_delta(delta(8))
    (query,) = core.instances(reply(RED_CUP, ON_TABLE))
    assert (query.revision, query.state, query.stamp_ns) == (1, "INFORM-AMBIGUITY", 108)
    assert core.counters["revisions"] == 1


def test_deltas_during_a_request_ask_once_more_not_once_each():
    core = dialogue()
    core.instruction_graph(instruction())
    core.exploration(finished())
    assert core.grid_delta(delta(1)) == []
    assert core.grid_delta(delta(2)) == []
    query, ask = core.instances(reply(RED_CUP))
    assert isinstance(query, Query)
    assert asked([ask]) == ["cup"]
    assert core.instances(reply(RED_CUP)) == []


def test_a_belief_follows_the_deltas_while_exploring():
    core = dialogue(belief_every_frames=2)
    core.instruction_graph(instruction())
    core.exploration(started())
    assert core.grid_delta(delta(-1, reset=True)) == []
    assert core.grid_delta(delta(0)) == []
    assert asked(core.grid_delta(delta(1))) == ["cup"]
    (belief,) = core.instances(reply(BLUE_CUP, merged=2))
    assert isinstance(belief, Belief)
    assert (belief.dialogue_id, belief.state) == ("room/1", "INFORM-MISMATCH")
    assert (belief.frames_merged, belief.stamp_ns) == (2, 101)


def test_deltas_of_another_episode_are_counted_and_left():
    core = dialogue(belief_every_frames=1)
    core.instruction_graph(instruction())
    core.exploration(started())
    assert core.grid_delta(delta(0, episode="old")) == []
    assert core.counters["other_episode"] == 1


def test_a_new_episode_clears_what_was_decided_and_keeps_what_waits():
    core = dialogue()
    core.exploration(finished("a"))
    core.instruction_graph(instruction(RED_CUP))
    core.instances(reply(RED_CUP))
    core.instruction_graph(instruction(ObjectGraph("bowl")))
    assert core.exploration(started("b")) == []
    assert asked(core.exploration(finished("b"))) == ["bowl"]
    (query,) = core.instances(reply(name="bowl"))
    assert (query.dialogue_id, query.episode) == ("b/1", "b")


def test_a_reply_to_the_episode_before_is_counted_and_left():
    core = dialogue()
    core.instruction_graph(instruction())
    core.exploration(finished("a"))
    core.exploration(started("b"))
    assert core.instances(reply(RED_CUP)) == []
    assert core.counters["unexpected_replies"] == 1


def test_the_map_is_asked_again_until_it_has_the_last_frame():
    core = dialogue(settle_asks=3)
    core.instruction_graph(instruction())
    core.exploration(finished(frames=10))
    assert asked(core.instances(reply(merged=8))) == ["cup"]
    assert asked(core.instances(reply(merged=9))) == ["cup"]
    query, _ = core.instances(reply(RED_CUP, merged=10))
    assert query.state == "CONFIRM"


def test_a_lost_last_frame_does_not_silence_the_dialogue():
    core = dialogue(settle_asks=3)
    core.instruction_graph(instruction())
    outputs = core.exploration(finished(frames=10))
    rounds = 0
    while isinstance(outputs[0], Ask):
        outputs = core.instances(reply(RED_CUP, merged=9))
        rounds += 1
        assert rounds < 10
    assert rounds == 4
    assert outputs[0].state == "CONFIRM"


def test_without_a_map_the_dialogue_waits_and_asks_again():
    core = dialogue()
    core.instruction_graph(instruction())
    (ask,) = core.exploration(finished())
    with pytest.raises(Refused, match="nobody answered; 1 instruction"):
        core.unanswered(Unanswered(request=ask.request, reason="nobody answered"))
    assert asked(core.grid_delta(delta(3))) == ["cup"]
    query, _ = core.instances(reply(RED_CUP))
    assert (query.revision, query.stamp_ns) == (0, 90)


def test_a_sentence_that_was_not_understood_is_counted():
    core = dialogue()
    core.exploration(finished())
    assert core.instruction_graph(instruction(None)) == []
    assert core.counters["not_understood"] == 1


def test_a_graph_that_nests_too_deep_is_refused_and_loses_nothing_else():
    deep = ObjectGraph("cup")
    for _ in range(12):
        deep = ObjectGraph("cup", {}, [Relation("is-on", deep)])
    core = dialogue()
    core.exploration(finished())
    with pytest.raises(Refused, match="nests deeper than 8 landmarks"):
        core.instruction_graph(instruction(deep))
    assert asked(core.instruction_graph(instruction())) == ["cup"]
    with pytest.raises(Refused, match="instance 'cup-1' nests deeper"):
        core.instances(reply(deep))
    assert asked(core.instruction_graph(instruction(BLUE_CUP))) == ["cup", "cup"]


def test_two_runs_over_the_same_messages_say_the_same():
    def run() -> list[object]:
        core = dialogue(seed=3, belief_every_frames=1)
        core.instruction_graph(instruction())
        outputs = core.exploration(started()) + core.grid_delta(delta(0))
        outputs += core.instances(reply(RED_CUP)) + core.exploration(finished())
        return [*outputs, *core.instances(reply(RED_CUP, ON_TABLE, BLUE_CUP))]

    assert run() == run()


def test_paper_literal_is_a_setting():
    core = dialogue(paper_literal=True)
    core.exploration(finished())
    core.instruction_graph(instruction())
    (query,) = core.instances(reply(RED_CUP, RED_CUP))
    assert query.state == "CONFIRM"
    assert query.matches == ["cup-1", "cup-2"]


@pytest.mark.parametrize("wrong", [{"belief_every_frames": 0}, {"settle_asks": -1}])
def test_settings_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValueError, match="must be"):
        DialogueSettings(**wrong)


def test_an_emptied_map_begins_the_episode_even_before_the_word_of_it() -> None:
    """Deltas of a new pass may overtake its ``started``; they revise nothing that is over."""
    core = dialogue()
    core.exploration(started())
    core.instruction_graph(instruction())
    core.exploration(finished())
    core.instances(reply(RED_CUP))
    assert core.grid_delta(delta(-1, reset=True)) == []
    assert core.grid_delta(delta(0)) == []  # not a new look at the old decision
    assert core.exploration(started()) == []
    core.instruction_graph(instruction())
    asks = core.exploration(finished())
    assert len(asks) == 1
    query, _ = core.instances(reply(RED_CUP))
    assert isinstance(query, Query)
    assert (query.dialogue_id, query.revision) == ("room/1", 0)
