"""The bus: the only importer of zenoh. See :class:`Bus`; settings in :class:`BusSettings`."""

from doro_schemas.bus.config import BusSettings
from doro_schemas.bus.router import run_router
from doro_schemas.bus.samples import RawSample, Request
from doro_schemas.bus.session import Bus

__all__ = ["Bus", "BusSettings", "RawSample", "Request", "run_router"]
