"""``doro play --order planned``: the feeder follows the mapper's goals over the bus."""

from __future__ import annotations

from doro_schemas.messages import ExplorationGoal
from doro_schemas.messages.base import Message
from doro_schemas.topics import TOPICS
from doro_sim_feeder.play import PlaySettings
from tests.integration.chain import Chain


def test_planned_play_follows_goals_and_stops_where_told() -> None:
    goals: list[ExplorationGoal] = []

    def heard(message: Message) -> None:
        assert isinstance(message, ExplorationGoal)
        goals.append(message)

    settings = PlaySettings(order="planned", views="25%")
    with Chain() as chain:
        chain.bus.subscribe(TOPICS["goal"], heard, late=False)
        first = chain.play(settings=settings)
        digest = chain.digest()
        assert chain.wait(lambda: len(goals) == 18, 10.0)
        order = [goal.frame for goal in goals]
        goals.clear()
        second = chain.play(settings=settings)
        assert chain.digest() == digest
        assert chain.wait(lambda: len(goals) == 18, 10.0)
    assert (first.frames, first.merged, first.lost) == (18, 18, 0)
    assert len(order) == second.goals == 18
    assert [goal.frame for goal in goals] == order  # the same goals, so the same views
    assert order != sorted(order)
    assert all(goal.pose is not None and not goal.done for goal in goals)
