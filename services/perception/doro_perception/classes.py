"""What the captioner can name: classes, colours, materials; and what it was taught as unknown.

The order is the order of the models' outputs: a change means training again.
"""

from __future__ import annotations

from doro_schemas.vocabulary import canonical_name, split_camel_case

CLASSES = (
    # the evaluation's 21
    "Cup", "Mug", "Bowl", "Plate", "Bottle", "Apple", "Vase", "Book", "CellPhone",
    "RemoteControl", "Statue", "Laptop", "Pillow", "Box", "DeskLamp", "HousePlant", "Stool",
    "Chair", "SideTable", "ArmChair", "Sofa",
    # landmarks and other things of the house
    "DiningTable", "CoffeeTable", "Desk", "Bed", "Dresser", "TVStand", "ShelvingUnit",
    "CounterTop", "Sink", "Toilet", "Bathtub", "Television", "Fridge", "Microwave", "Toaster",
    "CoffeeMachine", "Kettle", "Pan", "Pot", "WineBottle", "Bread", "Tomato", "Potato",
    "Lettuce", "Egg", "AlarmClock", "Watch", "FloorLamp", "GarbageCan", "TeddyBear",
    "BasketBall", "SoapBottle", "SprayBottle", "TissueBox", "Newspaper", "LaundryHamper",
    "Safe", "Painting", "Window", "Mirror", "Curtains",
)  # fmt: skip
"""AI2-THOR's objectTypes."""

UNNAMED = (
    "Candle", "SaltShaker", "PepperShaker", "Spatula", "Ladle", "Knife", "ButterKnife", "Fork",
    "Spoon", "KeyChain", "CreditCard", "CD", "Pen", "Pencil", "DishSponge", "ToiletPaper",
    "PaperTowelRoll", "Towel", "HandTowel", "Cloth", "Plunger", "ScrubBrush", "SoapBar",
    "TennisRacket", "BaseballBat", "Boots", "WateringCan", "Dumbbell", "Ottoman", "Footstool",
    "DogBed", "Desktop", "GarbageBag", "AluminumFoil", "RoomDecor", "TableTopDecor",
    "VacuumCleaner",
)  # fmt: skip
"""Taught as things that are there and have no name, "unknown object"."""

COLOURS = (
    "red", "blue", "green", "yellow", "white", "black", "orange", "purple", "brown", "pink",
    "gray",
)  # fmt: skip
MATERIALS = (
    "wood", "metal", "glass", "ceramic", "plastic", "fabric", "paper", "stone", "leather",
)  # fmt: skip


def class_names() -> tuple[str, ...]:
    """Return the canonical names of :data:`CLASSES`."""
    return tuple(canonical_name(split_camel_case(name)) for name in CLASSES)
