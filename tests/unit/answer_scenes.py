"""The scenes about which answers are given: what was asked, and what was offered."""

from __future__ import annotations


def thing(name="cup", color="", *, material="", on="", near="", inside=""):
    """Return a graph as JSON; a landmark may have a color ("black table")."""

    def landmark(words):
        *own, noun = words.split(" ")
        return {"name": noun, "attributes": {"color": own[0]} if own else {}, "relations": []}

    relations = [("is-on", on), ("is-at", inside), ("is-near", near)]
    attributes = {"color": color, "material": material}
    return {
        "name": name,
        "attributes": {key: value for key, value in attributes.items() if value},
        "relations": [{"type": k, "target": landmark(v)} for k, v in relations if v],
    }


SCENES = {
    # Two cups; neither was described.
    "two": (
        thing(),
        {"red": thing(color="red", on="table"), "blue": thing(color="blue", near="lamp")},
        "I found one red cup, and one blue cup; which one do you mean?",
    ),
    "three": (
        thing(),
        {
            "red": thing(color="red", on="table"),
            "blue": thing(color="blue", near="lamp"),
            "green": thing(color="green", on="shelf"),
            "bowl": thing("bowl", "white"),
        },
        "I found one red cup, one blue cup, and one green cup; which one do you mean?",
    ),
    "row": (
        thing(),
        {"red": thing(color="red"), "blue": thing(color="blue"), "green": thing(color="green")},
        "From left to right I see one green cup, one red cup, and one blue cup; which one?",
    ),
    "five": (
        thing(color="red"),
        {
            "table": thing(color="red", material="plastic", on="table"),
            "sink": thing(color="red", material="plastic", inside="sink"),
            "glass": thing(color="red", material="glass", on="table"),
            "shelf": thing(color="red", material="glass", on="shelf"),
            "lamp": thing(color="red", material="metal", near="black lamp"),
        },
        "",
    ),
    "twins": (
        thing(),
        {
            "a": thing(color="red", on="shelf"),
            "b": thing(color="red", on="shelf"),
            "blue": thing(color="blue"),
        },
        "",
    ),
    "only twins": (
        thing(),
        {"a": thing(color="red", on="shelf"), "b": thing(color="red", on="shelf")},
        "I found two identical red cups on top of the shelf; is either of them fine?",
    ),
    # Nobody saw the color of the second.
    "unknown": (
        thing(),
        {"red": thing(color="red", on="table"), "sink": thing(inside="sink")},
        "I found one cup on top of the table, and one cup in the sink; which one do you mean?",
    ),
    # "bring me the red cup": it is blue.
    "mismatch": (thing(color="red"), {"blue": thing(color="blue", on="table")}, ""),
    "confirm": (
        thing(color="red"),
        {"red": thing(color="red", on="table"), "blue": thing(color="blue", near="lamp")},
        "",
    ),
    "missing": (thing(color="red"), {"bowl": thing("bowl", "white")}, ""),
    # Two red ones were offered, and there is a blue one.
    "not offered": (
        thing(color="red"),
        {
            "table": thing(color="red", on="table"),
            "sink": thing(color="red", inside="sink"),
            "blue": thing(color="blue", on="shelf"),
        },
        "",
    ),
    "landmarks": (
        thing(),
        {"black": thing(color="red", on="white table"), "red": thing(color="black", on="desk")},
        "I found one red cup on top of the white table, and one black cup on top of the desk;"
        " which one do you mean?",
    ),
    "kinds": (
        thing("lamp"),
        {"desk": thing("desk lamp"), "floor": thing("floor lamp")},
        "I found one desk lamp, and one floor lamp; which one do you mean?",
    ),
    "shades": (
        thing(),
        {"blue": thing(color="blue"), "dark": thing(color="dark blue")},
        "I found one blue cup, and one dark blue cup; which one do you mean?",
    ),
}
