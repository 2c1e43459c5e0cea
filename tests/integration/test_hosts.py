"""Several hosts: mutual TLS and access by role, with the files that ``doro hosts`` makes."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from doro_console.hosts import make_hosts
from doro_console.processes import free_port
from doro_schemas.bus import Bus, BusSettings
from doro_schemas.bus.access import ROLES, SERVICES, Host, access_control, parse_host
from doro_schemas.errors import Refused
from doro_schemas.messages import Exploration, Instruction, Query
from doro_schemas.messages.base import Message
from doro_schemas.topics import TABLE, topic_of
from doro_sim_feeder.play import Player, PlaySettings
from doro_sim_feeder.presence import Presence
from doro_sim_feeder.recording import Recording
from tests.integration.chain import BIN, READY_S, SAMPLE

HOSTS = [
    Host("bot", ("robot", "perception")),
    Host("edge", ("nlu", "mapper", "dialogue")),
    Host("desk", ("person",)),
]
WAIT_S = 10.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The files of three hosts, and a router that runs with its own."""
    path = tmp_path_factory.mktemp("hosts")
    make_hosts(path, "localhost", HOSTS, free_port(), "")
    with router("--set", f'bus.router_config="{path / "router.json5"}"'):
        yield path


@contextmanager
def router(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-m", "doro_schemas.router", *arguments]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(WAIT_S)
        if process.stderr is not None:
            process.stderr.close()


def bus_of(folder: Path, name: str, open_timeout_s: float = WAIT_S) -> Bus:
    settings = BusSettings(config=str(folder / f"{name}.json5"), open_timeout_s=open_timeout_s)
    return Bus(name, settings)


def test_a_message_passes_when_the_senders_role_may_send_it(folder: Path) -> None:
    with bus_of(folder, "edge") as edge, bus_of(folder, "desk") as desk:
        heard: list[Message] = []
        edge.subscribe(topic_of(Instruction), heard.append)
        publish_until(desk, Instruction(text="bring me the cup"), edge, heard)
        assert [type(one) for one in heard[:1]] == [Instruction]


def test_a_person_cannot_play_the_robot(folder: Path) -> None:
    """The forged message is dropped at the router; the robot's own, sent later, arrives."""
    with (
        bus_of(folder, "edge") as edge,
        bus_of(folder, "desk") as desk,
        bus_of(folder, "bot") as bot,
    ):
        heard: list[Message] = []
        edge.subscribe(topic_of(Exploration), heard.append)
        desk.publish(Exploration(episode="forged", state="started"))
        publish_until(bot, Exploration(episode="own", state="started"), edge, heard)
        episodes = {one.episode for one in heard}
        assert episodes == {"own"}


def publish_until(sender: Bus, message: Message, receiver: Bus, heard: list[Message]) -> None:
    """Send until something is heard: a late link may lose the first."""
    stop = threading.Event()

    def send() -> None:
        while not stop.is_set():
            sender.publish(message)
            stop.wait(0.1)

    thread = threading.Thread(target=send)
    thread.start()
    try:
        receiver.run_until(time.monotonic() + WAIT_S, lambda: bool(heard))
    finally:
        stop.set()
        thread.join()
    assert heard, "nothing arrived"


def test_without_a_certificate_of_this_authority_there_is_no_way_in(
    folder: Path, tmp_path: Path
) -> None:
    endpoint = next(
        line.split('"')[1]
        for line in (folder / "desk.json5").read_text().splitlines()
        if "tls/localhost" in line
    )
    make_hosts(tmp_path, "localhost", HOSTS, int(endpoint.rpartition(":")[2]), "")
    with pytest.raises(Refused, match="no Zenoh router answers"):
        bus_of(tmp_path, "desk", open_timeout_s=0.5).open()


def test_files_with_keys_are_for_their_owner_alone(folder: Path) -> None:
    for name in ("router.json5", "bot.json5", "edge.json5", "desk.json5", "authority.key"):
        assert (folder / name).stat().st_mode & 0o077 == 0, name


def test_the_authority_is_kept_when_a_host_is_added(tmp_path: Path) -> None:
    make_hosts(tmp_path, "edge-1", HOSTS[:1], 7447, "")
    before = (tmp_path / "authority.pem").read_bytes()
    make_hosts(tmp_path, "edge-1", HOSTS, 7447, "")
    assert (tmp_path / "authority.pem").read_bytes() == before
    (tmp_path / "authority.key").write_text("nonsense")
    with pytest.raises(Refused, match="authority"):
        make_hosts(tmp_path, "edge-1", HOSTS, 7447, "")


@pytest.mark.parametrize("endpoint", ["tcp/0.0.0.0:0", "tcp/[::]:0", "tls/0.0.0.0:0"])
def test_the_router_does_not_listen_wider_by_a_changed_address(endpoint: str) -> None:
    with router("--set", f"bus.endpoint={endpoint}") as process:
        assert process.wait(WAIT_S) == 1
        assert process.stderr is not None
        said = process.stderr.read()
    assert "will not listen" in said
    assert "doro hosts" in said


def test_every_topic_has_a_host_that_may_send_it() -> None:
    rules = access_control([Host("all", ROLES)])["rules"]
    keys = next(rule["key_exprs"] for rule in rules if rule["id"] == "serve-all")
    for topic in TABLE:
        expected = topic.key_for(camera="*", service="nlu", replica="*")
        assert expected in keys, topic.name


@pytest.mark.parametrize("text", ["edge", "edge=", "edge=cook", "=nlu", "Edge 1=nlu"])
def test_a_host_that_cannot_be_read_is_refused(text: str) -> None:
    with pytest.raises(Refused, match="host"):
        parse_host(text)


def test_the_whole_chain_runs_over_tls_from_three_hosts(folder: Path, tmp_path: Path) -> None:
    """The robot plays the sample room, the edge merges and asks, the person hears the question."""
    services = [(name, host.name) for host in HOSTS for name in host.roles if name in SERVICES]
    with ExitStack() as stack:
        for name, host in services:
            stack.enter_context(service(name, folder / f"{host}.json5", tmp_path))
        robot = stack.enter_context(bus_of(folder, "bot"))
        person = stack.enter_context(bus_of(folder, "desk"))
        queries: list[Message] = []
        person.subscribe(topic_of(Query), queries.append, late=False)
        Presence(robot).wait_for([name for name, _ in services], READY_S)
        person.publish(Instruction(text="bring me the red cup", stamp_ns=1))
        report = Player(robot, PlaySettings()).play(Recording(SAMPLE))
        person.run_until(time.monotonic() + READY_S, lambda: bool(queries))
    assert report.lost == 0
    assert [(type(one), getattr(one, "state", "")) for one in queries[:1]] == [
        (Query, "INFORM-AMBIGUITY")
    ]


@contextmanager
def service(name: str, config: Path, state_dir: Path) -> Iterator[None]:
    command = [str(BIN / f"doro-{name}"), "--set", f"bus.config={config}"]
    command += ["--set", f"dialogue.state_dir={state_dir}"]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.terminate()
        assert process.wait(20) == 0
