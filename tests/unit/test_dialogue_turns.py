"""Answers over messages: whose they are, what comes back, how a dialogue ends."""

from __future__ import annotations

import pytest

from doro_console.lines import load_nlu
from doro_dialogue.core import Dialogue
from doro_dialogue.settings import DialogueSettings
from doro_nlu.core import Nlu
from doro_schemas.effects import Ask, Output, Unanswered
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import (
    Answer,
    Exploration,
    Instance,
    Instances,
    InstancesRequest,
    InstructionGraph,
    ParseRequest,
    Query,
    Target,
)

CUP, BOWL = ObjectGraph("cup"), ObjectGraph("bowl")
ON_TABLE = [Relation("is-on", ObjectGraph("table"))]
WORLD = [
    ObjectGraph("cup", {"color": "red"}, ON_TABLE),
    ObjectGraph("cup", {"color": "blue"}),
    ObjectGraph("cup", {"color": "green"}),
    ObjectGraph("bowl", {"color": "white"}, ON_TABLE),
]


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return load_nlu(())


class Room:
    """The core with nlu's parser and a map beside it, as the shell connects them."""

    def __init__(self, nlu: Nlu, world=WORLD, **settings) -> None:
        self.core, self._nlu = Dialogue(DialogueSettings(**settings)), nlu
        self.world = list(world)
        self.asked: list[str] = []
        self.explore("room")

    def explore(self, episode: str) -> list[Output]:
        self.run(self.core.exploration(Exploration(state="started", episode=episode)))
        done = Exploration(state="finished", episode=episode, stamp_ns=90)
        return self.run(self.core.exploration(done))

    def say(
        self, graph: ObjectGraph = CUP, text: str = "bring me the cup", readings=()
    ) -> list[Output]:
        message = InstructionGraph(
            text=text, task="bring", graph=graph, readings=list(readings), stamp_ns=100
        )
        return self.run(self.core.instruction_graph(message))

    def look_again(self) -> list[Output]:
        """The robot has looked further: the map may have changed."""
        done = Exploration(state="finished", episode="room", stamp_ns=300)
        return self.run(self.core.exploration(done))

    def answer(self, text: str, dialogue_id: str = "", stamp_ns: int = 200) -> list[Output]:
        message = Answer(text=text, dialogue_id=dialogue_id, stamp_ns=stamp_ns)
        return self.run(self.core.answer(message))

    def run(self, outputs: list[Output]) -> list[Output]:
        published, waiting = [], list(outputs)
        while waiting:
            output = waiting.pop(0)
            if not isinstance(output, Ask):
                published.append(output)
            elif isinstance(output.request, ParseRequest):
                self.asked.append(output.request.text)
                waiting += self.core.parse_reply(self._nlu.parse(output.request))
            else:
                assert isinstance(output.request, InstancesRequest)
                waiting += self.core.instances(self.map(output.request.name))
        return published

    def map(self, name: str) -> Instances:
        found = [
            Instance(
                instance_id=f"{graph.name}-{i + 1}",
                graph=graph,
                position_m=[float(i), 1.0, 2.0],
                extent_m=[0.1, 0.2, 0.1],
                cells=[[i, i, 0]],
            )
            for i, graph in enumerate(self.world)
            if graph.name == name
        ]
        return Instances(
            name=name, episode="room", frames_merged=9, last_frame=8, instances=found, digest="d"
        )


def only(outputs: list[Output], kind):
    return [output for output in outputs if isinstance(output, kind)]


def test_an_answer_gives_the_target_and_the_acknowledgement(nlu):
    room = Room(nlu)
    (query,) = room.say()
    assert (query.state, query.revision) == ("INFORM-AMBIGUITY", 0)
    said, target = room.answer("the red one")
    assert room.asked == ["the red cup"]
    assert isinstance(said, Query)
    assert isinstance(target, Target)
    assert (said.dialogue_id, said.revision, said.reason) == ("room/1", 1, "answered")
    assert said.text.endswith("I will take the red cup on top of the table.")
    assert said.clauses[0].cells == [[0, 0, 0]]
    assert (target.dialogue_id, target.instance_id, target.episode) == ("room/1", "cup-1", "room")
    assert (target.graph, target.stamp_ns) == (WORLD[0], 200)
    assert (target.position_m, target.extent_m) == ([0.0, 1.0, 2.0], [0.1, 0.2, 0.1])
    assert (room.core.counters["answers"], room.core.counters["resolved"]) == (1, 1)


