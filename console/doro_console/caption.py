"""``doro caption`` and ``doro eval perception``: what the detectors see."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import msgspec
from rich.console import Console
from rich.table import Table

from doro_console.options import Common, common_options, says_refusals, talk

if TYPE_CHECKING:
    from doro_evaluation.perception.chain import Chained
    from doro_evaluation.perception.measure import Measured
    from doro_perception.settings import PerceptionSettings

LOOKING = click.Choice(["captioner", "coco", "onnx"])
FOLDER = click.Path(path_type=Path, file_okay=False)
FILE = click.Path(path_type=Path, dir_okay=False)
LOW_SCORE = 0.02
CHAINED = {
    "F1": "perception_counting/{}/average/f1",
    "exact": "perception_counting/{}/accuracy",
    "F1, 3 views": "perception_counting/{}/3_views/average/f1",
    "pairs F1": "perception_counting/{}/matched_f1_0.5m",
    "QA": "perception_answers/{}/qa",
    "AA": "perception_answers/{}/aa",
    "BLEU": "perception_answers/{}/bleu",
}
"""Columns of the table of --chain."""
SHOWN = ("map50", "map50_evaluated", "recall", "top1", "top3", "colour", "material")


@click.command()
@click.argument("images", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", default=Path("out/captions"), show_default=True, type=FOLDER)
@click.option("--backend", type=LOOKING, default="captioner", show_default=True)
@click.option("--relations/--no-relations", default=True, show_default=True)
@click.option("--json", "as_json", is_flag=True, help="The messages as JSON lines on stdout.")
@common_options
@says_refusals
def caption(
    common: Common,
    images: tuple[Path, ...],
    out: Path,
    backend: str,
    relations: bool,
    as_json: bool,
) -> None:
    """Draw boxes and captions into images; PNG files in --out.

    Of images of one name the second has its folder's name before it. An image that cannot be
    read is refused with a sentence, the others are done all the same.
    """
    from doro_perception.draw import draw_captions, write_png
    from doro_perception.files import describe_file
    from doro_schemas.errors import Refused

    settings = _settings(common, backend, relations=relations)
    core = _core(settings)
    out.mkdir(parents=True, exist_ok=True)
    refused, taken = 0, set[Path]()
    for number, path in enumerate(images):
        try:
            rgb, message = describe_file(core, path, number)
        except Refused as error:
            refused += 1
            talk.print(f"{path}: {error.reason}", markup=False)
            continue
        picture = draw_captions(rgb, message)
        target = _free(out, path, taken)
        write_png(target, picture)
        if as_json:
            click.echo(json.dumps({"image": str(path), **msgspec.to_builtins(message)}))
        else:
            click.echo(f"{path} -> {target}: {len(message.detections)} things")
            for box in message.detections:
                click.echo(f"  {box.score:.2f}  {box.caption}")
            if message.unnamed:
                click.echo(f"  and {len(message.unnamed)} that have no name")
    if refused:
        raise SystemExit(1)


def _free(out: Path, image: Path, taken: set[Path]) -> Path:
    """Return where an image's picture goes: images of one name do not overwrite each other."""
    names = (image.stem, f"{image.absolute().parent.name}-{image.stem}")
    targets = [out / f"{name}.png" for name in names]
    targets += [out / f"{image.stem}-{number}.png" for number in range(2, len(taken) + 3)]
    target = next(path for path in targets if path not in taken)
    taken.add(target)
    return target


def _settings(common: Common, backend: str, *, relations: bool) -> PerceptionSettings:
    from doro_perception.settings import PerceptionSettings
    from doro_schemas.settings import load_settings

    overrides = [*common.overrides, f"perception.backend={backend}"]
    if relations:
        overrides.append("perception.relations=boxes")
    return load_settings("perception", PerceptionSettings, common.config, overrides)


def _core(settings: PerceptionSettings) -> Any:
    from doro_perception.backends import make_backend
    from doro_perception.core import Perception
    from doro_perception.stages import Stages

    stages = Stages()
    return Perception(settings, make_backend(settings, stages), stages=stages)


def _listed(path: Path, settings: PerceptionSettings) -> None:
    """Print what the map holds after a recording; write a sheet of pictures beside the JSON."""
    from doro_evaluation.perception.walk import draw_sheet, listed, map_of
    from doro_perception.backends import make_backend
    from doro_perception.stages import Stages
    from doro_sim_feeder.recording import Recording

    detector = make_backend(settings, Stages())
    assert detector is not None
    messages = (sample.message() for sample in Recording(path).samples())
    found, colors = map_of(messages, detector, settings)
    for row in listed(found):
        click.echo(json.dumps(row))
    sheet = Path("out/perception") / f"{path.stem}.png"
    draw_sheet(sheet, found, colors)
    click.echo(f"sheet: {sheet}")


def _timed(settings: PerceptionSettings) -> dict[str, Any]:
    """Return the captioner's times, and print them."""
    import numpy as np

    from doro_evaluation.perception.speed import measure_speed

    image = np.random.default_rng(7).integers(0, 256, (300, 300, 3), np.uint8)
    figures = measure_speed([image], settings)
    for key, value in figures.items():
        click.echo(f"{key}: {value}")
    return figures


