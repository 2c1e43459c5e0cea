"""Labelled rendered frames: to train the captioner, to calibrate it, and to measure it.

The rooms of the evaluation (34 test rooms, 5 validation bedrooms) are in none of the lists here.
A shard is one npz file with the frames of one dressed room:
``jpeg`` uint8, all files joined; ``ends`` int64 (frames,); and per box, sorted by frame:
``frame`` int32, ``box`` float32 (n, 4) edges in pixels, ``kind`` int16 (index into CLASSES,
UNNAMED_KIND for a thing without a name, -1 for a thing that is neither taught nor forbidden),
``colour``, ``material`` int8 (-1: unknown), ``ignore`` bool (too small or hidden), ``copy`` bool.
``plain`` bool (): rendered as the evaluation renders, not dressed anew; ``varied`` bool (): with
other furniture, so that what is made of what says nothing of rooms.
"""

from __future__ import annotations

import argparse
import functools
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_evaluation.dressing.copied import with_copies, with_varied_copies
from doro_evaluation.dressing.dress import dressed
from doro_evaluation.dressing.labels import TAUGHT, Labels, label
from doro_evaluation.dressing.meshes.libraries import MoreMeshes
from doro_evaluation.dressing.scatter import held, scattered
from doro_evaluation.dressing.varied import varied_scene
from doro_evaluation.dressing.views import Views, bloomed, room_light
from doro_sim_feeder.rooms.camera import Camera
from doro_sim_feeder.rooms.evaluation_set import plan_set
from doro_sim_feeder.rooms.exploration import plan_views
from doro_sim_feeder.rooms.gl import GlRenderer
from doro_sim_feeder.rooms.layout import apartment_names, room_names
from doro_sim_feeder.rooms.lighting import ceiling_lighting
from doro_sim_feeder.rooms.raycast import make_soup
from doro_sim_feeder.rooms.scene import Scene, build_scene

KINDS = ("kitchens", "living_rooms", "bedrooms", "bathrooms", "apartments")
HELD_OUT = (306, 4, 224, 204, 16, 325, 216, 19, 23, 213, 314, 405, 420)
"""Numbers of the rooms that only measure, of all kinds from the first on; 19 is the sample's."""
CALIBRATION = (14, 211, 317, 411)
"""Numbers of the rooms that thresholds and calibration are fitted to."""
APARTMENT = 1000
SIZE_PX = 384
CLOSE_SHARE, RICH_SHARE = 0.3, 0.75


def rooms_of(part: str) -> list[str]:
    """Return the rooms of ``train``, ``calibration`` or ``held-out``."""
    measured = {row.room for row in plan_set()}
    numbers = {"calibration": CALIBRATION, "held-out": HELD_OUT}
    if part in numbers:
        return [f"FloorPlan{number}" for number in numbers[part]]
    apart = measured | {f"FloorPlan{number}" for number in (*CALIBRATION, *HELD_OUT)}
    rooms = [name for kind in KINDS for name in _names_of(kind) if name not in apart]
    # A third of the bathrooms: little of what the evaluation asks for stands there.
    return [
        name for name in rooms if not 400 < number_of(name) < APARTMENT or number_of(name) % 3 == 0
    ]


def _names_of(kind: str) -> list[str]:
    return apartment_names() if kind == "apartments" else room_names(kind)


def number_of(room: str) -> int:
    """Return the number of an iTHOR room, or a thousand and that of a RoboTHOR apartment."""
    if room.startswith("RoboTHOR"):
        return APARTMENT + int(room.removeprefix("RoboTHOR"))
    return int(room.removeprefix("FloorPlan"))


def _furnished(scene: Scene, rng: np.random.Generator, meshes: MoreMeshes | None) -> Scene:
    """Return a room dressed anew, with more things in it, some before the camera."""
    things = int(rng.integers(10, 34)), int(rng.integers(2, 9))
    scene = held(scattered(scene, rng, *things, meshes), rng, int(rng.integers(0, 4)), meshes)
    return dressed(scene, rng, meshes)


@functools.lru_cache(maxsize=128)
def _scene(room: str) -> Scene:
    """Return a room as built, which takes two seconds, for all seeds."""
    return build_scene(room)


