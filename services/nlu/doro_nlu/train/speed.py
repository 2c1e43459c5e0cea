"""``python -m doro_nlu.train.speed``: time from text to graph, one thread, beside bert-base.

``--reference DIR`` runs a bert-base model (fp32 ONNX) in turns with the tagger; ``--reference
random`` a network of its shape with random weights, which needs ``onnx`` (extra ``speed``); the
time does not depend on the weights. Neither needs torch.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from doro_nlu.core import Nlu
from doro_nlu.onnx_files import MODEL_FILE, load_session
from doro_nlu.settings import NluSettings
from doro_nlu.tagger import Tagger, load_tagger
from doro_nlu.tokens import tokenize
from doro_nlu.wordpiece import ROW_PIECES, rows_of
from doro_schemas.errors import Refused
from doro_schemas.messages import CaptionedBox, FrameCaptions, ParseRequest

SENTENCES = (
    "find the bed",
    "bring me the red cup",
    "take the plastic cup on the table",
    "can you bring me the red cup from the dining table",
    "go to the kitchen and get the white ceramic bowl next to the sink, then bring it to me",
)
TWELVE = "bring me the red plastic cup on the table near the sink"
COLORS = ("red", "green", "blue", "white", "black")
NAMES = ("cup on the table", "wooden chair", "bowl near the sink", "towel")


class Times(NamedTuple):
    """Of one call: percentiles of the wall clock, and of the thread's own time, microseconds."""

    p50_us: float
    p99_us: float
    cpu_p50_us: float


class Footprint(NamedTuple):
    """Of the service's process: seconds until it can parse, by the wall clock and of its own
    computing (less than the wall's on a busy machine), and its largest memory, megabytes."""

    ready_s: float
    cpu_s: float
    memory_mb: float


def measure(run: Callable[[], object], repeats: int) -> Times:
    """Return the times of a call, after one to warm up."""
    run()
    return _times([_once(run) for _ in range(repeats)])


def _once(run: Callable[[], object]) -> tuple[int, int]:
    wall_ns, cpu_ns = time.perf_counter_ns(), time.thread_time_ns()
    run()
    return time.perf_counter_ns() - wall_ns, time.thread_time_ns() - cpu_ns


