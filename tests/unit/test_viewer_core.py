"""The viewer's core: what it asks for, and when it draws."""

import socket
from pathlib import Path

import numpy as np
import pytest
import viewer_session as made

from doro_schemas import messages as m
from doro_schemas.effects import Ask, Unanswered
from doro_schemas.errors import Refused
from doro_schemas.messages.base import Message
from doro_viewer.core import Viewer
from doro_viewer.live import LiveViewer
from doro_viewer.service import check_settings
from doro_viewer.settings import ViewerSettings

LISTENERS = Path("/proc/net/tcp")


class Shown:
    def __init__(self) -> None:
        self.messages: list[Message] = []
        self.pictures: list[np.ndarray] = []

    def show(self, message: Message) -> None:
        self.messages.append(message)

    def keep(self, picture: np.ndarray, dialogue: str) -> None:
        self.pictures.append(picture)


def free_ports(count: int) -> list[int]:
    probes = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [int(probe.getsockname()[1]) for probe in probes]
    for probe in probes:
        probe.close()
    return ports


def listeners(port: int) -> list[str]:
    """Return the IPv4 addresses on which anyone listens on a port."""
    rows = [line.split() for line in LISTENERS.read_text().splitlines()[1:]]
    local = [row[1].split(":") for row in rows if row[3] == "0A"]
    found = [bytes.fromhex(address)[::-1] for address, number in local if int(number, 16) == port]
    return [socket.inet_ntoa(address) for address in found]


def viewer() -> tuple[Viewer, Shown]:
    shown = Shown()
    return Viewer(ViewerSettings(), shown, shown), shown


def delta(seq: int, *, reset: bool = False) -> m.GridDelta:
    return m.GridDelta(
        seq=seq,
        reset=reset,
        frame=seq,
        frames_merged=seq,
        cell_m=0.05,
        band_m=0.25,
        cells=np.zeros((0, 6), dtype=np.int32),
        weights=np.zeros(0, dtype=np.float32),
    )


def test_a_query_asks_for_the_map_and_the_class_and_then_draws_once() -> None:
    core, shown = viewer()
    grid, found = core.query(made.query())
    assert isinstance(grid, Ask)
    assert isinstance(found, Ask)
    assert grid.request == m.GridRequest(stamp_ns=6_000_000_000)
    assert found.request == m.InstancesRequest(name="cup", stamp_ns=6_000_000_000)
    assert core.grid(made.snapshot()) == []
    assert shown.pictures == []
    assert core.instances(made.instances()) == []
    assert len(shown.pictures) == 1
    assert core.counters["pictures"] == 1


def test_a_revised_query_is_drawn_again_from_new_replies() -> None:
    core, shown = viewer()
    for revision in (0, 1):
        core.query(made.query(revision))
        core.grid(made.snapshot())
        core.instances(made.instances())
    assert len(shown.pictures) == 2


def test_a_gap_in_the_deltas_asks_for_the_whole_map() -> None:
    core, shown = viewer()
    assert core.delta(delta(0)) == []
    assert core.delta(delta(1)) == []
    assert core.delta(delta(4)) == [Ask(m.GridRequest())]
    assert core.delta(delta(5)) == []
    assert core.delta(delta(0, reset=True)) == []
    core.grid(made.snapshot())
    assert core.counters["grid_gaps"] == 1
    assert shown.pictures == []
    assert isinstance(shown.messages[-1], m.GridSnapshot)


def test_no_reply_is_shown_and_counted() -> None:
    core, shown = viewer()
    core.query(made.query())
    lost = Unanswered(request=m.GridRequest(), reason="nobody answered: is mapper up?")
    assert core.unanswered(lost) == []
    core.instances(made.instances())
    assert shown.pictures == []
    assert core.counters["unanswered"] == 1
    assert lost in shown.messages


def test_live_watching_is_bound_to_loopback() -> None:
    for settings in (ViewerSettings(serve=True), ViewerSettings(spawn=True)):
        arguments = LiveViewer(settings).arguments()
        assert arguments[arguments.index("--bind") + 1] == "127.0.0.1"
    page = LiveViewer(ViewerSettings(grpc_port=4000, web_port=4001)).page
    assert page == "http://127.0.0.1:4001/?url=rerun%2Bhttp%3A%2F%2F127.0.0.1%3A4000%2Fproxy"


@pytest.mark.skipif(not LISTENERS.exists(), reason="needs Linux's /proc")
def test_the_served_page_listens_on_loopback_alone_and_ends_with_it() -> None:
    ports = free_ports(2)
    with LiveViewer(ViewerSettings(serve=True, grpc_port=ports[0], web_port=ports[1])):
        assert [listeners(port) for port in ports] == [["127.0.0.1"], ["127.0.0.1"]]
        with pytest.raises(Refused, match=f"port {ports[0]} on 127.0.0.1 is taken"):
            LiveViewer(ViewerSettings(spawn=True, grpc_port=ports[0])).open()
    assert [listeners(port) for port in ports] == [[], []]


def test_contradicting_settings_are_refused() -> None:
    with pytest.raises(Refused, match="choose page or window"):
        check_settings(ViewerSettings(serve=True, spawn=True))
    with pytest.raises(Refused, match=r"viewer\.jpeg_quality must be in 1\.\.100, got 0"):
        check_settings(ViewerSettings(jpeg_quality=0))
