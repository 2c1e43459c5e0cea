"""What survives: restarts, a lost map, silence. No bus, no clock: time comes in."""

from __future__ import annotations

import pytest

from doro_console.lines import load_nlu
from doro_dialogue.core import Dialogue
from doro_dialogue.settings import DialogueSettings
from doro_nlu.core import Nlu
from doro_schemas import codec
from doro_schemas.effects import Ask
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.kept import Due, Kept
from doro_schemas.messages import (
    Answer,
    Exploration,
    InstancesRequest,
    InstructionGraph,
    ParseRequest,
    Query,
    Target,
)
from doro_schemas.statefile import StateFile, default_folder, file_name
from tests.unit.test_dialogue_core import (
    BLUE_CUP,
    RED_CUP,
    delta,
    dialogue,
    finished,
    instruction,
    reply,
    started,
)
from tests.unit.test_dialogue_turns import CUP, WORLD, Room, only

S = 1_000_000_000


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return load_nlu(())


def restarted(core: Dialogue, **settings) -> tuple[Dialogue, list]:
    """A new process with what the old one kept."""
    fresh = Dialogue(DialogueSettings(**settings))
    return fresh, fresh.restore(core.snapshot())


class Restarting(Room):
    """A room whose dialogue service is started anew before every message."""

    def restart(self) -> list:
        self.core, outputs = restarted(self.core)
        return self.run(outputs)

    def answer(self, text: str, dialogue_id: str = "", stamp_ns: int = 200) -> list:
        assert self.restart() == []
        return super().answer(text, dialogue_id, stamp_ns)


CONVERSATIONS = [
    ["the red one"],
    ["not the red one", "the first one"],
    ["yes", "the big one", "no", "the green one"],
    ["I meant the bowl"],
    ["the purple one", "the blue one"],
    ["all three"],
    ["never mind"],
]


@pytest.mark.parametrize("answers", CONVERSATIONS, ids=[" / ".join(c) for c in CONVERSATIONS])
def test_a_restart_before_every_answer_changes_no_byte(nlu, answers):
    said = []
    for kind in (Room, Restarting):
        room = kind(nlu)
        outputs = room.say()
        for words in answers:
            outputs += room.answer(words)
        said.append([codec.encode(one) for one in outputs])
    assert said[0] == said[1]


def test_a_restart_while_the_map_is_asked_asks_again():
    core = dialogue()
    core.instruction_graph(instruction(CUP))
    (ask,) = core.exploration(finished())
    fresh, outputs = restarted(core)
    assert outputs == [ask]
    (query,) = fresh.instances(reply(RED_CUP, BLUE_CUP))
    assert (query.dialogue_id, query.revision, query.stamp_ns) == ("room/1", 0, 90)


def test_a_restart_while_the_parser_reads_an_answer_asks_it_again(nlu):
    room = Room(nlu)
    room.say()
    (ask,) = room.core.answer(Answer(text="the red one", stamp_ns=7))
    assert isinstance(ask.request, ParseRequest)
    room.core, outputs = restarted(room.core)
    assert outputs == [ask]
    assert only(room.run(outputs), Target)[0].instance_id == "cup-1"


def test_a_restart_while_exploring_keeps_what_waits():
    core = dialogue()
    core.exploration(started())
    core.instruction_graph(instruction(CUP))
    fresh, outputs = restarted(core)
    assert outputs == []
    (ask,) = fresh.exploration(finished())
    assert isinstance(ask, Ask)
    assert isinstance(ask.request, InstancesRequest)


def test_the_latest_messages_come_once_more_to_a_late_joiner_and_change_nothing():
    core = dialogue()
    core.exploration(started())
    core.instruction_graph(instruction(CUP))
    core.grid_delta(delta(9))
    core.exploration(finished())
    core.instances(reply(RED_CUP, BLUE_CUP))
    fresh, _ = restarted(core)
    assert fresh.instruction_graph(instruction(CUP)) == []
    assert fresh.exploration(finished()) == []
    assert fresh.grid_delta(delta(9)) == []
    assert fresh.counters["repeated"] == 3
    # Said once more it is a new instruction.
    (ask,) = fresh.instruction_graph(instruction(CUP))
    assert isinstance(ask, Ask)


def test_a_start_that_was_handled_does_not_begin_the_episode_again():
    core = dialogue()
    core.exploration(started())
    core.instruction_graph(instruction(CUP))
    core.grid_delta(delta(-1, reset=True))
    fresh, _ = restarted(core)
    fresh.exploration(started())
    fresh.grid_delta(delta(-1, reset=True))
    (ask,) = fresh.exploration(finished())
    assert isinstance(ask, Ask)


