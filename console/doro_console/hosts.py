"""``doro hosts``: one configuration file per host, with certificates and access rules."""

from __future__ import annotations

import datetime
import json
import os
from pathlib import Path
from typing import Any

import click

from doro_console.options import says_refusals, talk
from doro_schemas.bus.access import Credentials, Host, client_text, parse_host, router_text
from doro_schemas.bus.config import BusSettings
from doro_schemas.errors import Refused

AUTHORITY, AUTHORITY_KEY = "authority.pem", "authority.key"
ROUTER = "router.json5"


@click.command("hosts")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), required=True)
@click.option("--router", required=True, help="Name or address of the router's host.")
@click.option("--host", "texts", multiple=True, required=True, metavar="NAME=ROLE,ROLE",
              help="A host and its roles: robot, person, or services; repeatable.")  # fmt: skip
@click.option("--port", default=7447, show_default=True)
@click.option("--namespace", default="", help="Prefix of all keys, one per robot.")
@says_refusals
def hosts(out: Path, router: str, texts: tuple[str, ...], port: int, namespace: str) -> None:
    """Make TLS and access control for several hosts.

    Writes router.json5 and one NAME.json5 per host, each with its certificate and key inside:
    copy each to its host, and keep authority.key offline. A second call with the same folder
    keeps the authority, so that hosts can be added.
    """
    made = make_hosts(out, router, [parse_host(text) for text in texts], port, namespace)
    click.echo("\n".join(made))


def make_hosts(out: Path, router: str, hosts: list[Host], port: int, namespace: str) -> list[str]:
    """Write the files; return what to run where, a line each.

    Raises:
        Refused: two hosts of one name, or the authority there cannot be read.
    """
    from doro_console.certificates import issue

    names = [host.name for host in hosts]
    if len(set(names)) < len(names) or "router" in names:
        raise Refused(
            f"each host needs a name of its own, and none is 'router': {', '.join(names)}"
        )
    out.mkdir(parents=True, exist_ok=True, mode=0o700)
    now = datetime.datetime.now(datetime.UTC)
    authority = _authority(out, now)
    root = authority.certificate_pem()
    settings = BusSettings(endpoint=f"tls/{router}:{port}", namespace=namespace)
    own = issue(authority, "router", [router, "localhost", "127.0.0.1"], now)
    at_router = Credentials(root, own.certificate_pem(), own.key_pem())
    _write(out / ROUTER, router_text(settings, at_router, hosts, port=port))
    lines = [f"{router}: doro-router --set bus.router_config={ROUTER}"]
    for host in hosts:
        issued = issue(authority, host.name, [], now)
        mine = Credentials(root, issued.certificate_pem(), issued.key_pem())
        _write(out / f"{host.name}.json5", client_text(settings, mine))
        lines += [
            f"{host.name}: {command} --set bus.config={host.name}.json5"
            for command in _commands(host)
        ]
    return lines


def _authority(out: Path, now: datetime.datetime) -> Any:
    from doro_console.certificates import load, make_authority

    certificate, key = out / AUTHORITY, out / AUTHORITY_KEY
    if certificate.exists() or key.exists():
        try:
            kept = load(certificate.read_bytes(), key.read_bytes())
        except (OSError, ValueError, TypeError) as error:
            raise Refused(
                f"the authority in {out} cannot be read ({error}): bring {AUTHORITY} and"
                f" {AUTHORITY_KEY} back, or choose another folder"
            ) from error
        talk.print(f"the authority in {out} is kept", markup=False)
        return kept
    made = make_authority(now)
    certificate.write_bytes(made.certificate_pem())
    _write_private(key, made.key_pem())
    return made


def _commands(host: Host) -> list[str]:
    services = [role for role in host.roles if role not in ("robot", "person")]
    commands = [f"doro-{service}" for service in services]
    commands += ["doro play FILE"] if "robot" in host.roles else []
    commands += ["doro chat"] if "person" in host.roles else []
    return commands


def _write(path: Path, config: dict[str, Any]) -> None:
    text = "// Holds a private key: for this host only.\n" + json.dumps(config, indent=2) + "\n"
    _write_private(path, text.encode())


def _write_private(path: Path, data: bytes) -> None:
    """Write a file that only its owner can read, from its first byte on."""
    path.unlink(missing_ok=True)
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as stream:
        stream.write(data)
