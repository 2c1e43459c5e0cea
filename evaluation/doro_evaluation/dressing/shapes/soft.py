"""Soft and woven things: pillows, cushions for dogs, baskets, ottomans; lamps and plants."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_evaluation.dressing.looks.prints import Texture, cloth, stretched
from doro_evaluation.dressing.shapes.solids import (
    Maker,
    Rng,
    about_x,
    accent,
    between,
    dark,
    hollow,
    lathe,
    tube,
    turned,
)
from doro_sim_feeder.rooms.parts import Part, Rgb, blob_part, box_part, vertex_normals

Vectors = NDArray[Any]


def _bent(part: Part, vertices: Vectors) -> Part:
    """Return a part with its vertices elsewhere."""
    normals = vertex_normals(vertices, part.faces)
    facing = np.sign((normals * part.normals).sum(axis=1, keepdims=True))
    normals = normals * np.where(facing == 0, 1, facing)
    return replace(part, vertices=vertices.astype(np.float32), normals=normals.astype(np.float32))


def _pillow(rng: Rng, color: Rgb) -> list[Part]:
    """Return a pillow: puffed up, its corners pinched, a dent where a head lay, a piped edge."""
    long = between(rng, 1.0, 1.6)
    square = between(rng, 0.2, 0.45)
    body = blob_part(
        (long, between(rng, 0.25, 0.5), 1), color, squareness=(between(rng, 0.55, 1.0), square)
    )
    points = body.vertices.astype(np.float64)
    pinch = between(rng, 0.0, 0.22)
    x, z = points[:, 0] / (long / 2), points[:, 2] / 0.5
    points[:, 0] *= 1 - pinch * (1 - z**2) * np.abs(x)
    points[:, 2] *= 1 - pinch * (1 - x**2) * np.abs(z)
    middle = points[:, 1].max() / 2
    at = rng.uniform(-0.4, 0.4, 2)
    dent = between(rng, 0, 0.35) * np.exp(-((x - at[0]) ** 2 + (z - at[1]) ** 2) / 0.25)
    points[:, 1] -= np.where(points[:, 1] > middle, dent * (points[:, 1] - middle), 0)
    points[:, 1] += 0.02 * np.sin(9 * x + 4 * at[0]) * np.sin(7 * z) * (points[:, 1] > middle)
    parts = [_bent(body, points)]
    if rng.random() < 0.25:
        edge = blob_part((long * 1.04, 0.03, 1.04), accent(rng, color), squareness=(1, square))
        parts.append(edge.moved((0, middle - 0.015, 0)))
    return parts


def _dog_bed(rng: Rng, color: Rgb) -> list[Part]:
    """Return a bed for a dog: a thick ring, low in front, round a cushion."""
    soft = accent(rng, color) if rng.random() < 0.5 else (0.85, 0.82, 0.76)
    angle = np.linspace(0, 2 * np.pi, 33)
    square = between(rng, 0.5, 1.0)
    way = np.column_stack([np.cos(angle), np.zeros(33), np.sin(angle)])
    way[:, [0, 2]] = np.sign(way[:, [0, 2]]) * np.abs(way[:, [0, 2]]) ** square
    thick = between(rng, 0.16, 0.26)
    path = way * (between(rng, 1.0, 1.3), 1, 0.9) + (0, thick, 0)
    ring = tube(path, thick, color, 12)
    points = ring.vertices.astype(np.float64)
    points[:, 1] *= np.where(points[:, 2] > 0.6, between(rng, 0.4, 1.0), 1.0)
    cushion = blob_part((2.1, 0.34, 1.7), soft, squareness=(0.5, square))
    return [_bent(ring, points), cushion.moved((0, 0.02, 0))]


def _wicker(rng: Rng, color: Rgb) -> Texture:
    """Return a weave of canes or a grid of holes."""
    image = np.empty((96, 96, 3), np.float64)
    image[:] = np.asarray(color) * 255
    step = int(rng.integers(6, 14))
    rows, columns = np.meshgrid(np.arange(96), np.arange(96), indexing="ij")
    if rng.random() < 0.6:
        over = ((rows // step) + (columns // (2 * step))) % 2
        image *= (0.72 + 0.3 * np.sin(np.pi * (rows % step) / step) * (0.7 + 0.5 * over))[..., None]
    else:
        holes = (rows % (2 * step) < step) & (columns % step < step * 0.6)
        image[holes] *= 0.25
    done: Texture = np.clip(image, 0, 255).astype(np.uint8)
    return done


def _hamper(rng: Rng, color: Rgb) -> list[Part]:
    """Return a laundry basket: round or square, woven or with holes, with washing or a lid."""
    foot, around = between(rng, 0.7, 1.0), int(rng.choice([4, 24, 24]))
    high = between(rng, 1.0, 2.4)
    body = lathe(hollow([(foot, 0), (1, high)], 0.06), color, around=around)
    weave = _wicker(rng, color)
    uv = np.asarray(body.uv) * (float(rng.integers(3, 7)), 3.0)
    parts = [replace(body, texture=weave, uv=uv.astype(np.float32), color=(1.0, 1.0, 1.0))]
    parts.append(lathe([(1.04, high - 0.12), (1.06, high), (0.94, high)], dark(color, 0.9), around))
    if rng.random() < 0.4:
        for _ in range(3):
            heap = blob_part((1.1, 0.5, 1.0), accent(rng, color), squareness=(1.2, 0.8))
            parts.append(heap.moved((between(rng, -0.3, 0.3), high - 0.4, between(rng, -0.3, 0.3))))
    elif rng.random() < 0.4:
        parts.append(lathe([(1.05, high), (0.95, high + 0.1), (0, high + 0.14)], color, around))
    return parts


def _ottoman(rng: Rng, color: Rgb) -> list[Part]:
    """Return an ottoman: a soft block or a round one, on feet."""
    seat = blob_part((1, 0.6, between(rng, 0.6, 1)), color, squareness=(0.3, between(rng, 0.15, 1)))
    parts = [seat.moved((0, 0.12, 0))]
    for x in (-0.35, 0.35):
        for z in (-0.25, 0.25):
            parts.append(lathe([(0.025, 0), (0.04, 0.2)], (0.2, 0.12, 0.07), 8).moved((x, 0, z)))
    return parts


def _shade(rng: Rng, color: Rgb, wide: float, high: float) -> list[Part]:
    """Return a lamp's shade from y 0 up: cone, drum, dome, or with folds."""
    pale: Rgb = (0.93, 0.9, 0.82)
    tone = pale if rng.random() < 0.5 else color if rng.random() < 0.6 else accent(rng, color)
    if rng.random() < 0.25:
        rows = [(wide * np.cos(a), high * np.sin(a)) for a in np.linspace(0, np.pi / 2, 8)]
        return [lathe(rows, tone)]
    top = wide * between(rng, 0.35, 1.0)
    around = int(rng.choice([24, 24, 24, 6]))
    rows = [(wide, 0), (top, high), (top * 0.97, high), (wide * 0.97, 0)]
    shade = lathe(rows, tone, around)
    if rng.random() < 0.3:
        shade = stretched(shade, cloth(rng, tone))
    return [shade]