def test_what_is_no_snapshot_is_refused_and_changes_nothing():
    core = dialogue()
    core.exploration(finished())
    before = core.snapshot()
    for bad in (b"", b"\x00", b"\x81\xa5phase\xa3odd", before[:-1]):
        with pytest.raises(Refused, match="dialogues that were kept do not fit"):
            core.restore(bad)
    assert core.snapshot() == before


def test_an_empty_map_is_a_lost_map_and_takes_nothing_back():
    core = dialogue()
    core.instruction_graph(instruction(CUP))
    core.exploration(finished())
    core.instances(reply(RED_CUP, BLUE_CUP, merged=10))
    core.instruction_graph(instruction(CUP, text="bring me another", stamp_ns=6))
    with pytest.raises(Refused, match="the map has 0 frames and had 10: the mapper was started"):
        core.instances(reply(merged=0))
    assert core.counters["maps_lost"] == 1
    # The first question stands; the second instruction waits for the next exploration.
    (ask,) = core.answer(Answer(text="the red one", dialogue_id="room/1"))
    assert isinstance(ask.request, ParseRequest)
    assert core.exploration(started("room")) == []
    (ask,) = core.exploration(finished("room"))
    assert isinstance(ask.request, InstancesRequest)


def test_without_an_open_question_a_lost_map_is_a_new_beginning(nlu):
    """The whole system was started anew, and only the dialogue remembers."""
    room = Room(nlu)
    room.say()
    room.answer("the red one")
    core, _ = restarted(room.core)
    (ask,) = core.instruction_graph(instruction(CUP))
    assert isinstance(ask.request, InstancesRequest)
    assert core.instances(reply(merged=0)) == []
    assert core.exploration(started("other")) == []
    (ask,) = core.exploration(finished("other"))
    (query,) = core.instances(reply(RED_CUP, BLUE_CUP))
    assert query.dialogue_id == "other/1"


# --- silence -------------------------------------------------------------------------------


def test_silence_ends_a_dialogue_with_a_message(nlu):
    room = Room(nlu, timeout_s=10.0)
    (query,) = room.say()
    assert room.core.tick(100 * S) == []
    assert room.core.tick(109 * S) == []
    (ended,) = room.core.tick(110 * S)
    assert isinstance(ended, Query)
    assert (ended.reason, ended.ended, ended.stamp_ns) == ("timed_out", "timed_out", 110 * S)
    assert (ended.dialogue_id, ended.revision, ended.replaces) == (query.dialogue_id, 1, 0)
    assert (ended.clauses, ended.text.count("I leave it")) == ([], 1)
    assert room.core.tick(1000 * S) == []
    with pytest.raises(Refused, match=r"'room/1' is finished \(timed out\)"):
        room.answer("the red one", "room/1")


def test_an_answer_starts_the_wait_anew(nlu):
    room = Room(nlu, timeout_s=10.0)
    room.say()
    room.core.tick(100 * S)
    room.answer("yes")
    assert room.core.tick(111 * S) == []
    assert room.core.tick(120 * S) == []
    assert len(room.core.tick(121 * S)) == 1


def test_the_wait_goes_on_over_a_restart_and_a_clock_set_back_starts_it_anew(nlu):
    room = Room(nlu, timeout_s=10.0)
    room.say()
    room.core.tick(100 * S)
    core, _ = restarted(room.core, timeout_s=10.0)
    assert len(core.tick(111 * S)) == 1
    core, _ = restarted(room.core, timeout_s=10.0)
    assert core.tick(50 * S) == []
    assert core.tick(59 * S) == []
    assert len(core.tick(60 * S)) == 1


def test_without_a_limit_and_without_a_question_nothing_ends(nlu):
    room = Room(nlu, timeout_s=0.0)
    room.say()
    assert room.core.tick(S) == room.core.tick(10**6 * S) == []
    waiting = dialogue(timeout_s=1.0)
    waiting.exploration(started())
    waiting.instruction_graph(instruction(CUP))
    assert waiting.tick(S) == waiting.tick(10**6 * S) == []


# --- the file ------------------------------------------------------------------------------


