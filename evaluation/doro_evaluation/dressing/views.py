"""Where the camera of a training frame stands, and the light that it sees."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_perception.classes import CLASSES
from doro_sim_feeder.rooms.exploration import View
from doro_sim_feeder.rooms.footprints import Rect
from doro_sim_feeder.rooms.lighting import Lighting
from doro_sim_feeder.rooms.scene import Scene
from doro_sim_feeder.rooms.variation import random_view

Rng = np.random.Generator
CANDIDATE_VIEWS, HORIZON_DEG, FAR_M, SMALL_M = 4, (-8, 52), 3.5, 0.6
CLOSE_M, CLOSE_EYES_M, CLOSE_TRIES = (0.35, 1.3), (0.9, 1.7), 12
OFTEN_CLOSE, OFTEN_ODDS = (
    frozenset({"AlarmClock", "DeskLamp", "Book", "Laptop", "ArmChair", "Pillow"}), 3.0,
)  # fmt: skip
BLOOM_FROM, BLOOM_PX = 0.82, 9


class Views:
    """The views of one dressed room."""

    def __init__(self, scene: Scene, views: list[View], taught: frozenset[str]) -> None:
        self._scene, self._views = scene, views
        self._middles = np.array([np.mean(item.corners, axis=0) for item in scene.instances])
        self._sizes = np.array([np.ptp(item.corners, axis=0).max() for item in scene.instances])
        self._taught = np.array([item.object_type in taught for item in scene.instances])
        kinds = [item.object_type for item in scene.instances]
        named = np.array([kind in CLASSES for kind in kinds])
        often = np.array([kind in OFTEN_CLOSE for kind in kinds])
        self._near = np.flatnonzero(named & ((self._sizes < SMALL_M) | often))
        odds = np.where(often[self._near], OFTEN_ODDS, 1.0)
        self._odds = odds / max(odds.sum(), 1e-9)

    def rich(self, rng: Rng) -> View:
        """Return the one of several random views that has most small things before it."""
        return self._richest((self._turned(rng) for _ in range(CANDIDATE_VIEWS)), rng)

    def rich_as_recorded(self, rng: Rng) -> View:
        """Return the best of several of the room's own views, as an evaluation takes them."""
        numbers = rng.integers(len(self._views), size=CANDIDATE_VIEWS)
        return self._richest((self._views[int(number)] for number in numbers), rng)

    def _turned(self, rng: Rng) -> View:
        start = self._views[int(rng.integers(len(self._views)))]
        turned = random_view(start, int(rng.integers(1 << 30)))
        return View(turned.position_m, turned.yaw_deg, int(rng.integers(*HORIZON_DEG)))

    def _richest(self, views: Iterable[View], rng: Rng) -> View:
        judged = ((self.worth(view) + float(rng.uniform(0, 3)), view) for view in views)
        return max(judged, key=lambda pair: pair[0])[1]

    def worth(self, view: View) -> float:
        """Return how much that is taught a view shows, walls seen through."""
        pose = view.pose()
        at = (self._middles - np.asarray(pose.position_m)) @ pose.matrix()
        inside = (np.abs(at[:, :2]) < 0.8 * at[:, 2:]).all(axis=1) & (at[:, 2] < FAR_M)
        inside &= self._taught
        small = inside & (self._sizes < SMALL_M)
        return float(small.sum()) + 0.7 * float((inside & ~small).sum())

    def close(self, rng: Rng) -> View | None:
        """Return a view of a thing from near, from where the robot can stand; None without one."""
        for _ in range(CLOSE_TRIES if len(self._near) else 0):
            number = int(rng.choice(self._near, p=self._odds))
            middle, size = self._middles[number], float(self._sizes[number])
            low_m, high_m = max(CLOSE_M[0], size), max(CLOSE_M[1], 2.2 * size)
            away = self._scene.cells - middle[[0, 2]]
            distance = np.hypot(*away.T)
            near = np.flatnonzero((distance > low_m) & (distance < high_m))
            if len(near) == 0:
                continue
            x, z = self._scene.cells[int(rng.choice(near))].tolist()
            eyes = float(rng.uniform(*CLOSE_EYES_M))
            across = float(np.hypot(x - middle[0], z - middle[2]))
            yaw = np.degrees(np.arctan2(middle[0] - x, middle[2] - z)) + rng.normal(0, 9)
            down = np.degrees(np.arctan2(eyes - middle[1], across)) + rng.normal(0, 7)
            return View((x, eyes, z), int(yaw) % 360, int(np.clip(down, -30, 70)))
        return None


def room_light(room: Rect, rng: Rng) -> Lighting:
    """Return a light: even or hard, warm or cold, from anywhere below the ceiling."""
    share = rng.uniform(0.08, 0.92, 2)
    warmth = float(rng.normal(0.15, 0.5))
    hard = float(rng.uniform(0, 1))
    return Lighting(
        lamp_m=(
            float(room.x_low + share[0] * (room.x_high - room.x_low)),
            float(rng.uniform(1.7, 2.35)),
            float(room.z_low + share[1] * (room.z_high - room.z_low)),
        ),
        lamp_color=(1 + 0.12 * warmth, 1.0, 1 - 0.18 * warmth),
        ambient_color=(1 + 0.05 * warmth, 1.0, 1 - 0.07 * warmth),
        lamp=0.25 + 0.65 * hard,
        ambient=float(rng.uniform(0.5, 0.65)) - 0.35 * hard,
        sky=float(rng.uniform(0.0, 0.16)),
        side=float(rng.uniform(-0.14, 0.14)),
        head=float(rng.uniform(0.0, 0.2)),
        bounce=float(rng.uniform(0.05, 0.35)),
        shadow=float(rng.uniform(0.05, 0.5)),
        exposure=float(rng.uniform(0.6, 1.12)),
        gamma=float(rng.uniform(0.75, 1.2)),
    )


def bloomed(color: NDArray[np.uint8], rng: Rng) -> NDArray[np.uint8]:
    """Return a picture whose brightest places shine over their edges; now and then as it is."""
    if rng.random() < 0.4:
        return color
    light = color.astype(np.float32) / 255
    bright = np.maximum(light - BLOOM_FROM, 0)
    glow = cv2.GaussianBlur(bright, (0, 0), BLOOM_PX * float(rng.uniform(0.5, 1.5)))
    mean = light.mean(axis=2, keepdims=True)
    light = mean + (light - mean) * float(rng.uniform(0.8, 1.15))
    shone = light + glow * float(rng.uniform(0, 1.6))
    done: NDArray[np.uint8] = np.clip(shone * 255, 0, 255).astype(np.uint8)
    return done