def _stem(rng: Rng, color: Rgb, high: float, wide: float) -> list[Part]:
    """Return a lamp's foot and body up to a height: turned, bulging, plain, of balls or a block."""
    kind = int(rng.integers(5))
    if kind == 0:
        y = np.linspace(0, 1, 16)
        waves = rng.uniform(-0.4, 0.4, 4) @ np.sin(np.outer(np.arange(1, 5) * np.pi, y))
        radius = np.maximum(wide * (0.45 + waves) * (1 - 0.75 * y**3), 0.08)
        return [lathe(np.vstack([[[0, 0]], np.column_stack([radius, y * high])]), color)]
    if kind == 1:
        balls = []
        for k in range(count := int(rng.integers(2, 5))):
            size = high / count
            balls.append(blob_part((size * 1.1, size, size * 1.1), color).moved((0, k * size, 0)))
        return balls
    if kind == 2:
        return [box_part((-wide / 2, 0, -wide / 2), (wide / 2, high * 0.9, wide / 2), color),
                lathe([(0.08, high * 0.9), (0.08, high)], dark(color), 8)]  # fmt: skip
    foot = [
        (0, 0),
        (wide * between(rng, 0.5, 0.9), 0),
        (wide * 0.5, 0.15),
        (0.1, 0.25),
        (0.08, high),
    ]
    return [lathe(foot, color)]


def _table_lamp(rng: Rng, color: Rgb) -> list[Part]:
    """Return a lamp with a shade on a body."""
    wide, tall, high = between(rng, 1.1, 2.2), between(rng, 2.0, 4.5), between(rng, 1.2, 2.4)
    shade = [part.moved((0, tall * 0.9, 0)) for part in _shade(rng, color, wide, high)]
    return _stem(rng, color, tall, between(rng, 0.6, 1.6)) + shade


