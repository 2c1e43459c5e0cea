"""The next view worth taking (the paper's third item of future work).

What a view promises is counted in things made certain: things expected where nobody has looked
well enough (``space.py``), and things of the map that another look would settle
(``things.py``). The promise is ray-cast through the space as seen so far and weighed
against the way there. Both halves only shrink while the map grows, nearly, so a view's last
promise bounds its next one and only the best need to be cast again (lazy greedy).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doro_mapper.planner.rays import Fan, fan_of
from doro_mapper.planner.settings import PlannerSettings
from doro_mapper.planner.space import Space
from doro_mapper.planner.things import SIGHT_STEPS, Thing, Worth, novelty, shown, worth_of
from doro_mapper.planner.views import (
    Candidates,
    Look,
    Proposals,
    candidates_of,
    way_to,
    ways,
)
from doro_mapper.views import Camera, Floats
from doro_schemas.camera import World
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Exploration, ExplorationGoal
from doro_schemas.viewpoint import Viewpoint

BATCH = 16
LONGER = 4
"""Times the budget, before a robot is told that there is nothing left."""
REFRESHED = 8
"""Views looked at in turn, whatever they promised last."""
PENDING = 16
PAST = 256
"""Cameras remembered, so that no view is proposed that was just taken."""
SEEN_BEFORE = 0.3
"""A look from where a thing was seen before is worth so much of one from a new side."""
OPENING = 0.1
LITTLE = 1e-6
PARTS = ("area", "tentative", "twins", "unclear")


@dataclass(frozen=True, slots=True)
class Promise:
    """What views promise, (n, len(PARTS))."""

    parts: Floats

    @property
    def total(self) -> Floats:
        out: Floats = self.parts.sum(axis=1)
        return out


class Planner:
    """Chooses the next view of one episode. Bounded in time and memory; deterministic."""

    def __init__(self, settings: PlannerSettings) -> None:
        self._settings = settings
        self._named: list[Viewpoint] = []
        self._asked: ObjectGraph | None = None
        self._candidates: Candidates | None = None
        self.wanted = False
        self._empty()

    def _empty(self) -> None:
        self._space = Space(self._settings)
        self._pending: list[Look] = []
        self._camera: Camera | None = None
        self._world: World = "unity"
        self._candidates = None
        self._proposals: Proposals | None = None
        self._past: list[Camera] = []
        self._turn = 0
        self._fan: Fan | None = None

    def start(self, message: Exploration | None = None) -> None:
        """Forget the area; take over which views are reachable and whether goals are wanted."""
        self._empty()
        self._named = list(message.reachable or []) if message is not None else []
        self.wanted = bool(message is not None and message.goals)

    def ask(self, graph: ObjectGraph | None) -> None:
        """Prefer what an instruction is about; None: nothing in particular."""
        self._asked = graph

    def frame(self, look: Look) -> None:
        """Take a merged frame: cheap now, worked in when a goal is asked for."""
        self._camera, self._world = look.camera, look.world
        self._pending.append(look)
        if len(self._pending) >= PENDING:
            self._work_in()

    def _work_in(self) -> None:
        for look in self._pending:
            self._space.add(look.camera, look.thumb_m)
            self._past.append(look.camera)
        known = self._proposals.candidates if self._proposals else self._candidates
        if known is not None:
            known.take([look.camera for look in self._pending])
        del self._past[:-PAST]
        self._pending.clear()

    def goal(self, things: Callable[[], Sequence[Thing]]) -> ExplorationGoal:
        """Return the next view; the caller fills in episode, frame and coverage.

        Args:
            things: gives the instances and tracks of the map, called only when needed.
        """
        self._work_in()
        camera = self._camera
        if camera is None:
            return ExplorationGoal(reason="nothing seen yet")
        way = ways(self._space, self._past, self._settings)
        candidates, left = self._choices(camera, way)
        far = way_to(self._space, camera, way, candidates.position_m)
        worth = worth_of(things(), self._asked, self._settings)
        best, parts, rest = self._search(candidates, left, far, worth, camera)
        if best < 0:
            return ExplorationGoal(done=True, reason="no reachable view is left")
        gain = float(parts.sum())
        view = candidates.views[best]
        return ExplorationGoal(
            done=max(gain, rest) < self._settings.least_gain,
            view=view,
            pose=view.pose(self._world),
            distance_m=round(float(far[best]), 3),
            gain=round(gain, 4),
            parts={name: round(float(x), 4) for name, x in zip(PARTS, parts, strict=True)},
            reason=_reason(parts),
        )

    def _choices(
        self, camera: Camera, way: NDArray[np.float32]
    ) -> tuple[Candidates, NDArray[np.int64]]:
        """Return the named views, or those of the free floor, and which of them are left."""
        if not self._named:
            if self._proposals is None:
                self._proposals = Proposals(self._settings, self._world)
            allowed = self._proposals.update(self._space, self._past, way)
            proposed = self._proposals.candidates
            return proposed, np.flatnonzero(allowed & ~proposed.taken)
        if self._candidates is None:
            self._candidates = candidates_of(self._named, self._world, self._settings)
            self._candidates.take(self._past)
            self._space.make_room(camera.position_m, self._candidates.position_m)
        return self._candidates, np.flatnonzero(~self._candidates.taken)

    def _search(
        self,
        candidates: Candidates,
        left: NDArray[np.int64],
        far: Floats,
        worth: Worth,
        camera: Camera,
    ) -> tuple[int, Floats, float]:
        """Return the view with the best gain per way (-1: none), the parts of its gain, and what
        the views that were not looked at now may promise at most.
        """
        if not len(left):
            return -1, np.zeros(len(PARTS)), 0.0
        cost = 1.0 + self._settings.travel_per_m * far
        hopes = np.zeros(len(candidates))
        hopes[left] = self._things_promise(candidates, left, worth, camera, seen_through=True).total
        # What was in the way of things last time is nearly all still there.
        hoped = candidates.area_gain + hopes * candidates.open_share
        bound = hoped / cost
        # Of those never looked at, the nearest first.
        order = left[np.lexsort((left, far[left], -bound[left]))]
        turn = np.unique((self._turn + np.arange(REFRESHED)) % len(left))
        self._turn += REFRESHED
        best, best_score, best_parts = -1, -np.inf, np.zeros(len(PARTS))
        looked = np.zeros(len(candidates), np.bool_)
        batches = [left[turn], *(order[k : k + BATCH] for k in range(0, len(order), BATCH))]
        for number, batch in enumerate(batches):
            enough = best_parts.sum() >= self._settings.least_gain
            most = self._settings.budget * (1 if enough else LONGER)
            if number and (looked.sum() >= most or bound[batch[0]] <= best_score):
                break
            parts = self._promise(candidates, batch, worth, camera).parts
            looked[batch] = True
            seen = (parts[:, 1:].sum(axis=1) + LITTLE) / (hopes[batch] + LITTLE)
            candidates.open_share[batch] = np.minimum(1.0, seen + OPENING)
            score = parts.sum(axis=1) / cost[batch]
            at = int(np.lexsort((batch, -score))[0])
            if (score[at], -batch[at]) > (best_score, -best):
                best, best_score, best_parts = int(batch[at]), float(score[at]), parts[at]
        rest = left[~looked[left]]
        return best, best_parts, float(hoped[rest].max(initial=0.0))

    def _promise(
        self, candidates: Candidates, chosen: NDArray[np.int64], worth: Worth, camera: Camera
    ) -> Promise:
        area = self._area_promise(candidates, chosen, camera)
        candidates.area_gain[chosen] = area
        promise = self._things_promise(candidates, chosen, worth, camera, seen_through=False)
        promise.parts[:, 0] = area
        return promise

    def _area_promise(
        self, candidates: Candidates, chosen: NDArray[np.int64], camera: Camera
    ) -> Floats:
        """Return the things (n,) that views would show in what nobody has looked at well."""
        space, fan = self._space, self._fan_of(camera)
        # In voxels from the grid's corner, so that a floor is all that is left to do.
        start = (candidates.position_m[chosen] - space.origin_m) / space.edge_m
        rays = (fan.rays @ candidates.rotation[chosen]).astype(np.float32)
        steps = rays[:, :, None] * fan.reach[:, None] + start.astype(np.float32)[:, None, None]
        index = space.flat(steps)
        open_share = 1 - space.opacity[index]
        np.cumprod(open_share, axis=2, out=open_share)
        gain = space.value[index] * fan.share
        gain[..., 1:] *= open_share[..., :-1]
        return np.asarray(gain.sum(axis=(1, 2), dtype=np.float64))

    def _fan_of(self, camera: Camera) -> Fan:
        if self._fan is None or self._fan.camera != (camera.intrinsics, camera.size_px):
            self._fan = fan_of(camera, self._space.edge_m, self._settings)
        return self._fan

    def _things_promise(
        self,
        candidates: Candidates,
        chosen: NDArray[np.int64],
        worth: Worth,
        camera: Camera,
        *,
        seen_through: bool,
    ) -> Promise:
        """Return what views promise to settle about things of the map.

        Args:
            seen_through: as if nothing were in the way.
        """
        parts = np.zeros((len(chosen), len(PARTS)))
        if not len(worth):
            return Promise(parts)
        position, rotation = candidates.position_m[chosen], candidates.rotation[chosen]
        chance = shown(worth, position, rotation, camera, self._settings)
        if not seen_through:
            stop = worth.radius_m + self._space.edge_m
            chance = chance * self._space.clear(position, worth.center_m, stop, SIGHT_STEPS)
        new = novelty(worth, position)
        parts[:, 1] = (chance * (SEEN_BEFORE + (1 - SEEN_BEFORE) * new)) @ worth.tentative
        if len(worth.pairs):
            both = chance[:, worth.pairs[:, 0]] * chance[:, worth.pairs[:, 1]]
            parts[:, 2] = both @ worth.twins
        parts[:, 3] = (chance * new) @ worth.unclear
        return Promise(parts)


def _reason(parts: Floats) -> str:
    names = {
        "area": "not looked at closely yet",
        "tentative": "things seen too seldom",
        "twins": "things alike, never seen together",
        "unclear": "things whose place or attributes are unclear",
    }
    order = np.argsort(-parts, kind="stable")
    return ", ".join(names[PARTS[k]] for k in order if parts[k] > 0.1 * parts.sum())
