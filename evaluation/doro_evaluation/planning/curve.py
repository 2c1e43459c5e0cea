"""Views needed: counting after a part of the views, chosen by the planner or not.

One recording has one view per reachable cell. The planner chooses among just those, as a feeder
does over the bus (``doro play --order planned``): after each merged frame it names a goal and the
view left that is nearest to it comes next. Beside it: the recorded order (a walk from cell to
nearest cell) and seeded random orders of the same views. At the marks the map is counted against
all that any view of the recording can show.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from time import thread_time

import msgspec
import numpy as np

from doro_evaluation.chain import ERROR_MODELS, Language, Room, load_room
from doro_evaluation.outcomes import Outcome, Thing, found_things, true_things
from doro_mapper.core import Mapper
from doro_mapper.planner.guide import Guide
from doro_mapper.settings import MapperSettings
from doro_nlu.settings import NluSettings
from doro_perception.settings import PerceptionSettings
from doro_schemas.detector_errors import read_pool
from doro_schemas.errors import Refused
from doro_schemas.messages import ExplorationGoal, FrameGraphs, InstancesRequest
from doro_schemas.viewpoint import viewpoint_of
from doro_sim_feeder.planned import nearest_view

SHARES = (0.05, 0.1, 0.15, 0.2, 0.25, 1 / 3, 0.4, 0.5, 0.67, 0.8, 1.0)
THIRD = 1 / 3
DONE = -1.0
"""In place of a share: where the planner first said that it was done."""
PLANNED, RECORDED, RANDOM = "planned", "recorded", "random"
ORDERS = (PLANNED, RECORDED, RANDOM)


class Point(msgspec.Struct, frozen=True):
    """What is known after a part of a recording's views.

    Attributes:
        order, seed: how the views were ordered; the seed is that of a random order.
        share: mark, of :data:`SHARES`, or :data:`DONE`.
        views, of_views: taken, and all there are.
        travel_m: straight lines from view to view.
        coverage: share of the area that was seen.
        goal_ms: CPU time of a goal, median over the views so far; nan for the other orders.
    """

    order: str
    seed: int
    share: float
    views: int
    of_views: int
    travel_m: float
    coverage: float
    goal_ms: float
    outcome: Outcome


class PlanningContext(msgspec.Struct, frozen=True, kw_only=True):
    """What all runs share.

    Attributes:
        errors: name of an error model; pool: file of its false positives, where it has some.
        seeds: of the random orders; error_seed: of the error model.
    """

    mapper: MapperSettings = MapperSettings()
    perception: PerceptionSettings = PerceptionSettings()
    nlu: NluSettings = NluSettings()
    errors: str = "gt"
    pool: str = ""
    seeds: tuple[int, ...] = (0, 1, 2)
    error_seed: int = 0
    shares: tuple[float, ...] = SHARES


class Walk:
    """One order of a room's views, merged view by view."""

    def __init__(self, room: Room, graphs: Sequence[FrameGraphs], settings: MapperSettings) -> None:
        self._room, self._graphs = room, graphs
        self._core = Mapper(settings)
        # Goals are asked for, so that other orders pay nothing for them.
        silent = msgspec.structs.replace(settings.planner, every=0)
        self._guide = Guide(self._core, silent, settings.max_pending_frames)
        self._views = [viewpoint_of(depth.pose) for depth in room.depths]
        self._left: dict[int, None] = dict.fromkeys(range(len(self._views)))
        self.taken: list[int] = []
        self.travel_m = 0.0
        self.goal_ms: list[float] = []
        self._guide.exploration(msgspec.structs.replace(room.start(), reachable=self._views))

    def take(self, number: int) -> None:
        """Merge a view."""
        if self.taken:
            here = self._views[self.taken[-1]].position_m
            self.travel_m += math.dist(here, self._views[number].position_m)
        self.taken.append(number)
        del self._left[number]
        self._guide.depth_frame(self._room.depths[number])
        self._guide.frame_graphs(self._graphs[number])

    def goal(self) -> ExplorationGoal:
        """Return the next view worth taking; its time is kept."""
        started = thread_time()
        goal = self._guide.goal()
        self.goal_ms.append((thread_time() - started) * 1e3)
        return goal

    def nearest(self, goal: ExplorationGoal) -> int:
        """Return the view left that is nearest to a goal, the first left where it names none."""
        if goal.view is None:
            return next(iter(self._left))
        chosen: int = nearest_view(self._views, self._left, goal.view)
        return chosen

    def coverage(self) -> float:
        """Return the share of the area seen so far."""
        return 1.0 - self._core.unseen_share()

    def found(self) -> tuple[Thing, ...]:
        """Return the instances as of now."""
        return found_things(self._core.instances(InstancesRequest()).instances)