def test_a_state_file_holds_what_was_saved_last(tmp_path):
    path = tmp_path / "folder" / "a.state"
    file = StateFile(path, "doro.Test")
    assert file.load() is None
    assert file.save(b"one")
    assert not file.save(b"one")
    assert file.save(b"two")
    assert StateFile(path, "doro.Test").load() == b"two"
    file.sync()
    path.unlink()
    file.sync()  # nothing was saved since: the file is not looked at
    assert file.save(b"three")
    path.unlink()
    with pytest.raises(Refused, match="cannot be kept"):
        file.sync()
    assert file.save(b"four")
    assert [one.name for one in path.parent.iterdir()] == ["a.state"]


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda content: content[:-3], "no complete msgpack map"),
        (lambda content: b"", "no complete msgpack map"),
        (lambda content: content.replace(b"hello", b"jello"), "checksum"),
        (lambda content: content.replace(b"doro.Test", b"doro.Text"), "'doro.Text' version 1"),
        (lambda content: b"\x01", "no state"),
    ],
)
def test_a_damaged_file_is_kept_aside_with_one_sentence(tmp_path, damage, says):
    path = tmp_path / "a.state"
    StateFile(path, "doro.Test").save(b"hello")
    content = damage(path.read_bytes())
    path.write_bytes(content)
    file = StateFile(path, "doro.Test")
    with pytest.raises(Refused, match=says) as caught:
        file.load()
    assert "starting afresh" in caught.value.reason
    assert (tmp_path / "a.state.damaged").read_bytes() == content
    assert file.load() is None
    assert file.save(b"new")


def test_a_folder_that_takes_nothing_is_refused_once(tmp_path):
    (tmp_path / "file").write_text("no folder")
    kept = Kept(StateFile(tmp_path / "file" / "a.state", "doro.Test"), lambda: b"x")
    with pytest.raises(Refused, match="choose another folder with the setting state_dir"):
        kept.save(())
    kept.save(())


def test_what_may_not_have_been_said_is_said_again(tmp_path):
    path = tmp_path / "a.state"
    query = Answer(text="hello", stamp_ns=3)
    Kept(StateFile(path, "doro.Test"), lambda: b"core").save(
        [query, Ask(InstancesRequest(name="cup"))]
    )
    given = []
    fresh = Kept(StateFile(path, "doro.Test"), lambda: b"core")
    assert fresh.load(lambda state: given.append(state) or []) == [query]
    assert given == [b"core"]
    fresh.save(())
    assert Kept(StateFile(path, "doro.Test"), lambda: b"").load(lambda state: []) == []


def test_a_state_that_the_core_refuses_is_kept_aside(tmp_path):
    path = tmp_path / "a.state"
    Kept(StateFile(path, "doro.Test"), lambda: b"old").save(())
    core = dialogue()
    with pytest.raises(Refused, match=r"do not fit.*starting afresh"):
        Kept(StateFile(path, "doro.Test"), core.snapshot).load(core.restore)
    assert not path.exists()


def test_every_namespace_on_every_router_has_its_own_file(monkeypatch, tmp_path):
    names = {
        file_name("dialogue", namespace, endpoint)
        for namespace in ("", "robot/1", "robot-2")
        for endpoint in ("tcp/127.0.0.1:7447", "tcp/127.0.0.1:7448")
    }
    assert len(names) == 6
    assert not any("/" in name for name in names)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    assert default_folder() == tmp_path / "doro"


def test_what_is_due_is_taken_once_a_period_and_what_was_missed_is_skipped():
    due = Due(2.0, lambda now_ns: [], 10.0)
    taken = [now for now in (10.0, 11.9, 12.0, 12.1, 14.5, 15.9, 23.0, 23.5, 24.0) if due.take(now)]
    assert taken == [12.0, 14.5, 23.0, 24.0]


def test_the_state_holds_positions_so_that_a_target_needs_no_map(nlu):
    room = Room(nlu, world=[ObjectGraph("cup", {"color": "blue"}), WORLD[0]])
    room.say()
    room.core, _ = restarted(room.core)
    room.world = []
    (target,) = only(room.answer("the red one"), Target)
    assert target.position_m == [1.0, 1.0, 2.0]


def test_messages_that_were_not_understood_are_no_trouble_after_a_restart():
    core = dialogue()
    core.exploration(Exploration(state="finished", episode="room"))
    core.instruction_graph(InstructionGraph(text="hm", graph=None))
    fresh, outputs = restarted(core)
    assert outputs == fresh.instruction_graph(InstructionGraph(text="hm", graph=None)) == []
