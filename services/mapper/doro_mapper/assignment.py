"""Linear assignment: one-to-one pairs of least total cost."""

from __future__ import annotations

import numpy as np

from doro_mapper.views import Floats


def assign(cost: Floats) -> list[tuple[int, int]]:
    """Return the pairs (row, column), by row, of a one-to-one assignment of least cost.

    Shortest augmenting paths with potentials (Jonker and Volgenant 1987), O(n^2 m); there are
    at most some dozen rows here. All of the shorter side is assigned.

    Args:
        cost: (n, m), finite.
    """
    if not cost.size:
        return []
    if cost.shape[0] > cost.shape[1]:
        return sorted((row, column) for column, row in assign(cost.T))
    rows, columns = cost.shape
    row_price = np.zeros(rows)
    column_price = np.zeros(columns)
    owner = np.full(columns, -1)
    for start in range(rows):
        best = np.full(columns, np.inf)
        came_from = np.full(columns, -1)
        done = np.zeros(columns, dtype=bool)
        row, column, reached = start, -1, 0.0
        path_rows = [start]
        while True:
            reduced = cost[row] - row_price[row] - column_price + reached
            better = ~done & (reduced < best)
            best[better] = reduced[better]
            came_from[better] = column
            open_best = np.where(done, np.inf, best)
            column = int(np.argmin(open_best))
            reached = float(open_best[column])
            done[column] = True
            if owner[column] < 0:
                break
            row = int(owner[column])
            path_rows.append(row)
        row_price[start] += reached
        for closed in path_rows[1:]:
            at = int(np.flatnonzero(owner == closed)[0])
            row_price[closed] += reached - best[at]
            column_price[at] -= reached - best[at]
        while column >= 0:
            previous = int(came_from[column])
            owner[column] = start if previous < 0 else owner[previous]
            column = previous
    return sorted((int(row), column) for column, row in enumerate(owner) if row >= 0)
