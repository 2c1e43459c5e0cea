"""The label set: BIO over the paper's types (Section IV-A), values carrying their type."""

from __future__ import annotations

OBJECT = "object"
RELATED = "related"
RELATION_PREFIX = "is-"
TYPES: tuple[str, ...] = (OBJECT, RELATED, "color", "material", "is-near", "is-on", "is-at")
OUTSIDE = "O"
LABELS: tuple[str, ...] = (
    OUTSIDE,
    *(f"{prefix}-{kind}" for kind in TYPES for prefix in ("B", "I")),
)


def kind_of(label: str) -> str:
    """Return the type of a BIO label, ``""`` for O."""
    return "" if label == OUTSIDE else label[2:]


def may_follow(previous: str, label: str) -> bool:
    """Tell whether ``label`` may follow ``previous`` in BIO: I-x only after B-x or I-x."""
    return not label.startswith("I-") or kind_of(previous) == kind_of(label)


def is_relation(kind: str) -> bool:
    """Tell whether a type is a relational attribute (at_R)."""
    return kind.startswith(RELATION_PREFIX)


def is_noun(kind: str) -> bool:
    """Tell whether a type names a thing: the object or a landmark."""
    return kind in (OBJECT, RELATED)
