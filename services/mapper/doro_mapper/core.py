"""The mapper's core: messages in, messages out."""

from __future__ import annotations

import numpy as np

from doro_mapper.area import Area, Change
from doro_mapper.canonical import canonical
from doro_mapper.carried import with_carried
from doro_mapper.finder import TrackSummary
from doro_mapper.instances import Answer, build
from doro_mapper.join import FrameRuns, Half, Join, Key
from doro_mapper.settings import MapperSettings
from doro_schemas.camera import World
from doro_schemas.effects import Output
from doro_schemas.errors import Refused
from doro_schemas.messages import (
    DepthFrame,
    Exploration,
    FrameGraphs,
    GridDelta,
    GridRequest,
    GridSnapshot,
    Instances,
    InstancesRequest,
    PoseCorrections,
    Rejected,
)
from doro_schemas.topics import topic_of
from doro_schemas.vocabulary import name_satisfies

MAX_ENDED = 64
COUNTERS = (
    "frames_merged",
    "detections_merged",
    "detections_without_depth",
    "detections_too_small",
    "detections_duplicate",
    "duplicates",
    "late",
    "pending_dropped",
    "resets",
    "cells_dropped",
    "frames_corrected",
)


class Mapper:
    """Joins depth and graphs by frame, keeps the map, answers for instances and grid.

    Frames are merged in the order in which their second half arrives. Memory is bounded by the
    settings: pending frames, views, tracks, cells (see the README).
    """

    def __init__(self, settings: MapperSettings) -> None:
        self._settings = settings
        self._join = Join(settings.max_pending_frames)
        self._area = Area(settings)
        self._episode: str | None = None
        self._ended: dict[str, None] = {}
        self._merged = FrameRuns()
        self._seq = 0
        self._stamp_ns = 0
        self._last_frame = -1
        self._world: World | None = None
        self._answer: Answer | None = None
        self.counters: dict[str, int] = dict.fromkeys(COUNTERS, 0)

    @property
    def pending(self) -> int:
        """Number of frames that wait for their other half."""
        return len(self._join)

    def depth_frame(self, message: DepthFrame) -> list[Output]:
        """Take a frame's depth and pose; merge the frame if its graphs are there.

        Raises:
            Refused: depth and graphs disagree about the size, or the world's axes changed.
        """
        return self._half(message)

    def frame_graphs(self, message: FrameGraphs) -> list[Output]:
        """Take a frame's graphs; merge the frame if its depth is there. Errors as above."""
        return self._half(message)

    def exploration(self, message: Exploration) -> list[Output]:
        """Start an episode with an empty map; ``finished`` changes nothing here."""
        if message.state != "started":
            return []
        self._stamp_ns = message.stamp_ns
        if message.episode != self._episode or len(self._merged):
            return self._reset(message.episode)
        # Depth that came before the word "started" on another key waits on.
        return [self._reset_delta()]

    def pose_corrections(self, message: PoseCorrections) -> list[Output]:
        """Place frames anew; the delta says which cells the map has now.

        Raises:
            Refused: the poses are in another world than the map, or of another episode.
        """
        self._check_episode(message.episode)
        if message.poses and message.poses[0].world != self._world:
            raise Refused(
                f"corrected poses are in a '{message.poses[0].world}' world but the map is in"
                f" '{self._world or 'none yet'}': send them as the frames were sent",
                episode=message.episode,
            )
        known, change = self._area.correct(message.camera, message.frames, message.poses)
        self.counters["frames_corrected"] += known
        if not known or change is None:
            return []
        self._answer = None
        self._stamp_ns = message.stamp_ns
        self._seq += 1
        return [self._delta(change, message.camera, -1, known)]

    def instances(self, request: InstancesRequest) -> Instances:
        """Return the unique instances of a class and its kinds; of all classes for no name.

        Raises:
            Refused: the request is about another episode than the map.
        """
        self._check_episode(request.episode)
        area, world = self._area, self._world or "unity"
        if self._answer is None:
            found = area.find()
            unnamed = area.unnamed(found)
            self._answer = build(found, area.lost(), world, self._settings, unnamed)
        answer = self._answer
        wanted = request.name.strip()
        chosen = [i for i in answer.counted if not wanted or name_satisfies(wanted, i.graph.name)]
        return Instances(
            stamp_ns=self._stamp_ns,
            episode=self._episode or "",
            name=request.name,
            frames_merged=len(self._merged),
            last_frame=self._last_frame,
            digest=area.digest(),
            unseen_share=area.coverage.unseen_share(),
            instances=with_carried(chosen, answer.counted, request.carried, world),
            tentative=answer.tentative_of(wanted),
            gone=answer.gone_of(wanted),
            one_sided_share=area.coverage.one_sided_share(),
            unnamed=answer.unnamed,
        )

    def tracks(self) -> list[TrackSummary]:
        """Return what is being tracked, whether it counts or not; map axes."""
        return self._area.tracks()

    def unseen_share(self) -> float:
        """Return the share of the area inside the map's bounds that no frame observed."""
        return self._area.coverage.unseen_share()

    def grid(self, request: GridRequest) -> GridSnapshot:
        """Return the whole map, or the graphs and cells of one class and its kinds.

        Raises:
            Refused: the request is about another episode than the map.
        """
        self._check_episode(request.episode)
        area, settings = self._area, self._settings
        shown = area.snapshot(request.name.strip())
        return GridSnapshot(
            stamp_ns=self._stamp_ns,
            episode=self._episode or "",
            frames_merged=len(self._merged),
            last_frame=self._last_frame,
            cell_m=settings.cell_m,
            band_m=settings.band_m,
            graphs=shown.graphs,
            digest=area.digest(),
            cells=shown.cells,
            weights=shown.weights,
            floor=area.coverage.floor(),
            path_m=area.coverage.path_m(),
            blocks=shown.blocks,
            squares=area.coverage.squares(),
            regions=shown.regions,
            region_scores=shown.region_scores,
            square_m=settings.coverage_cell_m,
            region_m=settings.region_m,
        )

    def _check_episode(self, episode: str) -> None:
        if episode and episode != self._episode:
            now = f"'{self._episode}'" if self._episode is not None else "none yet"
            raise Refused(
                f"the map is of episode {now}, not '{episode}': ask without an episode,"
                " or play that one again",
                episode=episode,
            )

    def _half(self, message: DepthFrame | FrameGraphs) -> list[Output]:
        episode = message.episode or self._episode or ""
        if episode in self._ended:
            self.counters["late"] += 1
            return []
        outputs: list[Output] = []
        if episode != self._episode:
            self._stamp_ns = message.stamp_ns
            outputs += self._reset(episode)
        if (message.camera, message.frame) in self._merged:
            self.counters["duplicates"] += 1
            return outputs
        pair = self._join.add(message)
        outputs += [self._dropped(key, half) for key, half in self._join.overflow()]
        if pair is not None:
            outputs.append(self._merge(*pair))
        return outputs

    def _merge(self, depth: DepthFrame, graphs: FrameGraphs) -> GridDelta:
        """Merge one complete frame; the delta is also the word that it is merged."""
        if self._world is not None and depth.pose.world != self._world:
            raise Refused(
                f"frame {depth.frame} of {depth.camera} has a pose in a '{depth.pose.world}' world"
                f" but the episode's map is in '{self._world}': send one kind of world per episode",
                episode=depth.episode,
                frame=depth.frame,
            )
        self._world = depth.pose.world
        change = self._area.merge(depth, canonical(graphs), self.counters)
        self._merged.add((depth.camera, depth.frame))
        self._answer = None
        self._last_frame = depth.frame
        self._stamp_ns = depth.stamp_ns
        self._seq += 1
        self.counters["frames_merged"] += 1
        return self._delta(change, depth.camera, depth.frame, 0)

    def _delta(self, change: Change, camera: str, frame: int, corrected: int) -> GridDelta:
        return GridDelta(
            stamp_ns=self._stamp_ns,
            episode=self._episode or "",
            seq=self._seq,
            camera=camera,
            frame=frame,
            frames_merged=len(self._merged),
            cell_m=self._settings.cell_m,
            band_m=self._settings.band_m,
            new_graphs=change.new_graphs,
            cells=change.cells,
            weights=change.weights,
            blocks=change.blocks,
            corrected=corrected,
        )

    def _reset(self, episode: str) -> list[Output]:
        """Empty the map and start ``episode``; what comes late for the old one is ignored."""
        if self._episode is not None and self._episode != episode:
            self._ended[self._episode] = None
            while len(self._ended) > MAX_ENDED:
                del self._ended[next(iter(self._ended))]
        self._ended.pop(episode, None)
        self._episode = episode
        self._join.clear()
        self._area = Area(self._settings)
        self._merged = FrameRuns()
        self._world = None
        self._answer = None
        self._last_frame = -1
        self.counters["resets"] += 1
        return [self._reset_delta()]

    def _reset_delta(self) -> GridDelta:
        self._seq = 0
        return GridDelta(
            stamp_ns=self._stamp_ns,
            episode=self._episode or "",
            seq=0,
            reset=True,
            frame=-1,
            frames_merged=0,
            cell_m=self._settings.cell_m,
            band_m=self._settings.band_m,
            cells=np.zeros((0, 6), np.int32),
            weights=np.zeros(0, np.float32),
        )

    def _dropped(self, key: Key, half: Half) -> Rejected:
        """Return the word to the operator that a frame never became whole."""
        self.counters["pending_dropped"] += 1
        had, lacked = ("depth", "graphs") if half.depth is not None else ("graphs", "depth")
        message = half.depth or half.graphs
        return Rejected(
            stamp_ns=message.stamp_ns if message is not None else self._stamp_ns,
            episode=self._episode or "",
            service="mapper",
            key=topic_of(DepthFrame if half.depth is not None else FrameGraphs).key,
            reason=(
                f"frame {key[1]} of {key[0]} has {had} but its {lacked} did not come within"
                f" {self._settings.max_pending_frames} frames: check that both are published with"
                " the same episode, camera and frame"
            ),
            frame=key[1],
        )