def _times(samples: Sequence[tuple[int, int]]) -> Times:
    walls = sorted(wall / 1000 for wall, _ in samples)
    cpus = sorted(cpu / 1000 for _, cpu in samples)
    return Times(walls[len(walls) // 2], walls[len(walls) * 99 // 100], cpus[len(cpus) // 2])


def _captions() -> FrameCaptions:
    boxes = [
        CaptionedBox(box_px=[0, 0, 9, 9], score=0.9, caption=f"a {color} {name}")
        for color in COLORS
        for name in NAMES
    ]
    return FrameCaptions(
        stamp_ns=0, episode="speed", camera="c", frame=0, height_px=10, width_px=10,
        detections=boxes,
    )  # fmt: skip


def reference_session(directory: Path | None) -> Callable[[], object]:
    """Return a call that runs bert-base in fp32 on the 12-token instruction.

    Args:
        directory: of a fine-tuned bert-base; None = its shape (12 layers x 768, 110M) with random
            weights.

    Raises:
        Refused: the model cannot be loaded, or ``onnx`` is missing for the random one.
    """
    if directory is not None:
        tagger = load_tagger(directory)
        tokens = tokenize(TWELVE)
        return lambda: tagger.tag([tokens])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / MODEL_FILE
        _write_random(path)
        session = load_session(path, "")
    rows, _ = rows_of([[[100 + index] for index in range(12)]])
    feed = {"pieces": rows.pieces, "mask": rows.mask}
    return lambda: session.run(None, feed)


def _write_random(path: Path) -> None:
    """Write bert-base's shape with random weights."""
    try:
        from doro_nlu.train.graph import encoder_graph  # noqa: PLC0415 - onnx is an extra
    except ImportError as error:
        raise Refused(
            "the reference of random weights needs onnx: pip install onnx, or name the directory"
            " of a bert-base model"
        ) from error
    draw = np.random.default_rng(0)
    hidden, inner, pieces, labels = 768, 3072, 30522, 15
    sizes = {"words": (pieces, hidden), "positions": (ROW_PIECES, hidden), "norm": (hidden,),
             "head": (hidden, labels)}  # fmt: skip
    parts = {"qkv": (hidden, 3 * hidden), "out": (hidden, hidden), "norm1": (hidden,),
             "up": (hidden, inner), "down": (inner, hidden), "norm2": (hidden,)}  # fmt: skip
    sizes |= {f"l{index}.{part}": size for index in range(12) for part, size in parts.items()}
    weights = {}
    for name, size in sizes.items():
        weights[f"{name}.w"] = draw.standard_normal(size, np.float32) * np.float32(0.02)
        weights[f"{name}.b"] = np.zeros(size[-1], np.float32)
    path.write_bytes(encoder_graph(weights).SerializeToString())


def beside_reference(
    tagger: Tagger, reference: Callable[[], object], repeats: int = 60
) -> tuple[Times, Times]:
    """Return the times of the tagger and of the reference on 12 tokens, run in turns."""
    tokens = tokenize(TWELVE)
    ours, theirs = [], []
    reference()
    tagger.tag([tokens])
    for _ in range(repeats):
        theirs.append(_once(reference))
        ours += [_once(lambda: tagger.tag([tokens])) for _ in range(10)]
    return _times(ours), _times(theirs)


def text_to_graph(tagger: Tagger) -> dict[str, Times]:
    """Return the times of a tagger, of whole sentences, and of the 20 captions of a frame."""
    nlu, cached = Nlu(NluSettings(cache_size=0), tagger), Nlu(NluSettings(), tagger)
    tokens, frame = tokenize(TWELVE), _captions()

    def sentences() -> None:
        for text in SENTENCES:
            nlu.parse(ParseRequest(text=text))

    return {
        "tagger, 12 tokens": measure(lambda: tagger.tag([tokens]), 500),
        "text -> graph, 12 tokens": measure(lambda: nlu.parse_text(TWELVE), 500),
        "text -> graph, 5 sentences": measure(sentences, 200),
        "20 captions, uncached": measure(lambda: nlu.captions(frame), 100),
        "20 captions, cached": measure(lambda: cached.captions(frame), 500),
    }


def footprint(name: str) -> Footprint:
    """Return ready time and memory of a fresh process with the service's code and a tagger."""
    # Not ru_maxrss: a process begins with its parent's.
    code = (
        "import re, time, doro_nlu.service; from doro_nlu.core import Nlu;"
        f" from doro_nlu.settings import NluSettings; Nlu(NluSettings(tagger={name!r}));"
        " status = open('/proc/self/status').read();"
        " print(re.search(r'VmHWM:\\s+([0-9]+)', status)[1], time.process_time())"
    )
    began = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    memory_kb, cpu_s = done.stdout.split()
    return Footprint(time.perf_counter() - began, float(cpu_s), int(memory_kb) / 1024)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tagger", default="default", help="of the shipped ones")
    parser.add_argument("--model", type=Path, help="directory of a model")
    parser.add_argument("--reference", help="directory of a bert-base, or random")
    arguments = parser.parse_args()
    tagger = load_tagger(arguments.model, arguments.tagger)
    figures = text_to_graph(tagger)
    if arguments.reference:
        named = None if arguments.reference == "random" else Path(arguments.reference)
        ours, theirs = beside_reference(tagger, reference_session(named))
        figures |= {"tagger, in turns": ours, "bert-base fp32, in turns": theirs}
        print(f"times faster than bert-base: {theirs.cpu_p50_us / ours.cpu_p50_us:.0f}")
    for name, times in figures.items():
        print(f"{name}: p50 {times.p50_us:.0f} us, p99 {times.p99_us:.0f} us,"
              f" own time p50 {times.cpu_p50_us:.0f} us")  # fmt: skip
    if arguments.model is None:
        ready = footprint(arguments.tagger)
        print(f"ready after {ready.ready_s:.2f} s, {ready.cpu_s:.2f} s of its own,"
              f" memory {ready.memory_mb:.0f} MB")  # fmt: skip


if __name__ == "__main__":
    main()
