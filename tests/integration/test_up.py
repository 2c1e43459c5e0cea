"""`doro up` as its user meets it: zenoh put, status, a service that dies, a clean stop."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Iterator

import psutil
import pytest

from doro_console.processes import NEEDED, free_port
from doro_schemas.bus import Bus, BusSettings
from doro_schemas.messages import Health, InstructionGraph, Query
from doro_schemas.messages.base import Message
from doro_schemas.topics import TOPICS
from doro_sim_feeder.presence import Presence
from tests.integration.chain import BIN, READY_S, SAMPLE

ENDPOINT = f"tcp/127.0.0.1:{free_port()}"
ON = ("--set", f"bus.endpoint={ENDPOINT}", "--set", "dialogue.state_dir=off")


def doro(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [str(BIN / "doro"), *arguments, *ON]
    return subprocess.run(command, capture_output=True, text=True, timeout=90, check=False)


@pytest.fixture(scope="module")
def up() -> Iterator[subprocess.Popen[str]]:
    command = [str(BIN / "doro"), "up", *ON]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        line = process.stderr.readline()
        assert "all services are up" in line, line + process.stderr.read()
        yield process
        process.send_signal(signal.SIGTERM)


@pytest.fixture(scope="module")
def bus(up: subprocess.Popen[str]) -> Iterator[Bus]:
    with Bus("test", BusSettings(endpoint=ENDPOINT, open_timeout_s=READY_S)) as opened:
        yield opened


def zenoh_put(text: str) -> None:
    """The newcomer's command, with the flags that the README names."""
    command = [
        *(str(BIN / "zenoh"), "--mode", "client", "--connect", ENDPOINT),
        *("put", "-k", TOPICS["instruction"].key, "-v", text),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 0, done.stderr


def test_zenoh_put_of_plain_text_is_understood_and_answered(bus: Bus) -> None:
    heard: list[Message] = []
    bus.subscribe(TOPICS["instruction_graph"], heard.append, late=False)
    queries: list[Message] = []
    bus.subscribe(TOPICS["query"], queries.append, late=False)
    played = doro("play", str(SAMPLE))
    assert played.returncode == 0, played.stderr
    assert json.loads(played.stdout)["merged"] == 72
    zenoh_put("bring me the red cup")
    assert bus.run_until(time.monotonic() + 30, lambda: bool(queries))
    parsed, query = heard[-1], queries[-1]
    assert isinstance(parsed, InstructionGraph)
    assert parsed.graph is not None
    assert parsed.graph.attributes == {"color": "red"}
    assert isinstance(query, Query)
    assert query.state == "INFORM-AMBIGUITY"


def test_say_prints_the_answer() -> None:
    said = doro("say", "bring me the blue cup")
    assert said.returncode == 0, said.stderr
    assert "blue cup" in said.stdout
    assert "CONFIRM" in said.stdout


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "instruction is empty"), ("good morning", "not understood"), ("x" * 3000, "3000 char")],
)
def test_say_of_nothing_is_one_sentence(text: str, words: str) -> None:
    said = doro("say", text)
    assert said.returncode == 1
    assert words in said.stderr
    assert len(said.stderr.strip().splitlines()) == 1


def test_status_shows_all_services_alive() -> None:
    shown = doro("status", "--json")
    assert shown.returncode == 0, shown.stdout + shown.stderr
    statuses = {one["service"]: one for one in map(json.loads, shown.stdout.splitlines())}
    assert set(NEEDED) <= set(statuses)
    assert all(one["alive"] for one in statuses.values())
    assert statuses["mapper"]["health"]["counters"]["received.depth"] == 72


def test_a_service_that_cannot_start_is_named_with_its_own_words() -> None:
    endpoint = f"bus.endpoint=tcp/127.0.0.1:{free_port()}"
    command = [str(BIN / "doro"), "up", "--set", "perception.backend=crystal", "--set", endpoint]
    done = subprocess.run(command, capture_output=True, text=True, timeout=55, check=False)
    assert done.returncode == 1
    assert "not running on this router: doro-perception" in done.stderr
    assert "Invalid enum value 'crystal'" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_second_up_is_refused() -> None:
    second = doro("up")
    assert second.returncode == 1
    assert "already running" in second.stderr
    assert len(second.stderr.strip().splitlines()) == 1


def test_a_service_that_is_killed_comes_back(bus: Bus) -> None:
    first: dict[str, Health] = {}
    bus.subscribe(TOPICS["health"], lambda one: _keep(first, one))
    assert bus.run_until(time.monotonic() + 10, lambda: "nlu" in first)
    before = first["nlu"].uptime_s
    presence = Presence(bus)
    presence.wait_for(["nlu"], 10)
    _kill_service("doro-nlu")
    assert bus.run_until(time.monotonic() + 10, lambda: "nlu" not in presence.alive)
    presence.wait_for(["nlu"], READY_S)
    assert bus.run_until(time.monotonic() + 10, lambda: first["nlu"].uptime_s < before)
    said = doro("say", "bring me the blue cup")
    assert "CONFIRM" in said.stdout, said.stderr


def test_sigterm_stops_everything(up: subprocess.Popen[str], bus: Bus) -> None:
    presence = Presence(bus)
    presence.wait_for(NEEDED, 10)
    pids = _pids()
    assert len(pids) >= len(NEEDED) + 1
    up.send_signal(signal.SIGTERM)
    assert up.wait(30) == 0
    assert not _pids()


def _keep(health: dict[str, Health], message: Message) -> None:
    if isinstance(message, Health):
        health[message.service] = message


def _pids() -> dict[int, str]:
    """Return the service processes that were started with our endpoint."""
    found = {}
    for process in psutil.process_iter(["cmdline"]):
        words = process.info["cmdline"] or []
        services = [word for word in words[:2] if "/doro-" in word]
        if services and any(ENDPOINT in word for word in words):
            found[process.pid] = services[0]
    return found


def _kill_service(name: str) -> None:
    (pid,) = [pid for pid, command in _pids().items() if command.endswith(name)]
    os.kill(pid, signal.SIGKILL)
