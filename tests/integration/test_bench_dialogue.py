"""A small slice of the dialogue's benchmark through real services: what it measures adds up."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.integration.test_bench import bench


def test_dialogue_bench_asks_through_the_bus_and_says_where_the_time_goes(tmp_path: Path) -> None:
    figures = bench(tmp_path, "dialogue", "--count", "8", "--scenes", "8")
    part = {
        name: figures[f"speed/dialogue/bus_{name}_p50_ms"]
        for name in ("instruction_to_query", "without_state", "nlu", "mapper", "dialogue", "rest")
    }
    assert figures["speed/dialogue/bus_queries"] == 8
    assert part["without_state"] == pytest.approx(
        part["nlu"] + part["mapper"] + part["dialogue"] + part["rest"], abs=1e-3
    )
    assert min(part[name] for name in ("without_state", "nlu", "mapper", "dialogue")) > 0
