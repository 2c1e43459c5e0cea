"""Closed word classes that the parser needs; English."""

from __future__ import annotations


def _words(text: str) -> list[str]:
    return text.split()


BREAKERS = frozenset(
    _words(
        """
    that which who whose is are was were 's that's it's made has have with in of , . ; :
    ! ? ( ) but not
    """
    )
)
"""Words that end a noun phrase: a value before one does not belong to the noun after it."""

DETERMINERS = frozenset(
    _words(
        """
    the a an my your our his her their its this that these those some any another one
    two three
    """
    )
)
PRONOUNS = frozenset(["one", "ones"])
JOINTS = frozenset(["and", ",", "or", "&"])
COMPANIONS = frozenset(["with", "having", "has", "have", "containing"])
ROOMS = frozenset(
    _words(
        """
    kitchen office bedroom bathroom hallway hall corridor garage basement attic lounge
    library study balcony lobby restroom pantry den garden house apartment
    """
    )
)


def is_room(name: str) -> bool:
    """Tell whether a name is that of a room ("living room")."""
    return name in ROOMS or name.endswith(" room") or name == "room" or name.endswith("bedroom")


TASKS: tuple[str, ...] = (
    "pick up", "take out", "pull out", "go get", "look for", "search for", "look at",
    "point to", "point at", "show me", "turn on", "turn off", "switch on", "switch off",
    "put down", "lift up", "hand over", "bring over", "bring back", "reach for", "plug in",
    "throw away", "where is", "where are", "where 's", "acquire", "activate", "bring",
    "carry", "check", "chill", "choose", "clean", "close", "collect", "cook", "cut",
    "deliver", "detect", "drop", "dust", "empty", "examine", "fetch", "fill", "find", "fold",
    "gather", "get", "give", "grab", "hand", "hang", "heat", "hold", "identify", "insert",
    "inspect", "lay", "leave", "lift", "locate", "lock", "move", "obtain", "open", "pass",
    "pick", "pickup", "place", "point", "press", "pull", "push", "put", "reach", "recover",
    "remove", "retrieve", "return", "rinse", "search", "seek", "select", "send", "show",
    "shut", "slice", "spot", "stack", "start", "stop", "store", "take", "throw", "touch",
    "transfer", "unplug", "use", "want", "need", "wash", "water", "wipe",
)  # fmt: skip
"""Verb phrases of tasks, particles with them; longer ones first."""

PARTICLES = frozenset(["up", "out", "over", "down", "off", "on"])
SPLIT_VERBS = frozenset(["pick", "take", "turn", "switch", "put", "lift", "hand", "pull", "bring"])
