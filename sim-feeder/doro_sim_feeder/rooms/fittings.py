"""What is built into a room: shell, counters, cabinets, sinks, stoves, things on walls.

iTHOR's data has boxes for them and no meshes that could be had, so they are made of boxes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.appearance import PALETTE, color_of
from doro_sim_feeder.rooms.footprints import Rect, counter_rects, rect_of, room_rect
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.layout import LayoutObject, RoomLayout
from doro_sim_feeder.rooms.parts import Part, Rgb, box_part, stable_number
from doro_sim_feeder.rooms.patterns import pattern_texture

CEILING_M = 2.6
WALL_M = 0.1
TOP_M = 0.04
FRONT_M = 0.018
# Doors whose boxes overlap in iTHOR would coincide: each stands back by some steps of its own.
BOARD_M = 0.02
STEP_BACK_M, STEPS_BACK = 0.00015, 32
FLOOR_COLORS: tuple[Rgb, ...] = ((0.62, 0.60, 0.56), (0.56, 0.40, 0.25), (0.70, 0.57, 0.41))
WALL_COLORS: tuple[Rgb, ...] = (
    (0.83, 0.81, 0.75),
    (0.73, 0.79, 0.81),
    (0.85, 0.78, 0.69),
    (0.77, 0.81, 0.72),
)
STEEL: Rgb = (0.60, 0.62, 0.64)
HANDLE: Rgb = (0.25, 0.25, 0.26)


@dataclass(frozen=True)
class Fitting:
    """Builds the fittings of one room."""

    layout: RoomLayout
    room: Rect

    def shell(self) -> list[Instance]:
        """Return floor, walls and ceiling."""
        room, name = self.room, self.layout.name
        tiled = self.layout.kind in ("kitchens", "bathrooms") and stable_number(name) % 2 == 0
        floor_color = FLOOR_COLORS[0 if tiled else 1 + stable_number(name + "floor") % 2]
        floor = pattern_texture("tiles" if tiled else "planks", floor_color, stable_number(name))
        wall_color = WALL_COLORS[stable_number(name + "wall") % len(WALL_COLORS)]
        wall = pattern_texture("plaster", wall_color, stable_number(name) + 1)
        x0, x1, z0, z1 = room.x_low, room.x_high, room.z_low, room.z_high
        sides = (
            ((x0 - WALL_M, 0, z0 - WALL_M), (x0, CEILING_M, z1 + WALL_M)),
            ((x1, 0, z0 - WALL_M), (x1 + WALL_M, CEILING_M, z1 + WALL_M)),
            ((x0 - WALL_M, 0, z0 - WALL_M), (x1 + WALL_M, CEILING_M, z0)),
            ((x0 - WALL_M, 0, z1), (x1 + WALL_M, CEILING_M, z1 + WALL_M)),
        )
        white: Rgb = (1.0, 1.0, 1.0)
        return [
            Instance("Floor|0", "Floor", (box_part((x0, -0.05, z0), (x1, 0, z1), white, floor),)),
            *(
                Instance(f"Wall|{number}", "Wall", (box_part(low, high, white, wall),))
                for number, (low, high) in enumerate(sides)
            ),
            Instance(
                "Ceiling|0",
                "Ceiling",
                (box_part((x0, CEILING_M, z0), (x1, CEILING_M + 0.05, z1), (0.93, 0.93, 0.91)),),
            ),
        ]

    def counter(self, item: LayoutObject) -> list[Instance]:
        """Return a counter's top and, as structure, the block below it."""
        rects = counter_rects(self.layout, item, self.room)
        if not rects:
            return []
        top_m = item.high_m[1]
        color = self._color(item) or "gray"
        seed = stable_number(self.layout.name + "counter")
        stone = pattern_texture("granite", PALETTE[color], seed)
        slabs = tuple(
            box_part(
                (r.x_low, top_m - TOP_M, r.z_low),
                (r.x_high, top_m, r.z_high),
                (1, 1, 1),
                stone,
                0.5,
            )
            for r in rects
        )
        inset = 0.01
        block = tuple(
            box_part(
                (r.x_low + inset, 0, r.z_low + inset),
                (r.x_high - inset, top_m - TOP_M, r.z_high - inset),
                self.door_color(),
            )
            for r in rects
        )
        return [
            Instance(item.object_id, "CounterTop", slabs, color, "stone"),
            Instance(f"Structure|{item.object_id}", "Structure", block),
        ]

    def stoves(self) -> list[Instance]:
        """Return the bodies of the stoves, as structure below the burners."""
        burners = self.layout.of_type("StoveBurner")
        if not burners:
            return []
        low = np.min([item.low_m for item in burners], axis=0)
        high = np.max([item.high_m for item in burners], axis=0)
        if max(high[0] - low[0], high[2] - low[2]) > 1.5:
            return []
        top = float(low[1])
        body = box_part(
            (low[0] - 0.04, 0, low[2] - 0.04),
            (high[0] + 0.04, top, high[2] + 0.04),
            PALETTE["white"],
        )
        return [Instance("Structure|Stove", "Structure", (body,))]

    def basin(self, item: LayoutObject) -> list[Instance]:
        """Return a sink, open from above, and the structure that carries it."""
        (x0, y0, z0), (x1, y1, z1) = item.low_m, item.high_m
        tops = [c.high_m[1] for c in self.layout.of_type("CounterTop")]
        near = [top for top in tops if y1 - 0.05 <= top <= y1 + 0.25]
        rim = min(near, default=y1)
        wall = 0.02
        parts = (
            box_part((x0, y0 - 0.02, z0), (x1, y0, z1), STEEL),
            box_part((x0, y0, z0), (x0 + wall, rim, z1), STEEL),
            box_part((x1 - wall, y0, z0), (x1, rim, z1), STEEL),
            box_part((x0, y0, z0), (x1, rim, z0 + wall), STEEL),
            box_part((x0, y0, z1 - wall), (x1, rim, z1), STEEL),
        )
        sinks = [s for s in self.layout.of_type("Sink") if item.object_id.startswith(s.object_id)]
        if not sinks:
            return [Instance(item.object_id, "Sink", parts, "gray", "metal")]
        surround, block = self._sink_surround(sinks[0], rect_of(item), rim)
        sink = Instance(sinks[0].object_id, "Sink", (*parts, *surround), "gray", "metal")
        below = Instance(f"Structure|{sink.object_id}", "Structure", block)
        return [sink, below] if block else [sink]

    def _sink_surround(
        self, sink: LayoutObject, hole: Rect, rim_m: float
    ) -> tuple[tuple[Part, ...], tuple[Part, ...]]:
        """Return the rim around the basin and the block below it."""
        x0, x1 = min(sink.low_m[0], hole.x_low), max(sink.high_m[0], hole.x_high)
        z0, z1 = min(sink.low_m[2], hole.z_low), max(sink.high_m[2], hole.z_high)
        frame = [
            Rect(x0, hole.x_low, z0, z1),
            Rect(hole.x_high, x1, z0, z1),
            Rect(hole.x_low, hole.x_high, z0, hole.z_low),
            Rect(hole.x_low, hole.x_high, hole.z_high, z1),
        ]
        frame = [r for r in frame if r.x_high - r.x_low > 0.005 and r.z_high - r.z_low > 0.005]
        top = rim_m + 0.003
        rim = [
            box_part((r.x_low, top - 0.03, r.z_low), (r.x_high, top, r.z_high), STEEL)
            for r in frame
        ]
        block = [
            box_part((r.x_low, 0, r.z_low), (r.x_high, top - 0.03, r.z_high), self.door_color())
            for r in frame
        ]
        return tuple(rim), tuple(block)

    def front(self, item: LayoutObject, solid: list[Rect]) -> list[Instance]:
        """Return a cabinet or drawer: a body, a door front with a gap around it, a handle."""
        low, high = np.asarray(item.low_m), np.asarray(item.high_m)
        axis, sign = self._open_side(item, solid)
        back_m = STEP_BACK_M * (stable_number(item.object_id) % STEPS_BACK)
        low, high = low + back_m, high - back_m
        face = high[axis] if sign > 0 else low[axis]
        panel_low, panel_high = low + 0.008, high - 0.008
        panel_low[axis], panel_high[axis] = sorted((face - sign * 0.002, face + sign * FRONT_M))
        center = (low + high) / 2
        upright = item.object_type == "Cabinet"
        half = np.array([0.012, 0.06 if upright else 0.008, 0.012])
        if not upright:
            half[2 - axis] = 0.05
        center[axis] = face + sign * (FRONT_M + 0.012)
        tall = high[1] - low[1]
        if upright:
            center[1] = low[1] + (0.2 if low[1] > 1.2 else 0.8) * tall
            half[1] = min(0.06, tall / 6)
        color = self.door_color()
        parts = (
            box_part(low, high, color),
            box_part(panel_low, panel_high, color),
            box_part(center - half, center + half, HANDLE),
        )
        return [Instance(item.object_id, item.object_type, parts, self._color(item), "wood")]

    def _open_side(self, item: LayoutObject, solid: list[Rect]) -> tuple[int, int]:
        """Return axis and sign of the side that looks into the room, away from what is solid."""
        room = self.room
        x, z = ((item.low_m[k] + item.high_m[k]) / 2 for k in (0, 2))
        middle = ((room.x_low + room.x_high) / 2, (room.z_low + room.z_high) / 2)
        best = (-np.inf, 0, 1)
        for axis, sign in ((0, 1), (0, -1), (2, 1), (2, -1)):
            probe = np.array([[x, z]])
            k = 0 if axis == 0 else 1
            probe[0, k] = (item.high_m if sign > 0 else item.low_m)[axis] + sign * 0.3
            inside = (
                room.x_low < probe[0, 0] < room.x_high and room.z_low < probe[0, 1] < room.z_high
            )
            clear = all(rect.distance_m(probe)[0] > 0 for rect in solid)
            wide = item.size_m()[2 - axis]  # a door is wider than the cabinet's side
            score = 4.0 * inside + 2.0 * clear + wide + 0.3 * sign * (middle[k] - (x, z)[k])
            if score > best[0]:
                best = (float(score), axis, sign)
        return best[1], best[2]

    def door_color(self) -> Rgb:
        name = color_of("Cabinet", "", self.layout.name)
        return PALETTE[name or "white"]

    def _color(self, item: LayoutObject) -> str | None:
        return color_of(item.object_type, item.object_id, self.layout.name)