def _counted(
    common: Common, backend: str, rooms: int, views: int, keep: Path | None
) -> dict[str, Any]:
    """Return the counting figures of rendered test rooms, and print them."""
    from rich.progress import track

    from doro_evaluation.perception.chain import (
        SYSTEMS,
        figures_of,
        kept_or_rendered,
        lowest_score,
        outcomes,
        test_rows,
    )
    from doro_perception.backends import make_backend
    from doro_perception.stages import Stages

    settings = _settings(common, backend, relations=False)
    settings = msgspec.structs.replace(settings, captioner_threshold=lowest_score())
    detector = make_backend(settings, Stages())
    assert detector is not None
    found: list[Chained] = []
    for row in track(test_rows(rooms), "rooms", console=talk, transient=True):
        found += outcomes(kept_or_rendered(row, views or None, keep), detector, settings)
    figures = figures_of(found)
    table = Table("", *CHAINED, title=f"end to end, {rooms} test rooms")
    for system in SYSTEMS:
        values = (figures[path.format(system)] for path in CHAINED.values())
        table.add_row(system, *(str(value) for value in values))
    Console().print(table)
    classes = Table("fused", "true", "found", "matched", title="by class")
    prefix = "perception_counting/fused/class/"
    for kind in sorted({key.split("/")[3] for key in figures if key.startswith(prefix)}):
        counts = (figures[f"{prefix}{kind}/{key}"] for key in ("true", "found", "matched"))
        classes.add_row(kind, *(str(value) for value in counts))
    Console().print(classes)
    return figures


def _looked_at(
    settings: PerceptionSettings, chosen: tuple[int, int, int], shared: Path
) -> list[Measured]:
    """Look at held-out images and print what was right; ``chosen``: frames, seed and rooms."""
    from doro_evaluation.perception.measure import figures_of, measure, real, rendered
    from doro_perception.backends import make_backend
    from doro_perception.captioner import Captioner
    from doro_perception.stages import Stages

    detector = make_backend(settings, Stages())
    assert detector is not None
    named = detector if isinstance(detector, Captioner) else None
    sets = {"rendered": rendered(*chosen)}
    if (shared / "ai2thor_events_boxes").is_dir():
        sets["real"] = real(shared)
    else:
        talk.print(f"{shared} has no ai2thor_events_boxes: rendered rooms only", markup=False)
    measured = [measure(name, images, detector.detect, named) for name, images in sets.items()]
    figures = {key: value for one in measured for key, value in figures_of(one).items()}
    title = f"{settings.backend}, held-out images"
    table = Table("", *(one.name for one in measured), title=title)
    table.add_row("images", *(str(one.images) for one in measured))
    for metric in (*SHOWN, "calibration_error", "top1_given_box", "top3_given_box"):
        values = [figures.get(f"perception/{one.name}/{metric}", "") for one in measured]
        table.add_row(metric, *(str(value) for value in values))
    Console().print(table)
    return measured


@click.command("perception")
@click.option("--backend", type=LOOKING, default="captioner", show_default=True)
@click.option(
    "--frames", default=30, show_default=True, help="Of each held-out room; 0: no images."
)
@click.option("--rooms", default=0, help="Only the first so many of the held-out rooms.")
@click.option("--seed", default=7, show_default=True, help="Of copies and views.")
@click.option("--shared", type=FOLDER, default=Path("../shared/data"), show_default=True)
@click.option("--chain", default=0, help="Count end to end in so many test rooms; slow.")
@click.option("--views", default=0, help="Of each of these rooms, at most; 0: all there are.")
@click.option("--keep", type=FOLDER, help="Folder where these rooms' frames are kept.")
@click.option("--recording", type=FILE, help="List all that the map holds after it, with a sheet.")
@click.option("--speed", is_flag=True, help="Time the captioner on 300 x 300 px, ten boxes.")
@click.option("--plot", type=FILE, help="Where to draw the reliability plot (PNG).")
@click.option("--json", "json_path", type=FILE, help="Where to write the figures.")
@common_options
@says_refusals
def perception(
    common: Common,
    backend: str,
    frames: int,
    rooms: int,
    seed: int,
    shared: Path,
    chain: int,
    views: int,
    keep: Path | None,
    recording: Path | None,
    speed: bool,
    plot: Path | None,
    json_path: Path | None,
) -> None:
    """Boxes, names, colours and materials on rooms never trained on, and on real frames."""
    from doro_evaluation.figures import write_figures
    from doro_evaluation.perception.measure import figures_of
    from doro_evaluation.perception.plot import draw_reliability

    if plot is not None and not frames:
        raise click.UsageError("--plot draws what was seen on held-out images: give it --frames")
    settings = msgspec.structs.replace(
        _settings(common, backend, relations=False),
        captioner_threshold=LOW_SCORE,
        score_threshold=max(LOW_SCORE, 0.05),
        unnamed_threshold=2.0,
    )
    measured = _looked_at(settings, (frames, seed, rooms), shared) if frames else []
    figures = {key: value for one in measured for key, value in figures_of(one).items()}
    if plot is not None:
        draw_reliability(plot, {one.name: one.detected.certain for one in measured})
    if chain:
        figures |= _counted(common, backend, chain, views, keep)
    if recording is not None:
        _listed(recording, _settings(common, backend, relations=False))
    if speed:
        figures |= _timed(settings)
    command = f"doro eval perception --backend {backend} --frames {frames} --seed {seed}"
    write_figures(json_path, figures, command, seed)
