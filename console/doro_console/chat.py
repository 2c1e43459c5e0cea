"""``doro chat``: a conversation at the terminal with the running services."""

from __future__ import annotations

import time
from typing import IO

import click

from doro_console.conversation import Conversation
from doro_console.options import talk
from doro_console.report import describe_graph, describe_target
from doro_schemas.bus import Bus
from doro_schemas.errors import Refused
from doro_schemas.messages import Query

ENDED = ("cancelled", "turn_limit", "timed_out", "search_again")
ANSWER_TIMEOUT_S = 10.0
CONFIRM_TARGET_S = 1.0


def run_chat(bus: Bus, source: IO[str], wait_s: float) -> None:
    """Take lines: an instruction, then answers until its dialogue has ended, and again.

    A refusal is told and the conversation goes on. Queries and targets go to stdout, talk
    to stderr.
    """
    conversation = Conversation(bus)
    open_query: Query | None = None
    talk.print("say what is wanted; end with Ctrl-D", markup=False)
    for line in source:
        text = line.strip()
        if not text:
            continue
        if open_query is not None:
            bus.run_until(time.monotonic())
            open_query = _latest(conversation, open_query)
        try:
            if open_query is None:
                open_query = _instruct(conversation, text, wait_s)
            else:
                open_query = _answer(conversation, text, open_query)
        except Refused as refused:
            talk.print(refused.reason, markup=False)
            if "is finished" in refused.reason or "there is no dialogue" in refused.reason:
                open_query = None


def _latest(conversation: Conversation, query: Query) -> Query | None:
    """Tell what became of a question meanwhile: revised by the map, or ended by silence."""
    latest = next(
        one for one in [*conversation.queries[::-1], query] if one.dialogue_id == query.dialogue_id
    )
    if latest.revision > query.revision:
        click.echo(f'robot:  "{latest.text}"')
    return None if latest.ended else latest


def _instruct(conversation: Conversation, text: str, wait_s: float) -> Query | None:
    asked = len(conversation.queries)
    parsed = conversation.say(text)
    talk.print(f"heard:  {describe_graph(parsed)}", markup=False)
    if parsed.graph is None:
        return None
    query = conversation.wait_for_query(asked + 1, wait_s)
    if query is None:
        talk.print("robot:  still looking around; the question comes when it has finished.")
        return None
    click.echo(f'robot:  "{query.text}"')
    if query.state == "CONFIRM" and not query.also:
        for target in conversation.targets_of(query, CONFIRM_TARGET_S):
            click.echo(describe_target(target))
    return query


def _answer(conversation: Conversation, text: str, query: Query) -> Query | None:
    reply, targets = conversation.answer(text, query, ANSWER_TIMEOUT_S)
    click.echo(f'robot:  "{reply.text}"')
    for target in targets:
        click.echo(describe_target(target))
    return None if targets or reply.reason in ENDED else reply
