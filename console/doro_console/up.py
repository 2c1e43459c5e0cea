"""``doro up``: the router and all services on this host, supervised."""

from __future__ import annotations

import signal

from doro_console.options import Common, talk
from doro_console.processes import NEEDED, Processes
from doro_schemas.bus import Bus
from doro_schemas.errors import Refused
from doro_sim_feeder.presence import Presence

READY_TIMEOUT_S = 60.0


def run_up(common: Common) -> int:
    """Run until SIGINT or SIGTERM; return supervisord's exit status.

    Raises:
        Refused: another router has the endpoint, or a service does not start.
    """
    settings = common.bus_settings(open_timeout_s=0.2)
    if _answers(common):
        raise Refused(
            f"a router is already running at {settings.endpoint}: stop it, or take another port"
            " with --set bus.endpoint=tcp/127.0.0.1:PORT"
        )
    arguments = ["--config", str(common.config)] if common.config else []
    for override in common.overrides:
        arguments += ["--set", override]
    with Processes(arguments) as processes:
        signal.signal(signal.SIGTERM, lambda *_: processes.terminate())
        try:
            with Bus("up", common.bus_settings(open_timeout_s=READY_TIMEOUT_S)) as bus:
                Presence(bus).wait_for(NEEDED, READY_TIMEOUT_S, processes.failed)
        except Refused as refused:
            raise Refused(f"{refused.reason}\n{processes.logs()}".strip()) from refused
        talk.print(f"doro: all services are up, router at {settings.endpoint}; stop with Ctrl-C")
        talk.print(f"      logs and supervisor socket: {processes.run_folder}")
        try:
            return processes.wait()
        except KeyboardInterrupt:
            return 0


def _answers(common: Common) -> bool:
    try:
        with Bus("up", common.bus_settings(open_timeout_s=0.2)):
            return True
    except Refused:
        return False
