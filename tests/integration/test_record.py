"""Recording from the bus, and playing that recording again."""

from __future__ import annotations

import subprocess
from pathlib import Path

from doro_schemas import codec
from doro_sim_feeder.recording import Recording, describe
from tests.integration.chain import BIN, READY_S, Chain


def test_a_recorded_run_plays_to_the_same_query(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    command = [str(BIN / "doro"), "record", "--bus", "--out", str(path)]
    with Chain() as chain:
        recorder = subprocess.Popen([*command, "--set", f"bus.endpoint={chain.endpoint}"])
        chain.presence.wait_for(["recorder"], READY_S)
        chain.say("bring me the red cup")
        chain.play()
        first = codec.encode(chain.query(1))
        recorder.terminate()
        assert recorder.wait(20) == 0

        counts = describe(Recording(path))["messages"]
        assert counts["doro/frames/cam0/depth"] == counts["doro/captions"] == 72
        assert counts["doro/grid/delta"] == 73  # and one for the start
        assert counts["doro/query"] == 1

        assert chain.play(path).merged == 72
        chain.say("bring me the red cup")
        assert codec.encode(chain.query(2)) == first
