"""Fifteen lines of somebody else's code take the place of our perception."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

from tests.integration.chain import READY_S, Chain

FOREIGN = Path(__file__).parent / "foreign_perception.py"


def test_it_uses_nothing_of_ours() -> None:
    tree = ast.parse(FOREIGN.read_text(encoding="utf-8"))
    imported = {
        alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import)
        for alias in node.names
    }
    assert imported == {"sys", "msgpack", "zenoh"}
    statements = [line for line in FOREIGN.read_text(encoding="utf-8").splitlines() if line.strip()]
    assert len(statements) - 1 <= 15  # the docstring aside


def test_the_chain_gives_the_right_answer_with_it() -> None:
    with Chain(("router", "nlu", "mapper", "dialogue")) as chain:
        foreign = subprocess.Popen([sys.executable, str(FOREIGN), chain.endpoint])
        try:
            chain.presence.wait_for(["perception"], READY_S)
            chain.say("bring me the red cup")
            report = chain.play()
            query = chain.query(1)
        finally:
            foreign.terminate()
            foreign.wait(10)
    assert report.merged == report.frames == 72
    assert query.state == "INFORM-AMBIGUITY"
    assert len(query.instances) == 5
    assert len(query.matches) == 2
    assert chain.rejected == []
