"""Procedural textures of floors, walls and counter tops."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.parts import Rgb

SIDE_PX = 256
Pattern = Literal["planks", "tiles", "plaster", "granite"]


def pattern_texture(pattern: Pattern, color: Rgb, seed: int) -> NDArray[np.uint8]:
    """Return a repeating uint8 (256, 256, 3) texture around ``color``."""
    rng = np.random.default_rng(seed)
    if pattern == "planks":
        shade = _planks(rng)
    elif pattern == "tiles":
        shade = _tiles(rng)
    elif pattern == "granite":
        shade = 1 + 0.16 * _smooth(rng, 2) + 0.06 * _smooth(rng, 9)
    else:
        shade = 1 + 0.008 * _smooth(rng, 3)
    image = np.clip(np.asarray(color) * shade[..., None], 0, 1)
    return (image * 255).astype(np.uint8)


def _smooth(rng: np.random.Generator, width_px: int) -> NDArray[np.float64]:
    """Return periodic noise of about unit variance, blurred over ``width_px``."""
    noise = rng.normal(size=(SIDE_PX, SIDE_PX))
    frequency = np.fft.fftfreq(SIDE_PX)[:, None] ** 2 + np.fft.fftfreq(SIDE_PX)[None, :] ** 2
    blurred = np.fft.ifft2(np.fft.fft2(noise) * np.exp(-frequency * (width_px * 3.0) ** 2)).real
    result: NDArray[np.float64] = blurred / blurred.std()
    return result


def _planks(rng: np.random.Generator) -> NDArray[np.float64]:
    rows, plank_px = 8, SIDE_PX // 8
    grain = rng.normal(size=(SIDE_PX, SIDE_PX))
    spectrum = np.fft.fft(grain, axis=1) * np.exp(-((np.fft.fftfreq(SIDE_PX) * 60) ** 2))
    grain = np.fft.ifft(spectrum, axis=1).real
    shade: NDArray[np.float64] = 1 + 0.07 * grain / grain.std()
    for row in range(rows):
        band = slice(row * plank_px, (row + 1) * plank_px)
        joint = int(rng.integers(SIDE_PX))
        shade[band] *= 1 + rng.uniform(-0.12, 0.12)
        shade[band, joint : joint + 2] *= 0.6
        shade[row * plank_px] *= 0.6
    return shade


def _tiles(rng: np.random.Generator) -> NDArray[np.float64]:
    tile_px = SIDE_PX // 4
    shade = 1 + 0.025 * _smooth(rng, 4)
    tones = rng.uniform(0.95, 1.05, size=(4, 4))
    shade *= np.kron(tones, np.ones((tile_px, tile_px)))
    line = np.arange(SIDE_PX) % tile_px < 3
    shade[line, :] = 0.68
    shade[:, line] = 0.68
    return shade
