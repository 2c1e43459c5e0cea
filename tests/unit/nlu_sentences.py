"""Sentences written by hand, not from the templates of the generator, with their graphs."""

from doro_schemas.graph import ObjectGraph


def show(graph: ObjectGraph | None) -> str:
    """Return a graph in short form: ``cup{color=red}(is-on table)``; inverse: ``is-on^``."""
    if graph is None:
        return "-"
    values = ",".join(f"{kind}={value}" for kind, value in sorted(graph.attributes.items()))
    relations = "".join(
        f"({item.type}{'^' * item.inverse} {show(item.target)})" for item in graph.relations
    )
    return graph.name + (f"{{{values}}}" if values else "") + relations


MUST = [
    ("bring me the red cup", "cup{color=red}", "bring"),
    ("find the bed", "bed", "find"),
    ("bring the chair near the table", "chair(is-near table)", "bring"),
    ("take the plastic cup on the table", "cup{material=plastic}(is-on table)", "take"),
    ("can you bring me the red cup from the dining table",
     "cup{color=red}(is-at dining table)", "bring"),
    ("pick up a plastic cup", "cup{material=plastic}", "pick up"),
    ("bring a cup", "cup", "bring"),
    ("Pick up the white mug next to the coffee machine.",
     "mug{color=white}(is-near coffee machine)", "pick up"),
    ("Bring me the blue book on the wooden desk", "book{color=blue}(is-on desk{material=wood})",
     "bring"),
    ("find the flibber", "flibber", "find"),
]  # fmt: skip

OTHERS = [
    ("Could you fetch the remote control that is lying on the sofa?",
     "remote control(is-on sofa)", "fetch"),
    ("On the kitchen counter there is a green apple, bring it to me.",
     "apple{color=green}(is-on kitchen counter)", "bring"),
    ("I need the dark blue pillow from the bed", "pillow{color=dark blue}(is-at bed)", "need"),
    ("get the bottle from the fridge and put it on the dining table",
     "bottle(is-at refrigerator)", "get"),
    ("Go to the living room and bring me the newspaper", "newspaper", "bring"),
    ("pick the keys up from the side table", "keys(is-at side table)", "pick up"),
    ("Take the knife to the sink", "knife", "take"),
    ("put the vase in the cabinet", "vase", "put"),
    ("hand me that small ceramic bowl beside the toaster",
     "bowl{material=ceramic}(is-near toaster)", "hand"),
    ("please look for my black leather wallet in the bedroom",
     "wallet{color=black,material=leather}(is-at bedroom)", "look for"),
    ("grab the spoon between the plate and the fork", "spoon(is-near plate)(is-near fork)", "grab"),
    ("bring the cup which is red", "cup{color=red}", "bring"),
    ("the lamp", "lamp", ""),
    ("Where is the yellow umbrella?", "umbrella{color=yellow}", "where is"),
    ("Fetch the laptop on the desk near the window", "laptop(is-on desk(is-near window))", "fetch"),
    ("retrieve the spray bottle under the bathroom sink",
     "spray bottle(is-at bathroom sink)", "retrieve"),
    ("bring me the glass of water in front of the television",
     "glass of water(is-near television)", "bring"),
    ("bring me the zorbel from the grabbet", "zorbel(is-at grabbet)", "bring"),
    ("Robot, get me the metal pot on top of the stove please.",
     "pot{material=metal}(is-on stove)", "get"),
    ("fetch the teddy bear, not the pillow", "teddy bear", "fetch"),
    ("I am cold, bring me the grey wool blanket from the armchair",
     "blanket{color=gray,material=wool}(is-at arm chair)", "bring"),
    ("bring the red and white cup", "cup{color=red and white}", "bring"),
    ("can you find a chair made of wood", "chair{material=wood}", "find"),
    ("bring teh blakc chair", "chair{color=black}", "bring"),
]  # fmt: skip

CAPTIONS = [
    ("a red plastic cup on the table", "cup{color=red,material=plastic}(is-on table)"),
    ("a brown wooden chair near the white dining table, next to a box",
     "chair{color=brown,material=wood}(is-near dining table{color=white})(is-near box)"),
    ("cup", "cup"),
    ("a wine glass", "wine glass"),
    ("white refrigerator next to the sink", "refrigerator{color=white}(is-near sink)"),
    ("a black cat sleeping on a gray sofa", "cat{color=black}(is-on sofa{color=gray})"),
    ("a silver laptop sitting on a wooden desk beside a lamp",
     "laptop{color=silver}(is-on desk{material=wood}(is-near lamp))"),
    ("potted plant near a window", "house plant(is-near window)"),
    ("the book is blue", "book{color=blue}"),
    ("an orange", "orange"),
    ("a green garbage can in the kitchen", "garbage can{color=green}(is-at kitchen)"),
    ("a sports ball on the floor", "sports ball(is-on floor)"),
]  # fmt: skip

NOT_UNDERSTOOD = [
    "hello, how are you?",
    "bring mir bitte die rote Tasse",
    "apporte-moi la tasse rouge",
    "把红色的杯子给我",
    "!!! ???",
    "turn left and walk to the door",
    "put it on the table",
    "thank you very much",
]
