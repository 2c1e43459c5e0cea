"""Settings of the mapper; every field can be set in the table ``[mapper]``."""

from __future__ import annotations

from typing import Literal

import msgspec

from doro_mapper.planner.settings import PlannerSettings

NO_LANDMARKS = (
    "cabinet",
    "drawer",
    "stove burner",
    "stove knob",
    "faucet",
    "window",
    "curtain",
    "blinds",
    "mirror",
    "painting",
    "poster",
    "light switch",
    "towel",
)


Part = Literal["cannot_link", "observability", "voting"]
MAX_SAMPLES = 32
"""Per side: a box's samples are numbered with 10 bits."""


class MapperSettings(msgspec.Struct, frozen=True, kw_only=True):
    """What may be tuned. Defaults are the study's (five bedrooms, then frozen).

    Attributes:
        finder: method that tells instances apart: ``tracks`` (object tracks with negative
            evidence), ``grid`` (the paper's regions over the hash maps, corrected) or
            ``paper_literal`` (Algorithm 1 as printed).
        cell_m, band_m: edge of a ground cell and height of a band.
        sigma: width of the soft mask as a fraction of the box side.
        samples: pixels looked at per side of a box.
        min_box_px: boxes with a shorter side are ignored.
        duplicate_iou: two boxes of one class in one frame that overlap more and lie in one
            place are one thing.
        fuse_names: class distributions of a place are fused over views before a name is taken.
        max_depth_m: farther depth is not used.
        max_pending_frames: frames that wait for their other half; the oldest goes first.
        max_views: frames remembered for negative evidence; the oldest is forgotten first, its
            hits and misses stay counted.
        max_tracks: tracks kept; beyond it the weakest is forgotten.
        max_cells: cells of the map; further ones are counted and left out.
        coverage_cell_m: edge of the squares in which unseen area is counted.
        region_m, gamma: edge of a region and least score, of ``paper_literal`` only.
        literal_index: what ``paper_literal`` takes for the next best region: ``id`` as printed,
            ``rank`` as meant.
        min_hits: views that make an instance.
        min_hit_share: least hits / (hits + misses) of an instance.
        min_certain, min_certain_share: the same two for what a detector with calibrated scores
            reports; each view counts by its score.
        min_certain_share_furniture: the share for what is longer than 0.6 m.
        many_certain, many_certain_share: so many views, counted likewise, need this share only.
        set_things, set_share: where so many things of a class are believed, another one that stands
            in none of them needs this share only; 0 things: never.
        few_views: below so many frames one view without a miss makes an instance.
        max_evidence: views listed per instance.
        relation_share: share of its views in which a captioned relation must occur.
        max_near: is-near landmarks listed per instance.
        no_landmarks: classes that no measured relation leads to: too many of a kind in a room,
            too small or too flat to say where something is. Captions may still name them.
        without: parts of ``tracks`` that are left out, to measure what they are worth:
            ``cannot_link`` (two things of one frame are two), ``observability`` (views that should
            have seen a thing and did not), ``voting`` (the first view says what a thing is).
        planner: of the next view, table ``[mapper.planner]``.
    """

    finder: Literal["tracks", "grid", "paper_literal"] = "tracks"
    cell_m: float = 0.05
    band_m: float = 0.10
    sigma: float = 0.25
    samples: int = 24
    min_box_px: float = 3.0
    duplicate_iou: float = 0.7
    fuse_names: bool = False
    max_depth_m: float = 20.0
    max_pending_frames: int = 64
    max_views: int = 1024
    max_tracks: int = 500
    max_cells: int = 500_000
    coverage_cell_m: float = 0.25
    region_m: float = 0.5
    gamma: float = 0.2
    literal_index: Literal["id", "rank"] = "id"
    min_hits: int = 2
    min_hit_share: float = 0.25
    min_certain: float = 2.5
    min_certain_share: float = 0.5
    min_certain_share_furniture: float = 0.5
    many_certain: float = 16.0
    many_certain_share: float = 0.4
    set_things: int = 2
    set_share: float = 0.2
    few_views: int = 40
    max_evidence: int = 5
    relation_share: float = 0.3
    max_near: int = 3
    no_landmarks: tuple[str, ...] = NO_LANDMARKS
    without: tuple[Part, ...] = ()
    planner: PlannerSettings = PlannerSettings()

    def __post_init__(self) -> None:
        lengths = [self.cell_m, self.band_m, self.sigma, self.coverage_cell_m]
        lengths += [self.max_depth_m, self.region_m]
        if min(lengths) <= 0:
            raise ValueError(
                "cell_m, band_m, sigma, coverage_cell_m, max_depth_m and region_m must be > 0"
            )
        bounds = [self.samples, self.max_pending_frames, self.max_views, self.max_cells]
        bounds += [self.max_tracks, self.min_hits]
        if self.samples > MAX_SAMPLES:
            raise ValueError(f"samples must be at most {MAX_SAMPLES} per side")
        if min(bounds) < 1:
            raise ValueError("samples, min_hits and all max_... counts must be at least 1")
