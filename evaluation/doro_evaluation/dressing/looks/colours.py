"""What colour a thing is called by what is seen of it; the colours that things come in."""

from __future__ import annotations

import colorsys
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from doro_evaluation.dressing.looks.surfaces import WOODS, near
from doro_sim_feeder.rooms.parts import Part, Rgb

Rng = np.random.Generator
# Name, hue in degrees plus 15, least saturation, lightness.
HUES: tuple[tuple[str, tuple[int, int], float, tuple[float, float]], ...] = (
    ("red", (0, 29), 0.6, (0.35, 1.01)),
    ("brown", (0, 29), 0.3, (0.15, 0.4)),
    ("orange", (29, 57), 0.75, (0.78, 1.01)),
    ("brown", (29, 57), 0.3, (0.15, 0.74)),
    ("yellow", (57, 83), 0.5, (0.6, 1.01)),
    ("green", (95, 180), 0.25, (0.15, 1.01)),
    ("blue", (210, 265), 0.3, (0.15, 1.01)),
    ("purple", (277, 327), 0.28, (0.15, 1.01)),
    ("pink", (330, 360), 0.25, (0.6, 1.01)),
)
CLEAR_SHARE = 0.55
SAMPLES = 64
PLAIN: tuple[Rgb, ...] = (
    (0.9, 0.9, 0.88), (0.06, 0.06, 0.065), (0.45, 0.45, 0.46), (0.75, 0.75, 0.74),
    (0.2, 0.2, 0.21),
)  # fmt: skip
MUTED: tuple[Rgb, ...] = (
    (0.88, 0.86, 0.8), (0.65, 0.58, 0.48), (0.4, 0.3, 0.23), (0.3, 0.36, 0.45),
    (0.45, 0.12, 0.12), (0.33, 0.4, 0.3), (0.55, 0.55, 0.56), (0.15, 0.15, 0.17),
    (0.15, 0.22, 0.5), (0.75, 0.6, 0.3), (0.1, 0.45, 0.55), (0.6, 0.35, 0.4),
)  # fmt: skip
METALS: tuple[Rgb, ...] = (
    (0.62, 0.62, 0.63), (0.72, 0.58, 0.22), (0.3, 0.3, 0.31), (0.55, 0.35, 0.2), (0.8, 0.8, 0.8),
    (0.12, 0.12, 0.13),
)  # fmt: skip
CARDBOARD: tuple[Rgb, ...] = ((0.66, 0.49, 0.31), (0.74, 0.58, 0.4), (0.55, 0.39, 0.24))
CLAY: tuple[Rgb, ...] = ((0.9, 0.89, 0.85), (0.55, 0.3, 0.18), (0.2, 0.3, 0.5), (0.35, 0.25, 0.2))
COMES_IN: dict[str, tuple[Rgb, ...]] = {
    "wood": WOODS,
    "metal": METALS,
    "fabric": MUTED,
    "leather": ((0.1, 0.09, 0.09), (0.3, 0.16, 0.09), (0.45, 0.22, 0.13), (0.8, 0.76, 0.68)),
    "stone": ((0.6, 0.6, 0.58), (0.75, 0.72, 0.66), (0.3, 0.3, 0.31), (0.5, 0.42, 0.36)),
    "glass": ((0.72, 0.82, 0.82), (0.1, 0.25, 0.12), (0.35, 0.18, 0.06), (0.8, 0.85, 0.88)),
    "ceramic": CLAY,
    "paper": (*CARDBOARD, (0.88, 0.87, 0.84)),
}
OWN = {
    "Box": CARDBOARD,
    "Pillow": ((0.9, 0.89, 0.87), (0.9, 0.89, 0.87), *MUTED),
    "Bed": ((0.9, 0.89, 0.87), *MUTED),
    "TeddyBear": ((0.5, 0.32, 0.17), (0.62, 0.44, 0.26), (0.8, 0.68, 0.5), (0.35, 0.35, 0.37)),
    "Apple": ((0.7, 0.06, 0.05), (0.72, 0.06, 0.05), (0.45, 0.62, 0.12), (0.85, 0.72, 0.15)),
    "Tomato": ((0.78, 0.08, 0.05),),
    "Potato": ((0.5, 0.34, 0.18), (0.6, 0.45, 0.28)),
    "Egg": ((0.9, 0.87, 0.8), (0.75, 0.55, 0.4)),
    "Lettuce": ((0.25, 0.5, 0.12),),
    "Bread": ((0.6, 0.38, 0.16), (0.45, 0.27, 0.12)),
    "DogBed": MUTED,
    "Laptop": PLAIN,
    "CellPhone": PLAIN,
    "RemoteControl": ((0.06, 0.06, 0.065), (0.12, 0.12, 0.13), (0.5, 0.5, 0.5), (0.85, 0.85, 0.85)),
    "Television": ((0.05, 0.05, 0.055), (0.1, 0.1, 0.11), (0.4, 0.4, 0.41)),
    "Toilet": ((0.92, 0.92, 0.9),),
    "Bathtub": ((0.92, 0.92, 0.9),),
    "Statue": ((0.75, 0.58, 0.16), (0.9, 0.9, 0.88), (0.1, 0.1, 0.1), (0.35, 0.22, 0.13),
               (0.5, 0.5, 0.5), (0.3, 0.42, 0.36)),
    "Fridge": ((0.92, 0.92, 0.91), (0.6, 0.6, 0.61), (0.1, 0.1, 0.11)),
    "Microwave": PLAIN,
    "CoffeeMachine": (*PLAIN, (0.55, 0.08, 0.07)),
    "Toaster": (*PLAIN, (0.55, 0.08, 0.07)),
    "Safe": ((0.4, 0.41, 0.42), (0.2, 0.22, 0.24), (0.12, 0.2, 0.16)),
}  # fmt: skip


