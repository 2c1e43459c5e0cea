"""Asking before the exploration has ended: when a belief is stable and confident enough."""

from __future__ import annotations

import msgspec

from doro_dialogue.readings import Read
from doro_dialogue.settings import DialogueSettings
from doro_dialogue.talk import belief_of
from doro_dialogue.talks import WITHDRAWN, Talk
from doro_schemas.messages import Belief, Instances, Query

EARLY_STATES = ("CONFIRM", "INFORM-AMBIGUITY")
EARLY_REASONS = ("unique_match", "several_match", "readings")
"""A thing not found yet, or found only otherwise, may still come into view: never early."""

LOOKS_AGAIN = "Wait, I have to look again before I can ask that."


def take_note(talk: Talk, read: Read, reply: Instances, dialogue_id: str, episode: str) -> Belief:
    """Return the Belief, without a stamp, and count how long it has been the same."""
    decision = read.decision
    key = repr((decision.state, decision.reason, decision.matches, decision.instances))
    talk.stable = talk.stable + 1 if key == talk.belief else 1
    talk.belief = key
    belief = belief_of(read, reply, dialogue_id, episode)
    return msgspec.structs.replace(belief, stable_beliefs=talk.stable)


def is_settled(belief: Belief, settings: DialogueSettings) -> bool:
    """Tell whether a belief is stable and confident enough to act on before the end.

    Where nothing was found there is nothing to be confident of: that only withdraws.
    """
    return (
        0 < settings.early_beliefs <= belief.stable_beliefs
        and (belief.confidence >= settings.early_confidence or not belief.instances)
        and belief.unseen_share <= settings.early_unseen_share
    )


def withdrawal(talk: Talk, stamp_ns: int) -> Query:
    """Return the message that takes back a question raised early."""
    assert talk.query is not None
    query = msgspec.structs.replace(
        talk.query, reason=WITHDRAWN, text=LOOKS_AGAIN, clauses=[], seen_from=None, also=[]
    )
    return talk.follow(query, stamp_ns)
