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
        paper_literal: decide by the paper's formulas as printed.
    """

    seed: int = 0
    belief_every_frames: int = 25
    settle_asks: int = 20
    max_turns: int = 6
    paper_literal: bool = False

    def __post_init__(self) -> None:
        if self.belief_every_frames < 1:
            raise ValueError(f"belief_every_frames must be 1 or more: {self.belief_every_frames}")
        if self.max_turns < 1:
            raise ValueError(f"max_turns must be 1 or more, got {self.max_turns}")
        if self.settle_asks < 0:
            raise ValueError(f"settle_asks must be 0 or more, got {self.settle_asks}")
