"""Sentences written and labelled by hand for choosing between taggers, by the annotation guide.

Written before any tagger had seen them; neither trained on nor part of the reported tests.
"""

from __future__ import annotations

from doro_nlu.train.annotate import Example, annotate

_TEXT = """
Walk over to the dresser, take the {O watch} that is lying {P on top of} the {C brown} {R box}.
Grab the {C light blue} {O water bottle} {A out of} the {R fridge} and shut the door.
turn right and pick the {O spatula} up {A off} the {R counter} {N beside} the {R stove}
Put the rinsed {O plate} in the cupboard over the sink.
Go to the bedroom, find the {O laptop} {P on} the {R bed} and carry it to the wooden desk.
Take the {O vase} {A from} the {C white} {R shelf} to place it on the table next to the lamp.
There is a {O basketball} {N near} the {R couch}, please bring it to me.
{P On} the {R nightstand} {N next to} the {R bed} you will find my {O glasses}, fetch them.
robot please bring the {M plastic} {O jar} that is {P on} the {R table} {A in} the {R kitchen}
can you check if there is a {O mug} {A in} the {R dishwasher}
Move the small {C black} {O clock} {A from} the {R desk} to the top shelf of the bookcase.
Pick up the {O apple} closest to you.
Pick up the {O apple} {N closest to} the {R toaster}.
Bring the {O tray} with the {R cup} {P on} it to the dining table.
get the {O basket} that the {R towels} are {A in}
Hold the {C red} {M leather} {O wallet} and turn on the lamp by the window.
look at the {O newspaper} under the light of the floor lamp
Slice the {O bread} on the left.
Cook the {O potato} and put it in the trash.
Take the {O knife} {N between} the {R fork} and the {R spoon} to the sink.
I would like the {C dark green} {O pillow} {A from} the {R armchair} {A in} the {R living room}
fetch the {O remote} {N to the left of} the {R television}
Find the {O pen} {N in front of} the {R computer} and drop it into the bin.
Look for a {O book} with a {C yellow} cover.
take the {C silver} {O kettle} with a {C black} handle {P on} the {R stove}
go straight, turn left at the sofa and stop at the door
open the {O drawer} {N to the left of} the {R oven}
Open the top drawer and take out the {O ladle}.
Place two {O candles} on the edge of the bathtub.
put both {O soap bars} in the garbage can next to the toilet
Take the {O roll of paper towels} {A under} the {R sink}.
i need some {O coffee}, it is {A in} the {R cabinet} {A above} the {R microwave}
grab my {O phone} {P on the right side of} the {R table}
Grab the {O phone} on your right and bring it over.
pick up the {C green} {O sponge} {N behind} the {R faucet}
bring me the {C red} {O cup}, not the blue one
bring the {O towel} hanging {P on} the {R rack} {A in} the {R bathroom}
take the {O keys} {A from under} the {R cushion}
take the {O box} {A in the corner of} the {R room}
Where did I leave my {O umbrella}?
is the {O cat} {P on} the {C gray} {R sofa}?
a {M wooden} {O bench} {N against} a {C white} {R wall}
{O person} sitting {P on} a {M metal} {R chair} {N near} a {R window}
a {C black} and {C white} {O cat}
two {C brown} {O chairs} {N near} a round {R table}
{C blue} {O curtain} {N next to} a {R radiator}, {N in front of} a {R desk}
the {O frisbee} {A inside} the {C green} {R crate} is what i want
Take the {O lettuce} {P on} the {R counter}, chill it in the refrigerator, and put it on the table.
Turn around and pick the {O tissue box} up {A from the back of} the {R toilet}.
Remove the {O disc} {A from} the {R safe}, which is {P on} the {R dresser}.
Bring {O plate} from here to the kitchen
give me that {O thing} {P on} the {R shelf}
retrieve what is {A under} the {R couch}
get the {M cardboard} {O box} that has a {R ball} {A in} it
Put the {O bowl} that's {P on} the {R chair} on the floor.
carry the {O suitcase} to the bed and open it
Find the {C orange colored} {O ball} {N close to} the {R tv stand}
bring the {O orange juice}
please take the {O glass of milk} {A from} the {R table} and give it to my daughter
could you go to the garage and look for the {O hammer} {N near} the {C red} {R toolbox}
Pull the second {O drawer} {P on the left side of} the {R desk}.
throw away the {O tomato slice} left {A in} the {R pan}
Step back, then walk to the end of the hallway on the first floor.
{A In} the {R study} {P on} the {R second floor} there is a {O guitar}; bring it down.
of the three mugs pick the {C white} one
Pick up the {O statue} {N to the immediate right of} the {R laptop} {P on} the {R desk}.
place the {O tennis racket} next to the blue chair in the hall
move the {O pot} {P on} the left {R burner} of the {R stove} to the fridge
put the {O wine bottle} inside the cabinet under the sink
i want you to put on the table the {O book} that is {A in} my {R bag}
"""


def own_examples() -> list[Example]:
    """Return the sentences."""
    return [annotate(line) for line in _TEXT.strip().splitlines()]
