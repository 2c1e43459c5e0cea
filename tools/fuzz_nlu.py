"""Random and mutated strings against nlu: ``python -m tools.fuzz_nlu --count 100000 --seed 0``.

Every string goes the way of the wire: bytes -> ``decode_text`` -> the core -> ``encode``. What must
come out is a graph, a reason, or a refusal of one sentence; anything else ends the run. Prints
counts and the longest single parse as JSON.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_schemas import codec
from doro_schemas.errors import Refused
from doro_schemas.graph import MAX_DEPTH, ObjectGraph, walk
from doro_schemas.messages import Instruction, InstructionGraph, ParseRequest

_DATA = Path(__file__).resolve().parents[1] / "evaluation" / "doro_evaluation" / "data"
_HUGE_BYTES = 100_000
_POOLS = (
    "abcdefghijklmnopqrstuvwxyz ",
    " .,;:!?'\"()-/&",
    "0123456789 ",
    "äöüßéñçøåœ ",
    "漢字赤いカップ한글컵 ",
    "\u202e\u200f\u200b\u2066אבגד عربي ",
    "e\u0301\u0308\u0327a\u20e3\ufe0f ",
    "\U0001f600\U0001f964\U0001f468\u200d\U0001f469 ",
    "\x00\x01\x07\x08\x0b\x1b\x7f\t\r\n ",
)
_SALAD = """
the a red cup plate table on near in with it that which is of and , not bring take go to between
box containing one my from under
"""


def strings(count: int, seed: int, texts: list[str]) -> Iterator[bytes]:
    """Yield payloads: noise of every kind, English word salad, and mutations of ``texts``."""
    rng = random.Random(seed)
    makers = (_noise, _salad, _mutated, _mutated, _bytes)
    for number in range(count):
        if number % 2000 == 0:
            yield _huge(rng)
        elif number % 500 == 1:
            yield b" " * rng.randrange(4)
        else:
            yield rng.choice(makers)(rng, texts)


def _noise(rng: random.Random, _texts: list[str]) -> bytes:
    pools = rng.sample(_POOLS, rng.choice((1, 1, 2, 9)))
    length = rng.choice((1, 3, 12, 40, 200))
    if rng.random() < 0.01:
        length = 2000
    return "".join(rng.choice(rng.choice(pools)) for _ in range(length)).encode()


def _salad(rng: random.Random, _texts: list[str]) -> bytes:
    count = rng.choice((1, 4, 8, 16, 40))
    if rng.random() < 0.01:
        count = 380
    words = _SALAD.split()
    return " ".join(rng.choice(words) for _ in range(count)).encode()


def _mutated(rng: random.Random, texts: list[str]) -> bytes:
    text = list(rng.choice(texts))
    for _ in range(rng.choice((1, 1, 2, 5, 20))):
        at = rng.randrange(len(text) + 1)
        kind = rng.randrange(5)
        if kind == 0:
            text[at:at] = rng.choice(rng.choice(_POOLS))
        elif kind == 1:
            del text[at : at + rng.randrange(1, 6)]
        elif kind == 2:
            text[at:at] = text[at : at + rng.randrange(1, 30)]
        elif kind == 3:
            text[at:at] = list(rng.choice(texts))[rng.randrange(20) :]
        else:
            text[at : at + 1] = "".join(text[at : at + 1]).swapcase()
    return "".join(text)[:2000].encode()


def _bytes(rng: random.Random, texts: list[str]) -> bytes:
    """Bytes that are no UTF-8: noise, or a text that is cut or spoilt inside a character."""
    if rng.random() < 0.3:
        return rng.randbytes(rng.choice((1, 5, 60)))
    raw = bytearray(rng.choice(texts).encode())
    broken = (b"\xff", b"\xc3", b"\xed\xa0\x80", b"\xf8\x88\x80\x80\x80", b"\xc0\x80")
    raw[rng.randrange(len(raw)) : 0] = rng.choice(broken)
    at = rng.randrange(len(raw) + 1)
    raw[at:at] = rng.choice(broken)
    return bytes(raw)


def _huge(rng: random.Random) -> bytes:
    piece = rng.choice((b"red cup ", b"a", "\U0001f600".encode(), b"\n", b"\xff"))
    return piece * (_HUGE_BYTES // len(piece))


class Run:
    """Feeds payloads to one core and counts what comes out."""

    def __init__(self, nlu: Nlu) -> None:
        self.nlu = nlu
        self.outcomes: Counter[str] = Counter()
        self.longest_ms, self.longest_of = 0.0, b""

    def feed(self, payload: bytes) -> None:
        """Take one payload; raise AssertionError where what comes out is neither nor."""
        started = time.thread_time()
        try:
            outcome = self._outcome(payload)
        except Refused as refused:
            check_sentence(refused.reason)
            outcome = "refused"
        spent_ms = (time.thread_time() - started) * 1e3
        self.outcomes[outcome] += 1
        if spent_ms > self.longest_ms:
            self.longest_ms, self.longest_of = spent_ms, payload

    def _outcome(self, payload: bytes) -> str:
        message = codec.decode_text(payload, Instruction)
        assert isinstance(message, Instruction)
        (reply,) = self.nlu.instruction(message)
        assert isinstance(reply, InstructionGraph)
        sent = codec.decode(codec.encode(reply), codec.encoding_of(InstructionGraph))
        assert sent == reply, "the wire changes it"
        check(reply)
        caption = self.nlu.parse(ParseRequest(text=message.text, caption=True))
        assert (caption.graph is None) == bool(caption.reason)
        return "graph" if reply.graph else reply.reason_kind


def check_sentence(reason: str) -> None:
    """Raise AssertionError unless a reason is one line of sensible length."""
    assert reason.strip()
    assert reason.isprintable()
    assert len(reason) < 400


def check(reply: InstructionGraph) -> None:
    """Raise AssertionError unless a reply is well formed."""
    assert len(reply.tokens) == len(reply.labels) == len(reply.probabilities)
    assert (reply.graph is None) == bool(reply.reason) == bool(reply.reason_kind)
    check_sentence(reply.reason or "-")
    assert 0.0 <= reply.confidence <= 1.0
    assert len(reply.readings) == len(reply.reading_confidences)
    assert not reply.readings or reply.graph is not None
    assert reply.reading_confidences == sorted(reply.reading_confidences, reverse=True)
    graphs = [one for one in (reply.graph, *reply.readings) if one is not None]
    for at, graph in enumerate(graphs):
        assert graph not in graphs[:at], "a reading twice"
        assert all(node.name == node.name.strip().lower() for node in walk(graph))
        assert _depth(graph) <= MAX_DEPTH


def _depth(graph: ObjectGraph) -> int:
    return 1 + max((_depth(one.target) for one in graph.relations), default=0)


def base_texts() -> list[str]:
    """Return the sentences that are mutated: the hand-written instructions."""
    lines = (_DATA / "instructions.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line)["text"] for line in lines]


def fuzz(count: int, seed: int, tagger: str) -> dict[str, object]:
    """Run ``count`` strings; return the figures."""
    run = Run(Nlu(NluSettings(tagger=tagger)))
    started = time.monotonic()
    for number, payload in enumerate(strings(count, seed, base_texts()), 1):
        try:
            run.feed(payload)
        except Exception as error:
            error.add_note(f"string {number} of seed {seed}: {payload[:300]!r}")
            raise
        if number % 10_000 == 0:
            done = f"{number} strings, longest {run.longest_ms:.1f} ms, {dict(run.outcomes)}"
            print(done, file=sys.stderr, flush=True)
    return {
        "count": count,
        "seed": seed,
        "tagger": tagger,
        "outcomes": dict(sorted(run.outcomes.items())),
        "longest_parse_cpu_ms": round(run.longest_ms, 1),
        "longest_text": run.longest_of[:80].decode("utf-8", "replace"),
        "longest_text_bytes": len(run.longest_of),
        "wall_s": round(time.monotonic() - started, 1),
    }


def main() -> None:
    """Run the fuzz from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--tagger", default="bilstm")
    arguments = parser.parse_args()
    figures = fuzz(arguments.count, arguments.seed, arguments.tagger)
    print(json.dumps(figures, ensure_ascii=False, indent=2))


if __name__ == "__main__":
    main()