def _arm_lamp(rng: Rng, color: Rgb) -> list[Part]:
    """Return a lamp for work: a foot, an arm with joints or a bent neck, a small shade."""
    wide = between(rng, 0.6, 1.1)
    parts = [lathe([(0, 0), (wide, 0), (wide, 0.15), (wide * 0.8, 0.25), (0, 0.25)], color)]
    if rng.random() < 0.5:
        knee = np.array([0, between(rng, 1.8, 2.8), -between(rng, 0.3, 1.2)])
        end = np.array([0, between(rng, 3.0, 4.2), between(rng, 0.4, 1.6)])
        for start, stop in ((np.array([0, 0.2, 0]), knee), (knee, end)):
            parts.append(tube(np.linspace(start, stop, 3), between(rng, 0.05, 0.1), color))
        parts.append(blob_part((0.3, 0.3, 0.3), dark(color)).moved(knee - [0, 0.15, 0]))
    else:
        angle = np.linspace(0, np.pi * between(rng, 0.5, 0.9), 14)
        bow = between(rng, 0.6, 1.2)
        up = between(rng, 2.0, 3.2)
        path = np.column_stack([np.zeros(14), up + bow * np.sin(angle), bow * (1 - np.cos(angle))])
        path = np.vstack([[[0, 0.2, 0]], path])
        parts.append(tube(path, 0.08, color))
        end = path[-1]
    head = [(between(rng, 0.6, 1.0), 0), (between(rng, 0.3, 0.7), 0.6), (0.15, 0.9), (0, 0.9)]
    lean = about_x(between(rng, -0.9, 0.3))
    parts.append(turned(lathe(head, color), lean, end - lean @ np.array([0, 0.8, 0])))
    return parts


def _banker_lamp(rng: Rng, color: Rgb) -> list[Part]:
    """Return a banker's lamp: half a cylinder of glass on a pole."""
    green: Rgb = (0.05, 0.35, 0.16) if rng.random() < 0.6 else accent(rng, color)
    at = np.linspace(0, np.pi, 9)
    parts = [lathe([(0, 0), (0.8, 0), (0.7, 0.15), (0.1, 0.3), (0.08, 2.4)], color)]
    for k in range(8):
        low = (-1.2, 2.1 + 0.45 * min(np.sin(at[k]), np.sin(at[k + 1])), 0.55 * np.cos(at[k + 1]))
        high = (1.2, 2.16 + 0.45 * max(np.sin(at[k]), np.sin(at[k + 1])), 0.55 * np.cos(at[k]))
        parts.append(box_part(low, high, green))
    return parts


def _desk_lamp(rng: Rng, color: Rgb) -> list[Part]:
    kinds = (_table_lamp, _table_lamp, _arm_lamp, _arm_lamp, _banker_lamp)
    return kinds[int(rng.integers(5))](rng, color)


def _floor_lamp(rng: Rng, color: Rgb) -> list[Part]:
    """Return a floor lamp: shade on a pole or on three legs, an uplight, a bow."""
    kind, tall = rng.random(), between(rng, 9, 14)
    wide, high = between(rng, 1.0, 2.0), between(rng, 1.4, 2.6)
    shade = [part.moved((0, tall, 0)) for part in _shade(rng, color, wide, high)]
    if kind < 0.25:
        legs = []
        for angle in np.arange(3) * 2 * np.pi / 3:
            foot = (1.8 * np.cos(angle), 0, 1.8 * np.sin(angle))
            legs.append(tube(np.linspace(foot, (0, tall * 0.95, 0), 3), 0.12, color))
        return legs + shade
    base = lathe([(0, 0), (1.3, 0), (1.3, 0.2), (0.15, 0.4), (0.1, tall + 0.3)], color)
    if kind < 0.5:
        cup = lathe([(0.1, tall), (0.5, tall + 0.3), (wide, tall + 1.0)], color)
        return [base, cup]
    if kind < 0.62:
        at = np.linspace(0, np.pi * 0.8, 16)
        bow = np.column_stack([3.5 * (1 - np.cos(at)), tall + 2.5 * np.sin(at), np.zeros(16)])
        dome = lathe([(1.1, 0), (0.9, 0.6), (0.2, 1.0), (0, 1.0)], color)
        return [base, tube(bow, 0.1, color), dome.moved(bow[-1] - [0, 0.9, 0])]
    return [base, *shade]