def usual_rgb(kind: str, material: str | None, rng: Rng) -> Rgb:
    """Return a colour that a thing of a class and a material comes in."""
    some = OWN.get(kind) or COMES_IN.get(material or "")
    if some is None or rng.random() < 0.12:
        some = PLAIN if rng.random() < 0.4 else MUTED
    if some is MUTED and rng.random() < 0.25:
        red, green, blue = colorsys.hsv_to_rgb(*rng.uniform((0, 0.4, 0.35), (1, 0.95, 0.95)))
        return red, green, blue
    return near(some[int(rng.integers(len(some)))], rng, 0.02)


def colour_name(rgb: Rgb) -> str | None:
    """Return what one would call a colour; None where people would not agree."""
    hue, strong, light = colorsys.rgb_to_hsv(*rgb)
    if light < 0.15:
        return "black"
    if strong < 0.13:
        return "white" if light > 0.76 else "gray" if 0.24 < light < 0.64 else None
    for name, ends, least, lights in HUES:
        fits = ends[0] <= (hue * 360 + 15) % 360 < ends[1] and lights[0] <= light < lights[1]
        if fits and strong > least:
            return name
    return None


def seen_colour(parts: tuple[Part, ...]) -> str | None:
    """Return the name of the colour of most of a thing's surface; None where none is most."""
    shares: dict[str | None, float] = {}
    areas = np.array([part.area_m2() for part in parts])
    for part, area in zip(parts, (areas / max(areas.sum(), 1e-12)).tolist(), strict=True):
        if part.texture is None:
            name = colour_name(part.color)
            shares[name] = shares.get(name, 0) + area
            continue
        some = _texels(part) / 255 * np.asarray(part.color)
        for texel in some.tolist():
            name = colour_name((texel[0], texel[1], texel[2]))
            shares[name] = shares.get(name, 0) + area / len(some)
    best = max(shares, key=lambda name: shares[name])
    return best if shares[best] >= CLEAR_SHARE else None


def _texels(part: Part) -> NDArray[np.uint8]:
    """Return colours of a part's texture where its vertices are, uint8 (n, 3): not all is used."""
    assert part.texture is not None
    if part.uv is None:
        return part.texture.reshape(-1, 3)[:SAMPLES]
    some = part.uv[:: max(len(part.uv) // SAMPLES, 1)]
    height, width = part.texture.shape[:2]
    column = ((some[:, 0] % 1) * width).astype(np.int64) % width
    row = (((1 - some[:, 1]) % 1) * height).astype(np.int64) % height
    texels: NDArray[np.uint8] = part.texture[row, column]
    return texels


def shifted(parts: tuple[Part, ...], rng: Rng) -> tuple[Part, ...]:
    """Return the parts all a little lighter or darker, warmer or colder."""
    factor = rng.uniform(0.75, 1.15) * rng.uniform(0.94, 1.06, 3)
    return tuple(_times(part, factor) for part in parts)


def _times(part: Part, factor: NDArray[np.float64]) -> Part:
    red, green, blue = np.clip(np.asarray(part.color) * factor, 0, 1).tolist()
    return replace(part, color=(red, green, blue))
