"""Whether enough speaks for things: each by itself, or beside others of its class."""

from __future__ import annotations

from doro_mapper.existence import enough
from doro_mapper.sets import completes
from doro_mapper.settings import MapperSettings
from doro_mapper.tracks.items import Group, counted
from doro_mapper.tracks.singles import Singles
from doro_mapper.tracks.table import TrackTable
from doro_mapper.views import Views
from doro_mapper.votes import Votes


class Belief:
    """Judges the things of a map.

    Args:
        groups: all things by their main track; kept up to date by who owns it.
    """

    def __init__(
        self,
        settings: MapperSettings,
        views: Views,
        table: TrackTable,
        votes: dict[int, Votes],
        groups: dict[int, Group],
    ) -> None:
        self._settings, self._views = settings, views
        self._table, self._votes, self._groups = table, votes, groups
        self._singles = Singles()

    @property
    def singles_trusted(self) -> bool:
        """Whether what one view saw is believed."""
        return self._singles.trusted

    def judge_singles(self) -> None:
        """Judge anew what one view saw."""
        self._singles.judge(self._table, self._groups)

    def drop(self, row: int) -> None:
        """Remember a track that is about to go."""
        self._singles.drop(self._table, row)

    def enough(self, group: Group, found: tuple[int, int]) -> bool:
        """Tell whether a thing counts.

        Args:
            found: its hits and misses.
        """
        if self._alone(group, found):
            return True
        return self._alone(group, found, of_set=True) and self._completes(group)

    def _alone(self, group: Group, found: tuple[int, int], *, of_set: bool = False) -> bool:
        item, sure, views = group.item, self._singles.trusted, self._views.total
        doubt = sum(self._votes[row].doubt for row in item.rows)
        use, size_m = self._settings, item.longest_m
        return enough(found, views, use, doubt, singles=sure, longest_m=size_m, of_set=of_set)

    def _completes(self, group: Group) -> bool:
        name, item = self._name(group), group.item
        others = (
            (other.item.outer_low_m, other.item.outer_high_m)
            for other in self._groups.values()
            if other is not group
            and self._name(other) == name
            and self._alone(other, counted(other, self._table))
        )
        return completes((item.outer_low_m, item.outer_high_m), others, self._settings)

    def _name(self, group: Group) -> str:
        rows = group.item.rows
        # Of a single track the item may be older than its last votes.
        return self._votes[rows[0]].look()[0] if len(rows) == 1 else group.item.look[0]
