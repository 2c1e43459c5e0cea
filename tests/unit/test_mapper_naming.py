"""Class distributions of many views name a thing once and for all."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np

from doro_mapper.naming import NameMemory
from doro_mapper.projection import Measured
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import ClassProbability, GraphBox


def measured(*centers: tuple[float, float, float], side_m: float = 0.1) -> Measured:
    center = np.array(centers, np.float64)
    half = np.full(3, side_m / 2)
    return cast(
        Measured, SimpleNamespace(center_m=center, low_m=center - half, high_m=center + half)
    )


def seen(**shares: float) -> GraphBox:
    classes = [ClassProbability(name=name, probability=share) for name, share in shares.items()]
    best = max(shares, key=lambda name: shares[name])
    graph = ObjectGraph(name=best, attributes={"color": "red"})
    return GraphBox(box_px=[0, 0, 9, 9], score=0.5, graph=graph, caption=best, classes=classes)


HERE, THERE = (1.0, 0.5, 1.0), (2.0, 0.5, 1.0)


def test_the_distribution_wins_over_single_winners() -> None:
    """Three views say mug, vase, bowl; all of them hold a cup for nearly as likely."""
    memory = NameMemory()
    views = [seen(mug=0.5, cup=0.4), seen(vase=0.5, cup=0.4), seen(bowl=0.5, cup=0.4)]
    names = [memory.fused([view], measured(HERE))[0].graph.name for view in views]
    assert names == ["mug", "cup", "cup"]
    (last,) = memory.fused([seen(mug=0.5, cup=0.4)], measured(HERE))
    assert last.graph.attributes == {"color": "red"}
    assert last.classes[0].name == "cup"
    assert sum(one.probability for one in last.classes) <= 1 + 1e-9


def test_places_are_kept_apart() -> None:
    memory = NameMemory()
    for _ in range(3):
        memory.fused([seen(mug=0.6, cup=0.3), seen(cup=0.7, mug=0.2)], measured(HERE, THERE))
    both = [seen(mug=0.5, cup=0.45), seen(mug=0.5, cup=0.45)]
    assert [box.graph.name for box in memory.fused(both, measured(HERE, THERE))] == ["mug", "cup"]
    # Two things of one frame are two, however near.
    near = memory.fused([seen(cup=0.9, mug=0.1), seen(mug=0.9, cup=0.1)], measured(HERE, HERE))
    assert len({box.graph.name for box in near}) == 2


def test_oracles_pass_untouched() -> None:
    plain = GraphBox(box_px=[0, 0, 9, 9], score=1.0, graph=ObjectGraph(name="cup"))
    memory = NameMemory()
    memory.fused([seen(mug=0.9, cup=0.1)], measured(HERE))
    assert memory.fused([plain], measured(HERE)) == [plain]
