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
THIRD = frozenset(["it", "them", "itself", "themselves"])
JOINTS = frozenset(["and", ",", "or", "&", "plus"])
COMPANIONS = frozenset(
    _words("with having has have containing contains contain holding holds carrying full w")
)
"""Words that bring in what a thing holds or carries: "the bowl with an apple"."""

RELATIVES = frozenset(["that", "which", "where", "whom"])
COPULAS = frozenset(
    _words(
        """
    is are was were 's sits sit sitting stands stand standing lies lie lying rests resting
    hangs hanging stays placed put kept stored located
    """
    )
)
STRANDED = {
    "on": "is-on", "upon": "is-on", "in": "is-at", "inside": "is-at", "at": "is-at",
    "under": "is-at", "near": "is-near", "beside": "is-near", "by": "is-near",
    "behind": "is-near", "above": "is-at", "below": "is-at", "opposite": "is-near",
}  # fmt: skip
"""Prepositions of one word and what they say, for where the tagger has left one out, as at the end
of "the table that the lamp is on"."""

FILLED = frozenset(["full", "filled"])
NAME_EDGES = frozenset(_words("of the a an my your and or with to for called named"))
"""Words that begin or end no name: a label that runs over by one is cut back."""

NEGATORS = frozenset(
    _words(
        """
    not isn't aren't wasn't don't dont doesn't didn't without except never neither nor
    isnt arent cannot
    """
    )
)
SURFACES = frozenset(
    _words("table counter countertop desk floor shelf stove bed dresser stand mat top island")
)
"""Last words of names that carry things and hold nothing: an apple "in it" is elsewhere."""


def is_surface(name: str) -> bool:
    """Tell whether nothing can be in a thing of this name, only on it."""
    return name.rsplit(" ", maxsplit=1)[-1] in SURFACES


TOOL_VERBS = frozenset(
    _words("cut slice chop clean wipe open heat cook fill stir wash dust scrub dry cover close")
)
"""Tasks that are done with a tool: "cut the bread with the knife" is no bread that has one."""

FETCH_VERBS = frozenset(
    _words("bring fetch get grab give hand pass pick pickup retrieve take collect deliver acquire")
)
"""First words of the tasks that bring a thing: two of them name two targets."""

NOT_TARGETS = frozenset(
    _words(
        "left right step steps turn look seat break moment rest second minute time few"
        " pass care note bite sip photo picture hold"
    )
)
"""What follows "take" in "take a left", "take two steps": nothing to fetch."""

MODALS = frozenset(_words("can could will would"))
NO_THINGS = frozenset(
    _words(
        "straight ahead forward forwards backward backwards left right here there now today"
        " tomorrow tonight please thanks hello hi okay yes no"
    )
)
"""Words that are never the target, whatever a tagger says."""

MOVES = frozenset(
    _words("go walk move head drive come navigate run proceed travel step return turn roll cross")
)
"""Verbs that move the robot."""

WAYS = frozenset(_words("over back straight down up ahead forward along out around left right"))
TOWARDS = frozenset(_words("to towards toward into through across in inside"))
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
    "pick up", "take out", "pull out", "go get", "look for", "search for", "look at", "point to",
    "point at", "show me", "turn on", "turn off", "switch on", "switch off", "put down",
    "lift up", "hand over", "bring over", "bring back", "reach for", "plug in", "throw away",
    "get rid of", "where is", "where are", "where 's", "acquire", "activate", "arrange", "attach",
    "bring", "carry", "check", "chill", "choose", "clean", "close", "collect", "cook", "cut",
    "deliver", "detect", "drop", "dust", "empty", "examine", "fetch", "fill", "find", "fold",
    "follow", "gather", "get", "give", "grab", "grasp", "hand", "hang", "heat", "hold",
    "identify", "insert", "inspect", "lay", "leave", "lift", "locate", "lock", "move", "need",
    "obtain", "open", "pass", "pick", "pickup", "place", "point", "press", "pull", "push", "put",
    "reach", "read", "recover", "release", "remove", "restart", "retrieve", "return", "rinse",
    "search", "seek", "select", "send", "set", "show", "shut", "slice", "spot", "stack", "stand",
    "start", "stop", "store", "take", "throw", "touch", "transfer", "unplug", "use", "want",
    "wash", "water", "wipe",
)  # fmt: skip
"""Verb phrases of tasks, particles with them; longer ones first."""

PARTICLES = frozenset(["up", "out", "over", "down", "off", "on"])
SPLIT_VERBS = frozenset(["pick", "take", "turn", "switch", "put", "lift", "hand", "pull", "bring"])