def test_an_ordinal_needs_no_parser(nlu):
    room = Room(nlu)
    room.say()
    assert only(room.answer("the second"), Target)[0].instance_id == "cup-2"
    assert room.asked == []


def test_plain_text_has_no_stamp_and_takes_the_questions(nlu):
    room = Room(nlu)
    (query,) = room.say()
    assert {output.stamp_ns for output in room.answer("the second", stamp_ns=0)} == {query.stamp_ns}


def test_all_of_them_are_several_targets(nlu):
    room = Room(nlu)
    room.say()
    targets = only(room.answer("all three"), Target)
    assert [one.instance_id for one in targets] == ["cup-1", "cup-2", "cup-3"]


def test_a_narrower_question_is_a_revision_and_its_answer_is_held_against_it(nlu):
    room = Room(nlu)
    room.say()
    (narrower,) = room.answer("not the red one")
    assert (narrower.dialogue_id, narrower.revision) == ("room/1", 1)
    assert [clause.instance_ids for clause in narrower.clauses] == [["cup-2"], ["cup-3"]]
    assert only(room.answer("the first one"), Target)[0].instance_id == "cup-2"


def test_a_confirmation_gives_the_target_and_may_still_be_corrected(nlu):
    room = Room(nlu)
    query, target = room.say(ObjectGraph("cup", {"color": "red"}))
    assert (query.state, query.ended, target.instance_id) == ("CONFIRM", "", "cup-1")
    assert (target.stamp_ns, target.position_m) == (query.stamp_ns, [0.0, 1.0, 2.0])
    assert only(room.answer("no, the blue one"), Target)[0].instance_id == "cup-2"


def test_silence_after_a_confirmation_is_consent(nlu):
    room = Room(nlu, timeout_s=1.0)
    room.say(ObjectGraph("cup", {"color": "red"}))
    assert room.core.tick(10**9) == room.core.tick(3 * 10**9) == []
    with pytest.raises(Refused, match=r"finished \(resolved\)"):
        room.answer("no, the blue one", "room/1")


@pytest.mark.parametrize(
    ("world", "settings"),
    [([CUP, WORLD[0]], {}), ([WORLD[0]], {"target_on_confirm": False})],
)
def test_without_certainty_or_by_setting_only_a_yes_gives_the_target(nlu, world, settings):
    room = Room(nlu, world=world, **settings)
    (query,) = room.say(ObjectGraph("cup", {"color": "red"}))
    assert query.state == "CONFIRM"
    assert only(room.answer("yes"), Target)[0].graph == WORLD[0]


def test_yes_takes_what_is_offered(nlu):
    room = Room(nlu, world=[ObjectGraph("cup", {"color": "blue"})])
    (query,) = room.say(ObjectGraph("cup", {"color": "red"}))
    assert query.state == "INFORM-MISMATCH"
    assert only(room.answer("yes please"), Target)[0].instance_id == "cup-1"


def test_another_object_is_asked_of_the_map(nlu):
    room = Room(nlu)
    room.say()
    said, target = room.answer("I meant the bowl")
    assert (said.state, said.revision, said.instruction) == ("CONFIRM", 1, "I meant the bowl")
    assert (said.input_graph, target.instance_id) == (BOWL, "bowl-4")
    with pytest.raises(Refused, match=r"'room/1' is finished \(resolved\)"):
        room.answer("the red one", "room/1")


def test_another_object_of_which_there_are_several_is_asked_about(nlu):
    room = Room(nlu, world=[*WORLD, ObjectGraph("bowl", {"color": "black"})])
    room.say()
    (query,) = room.answer("I meant the bowl")
    assert (query.state, query.revision, len(query.clauses)) == ("INFORM-AMBIGUITY", 1, 2)
    assert only(room.answer("the black one"), Target)[0].instance_id == "bowl-5"
    assert room.asked == ["the bowl", "the black bowl"]


def test_two_people_are_two_dialogues(nlu):
    room = Room(nlu, world=[*WORLD, ObjectGraph("bowl", {"color": "black"})])
    room.say()
    room.say(BOWL, "bring me the bowl")
    assert only(room.answer("the red one", "room/1"), Target)[0].instance_id == "cup-1"
    assert only(room.answer("the black one", "room/2"), Target)[0].instance_id == "bowl-5"


def test_an_answer_without_an_id_goes_to_the_dialogue_that_spoke_last(nlu):
    room = Room(nlu, world=[*WORLD, ObjectGraph("bowl", {"color": "black"})])
    room.say()
    room.say(BOWL, "bring me the bowl")
    assert only(room.answer("the first"), Target)[0].dialogue_id == "room/2"
    assert only(room.answer("the first"), Target)[0].dialogue_id == "room/1"
    with pytest.raises(Refused, match="nothing was asked that 'the first' could answer"):
        room.answer("the first")


