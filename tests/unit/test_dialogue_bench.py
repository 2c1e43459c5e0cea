"""The dialogue's benchmark: that it measures what it says; never how fast."""

from __future__ import annotations

import json
from pathlib import Path

from click.testing import CliRunner

from doro_console.__main__ import main
from doro_dialogue.decision import decide
from doro_evaluation.bench.dialogue import SAID, instructions, run_core_bench, scenes


def test_scenes_have_their_candidates_and_ask_as_well_as_confirm() -> None:
    made = scenes(5, 60, 0)
    assert all(len(one.candidates) == 5 for one in made)
    states = {decide(one.said, one.candidates).state for one in made}
    assert {"INFORM-AMBIGUITY", "CONFIRM"} <= states
    assert made[0].said is SAID[0]
    assert scenes(5, 3, 0)[2].candidates == made[2].candidates


def test_figures_are_there_and_ordered() -> None:
    figures = run_core_bench(count=8)
    for name in ("decide_5", "decide_100", "answer_5"):
        p50, p99 = (float(figures[f"speed/dialogue/{name}_{q}_ms"]) for q in ("p50", "p99"))
        assert 0 < p50 <= p99


def test_instructions_are_all_different() -> None:
    made = instructions(185)
    assert len(set(made)) == 185


def test_the_command_writes_flat_figures(tmp_path: Path) -> None:
    path = tmp_path / "f.json"
    done = CliRunner().invoke(
        main, ["bench", "dialogue", "--no-bus", "--scenes", "8", "--json", str(path)]
    )
    assert done.exit_code == 0, done.output
    figures = json.loads(path.read_text())["figures"]
    assert figures["speed/dialogue/decide_5_p50_ms"] > 0
