"""A small slice of each benchmark: that it measures what it says, not how fast."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

from tests.integration.chain import BIN


def bench(tmp_path: Path, *arguments: str) -> dict[str, float]:
    path = tmp_path / "figures.json"
    command = [str(BIN / "doro"), "bench", *arguments, "--json", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    report = json.loads(path.read_text(encoding="utf-8"))
    assert set(report) == {"figures", "command", "seed", "version"}
    figures: dict[str, float] = report["figures"]
    return figures


def test_bus_bench_loses_nothing_on_either_side(tmp_path: Path) -> None:
    figures = bench(tmp_path, "bus", "--count", "20")
    for series in ("1kB", "rgbd"):
        assert figures[f"speed/bus/{series}_received"] == 20
        assert figures[f"speed/bus/{series}_raw_p50_us"] > 0
        assert figures[f"speed/bus/{series}_ours_p50_us"] > 0


def test_play_bench_takes_every_frame(tmp_path: Path) -> None:
    figures = bench(tmp_path, "play", "--paced", "5")
    assert figures["speed/play/frames"] == 167
    assert figures["speed/play/lost"] == 0
    assert figures["speed/play/pacing_p95_ms"] >= 0
    assert figures["speed/play/paced_elapsed_s"] >= 0.5  # five frames at 10 Hz take their time
