"""The counting metrics on cases worked out by hand."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from doro_evaluation.counting.chairs import figures_of as chair_figures
from doro_evaluation.counting.metrics import intervals, items, measure, pairs, relevant
from doro_evaluation.counting.reasons import causes, reasons_of
from doro_evaluation.counting.report import (
    failures_of,
    figures_of,
    grouped,
    plot_counts,
    plot_failures,
    tables_of,
)
from doro_evaluation.outcomes import Outcome, Thing
from doro_mapper.assignment import assign

SIZE = (0.1, 0.1, 0.1)


def thing(kind: str, x: float, views: int = 5, z: float = 0.0) -> Thing:
    return Thing(kind, (x, 0.8, z), SIZE, views)


def outcome(name: str, true: list[Thing], found: list[Thing], room: str = "FloorPlan1") -> Outcome:
    return Outcome(name, room, "default", "ours", "gt", 10, tuple(true), tuple(found))


A = outcome(
    "a",
    [thing("Cup", 0), thing("Cup", 1), thing("Mug", 2)],
    [thing("Cup", 0.1), thing("Cup", 1.4), thing("Mug", 2), thing("Mug", 4), thing("Bowl", 5)],
)
B = outcome("b", [thing("Cup", 0)], [thing("Cup", 0.3)], room="FloorPlan2")


def test_items_are_all_classes_that_are_true_or_found() -> None:
    assert [(one.object_type, one.true, one.found) for one in items(A)] == [
        ("Bowl", 0, 1),
        ("Cup", 2, 2),
        ("Mug", 1, 2),
    ]


def test_f1_with_the_count_as_class() -> None:
    figures = measure([A, B])
    # Found 1: bowl (a), cup (b); true 1: mug (a), cup (b); both: cup (b).
    assert figures["1/f1"] == pytest.approx(2 * 1 / (2 + 2))
    # Found 2: cup, mug; true 2: cup.
    assert figures["2/f1"] == pytest.approx(2 * 1 / (2 + 1))
    assert np.isnan(figures["3/f1"])
    assert figures["1/items"] == 2
    assert figures["2/items"] == 1
    assert figures["average/f1"] == pytest.approx((2 * 0.5 + 1 * 2 / 3) / 3)
    assert figures["accuracy"] == pytest.approx(2 / 3)
    assert figures["mae"] == pytest.approx((1 + 0 + 1 + 0) / 4)


def test_matched_f1_and_centre_errors() -> None:
    figures = measure([A, B])
    # Within 0.5 m: 2 cups, 1 mug, 1 cup; within 0.25 m: 1 cup, 1 mug.
    assert figures["matched_f1_0.5m"] == pytest.approx(2 * 4 / (4 + 6))
    assert figures["matched_f1_0.25m"] == pytest.approx(2 * 2 / (4 + 6))
    assert figures["center_error_others_median_m"] == pytest.approx((0.1 + 0.3) / 2)
    assert np.isnan(figures["center_error_furniture_median_m"])


def test_pairs_are_one_to_one_and_as_many_as_possible() -> None:
    true = [thing("Cup", 0.0), thing("Cup", 0.4)]
    found = [thing("Cup", 0.3), thing("Cup", 0.85)]
    # The nearest pair (0.4, 0.3) would leave the other two 0.85 m apart.
    paired = pairs(outcome("c", true, found), 0.5)
    assert sorted(round(one.distance_m, 3) for one in paired) == [0.3, 0.45]


def test_what_too_few_views_show_is_neither_right_nor_wrong() -> None:
    true = [thing("Cup", 0), thing("Cup", 2, views=1), thing("Mug", 5, views=1)]
    found = [thing("Cup", 0.1), thing("Cup", 2.1), thing("Cup", 4)]
    one = outcome("d", true, found)
    assert [(item.object_type, item.true, item.found) for item in items(one)] == [
        ("Cup", 2, 3),
        ("Mug", 1, 0),
    ]
    cared, kept = relevant(one, 2)
    assert [item.center_m[0] for item in cared] == [0]
    assert [item.center_m[0] for item in kept] == [0.1, 4]


def test_a_room_where_nothing_is_right_scores_nothing() -> None:
    figures = measure([outcome("e", [thing("Sofa", 0)], [])])
    assert figures["1/f1"] == figures["average/f1"] == figures["accuracy"] == 0
    assert figures["mae"] == 1
    assert figures["matched_f1_0.5m"] == 0


def test_many_copies_count_in_the_average_only() -> None:
    seven = [thing("Chair", k) for k in range(7)]
    figures = measure([outcome("f", seven, seven)])
    assert figures["average/f1"] == 1
    assert figures["average/items"] == 1
    assert all(np.isnan(figures[f"{k}/f1"]) for k in (1, 2, 3, 4, 5))


def test_intervals_hold_the_figure_and_widen_with_disagreement() -> None:
    right = [outcome(f"r{k}", [thing("Cup", 0)], [thing("Cup", 0)], f"R{k}") for k in range(10)]
    wrong = [outcome(f"w{k}", [thing("Cup", 0)], [], f"W{k}") for k in range(10)]
    assert intervals(right)["average/f1"] == (1.0, 1.0)
    low, high = intervals(right + wrong)["accuracy"]
    assert low < 0.5 < high
    assert 0.2 < high - low < 0.6
    assert intervals(right + wrong) == intervals(right + wrong)


def test_recordings_of_one_room_are_drawn_together() -> None:
    same = [outcome(f"s{k}", [thing("Cup", 0)], [thing("Cup", 0)] * (k % 2), "R") for k in range(8)]
    low, high = intervals(same)["accuracy"]
    assert low == high == 0.5


def test_figures_tables_failures_and_pictures(tmp_path: object) -> None:
    from pathlib import Path

    folder = Path(str(tmp_path))
    runs = grouped([B, A])
    figures = figures_of(runs)
    assert figures["counting/ours/gt/1/f1"] == 0.5
    assert figures["counting/ours/gt/1/items"] == 2
    assert figures["counting/ours/gt/recordings"] == 2
    assert "counting/ours/gt/3/f1" not in figures
    assert [(f.recording, f.object_type, f.true, f.found) for f in failures_of(runs)] == [
        ("a", "Bowl", 0, 1),
        ("a", "Mug", 1, 2),
    ]
    first, second = tables_of(runs)
    assert first.row_count == 2  # ours and the paper's
    assert second.row_count == 1
    plot_counts(folder / "f1.png", runs)
    assert plot_failures(folder / "wrong.png", runs) == 2
    for name in ("f1.png", "wrong.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")


def test_chairs_are_right_where_as_many_are_found() -> None:
    four = [thing("Chair", k) for k in range(4)]
    runs = grouped(
        [
            outcome("x", four, four, "FloorPlan1"),
            outcome("y", four, four[:3], "FloorPlan2"),
        ]
    )
    figures = chair_figures(runs)
    assert figures["chairs/ours/gt/right"] == 1
    assert figures["chairs/ours/gt/rooms"] == 2
    assert figures["chairs/ours/gt/right_share"] == 0.5
    bounds = [figures[f"chairs/ours/gt/right_share_{end}"] for end in ("low", "high")]
    assert bounds == [0.0, 1.0]


def test_the_assignment_that_the_metrics_use_is_the_best() -> None:
    rng = np.random.default_rng(3)
    for rows, columns in ((1, 1), (3, 3), (2, 5), (5, 2), (4, 4)):
        cost = rng.random((rows, columns))
        found = sum(cost[row, column] for row, column in assign(cost))
        short, long = min(rows, columns), max(rows, columns)
        square = cost if rows <= columns else cost.T
        best = min(
            sum(square[k, order[k]] for k in range(short))
            for order in itertools.permutations(range(long), short)
        )
        assert found == pytest.approx(best)


@pytest.mark.parametrize(
    ("true", "found", "cause"),
    [
        ([thing("Cup", 0, views=2)], [], "seen in one or two views only"),
        ([thing("Cup", 0), thing("Cup", 0.6)], [thing("Cup", 0.1)], "taken for the one beside it"),
        ([thing("Cup", 0)], [thing("Mug", 0.1)], "found under another name"),
        ([thing("Cup", 0)], [], "not found, though three views or more show it"),
        ([thing("Cup", 0)], [thing("Cup", 0), thing("Cup", 0.7)], "one thing counted twice"),
        ([thing("Mug", 2)], [thing("Mug", 2), thing("Cup", 2.1)], "another thing under its name"),
        ([], [thing("Cup", 0)], "nothing of the class is there"),
    ],
)
def test_a_wrong_count_has_a_cause(true: list[Thing], found: list[Thing], cause: str) -> None:
    assert reasons_of(outcome("c", true, found), "Cup") == [cause]


def test_causes_are_of_wrong_items_only() -> None:
    """A is wrong in bowls (1 too many) and mugs (1 too many); a cup of A lies 0.4 m off."""
    assert causes([A, B]) == {"nothing of the class is there": 2}
