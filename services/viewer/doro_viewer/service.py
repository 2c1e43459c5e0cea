"""The shell of the viewer: what it listens to and where its work goes."""

from __future__ import annotations

from doro_schemas import messages as m
from doro_schemas.effects import Unanswered
from doro_schemas.errors import Refused
from doro_schemas.runner import Shell, run_service
from doro_viewer.core import Viewer
from doro_viewer.outputs import NoAlbum, NoScreen, PngAlbum, RerunScreen
from doro_viewer.settings import ViewerSettings

SHOWN = (
    m.ColorFrame,
    m.FrameCaptions,
    m.FrameGraphs,
    m.InstructionGraph,
    m.Belief,
    m.Exploration,
    m.Answer,
    m.Target,
    m.Rejected,
)


def check_settings(settings: ViewerSettings) -> None:
    """Raise Refused where settings contradict each other or are out of range."""
    if settings.serve and settings.spawn:
        raise Refused("viewer.serve and viewer.spawn are both set: choose page or window")
    limits = {
        "depth_stride": (1, 64),
        "flush_frames": (1, 1_000_000),
        "jpeg_quality": (1, 100),
        "png_width_px": (900, 8192),
    }
    for name, (low, high) in limits.items():
        value = getattr(settings, name)
        if not low <= value <= high:
            raise Refused(f"viewer.{name} must be in {low}..{high}, got {value}")


def wire(shell: Shell, settings: ViewerSettings) -> None:
    """Connect the core to the bus."""
    check_settings(settings)
    wanted = settings.rrd or settings.serve or settings.spawn
    album = PngAlbum(settings.png) if settings.png else NoAlbum()
    screen = RerunScreen(settings) if wanted else NoScreen()
    core = Viewer(settings, screen, album)
    for kind in SHOWN:
        shell.on(kind, core.show)
    shell.on(m.DepthFrame, core.depth)
    shell.on(m.GridDelta, core.delta)
    shell.on(m.Query, core.query)
    shell.on_reply(m.GridSnapshot, core.grid)
    shell.on_reply(m.Instances, core.instances)
    shell.on_reply(Unanswered, core.unanswered)
    shell.counters(lambda: core.counters)
    shell.on_stop(screen.close)


def main() -> None:
    """Run the service ``viewer``."""
    run_service("viewer", ViewerSettings, wire)