def _leaf(rng: Rng, root: Vectors, way: Vectors, size: tuple[float, float], tone: Rgb) -> Part:
    """Return a leaf: a strip that widens, narrows and bends down."""
    long, wide = size
    share = np.linspace(0, 1, 7)
    aside = np.cross(way, [0, 1.0, 0])
    aside = aside / max(float(np.linalg.norm(aside)), 1e-6)
    droop = between(rng, 0.1, 0.8) * long
    spine = root + way * long * share[:, None] - np.outer(droop * share**2, [0, 1.0, 0])
    half = wide * np.sin(np.pi * np.clip(share * 0.95 + 0.04, 0, 1))[:, None]
    points = np.concatenate([spine - aside * half, spine + aside * half])
    faces = [(k, k + 1, k + 8) for k in range(6)] + [(k, k + 8, k + 7) for k in range(6)]
    table = np.asarray(faces, np.int32)
    normals = vertex_normals(points, table).astype(np.float32)
    return Part(points.astype(np.float32), table, normals, None, tone)


def _cactus(rng: Rng, deep: float, tone: Callable[[], Rgb]) -> list[Part]:
    """Return one to three stems that stand in a pot of a depth."""
    stems = []
    for _ in range(int(rng.integers(1, 4))):
        tall, wide = between(rng, 0.8, 2.5), between(rng, 0.25, 0.5)
        rows = [(wide * 0.8, 0), (wide, tall * 0.5), (wide * 0.7, tall * 0.9), (0, tall)]
        at = (between(rng, -0.4, 0.4), deep * 0.9, between(rng, -0.4, 0.4))
        stems.append(lathe(rows, tone(), 10).moved(at))
    return stems


def _plant(rng: Rng, color: Rgb) -> list[Part]:
    """Return a plant in a pot: broad leaves, blades, a small tree, a cactus."""
    del color
    clay: Rgb = ((0.6, 0.33, 0.2), (0.9, 0.89, 0.86), (0.2, 0.2, 0.21), (0.35, 0.45, 0.5))[
        int(rng.integers(4))
    ]
    deep = between(rng, 0.7, 1.6)
    around = int(rng.choice([24, 24, 4]))
    parts = [lathe(hollow([(between(rng, 0.5, 0.9), 0), (1.0, deep)]), clay, around=around)]
    parts.append(lathe([(0.85, deep * 0.9), (0, deep * 0.92)], (0.16, 0.1, 0.06)))
    green = np.array([between(rng, 0.05, 0.3), between(rng, 0.25, 0.5), between(rng, 0.05, 0.2)])
    kind = rng.random()

    def tone() -> Rgb:
        red, high, blue = np.clip(green * rng.uniform(0.6, 1.4), 0.02, 1).tolist()
        return red, high, blue

    if kind < 0.12:
        return parts + _cactus(rng, deep, tone)
    trunk = between(rng, 0.8, 3.0) if kind < 0.4 else 0.0
    if trunk:
        bend = rng.uniform(-0.3, 0.3, 2)
        path = [(0, deep * 0.9, 0), (bend[0], deep + trunk / 2, bend[1]), (0, deep + trunk, 0)]
        parts.append(tube(path, between(rng, 0.06, 0.14), (0.3, 0.2, 0.12)))
    blades = rng.random() < 0.4
    for _ in range(int(rng.integers(14, 40))):
        turn, up = (
            rng.uniform(0, 2 * np.pi),
            between(rng, -0.1, 1.4) if trunk else between(rng, 0.4, 1.5),
        )
        way = np.array([np.cos(turn) * np.cos(up), np.sin(up), np.sin(turn) * np.cos(up)])
        root = np.array([0, deep * 0.9 + trunk * between(rng, 0.6, 1.0), 0])
        size = (
            between(rng, 0.8, 2.2),
            between(rng, 0.04, 0.1) if blades else between(rng, 0.15, 0.4),
        )
        parts.append(_leaf(rng, root, way, size, tone()))
    if rng.random() < 0.2:
        bloom = accent(rng, (0.9, 0.4, 0.5))
        for _ in range(int(rng.integers(3, 10))):
            spot = rng.uniform((-0.9, deep + trunk + 0.5, -0.9), (0.9, deep + trunk + 1.6, 0.9))
            parts.append(blob_part((0.3, 0.25, 0.3), bloom).moved(spot))
    return parts


SOFT: dict[str, Maker] = {
    "Pillow": _pillow,
    "DogBed": _dog_bed,
    "LaundryHamper": _hamper,
    "Ottoman": _ottoman,
    "DeskLamp": _desk_lamp,
    "FloorLamp": _floor_lamp,
    "HousePlant": _plant,
}
