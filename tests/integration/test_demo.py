"""`doro demo` on the sample: the four states, the pictures, and what the README shows."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import cv2

from tests.integration.chain import BIN, ROOT

STATES = ["INFORM-AMBIGUITY", "CONFIRM", "INFORM-MISMATCH", "INFORM-MISSING"]


def test_the_demo_gives_all_four_states_and_the_readme_shows_its_words(tmp_path: Path) -> None:
    command = [str(BIN / "doro"), "demo", "--json", "--out", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stderr
    queries = [json.loads(line) for line in done.stdout.splitlines()]
    assert [query["state"] for query in queries] == STATES
    ambiguity = queries[0]
    assert len(ambiguity["instances"]) == 5
    assert len(ambiguity["matches"]) == len(ambiguity["clauses"]) == 2
    for clause in ambiguity["clauses"]:
        assert clause["cells"]
        assert all("red plastic cup" in view["caption"] for view in clause["evidence"])

    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for query in queries:
        assert query["text"] in readme
        assert query["instruction"] in readme

    assert (tmp_path / "demo.rrd").read_bytes()[:4] == b"RRF2"
    for number in ("", "-2", "-3", "-4"):
        picture = cv2.imread(str(tmp_path / f"map{number}.png"))
        assert picture is not None
        assert picture.shape[1] == 1200


def test_an_instruction_without_an_object_ends_with_one_sentence(tmp_path: Path) -> None:
    command = [str(BIN / "doro"), "demo", "-i", "good morning", "--out", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 1
    assert "'good morning' was not understood" in done.stderr
    assert "Traceback" not in done.stderr
