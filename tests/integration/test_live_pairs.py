"""Pairs through router and services as processes: the same query as in process, word for word."""

from __future__ import annotations

from doro_console.live import compare_live
from doro_evaluation.context import Context
from tests.integration.chain import SAMPLE

ASKED = (
    "bring me the red cup",
    "pick up the white toaster",
    "find the vase",
    "take the blue cup on the counter top",
)


def test_the_services_say_what_the_cores_say() -> None:
    """Boxes are shifted, resized and left out, so that the map is not a trivial one."""
    asked = [(SAMPLE, text) for text in ASKED]
    found = list(compare_live(asked, "cs+sd+fn", Context()))
    assert [one.differences for one in found] == [()] * len(ASKED)
    assert len({one.live for one in found}) == len(ASKED)
    assert all(one.live == one.in_process for one in found)
