"""The table ``[viewer]`` of the settings file."""

from __future__ import annotations

import msgspec

from doro_schemas.camera import World


class ViewerSettings(msgspec.Struct, frozen=True, kw_only=True):
    """What is shown, and where it goes. With the defaults nothing is kept or shown.

    Attributes:
        rrd: Rerun recording to write; empty for none. An older file
            of that name is kept as ``<name>.previous.rrd``.
        png: picture of the map to write at a query; empty for none. Of the further dialogues
            of an episode the second goes beside it as ``map-2.png``, and so on.
        serve: serve the web viewer for live watching, on the loopback interface only.
        spawn: open Rerun's window for live watching instead (needs a screen).
        grpc_port: loopback port on which the live viewer takes the data.
        web_port: loopback port of the web viewer's page.
        memory_limit: memory of the live viewer's buffer; beyond it the oldest data go.
        depth: show depth images as well.
        depth_stride: every n-th pixel of the depth image is kept.
        jpeg_quality: raw ``rgb8`` images are shown as JPEG of this quality, 1..100.
        flush_frames: the recording is written through after this many frames.
        png_width_px: width of the picture, at least 900; its height follows from the text.
        world: axes of instances until a depth frame's pose tells.
    """

    rrd: str = ""
    png: str = ""
    serve: bool = False
    spawn: bool = False
    grpc_port: int = 9876
    web_port: int = 9090
    memory_limit: str = "1GiB"
    depth: bool = False
    depth_stride: int = 4
    jpeg_quality: int = 85
    flush_frames: int = 10
    png_width_px: int = 1200
    world: World = "unity"