def frames_of(
    room: str,
    seed: int,
    count: int,
    *,
    dress: bool,
    vary: bool = False,
    meshes: MoreMeshes | None = None,
) -> Iterator[tuple[NDArray[np.uint8], Labels]]:
    """Render the labelled frames of one room.

    Args:
        dress: with other looks, light and views than the evaluation has; False: as it has
            them, at 300 px, with copies.
        vary: these with other furniture (``varied.py``) and more of it.
        meshes: more models to dress with.
    """
    rng = np.random.default_rng([seed, number_of(room), int(dress)])
    if dress:
        scene = _furnished(_scene(room), rng, meshes)
    elif vary:
        scene = with_varied_copies(varied_scene(room, rng), rng)
    else:
        scene = with_copies(_scene(room), rng, 6)
    pairs = [(k, item.parts) for k, item in enumerate(scene.instances, start=1)]
    camera = Camera(SIZE_PX if dress else 300)
    light = room_light(scene.room, rng) if dress else ceiling_lighting(scene.room)
    views = plan_views(scene.cells, None, seed)
    chosen = np.resize(rng.permutation(len(views))[:count], count)
    rich = Views(scene, views, frozenset(TAUGHT))
    smooth = not dress or bool(rng.integers(2))
    with GlRenderer(
        make_soup(pairs), scene.part_materials(), light, camera, smooth=smooth
    ) as renderer:
        for k, index in enumerate(chosen.tolist()):
            view = views[index]
            if dress:
                close = rich.close(rng) if rng.random() < CLOSE_SHARE else None
                view = close or rich.rich(rng)
                field = float(rng.choice([90, 90, rng.uniform(45, 90)]))
                renderer.camera = Camera(SIZE_PX, field)
                if k % 4 == 3:
                    renderer.light(room_light(scene.room, rng))
            elif vary and rng.random() < RICH_SHARE:
                view = rich.rich_as_recorded(rng)
            picture = renderer.take(view.pose())
            if picture.color is not None:
                color = bloomed(picture.color, rng) if dress else picture.color
                yield color, label(scene, picture.ids, view.pose(), renderer.camera)


def write_shard(
    path: Path,
    frames: Iterator[tuple[NDArray[np.uint8], Labels]],
    *,
    plain: bool = False,
    varied: bool = False,
) -> int:
    """Write a shard; return how many frames have something to learn from."""
    data, ends, rows = [], [], []
    for color, labels in frames:
        if not ((labels.kind >= 0) & ~labels.ignore).any():
            continue
        quality = [cv2.IMWRITE_JPEG_QUALITY, 92]
        done, jpeg = cv2.imencode(".jpg", np.ascontiguousarray(color[..., ::-1]), quality)
        if not done:
            raise OSError("OpenCV cannot write JPEG")
        data.append(jpeg.ravel())
        ends.append(len(jpeg.ravel()))
        rows.append(labels)
    counts = [len(labels.kind) for labels in rows]
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(labels, name) for labels in rows])
        for name in ("box", "kind", "colour", "material", "ignore", "copy")
    }
    partial = path.with_suffix(".part.npz")
    np.savez(
        partial,
        jpeg=np.concatenate(data),
        ends=np.cumsum(ends),
        frame=np.repeat(np.arange(len(rows), dtype=np.int32), counts),
        plain=np.array(plain),
        varied=np.array(varied),
        **columns,
    )
    partial.rename(path)
    return len(rows)


def _out_of_time(_number: int, _frame: object) -> None:
    """Stop a room whose copies find no place for a long time."""
    raise TimeoutError("it took more than --most-s of CPU time")


def main() -> None:
    """Render shards: ``python -m doro_evaluation.dressing.frames --out DIR``; resumable."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--part", default="train", choices=("train", "calibration", "held-out"))
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--frames", type=int, default=40, help="per room and seed")
    parser.add_argument(
        "--meshes", type=Path, help="a folder with more models; see dressing/meshes/libraries.py"
    )
    parser.add_argument("--plain", action="store_true", help="as the evaluation renders")
    parser.add_argument("--vary", action="store_true", help="plain ones with other furniture")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS, help="of rooms")
    parser.add_argument("--most-s", type=float, default=0, help="of CPU time for a room; 0: any")
    parser.add_argument("--share", default="0/1", help="k/n: every n-th room from the k-th on")
    arguments = parser.parse_args()
    signal.signal(signal.SIGVTALRM, _out_of_time)
    arguments.out.mkdir(parents=True, exist_ok=True)
    meshes = MoreMeshes(arguments.meshes) if arguments.meshes else None
    first, step = (int(word) for word in arguments.share.split("/"))
    for seed in arguments.seeds:
        named = [name for kind in arguments.kinds for name in _names_of(kind)]
        rooms = [str(r) for r in np.random.default_rng(seed).permutation(rooms_of(arguments.part))]
        rooms = [room for room in rooms if room in named]
        for room in rooms[first::step]:
            path = arguments.out / f"{arguments.part}-{room}-{seed}.npz"
            if path.exists():
                continue
            start = time.monotonic()
            frames = frames_of(
                room,
                seed,
                arguments.frames,
                dress=not (arguments.plain or arguments.vary),
                vary=arguments.vary,
                meshes=meshes,
            )
            signal.setitimer(signal.ITIMER_VIRTUAL, arguments.most_s)
            try:
                count = write_shard(
                    path,
                    frames,
                    plain=arguments.plain or arguments.vary,
                    varied=arguments.vary,
                )
            except (ValueError, TimeoutError) as error:
                print(f"{room} seed {seed}: left out, {error}", file=sys.stderr)
                continue
            finally:
                signal.setitimer(signal.ITIMER_VIRTUAL, 0)
            print(f"{path.name}: {count} frames, {time.monotonic() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