def test_without_an_id_a_person_answers_the_own_question(nlu):
    room = Room(nlu, world=[*WORLD, ObjectGraph("bowl", {"color": "black"})])
    for person, graph in (("ann", CUP), ("bob", BOWL)):
        message = InstructionGraph(text="bring it", graph=graph, person=person, stamp_ns=1)
        (query,) = room.run(room.core.instruction_graph(message))
        assert query.person == person

    def answer(person: str, text: str) -> list[Output]:
        return room.run(room.core.answer(Answer(text=text, person=person, stamp_ns=2)))

    assert only(answer("ann", "the second"), Target)[0].instance_id == "cup-2"
    with pytest.raises(Refused, match="nothing was asked that 'the first' could answer"):
        answer("ann", "the first")
    assert only(answer("bob", "the black one"), Target)[0].instance_id == "bowl-5"


def test_an_answer_to_an_unknown_dialogue_is_refused(nlu):
    room = Room(nlu)
    with pytest.raises(Refused, match="nothing was asked"):
        room.answer("the red one")
    room.say()
    with pytest.raises(Refused, match="there is no dialogue 'room/7'"):
        room.answer("the red one", "room/7")
    assert only(room.answer("the red one", "room/1"), Target)


def test_a_cancelled_dialogue_is_finished(nlu):
    room = Room(nlu)
    room.say()
    (said,) = room.answer("never mind")
    assert (said.reason, said.text, said.clauses) == ("cancelled", "Okay, I will leave it.", [])
    with pytest.raises(Refused, match="finished"):
        room.answer("the red one", "room/1")


def test_the_limit_of_turns_ends_with_a_message(nlu):
    room = Room(nlu, max_turns=3)
    room.say()
    reasons = [room.answer("hm, the big one")[0].reason for _ in range(3)]
    assert reasons == ["ask_again", "ask_again", "turn_limit"]
    with pytest.raises(Refused, match=r"finished \(turn limit\)"):
        room.answer("the red one", "room/1")
    assert room.core.counters["turn_limits"] == 1


def test_asking_again_and_again_does_not_pile_up_words(nlu):
    room = Room(nlu)
    room.say()
    texts = [room.answer("yes")[0].text for _ in range(3)]
    assert all(text.count("I could not tell") == 1 for text in texts)


def test_another_place_is_searched_in_the_next_episode(nlu):
    room = Room(nlu, world=[])
    (missing,) = room.say()
    assert missing.state == "INFORM-MISSING"
    (said,) = room.answer("look in the kitchen")
    assert (said.reason, said.text) == ("search_again", "Okay, I will look there.")
    room.world = [WORLD[0]]
    query, target = room.explore("kitchen")
    assert target.dialogue_id == "kitchen/1"
    assert (query.dialogue_id, query.state, query.revision) == ("kitchen/1", "CONFIRM", 0)
    assert only(room.answer("yes"), Target)[0].dialogue_id == "kitchen/1"


def test_an_answer_to_a_dialogue_of_an_earlier_episode_is_refused(nlu):
    room = Room(nlu)
    room.say()
    room.explore("kitchen")
    with pytest.raises(Refused, match="there is no dialogue 'room/1'"):
        room.answer("the red one", "room/1")


def test_without_the_parser_the_answer_is_refused_and_may_be_said_again(nlu):
    room = Room(nlu)
    room.say()
    (ask,) = room.core.answer(Answer(text="the red one"))
    lost = Unanswered(request=ask.request, reason="nobody answered doro/nlu/parse within 2 s")
    with pytest.raises(Refused, match="the answer 'the red one' is lost, say it again"):
        room.core.unanswered(lost)
    assert only(room.answer("the red one"), Target)[0].instance_id == "cup-1"


def test_an_answered_question_is_not_raised_again_by_a_new_delta(nlu):
    room = Room(nlu)
    room.say()
    room.answer("not the red one")
    done = Exploration(state="finished", episode="room", stamp_ns=300)
    assert room.run(room.core.exploration(done)) == []
    room.world.append(ObjectGraph("cup", {"color": "white"}))
    (query,) = room.run(room.core.exploration(done))
    assert (query.revision, len(query.clauses)) == (2, 4)
    room.answer("the red one")
    room.world.pop()
    assert room.run(room.core.exploration(done)) == []
