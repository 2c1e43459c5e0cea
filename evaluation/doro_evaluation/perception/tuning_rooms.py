"""Rooms on which the map's settings for a detector that errs are chosen; none is a test room.

Kitchens and living rooms, as in the test, and bedrooms. The networks were not trained on these
rooms. The calibration of the scores is fitted on frames of FloorPlan14 and 211 (dressed
otherwise), and mAP is measured on frames of the others of them, which no setting of the map
changes.
"""

from __future__ import annotations

from doro_sim_feeder.rooms.evaluation_set import SetRow

COPIES = 3
ROOMS = {
    14: ("Book", "", "Apple"),
    211: ("RemoteControl", "", "ArmChair"),
    4: ("Mug", "", "Bottle"),
    213: ("Box", "", "DeskLamp"),
    16: ("Cup", "", "Vase"),
    204: ("Chair", "", "Laptop"),
    23: ("Plate", "", "CellPhone"),
    224: ("Statue", "", "SideTable"),
    216: ("Pillow", "", "HousePlant"),
    301: ("Cup", ""),
    303: ("Bottle", ""),
    312: ("Bowl", ""),
}
"""By number: of which class there are copies, in one recording each; "" for none."""
KINDS = {0: "kitchen", 2: "living room", 3: "bedroom"}


def kind_of(room: str) -> str:
    """Return what kind of room it is, by its number."""
    return KINDS[int(room.removeprefix("FloorPlan")) // 100]


def rows() -> list[SetRow]:
    """Return the recordings: one of each room, then a second of each, then a third."""
    made = []
    for number, classes in ROOMS.items():
        for order, name in enumerate(classes):
            row = SetRow(
                name=f"tune-FloorPlan{number}" + (f"-{name}" if name else ""),
                part="tune",
                room=f"FloorPlan{number}",
                room_kind=kind_of(f"FloorPlan{number}"),
                seed=100 + order,
                object_type=name,
                copies=COPIES if name else 0,
            )
            made.append((order, row))
    return [row for _, row in sorted(made, key=lambda item: item[0])]
