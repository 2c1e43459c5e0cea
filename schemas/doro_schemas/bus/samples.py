"""What arrives on the bus, decoded: samples, requests and their answers."""

from __future__ import annotations

import msgspec
import zenoh

from doro_schemas import codec
from doro_schemas.errors import Refused
from doro_schemas.messages.base import Message
from doro_schemas.topics import Topic


class RawSample(msgspec.Struct, frozen=True):
    """A sample as it came."""

    key: str
    payload: bytes
    encoding: str


class Request:
    """A query that waits for its answer."""

    def __init__(self, message: Message, query: zenoh.Query) -> None:
        self.message = message
        self._query = query

    def reply(self, message: Message) -> None:
        """Answer with a message."""
        with self._query as query:
            encoding = codec.encoding_of(type(message))
            query.reply(query.key_expr, codec.encode(message), encoding=encoding)

    def refuse(self, reason: str) -> None:
        """Answer with one sentence why not."""
        with self._query as query:
            query.reply_err(reason.encode(), encoding="text/plain")


def decode_sample(topic: Topic, payload: bytes, encoding: str) -> Message:
    """Read a sample of a topic; raises Refused where it does not fit."""
    if topic.plain_text and ";" not in encoding:
        return codec.decode_text(payload, topic.messages[0])
    return codec.decode(payload, encoding, topic.messages)


def decode_request(topic: Topic, query: zenoh.Query, payload: bytes) -> Message:
    """Read a request from the query's payload, or from its parameters (``...?name=cup``)."""
    if query.payload is not None:
        return decode_sample(topic, payload, str(query.encoding or ""))
    names = msgspec.structs.fields(topic.messages[0])
    fields = {item.name: query.parameters.get(item.name) for item in names}
    given = {name: value for name, value in fields.items() if value is not None}
    try:
        return msgspec.convert(given, topic.messages[0], strict=False)
    except msgspec.ValidationError as error:
        raise Refused(f"{codec.schema_name(topic.messages[0])}: {error}") from error
