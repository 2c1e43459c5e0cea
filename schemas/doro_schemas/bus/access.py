"""Zenoh configurations for several hosts: mutual TLS, and access control from the topic table.

Who may put what follows from the table's senders: a host has roles (``robot``, ``person``, or the
name of a service that runs there) and may put the topics of its roles alone. All hosts with a
certificate may read. What the rules do not allow, Zenoh drops silently.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from typing import Any

import msgspec

from doro_schemas.bus.config import BusSettings, client_config, router_config
from doro_schemas.errors import Refused
from doro_schemas.topics import EVERYTHING, TABLE, Topic

SERVICES = ("nlu", "perception", "mapper", "dialogue", "viewer")
ROLES = ("robot", "person", *SERVICES)
HOST_NAME = re.compile(r"[a-z0-9][a-z0-9.-]{0,62}")
_BOOKKEEPING = "/@adv/**"
"""Where advanced publishers keep caches, heartbeats and tokens, below their own key."""
_READ = ["declare_subscriber", "query", "liveliness_query", "declare_liveliness_subscriber"]
_SERVE = ["put", "reply", "declare_queryable", "liveliness_token"]


class Host(msgspec.Struct, frozen=True):
    """A machine with a certificate in its name, and what runs or sits there."""

    name: str
    roles: tuple[str, ...]


class Credentials(msgspec.Struct, frozen=True):
    """The certificate of the authority, and a host's own certificate and key, as PEM."""

    authority: bytes
    certificate: bytes
    key: bytes


def parse_host(text: str) -> Host:
    """Return the host of ``"edge-1=nlu,mapper"``.

    Raises:
        Refused: no such form, or an unknown role.
    """
    name, equals, roles = text.partition("=")
    chosen = tuple(role.strip() for role in roles.split(",") if role.strip())
    if not equals or not HOST_NAME.fullmatch(name) or not chosen:
        raise Refused(f"'{text}' is no host: write NAME=ROLE,ROLE, for example edge-1=nlu,mapper")
    for role in chosen:
        if role not in ROLES:
            raise Refused(f"host {name} has the unknown role '{role}': use any of {_list(ROLES)}")
    return Host(name, chosen)


def router_text(
    settings: BusSettings, own: Credentials, hosts: Sequence[Host], *, port: int
) -> dict[str, Any]:
    """Return the router's configuration: TLS on all interfaces, mutual, and the hosts' rules."""
    config = router_config(settings)
    config["listen"] = {"endpoints": [f"tls/0.0.0.0:{port}"]}
    config["scouting"] = {"multicast": {"enabled": False}, "gossip": {"enabled": False}}
    config["transport"]["link"] = {
        **config["transport"]["link"],
        "protocols": ["tls"],
        "tls": {
            "root_ca_certificate_base64": _text(own.authority),
            "listen_certificate_base64": _text(own.certificate),
            "listen_private_key_base64": _text(own.key),
            "enable_mtls": True,
            "close_link_on_expiration": True,
        },
    }
    config["access_control"] = access_control(hosts, settings.namespace)
    return config


def client_text(settings: BusSettings, own: Credentials) -> dict[str, Any]:
    """Return a host's configuration; ``settings.endpoint`` is the router's, ``tls/HOST:PORT``."""
    config = client_config(settings)
    config["transport"]["link"] = {
        **config["transport"]["link"],
        "protocols": ["tls"],
        "tls": {
            "root_ca_certificate_base64": _text(own.authority),
            "connect_certificate_base64": _text(own.certificate),
            "connect_private_key_base64": _text(own.key),
            "enable_mtls": True,
            "verify_name_on_connect": True,
        },
    }
    # Shared memory does not reach another host.
    config["transport"]["shared_memory"] = {"enabled": False}
    return config


def access_control(hosts: Sequence[Host], namespace: str = "") -> dict[str, Any]:
    """Return Zenoh's access control: all is denied but what the hosts' roles may do."""
    names = [host.name for host in hosts]
    everything = _prefixed([EVERYTHING, EVERYTHING + _BOOKKEEPING], namespace)
    rules = [
        _rule("read", "ingress", _READ, everything),
        _rule("deliver", "egress", [*_SERVE, "delete"], everything),
        _rule("interest", "egress", _READ, everything),
    ]
    policies = [{"rules": ["read", "deliver", "interest"], "subjects": names}]
    for host in hosts:
        keys = [key for topic in TABLE for key in _keys(topic, host)]
        below = [key + _BOOKKEEPING for key in keys]
        rule = _rule(f"serve-{host.name}", "ingress", _SERVE, _prefixed(keys + below, namespace))
        rules.append(rule)
        policies.append({"rules": [rule["id"]], "subjects": [host.name]})
    subjects = [{"id": name, "cert_common_names": [name]} for name in names]
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def _keys(topic: Topic, host: Host) -> list[str]:
    """Return the key expressions of a topic that a host may put, or answer for a queryable."""
    who = topic.receiver if topic.kind == "queryable" else topic.sender
    own = [role for role in host.roles if role in SERVICES]
    if "service" in who:
        if "{service}" not in topic.key:
            return [topic.pattern] if own else []
        return [topic.key_for(camera="*", service=role, replica="*") for role in own]
    senders = {"robot" if word == "feeder" else word for word in re.findall(r"[a-z]+", who)}
    return [topic.pattern] if senders & set(host.roles) else []


def _rule(name: str, flow: str, messages: list[str], keys: list[str]) -> dict[str, Any]:
    return {
        "id": name,
        "permission": "allow",
        "flows": [flow],
        "messages": messages,
        "key_exprs": keys,
    }


def _prefixed(keys: Sequence[str], namespace: str) -> list[str]:
    return [f"{namespace}/{key}" if namespace else key for key in keys]


def _text(pem: bytes) -> str:
    return base64.b64encode(pem).decode("ascii")


def _list(words: Sequence[str]) -> str:
    return ", ".join(words)
