"""Frames for training only: captions, answers, and sentences without an object."""

from __future__ import annotations

CAPTIONS = tuple("""
<cap> that is <rel>
<cap> with <wpart>
<cap> with <wpart> <rel>
<cap> <inverse>
<cap> <inverse> <rel>
<cap> that has <wpart>
<cap> and {N next to} the {R <place>}
an image of <cap>
a photo of <cap> <rel>
a picture showing <cap> <rel>
there are <plurals> <rel>
<plurals> <rel>
<plurals>
a <adj> <col> {O <name>}
a <col> and <col> {O <name>}
a <col> , <mat> {O <name>} <rel>
a <mat> {O <name>} painted <col>
a {O <name>} , <col> , <rel>
a {O <name>} in <col>
the {O <name>} is <col> and <col>
the {O <name>} <rel> is <col>
the <samecol> {O <name>} <rel> near a <samecol> thing
<samecol> {O <name>} {P on} a <samecol> {R <place>}
a {O <name>} of <samecol> color {A in} a {R <room>}
a {O <name>} sitting <rel> and <rel>
a {O <name>} <doing> <rel> {A in} a {R <room>}
{O <name>} {A in} {R <room>}
{O <name>} {P on} {R <place>}
<cap> here
<cap> seen from above
one <col> {O <name>}
<cap> , <mat>
<capbare> , <col>
{O <name>} : <col>
{O <name>} - <mat>
object : {O <name>}
i see <cap>
that is <cap>
here is <cap> <rel>
looks like <cap>
""".strip().splitlines())  # fmt: skip

ANSWERS = tuple("""
the <col> <mat> one
<col> one
a <col> one
<mat> one
<col> please
<mat> , please
<col> , not <xcol>
the <col> one , not the <xcol> one
<no> i do not want the <xcol> one . i want the <col> one
the <xcol> one is wrong , take the <mat> one
<no> the one <rel> , please
the one that 's <rel>
the one <rel> , not the one <notrel>
the one made of <mat> <rel>
the {O <name>} , please
a {O <name>}
<no> <obj>
i said <ref>
i meant the <col> one <rel>
<no> it is the one <rel>
<rel> , please
it should be <rel>
it 's <col> and <mat>
they are <col>
probably <rel>
maybe <col>
the <nth> one , <rel>
the <nth> , <col> one
the <adj> one <rel>
not <xcol> but <col>
<xcol> ? no , <col>
<col> and <col>
i don't like the <xcol> one , give me the <col> one
forget the <xcol> one . the <mat> one is right
please not that <xcol> thing , i want the <col> one
not the one <notrel> , the one <rel>
not that , <ref>
<no> not that one but the <mat> one
no , not there , <rel>
<col> with <wpart>
""".strip().splitlines())  # fmt: skip

NOTHING = tuple("""
take him to <plain>
please guide <person> to <plain>
show us the way to <plain> and wait <dest>
walk with her to <plain>
<go> , <go> , <go>
<go> . <go> .
<go> until you reach <plain>
<go> while holding it
<it> , <go>
<go> and <it>
<go> . <it>
hold on to it and <go>
take a step back and <go>
look down at <plain>
face <plain>
stand in front of <plain>
stay <dest>
wait <dest>
keep going until you are <dest>
<person2> is <dest>
i am <state>
i am <dest>
my name is <person>
this room is <plain>
you are in <plain>
we are <dest> now
don't go to <plain>
do not touch it
follow me to <plain>
bring it here
bring me that
take them <todest>
move it <todest>
<put2> them <dest> and <side>
<put2> it back
turn <nturn> degrees to the left
<go> and wait for me <dest>
let 's go to <plain>
meet me <dest>
""".strip().splitlines())  # fmt: skip
