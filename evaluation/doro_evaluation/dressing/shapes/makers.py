"""All shapes by class; more than the mesh library has.

For the training of the captioner only: the rooms of the evaluation have the library's shapes.
Every maker draws its proportions from the generator it is given; :func:`make_shape` fits the
result into the size that the thing has in the room.
"""

from __future__ import annotations

import numpy as np

from doro_evaluation.dressing.shapes.appliances import APPLIANCES
from doro_evaluation.dressing.shapes.cabinets import CABINETS
from doro_evaluation.dressing.shapes.figures import FIGURES
from doro_evaluation.dressing.shapes.gadgets import GADGETS
from doro_evaluation.dressing.shapes.oddments import ODDMENTS
from doro_evaluation.dressing.shapes.papers import PAPERS
from doro_evaluation.dressing.shapes.seats import SEATS
from doro_evaluation.dressing.shapes.soft import SOFT
from doro_evaluation.dressing.shapes.solids import Maker, Rng, fitted
from doro_evaluation.dressing.shapes.vessels import VESSELS
from doro_sim_feeder.rooms.parts import Part, Rgb, bounds, place

TRIES, LITTLE_STRETCH, SMALL_M = 4, 1.7, 0.5


def make_shape(
    object_type: str, size_m: tuple[float, float, float], color: Rgb, rng: Rng
) -> tuple[Part, ...] | None:
    """Return a thing standing on the origin, front to +z; None where the class has no maker."""
    maker = MAKERS.get(object_type)
    if maker is None:
        return None
    tries: list[tuple[float, list[Part]]] = []
    for _ in range(TRIES):
        parts = maker(rng, color)
        low, high = bounds(tuple(parts))
        across = (high[0] - low[0] > high[2] - low[2]) != (size_m[0] > size_m[2])
        if across and max(size_m) < SMALL_M:
            parts = list(place(tuple(parts), 90.0, (0, 0, 0)))
            low, high = bounds(tuple(parts))
        ratio = np.asarray(size_m) / np.maximum(high - low, 1e-6)
        tries.append((float(ratio.max() / ratio.min()), parts))
        if tries[-1][0] < LITTLE_STRETCH:
            break
    return fitted(min(tries, key=lambda one: one[0])[1], size_m)


MAKERS: dict[str, Maker] = {
    **SEATS,
    **FIGURES,
    **GADGETS,
    **PAPERS,
    **CABINETS,
    **APPLIANCES,
    **SOFT,
    **ODDMENTS,
    **VESSELS,
}
