"""A real AI2-THOR walk through the real detector to decisions for things that are there."""

from __future__ import annotations

from pathlib import Path

import pytest

from doro_sim_feeder.folder import FrameFolder
from doro_sim_feeder.recording import write_recording
from tests.integration.chain import Chain
from tests.unit.test_walk_geometry import WALKS

pytestmark = pytest.mark.skipif(not WALKS.exists(), reason="the recorded walks are not here")


def test_the_bed_and_the_chairs_of_walk_nine(tmp_path: Path) -> None:
    folder = FrameFolder(WALKS)
    (walk,) = [task for task in folder.tasks if task.startswith("task_9")]
    path = tmp_path / "walk.mcap"
    write_recording(path, folder.messages([walk], "walk-9"))
    with Chain(settings=["perception.backend=coco"]) as chain:
        chain.say("find the bed")
        report = chain.play(path)
        assert (report.frames, report.merged) == (40, 40)
        bed = chain.query(1)
        chain.say("bring the chair near the table")
        chair = chain.query(2)
        chain.say("find the red bed")
        red = chain.query(3)
    assert bed.state == "CONFIRM"
    assert len(bed.instances) == 1
    assert "bed" in bed.clauses[0].evidence[0].caption
    # Three chairs round one table: which of them count as near it hangs on noisy boxes.
    assert chair.state in ("CONFIRM", "INFORM-AMBIGUITY")
    assert 2 <= len(chair.instances) <= 5
    assert all("near the" in clause.text for clause in chair.clauses)
    assert red.state == "INFORM-MISMATCH"
    assert "blue" in red.text
    assert chain.rejected == []