def make_fitting(layout: RoomLayout) -> Fitting:
    return Fitting(layout, room_rect(layout))


def flat_parts(item: LayoutObject, color: Rgb, room: Rect) -> tuple[Part, ...]:
    """Return a window, picture, mirror, switch or shelf: a frame with a pane, inside the room."""
    low, high = np.asarray(item.low_m, np.float64), np.asarray(item.high_m, np.float64)
    if item.object_type == "Shelf":
        # iTHOR's box is the room above the board: things stand on its bottom, inside it.
        top = max(low[1], 0.005)
        return (
            box_part((low[0], max(top - BOARD_M, 0.001), low[2]), (high[0], top, high[2]), color),
        )
    size = high - low
    axis = 0 if size[0] < size[2] else 2
    edges = (room.x_low, room.x_high) if axis == 0 else (room.z_low, room.z_high)
    at_low = abs(low[axis] - edges[0]) < abs(high[axis] - edges[1])
    depth = float(np.clip(size[axis], 0.02, 0.06))
    if low[axis] < edges[0] + 0.02 or high[axis] > edges[1] - 0.02:  # hangs on that wall
        low[axis] = edges[0] if at_low else edges[1] - depth
        high[axis] = low[axis] + depth
    parts = [box_part(low, high, _frame_color(item.object_type, color))]
    if item.object_type in ("Window", "Painting", "Poster", "Mirror"):
        inner_low, inner_high = low + size * 0.06, high - size * 0.06
        inner_low[axis], inner_high[axis] = low[axis] - 0.004, high[axis] + 0.004
        parts.append(_pane(item, inner_low, inner_high, color))
    return tuple(parts)


def _frame_color(object_type: str, color: Rgb) -> Rgb:
    frames: dict[str, Rgb] = {
        "Window": (0.9, 0.9, 0.88),
        "Mirror": (0.5, 0.36, 0.22),
        "Painting": (0.30, 0.22, 0.15),
    }
    return frames.get(object_type, color)


def _pane(
    item: LayoutObject, low: NDArray[np.float64], high: NDArray[np.float64], color: Rgb
) -> Part:
    if item.object_type == "Window":
        return box_part(low, high, (0.66, 0.82, 0.95))
    if item.object_type == "Mirror":
        return box_part(low, high, (0.78, 0.82, 0.85))
    image = pattern_texture("granite", color, stable_number(item.object_id))
    return box_part(low, high, (1, 1, 1), image, 1.3)
