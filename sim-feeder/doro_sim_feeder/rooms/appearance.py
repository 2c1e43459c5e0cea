"""What objects look like: named colours, materials, and recolouring of meshes.

A named colour is what a person would call the rendered surface; every recoloured object
has the same colour in the picture and in the ground truth.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from doro_sim_feeder.rooms.parts import Part, Rgb, stable_number

PALETTE: dict[str, Rgb] = {
    "red": (0.76, 0.07, 0.06),
    "blue": (0.09, 0.20, 0.70),
    "green": (0.10, 0.48, 0.14),
    "yellow": (0.92, 0.78, 0.08),
    "white": (0.90, 0.90, 0.89),
    "black": (0.055, 0.055, 0.06),
    "orange": (0.94, 0.42, 0.04),
    "purple": (0.42, 0.12, 0.54),
    "brown": (0.35, 0.19, 0.09),
    "pink": (0.92, 0.47, 0.60),
    "gray": (0.43, 0.43, 0.44),
}
MAIN_PART_SHARE = 0.12
# Classes whose mesh or shape has its own colour, and what that colour is called.
NATURAL_COLOR = {
    "Apple": "red",
    "Tomato": "red",
    "Potato": "brown",
    "Egg": "white",
    "Lettuce": "green",
    "Bread": "brown",
    "HousePlant": "green",
    "BasketBall": "orange",
    "TeddyBear": "brown",
}
# Colours in which a class is sold; any of the palette where the class is not listed.
USUAL_COLORS = {
    "Fridge": ("white", "gray"),
    "Microwave": ("white", "black", "gray"),
    "Toaster": ("gray", "red", "white"),
    "CoffeeMachine": ("black", "red", "white"),
    "Television": ("black",),
    "Laptop": ("gray", "black", "white"),
    "CellPhone": ("black", "white"),
    "RemoteControl": ("black", "gray", "white"),
    "DiningTable": ("brown", "white", "black"),
    "CoffeeTable": ("brown", "white", "black"),
    "SideTable": ("brown", "white", "black"),
    "Desk": ("brown", "white", "black"),
    "Dresser": ("brown", "white"),
    "TVStand": ("brown", "white", "black"),
    "ShelvingUnit": ("brown", "white"),
    "Chair": ("brown", "white", "black", "blue", "red"),
    "Stool": ("brown", "white", "black", "red"),
    "Bed": ("white", "blue", "brown"),
    "Box": ("brown", "white"),
    "Pan": ("black", "gray", "red"),
    "Pot": ("gray", "black", "red"),
    "Knife": ("black",),
    "ButterKnife": ("gray",),
    "Fork": ("gray",),
    "Spoon": ("gray",),
    "Spatula": ("black", "red"),
    "Ladle": ("gray", "black"),
    "Faucet": ("gray",),
    "Sink": ("gray", "white"),
    "SinkBasin": ("gray", "white"),
    "StoveBurner": ("black",),
    "StoveKnob": ("black",),
    "LightSwitch": ("white",),
    "CounterTop": ("gray", "black", "white"),
    "Cabinet": ("white", "brown", "gray"),
    "Drawer": ("white", "brown", "gray"),
    "Shelf": ("brown", "white"),
    "Curtains": ("white", "gray", "blue", "brown"),
    "Blinds": ("white", "gray"),
    "GarbageCan": ("gray", "black", "blue", "green"),
    "PaperTowelRoll": ("white",),
    "TissueBox": ("white", "blue", "pink"),
    "CreditCard": ("blue", "red", "green"),
    "Plate": ("white", "blue", "green", "yellow"),
    "SaltShaker": ("white", "gray"),
    "PepperShaker": ("black", "brown"),
    "WineBottle": ("green", "black"),
    "Statue": ("white", "black", "brown", "gray"),
}
# One door front and one counter for the whole room.
ROOM_WIDE = ("Cabinet", "Drawer", "CounterTop", "Chair", "Stool", "Shelf", "StoveKnob")
NO_COLOR = frozenset(
    {"Floor", "Wall", "Ceiling", "Structure", "Window", "Mirror", "Painting", "Poster", "Newspaper"}
)

NO_MATERIAL = frozenset({"food", "organic", "sponge", "soap", "wax"})
USUAL_MATERIALS = {
    "metal": """Knife ButterKnife Fork Spoon Spatula Ladle Pan Pot Kettle Faucet Toaster Fridge
        Microwave CoffeeMachine StoveBurner StoveKnob GarbageCan Safe DeskLamp FloorLamp Sink
        SinkBasin KeyChain Watch Dumbbell""",
    "wood": """DiningTable CoffeeTable SideTable Desk Dresser TVStand ShelvingUnit Shelf Cabinet
        Drawer Chair Stool Bed BaseballBat Pencil""",
    "plastic": """Cup RemoteControl Laptop Television CellPhone AlarmClock LightSwitch SoapBottle
        SprayBottle CreditCard Pen CD BasketBall LaundryHamper WateringCan Blinds Desktop""",
    "ceramic": "Mug Plate Bowl Vase Statue HousePlant",
    "glass": "Bottle WineBottle Window Mirror SaltShaker PepperShaker",
    "fabric": "Sofa ArmChair Pillow Curtains TeddyBear Cloth Towel Ottoman DogBed Boots",
    "paper": "Book Newspaper Box TissueBox PaperTowelRoll Poster Painting",
    "stone": "CounterTop",
}
# What copies of a class are made of, in turn; other classes are of their usual material.
COPY_MATERIALS = {
    "Cup": ("plastic", "glass"),
    "Bottle": ("glass", "plastic"),
    "Bowl": ("ceramic", "plastic"),
    "Vase": ("ceramic", "glass"),
    "Plate": ("ceramic", "plastic"),
    "Mug": ("ceramic", "metal"),
    "Statue": ("ceramic", "metal", "stone"),
    "Box": ("paper", "plastic"),
    "DeskLamp": ("metal", "plastic"),
    "Chair": ("wood", "plastic", "metal"),
    "Stool": ("wood", "metal"),
    "SideTable": ("wood", "metal"),
    "ArmChair": ("fabric", "leather"),
    "Sofa": ("fabric", "leather"),
}


def usual_material(object_type: str) -> str | None:
    """Return the material that a class is usually made of, None where there is none."""
    for material, classes in USUAL_MATERIALS.items():
        if object_type in classes.split():
            return material
    return None


def material_of(object_type: str, salient: tuple[str, ...]) -> str | None:
    """Return one canonical material: AI2-THOR's first, else the class's usual one."""
    known = [value for value in salient if value not in NO_MATERIAL]
    if known:
        return known[0]
    return None if salient else usual_material(object_type)


def color_of(object_type: str, object_id: str, room: str) -> str | None:
    """Return the named colour of a room's own object, the same for the same names."""
    if object_type in NATURAL_COLOR:
        return NATURAL_COLOR[object_type]
    if object_type in NO_COLOR:
        return None
    names = USUAL_COLORS.get(object_type, tuple(PALETTE))
    kind = "Cabinet" if object_type == "Drawer" else object_type
    key = f"{room}|{kind}" if object_type in ROOM_WIDE else f"{room}|{object_id}"
    return names[stable_number(key) % len(names)]


def recoloured(parts: tuple[Part, ...], color: str) -> tuple[Part, ...]:
    """Return the parts with the large ones in a named colour; textures keep their pattern."""
    rgb = PALETTE[color]
    areas = [part.area_m2() for part in parts]
    threshold = MAIN_PART_SHARE * max(areas)
    return tuple(
        _recoloured(part, rgb) if area >= threshold else part
        for part, area in zip(parts, areas, strict=True)
    )


def _recoloured(part: Part, rgb: Rgb) -> Part:
    if part.texture is None:
        return replace(part, color=rgb)
    light = part.texture.mean(axis=-1, dtype=np.float32) / 255
    pattern = np.clip(light / max(float(light.mean()), 0.05), 0.55, 1.35)
    texture = np.clip(pattern[..., None] * np.asarray(rgb, np.float32) * 255, 0, 255)
    return replace(part, texture=texture.astype(np.uint8))
