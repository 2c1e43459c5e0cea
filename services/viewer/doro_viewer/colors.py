"""Colours: named ones as named, all others stable by name. RGB, 0..255."""

from __future__ import annotations

import colorsys
import zlib

from doro_schemas.graph import ObjectGraph, identity
from doro_schemas.vocabulary import canonical_value

Rgb = tuple[int, int, int]

NAMED: dict[str, Rgb] = {
    "red": (214, 39, 40),
    "orange": (255, 140, 26),
    "yellow": (240, 208, 30),
    "gold": (212, 175, 55),
    "green": (44, 150, 60),
    "olive": (128, 128, 0),
    "turquoise": (64, 200, 190),
    "teal": (0, 128, 128),
    "cyan": (40, 190, 215),
    "blue": (40, 96, 210),
    "navy": (24, 40, 110),
    "purple": (128, 60, 165),
    "violet": (148, 90, 210),
    "magenta": (205, 40, 160),
    "pink": (244, 150, 185),
    "maroon": (128, 20, 40),
    "brown": (130, 84, 48),
    "tan": (205, 170, 125),
    "beige": (225, 208, 172),
    "cream": (246, 236, 205),
    "white": (255, 255, 255),
    "silver": (192, 196, 202),
    "gray": (136, 136, 136),
    "black": (30, 30, 30),
}
_TOWARDS: dict[str, tuple[Rgb, float]] = {
    "dark": ((0, 0, 0), 0.40),
    "deep": ((0, 0, 0), 0.40),
    "light": ((255, 255, 255), 0.45),
    "pale": ((255, 255, 255), 0.45),
    "bright": ((255, 255, 255), 0.15),
}


def mix(color: Rgb, other: Rgb, share: float) -> Rgb:
    """Return ``color`` moved towards ``other``; share 0 keeps it, 1 gives ``other``."""
    red, green, blue = (round(a + (b - a) * share) for a, b in zip(color, other, strict=True))
    return red, green, blue


def named_color(value: str) -> Rgb | None:
    """Return the colour that words name ("dark blue"), None where they name none."""
    words = canonical_value(value).split(" ")
    color = NAMED.get(words[-1])
    if color is None:
        return None
    for word in words[:-1]:
        towards, share = _TOWARDS.get(word, (color, 0.0))
        color = mix(color, towards, share)
    return color


def stable_color(text: str) -> Rgb:
    """Return a colour that depends on the text alone: the same in every run and process."""
    code = zlib.crc32(text.encode())
    hue = (code & 0xFFFF) / 0x10000
    saturation = (0.55, 0.70, 0.85)[(code >> 16) % 3]
    value = (0.60, 0.75, 0.90)[(code >> 20) % 3]
    red, green, blue = (round(part * 255) for part in colorsys.hsv_to_rgb(hue, saturation, value))
    return red, green, blue


def graph_color(graph: ObjectGraph) -> Rgb:
    """Return the colour that the graph names, otherwise a stable one of its identity."""
    named = named_color(graph.attributes["color"]) if "color" in graph.attributes else None
    return named or stable_color(identity(graph))
