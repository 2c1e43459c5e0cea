"""The methods of telling instances apart, by name."""

from __future__ import annotations

from doro_mapper.finder import InstanceFinder
from doro_mapper.literal import LiteralFinder
from doro_mapper.maps.hashmaps import HashMaps
from doro_mapper.regions import RegionFinder
from doro_mapper.settings import MapperSettings
from doro_mapper.tracks.association import TrackFinder
from doro_mapper.views import Views


def make_finder(settings: MapperSettings, views: Views, maps: HashMaps) -> InstanceFinder:
    """Return the finder that the settings name."""
    if settings.finder == "grid":
        return RegionFinder(settings, views, maps)
    if settings.finder == "paper_literal":
        return LiteralFinder(settings)
    return TrackFinder(settings, views)
