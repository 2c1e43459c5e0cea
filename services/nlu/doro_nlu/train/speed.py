"""``python -m doro_nlu.train.speed``: time from text to graph, one thread.

With ``--reference`` (needs torch and onnx) a network of bert-base's shape (12 layers x 768, fp32,
random weights) runs the same 12-token instruction in the same run, as the measure of speed.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from doro_nlu.core import Nlu
from doro_nlu.onnx_files import MODEL_FILE, load_session
from doro_nlu.settings import NluSettings
from doro_nlu.tagger import load_tagger
from doro_nlu.tokens import tokenize
from doro_nlu.wordpiece import rows_of
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


def percentiles(run: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Return the 50th and 99th percentile of a call, microseconds, after one to warm up."""
    run()
    times_us = []
    for _ in range(repeats):
        started_ns = time.perf_counter_ns()
        run()
        times_us.append((time.perf_counter_ns() - started_ns) / 1000)
    times_us.sort()
    return times_us[len(times_us) // 2], times_us[len(times_us) * 99 // 100]


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


def reference(repeats: int) -> tuple[float, float]:
    """Return the times of the bert-base-shaped network on a batch of one 12-token sentence."""
    import torch  # noqa: PLC0415 - only this figure needs torch

    from doro_nlu.train.encoder_export import export  # noqa: PLC0415
    from doro_nlu.train.encoder_model import Encoder  # noqa: PLC0415

    torch.manual_seed(0)
    model = Encoder(30522, 128, 15, layers=12, hidden=768).eval()
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / MODEL_FILE
        export(model, path)
        session = load_session(path, "")
    rows, _ = rows_of([[[100 + index] for index in range(12)]])
    feed = {"pieces": rows.pieces, "mask": rows.mask}
    return percentiles(lambda: session.run(None, feed), repeats)


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tagger", default="bilstm", help="of the shipped ones")
    parser.add_argument("--model", type=Path, help="directory of a model")
    parser.add_argument("--reference", action="store_true")
    arguments = parser.parse_args()
    tagger = load_tagger(arguments.model, arguments.tagger)
    nlu, cached = Nlu(NluSettings(cache_size=0), tagger), Nlu(NluSettings(), tagger)
    tokens, frame = tokenize(TWELVE), _captions()

    def sentences() -> None:
        for text in SENTENCES:
            nlu.parse(ParseRequest(text=text))

    figures = {
        "tagger, 12 tokens": percentiles(lambda: tagger.tag([tokens]), 500),
        "text -> graph, 12 tokens": percentiles(lambda: nlu.parse_text(TWELVE), 500),
        "text -> graph, 5 sentences": percentiles(sentences, 200),
        "20 captions, uncached": percentiles(lambda: nlu.captions(frame), 100),
        "20 captions, cached": percentiles(lambda: cached.captions(frame), 500),
    }
    if arguments.reference:
        figures["bert-base shape fp32, 12 tokens"] = reference(60)
    for name, (p50_us, p99_us) in figures.items():
        print(f"{name}: p50 {p50_us:.0f} us, p99 {p99_us:.0f} us")


if __name__ == "__main__":
    main()
