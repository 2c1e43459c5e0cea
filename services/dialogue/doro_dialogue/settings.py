"""Settings of the dialogue service: table ``[dialogue]`` of the settings file."""

from __future__ import annotations

import msgspec


class DialogueSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Defaults of the service.

    Attributes:
        seed: chooses the wording, together with the dialogue's id.
        belief_every_frames: while exploring, a belief is published every so many deltas.
        settle_asks: if the exploration said how many frames it has and the map lacks the
            last, the map is asked again this often before it is decided on what there is.
        max_turns: answers to one instruction before the dialogue gives up.
        target_on_confirm: a CONFIRM after the exploration gives the target at once, unless an
            instance that may be meant too was not fully observed; else only a "yes" does.
        timeout_s: a question that nobody answers for so long ends its dialogue, with a message;
            0: never.
        state_dir: folder of the state file, by which a restart loses nothing; empty: the
            user's own (``$XDG_STATE_HOME/doro`` or ``~/.local/state/doro``); ``off``: none.
        early_beliefs: beliefs in a row that must decide the same before a question is raised
            while the exploration still runs; 0: it waits for the end.
        early_confidence: for the same, the least existence of every instance, 0..1.
        early_unseen_share: for the same, the most of the area that may be unseen, 0..1.
        paper_literal: decide by the paper's formulas as printed.
    """

    seed: int = 0
    belief_every_frames: int = 25
    settle_asks: int = 20
    max_turns: int = 6
    target_on_confirm: bool = True
    timeout_s: float = 600.0
    state_dir: str = ""
    early_beliefs: int = 0
    early_confidence: float = 0.8
    early_unseen_share: float = 0.2
    paper_literal: bool = False

    def __post_init__(self) -> None:
        if self.belief_every_frames < 1:
            raise ValueError(f"belief_every_frames must be 1 or more: {self.belief_every_frames}")
        if self.max_turns < 1:
            raise ValueError(f"max_turns must be 1 or more, got {self.max_turns}")
        for name in ("settle_asks", "timeout_s", "early_beliefs"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} must be 0 or more, got {getattr(self, name)}")
        for name in ("early_confidence", "early_unseen_share"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} must be in 0..1, got {getattr(self, name)}")