def run_order(
    room: Room,
    graphs: Sequence[FrameGraphs],
    truth: tuple[Thing, ...],
    context: PlanningContext,
    *,
    order: str,
    seed: int = 0,
) -> list[Point]:
    """Return the points of one order over a recording, and where the planner was done.

    Args:
        order: a name of :data:`ORDERS`; seed: of the random one.

    Raises:
        Refused: there is no such order.
    """
    count = len(room.depths)
    if order == RANDOM:
        given = [int(k) for k in np.random.default_rng([seed, count]).permutation(count)]
    elif order in (RECORDED, PLANNED):
        given = list(range(count))
    else:
        raise Refused(f"there is no order '{order}' to compare: use {', '.join(ORDERS)}")
    marks: dict[int, list[float]] = {}
    for share in context.shares:
        marks.setdefault(max(1, round(share * count)), []).append(share)
    walk = Walk(room, graphs, context.mapper)
    points: list[Point] = []
    following, was_done = 0, False
    while len(walk.taken) < max(marks):
        walk.take(following if order == PLANNED else given[len(walk.taken)])
        shares = marks.get(len(walk.taken), [])
        if order == PLANNED and len(walk.taken) < count:
            goal = walk.goal()
            following = walk.nearest(goal)
            if goal.done and not was_done:
                was_done, shares = True, [*shares, DONE]
        if shares:
            outcome = _outcome(room, truth, walk, order, context.errors)
            points += [_point(walk, len(room.depths), share, outcome, seed) for share in shares]
    return points


def _outcome(room: Room, truth: tuple[Thing, ...], walk: Walk, order: str, errors: str) -> Outcome:
    return Outcome(
        recording=room.name,
        room=room.room,
        part=room.name.split("-FloorPlan")[0],
        system=order,
        errors=errors,
        frames=len(walk.taken),
        truth=truth,
        found=walk.found(),
    )


def _point(walk: Walk, of_views: int, share: float, outcome: Outcome, seed: int) -> Point:
    return Point(
        order=outcome.system,
        seed=seed,
        share=share,
        views=len(walk.taken),
        of_views=of_views,
        travel_m=walk.travel_m,
        coverage=walk.coverage(),
        goal_ms=float(np.median(walk.goal_ms)) if walk.goal_ms else math.nan,
        outcome=outcome,
    )


def run_recording(path: Path, context: PlanningContext) -> list[Point]:
    """Return the points of all orders over one recording.

    Raises:
        Refused: the recording does not serve.
    """
    language = _language(context)
    room = load_room(path)
    graphs = language.graphs(room, ERROR_MODELS[context.errors], context.error_seed)
    truth = true_things(room, context.perception)
    runs = [(PLANNED, 0), (RECORDED, 0), *((RANDOM, seed) for seed in context.seeds)]
    points: list[Point] = []
    for order, seed in runs:
        points += run_order(room, graphs, truth, context, order=order, seed=seed)
    return points


class _Kept:
    """The language that a process keeps between recordings: loading its models takes seconds."""

    language: Language | None = None


def _language(context: PlanningContext) -> Language:
    if _Kept.language is None:
        pool = read_pool(Path(context.pool)) if context.pool else None
        _Kept.language = Language(context.perception, context.nlu, pool)
    return _Kept.language


def run_planning(
    paths: Sequence[Path], context: PlanningContext, workers: int = 1
) -> Iterator[list[Point]]:
    """Yield the points of each recording as they are done.

    Args:
        paths: recordings with depth, detections and truth (``doro rooms set``).
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    if workers <= 1 or len(paths) <= 1:
        _Kept.language = None
        for path in paths:
            yield run_recording(path, context)
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        futures = [pool.submit(run_recording, path, context) for path in paths]
        for future in as_completed(futures):
            yield future.result()
