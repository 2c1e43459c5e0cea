"""The words by which answers are told apart; English."""

from __future__ import annotations

import re

from doro_dialogue.facts import words

COLORS = words(
    "red green blue yellow orange purple pink brown black white gray grey silver gold golden beige"
    " tan cream ivory navy maroon violet turquoise teal cyan magenta crimson scarlet burgundy"
    " charcoal khaki olive dark light bright pale transparent clear"
)
SHADES = words("dark light bright pale deep")
MATERIALS = words(
    "plastic metal metallic wood wooden glass ceramic paper cardboard leather fabric cloth stone"
    " marble steel iron aluminum aluminium brass copper bronze porcelain rubber wicker wool woolen"
    " cotton linen velvet silicone clay concrete granite oak pine walnut foam straw bamboo"
)
PROPERTIES = words(
    "big small large tall short tiny huge little old new clean dirty full empty open closed broken"
    " round square heavy thin thick long wide cheap expensive usual striped shiny dotted nice other"
)
DESCRIBING = COLORS | MATERIALS | PROPERTIES | words("and very really")

FILLER = re.compile(
    r"\b(?:please|plz|pls|i think|i guess|i believe|i suppose|uh+|um+|er+m?|hmm+|well"
    r"|(?<!no )(?<!no, )thanks(?: a lot)?"
    r"|thank you|i would like|i'd like|maybe|probably|perhaps|just|robot|hey)\b"
    r"|\b(?:that |which )?you (?:just )?(?:said|mentioned|named|listed|described)\b"
)
CANCEL = re.compile(
    r"^(?:no,? |oh,? |ok,? |okay,? |actually,? |sorry,? |wait,? )*"
    r"(?:never ?mind|forget(?: about)?(?: it| that)?"
    r"|(?:please )?(?:stop|halt|abort|cancel)(?: it| that)?"
    r"|leave it(?: alone| be)?|drop it|do not bother|don't bother|no thanks|nothing"
    r"|not any ?more|i changed my mind|i have changed my mind|i've changed my mind"
    r"|it does not matter any ?more|it doesn't matter any ?more"
    r"|i do not (?:want|need) (?:it|any of them|anything)(?: any ?more)?"
    r"|i don't (?:want|need) (?:it|any of them|anything)(?: any ?more)?)(?=$|[ ,])"
)
REPEAT = re.compile(
    r"^(?:what|huh|pardon(?: me)?|sorry|excuse me|come again|again|repeat(?: that| it)?"
    r"|(?:can|could) you (?:repeat|say) (?:that|it)(?: again)?|say (?:that|it) again"
    r"|what did you say|i did not (?:hear|get) (?:that|you)|i didn't (?:hear|get) (?:that|you))$"
)
THANKS = re.compile(r"\b(?:thanks|thank you)\b")
ANY_OF_THE = re.compile(r"\b(?:any|either)(?: one)? of the\b(?= .*\bones?\b)")
UNSURE = re.compile(
    r"\b(?:not sure|do not know|don't know|no idea|can't tell|cannot tell|what do you mean"
    r"|not certain|dunno|what\b.*\bare there|which ones are)\b|^(?:what|why|how|who)\b"
)
_PLACE_WORD = r"(?:in|inside|on|under|behind|near|at|next to|by|around|upstairs|downstairs|outside)"
SEARCH = re.compile(
    rf"\b(?:look|search|looking|searching) (?:for (?:it|them) )?(?:again|around|elsewhere"
    rf"|somewhere else|further|more|{_PLACE_WORD}\b)"
    r"|\bkeep (?:looking|searching)\b"
    r"|^(?:no, |then |so |and |go |can you |could you |would you )*"
    r"(?:go to|try|check|search|have you (?:looked|checked|tried)"
    r"|did you (?:look|check|try)|what about in)"
    r" (?:in |on |under |at )?(?:the|my|our|another|a|under|in|inside|behind|upstairs|downstairs)\b"
    r"(?!.*\bones?\b)"
)
NO_PLACE = re.compile(r"\b(?:again|around|elsewhere|somewhere|further|more|keep)\b")
PLACE_PHRASE = re.compile(
    r"\b(?:in|inside|on|under|behind|near|at|next to|by|around) (?:the|my|our|a) .*"
)
NONE = re.compile(
    r"^(?:no, )?(?:none(?: of (?:them|these|those|the \w+))?|neither(?: of (?:them|these|those|the"
    r" \w+))?|neither one|not any of (?:them|these|those)|not (?:those|these|them)"
    r"|no,? none of (?:them|those|these)|neither is (?:right|it|correct))$"
)
LEADING_NO = re.compile(
    r"(?:no way|no(?: no)?|nope|nah|not really|(?:(?:that is|that's) )?(?:the )?wrong one|wrong"
    r"|that's not it|that is not it|not that(?: one)?|not it"
    r"|do not(?: take it)?|don't(?: take it)?|i don't|i do not|it isn't|it is not"
    r"|that's wrong|that is wrong|sorry)(?=$|,|(?<=no) (?=the\b|i\b|it\b|take\b|bring\b|that\b))"
)
LEADING_YES = re.compile(
    r"(?:yes(?:,? i do)?|yeah|yep|yup|sure|ok|okay|right|correct|exactly|of course|do(?: so| it)?"
    r"|go ahead|(?:take|bring|get|grab) (?:it|that|that one|this one)(?: to me)?|that one|this one"
    r"|that's (?:it|right|the one|fine|good|ok|okay)|that is (?:it|right|the one|fine|good)|it is"
    r"|that's what i mean|that is what i mean|i do|bring me that one"
    r"|that will do|that'll do|fine(?: by me| with me)?|good|perfect|great|cool|alright|all right"
    r"|sounds good|that works|works for me|(?:sure )?why not|yes it is)"
    r"(?=$|,|(?<=yes) )"
)
ANY = re.compile(
    r"^either(?: one| of (?:them|these|those|the two))?(?: (?:is|are|will be|would be|works|would)"
    r"\b.*)?$"
    r"|\b(?:any(?: one)?(?: of (?:them|these|those))?|anyone"
    r"|(?:whichever|whatever)(?: one)?(?: you (?:like|want|prefer))?"
    r"|does not matter(?: which(?: one)?)?|doesn't matter(?: which(?: one)?)?"
    r"|i do not (?:mind|care)(?: which(?: one)?)?|i don't (?:mind|care)(?: which(?: one)?)?"
    r"|(?:it's |it is )?(?:up to you|your choice)|you (?:choose|pick|decide)|no preference"
    r"|it is all the same(?: to me)?)\b(?! (?:other|but|except))"
)
ALL = re.compile(
    r"\b(?:both(?: of (?:them|these|those|the))?|all(?: (?:of|the))*(?: (?:two|three|four|five))?"
    r"(?: of)?(?: (?:them|these|those))?|every(?: one|thing)?(?: of (?:them|these|those))?"
    r"|everything|each(?: one)?(?: of them)?|them all|the (?:two|three|four|five) of them)\b"
)
ALL_BUT = re.compile(r"\b(?:all|every one|everything)(?: of them)? (?:but|except(?: for)?)\b")
EMPTY = re.compile(
    r"\b(?:the|of|it|them|these|those|ones?|is|are|fine|ok|okay|will|do|take|bring|get|me|to|for"
    r"|i|want|you|can|would)\b"
)
IT_IS = re.compile(
    r"\b(?:it (?:should|must|might|could|may) be|it is|it's|it was"
    r"|that is|that's|they are|this is)\b"
)
NO_CONTENT = re.compile(r"\b(?:the|a|an|this|that|take|want|bring|me|get|i|is|in|on|of)\b")
CORRECTION = re.compile(
    r"\b(?:i (?:actually )?(?:meant|mean)|i was (?:talking about|thinking of)|actually|rather"
    r"|instead(?! of)|sorry|correction|i said)\b"
)
NEGATION = re.compile(
    r"\b(?:anything|all|any|every one) (?:but|except)\b|\bbut not\b|\bother than\b"
    r"|\bdo not (?:want|take|mean|need)\b|\bdon't (?:want|take|mean|need)\b"
    r"|\b(?:is|are|was)n't\b|\b(?:is|are) not\b|\bexcept(?: for)?\b|\binstead of\b|\brather than\b"
    r"|\bwithout\b|\bnever\b|\bnot\b|\bneither\b|\bnor\b"
)
OTHER = re.compile(r"\b(?:other|remaining)(?: (?:ones?|two))?\b|\banother(?: one)?\b|\bthe rest\b")
_NUMBER = "one|two|three|four|five|six|seven|eight|nine|ten|10|[1-9]"
_NTH = "first|second|third|fourth|fifth|sixth|seventh|eighth|ninth|tenth|1st|2nd|3rd|[4-9]th|10th"
ORDINAL = re.compile(
    rf"\b({_NTH}|last|final|former|latter)\b"
    rf"(?! (?:to|from|closest|nearest|biggest|two|three|four|five|few|ones)\b)"
    rf"|(?:\b(?:number|option|no\.?) |#)({_NUMBER})\b"
    r"|^(?:the )?([1-9]|10)$"
)
ORDINALS = {
    word: number
    for number, group in enumerate(
        (
            "first 1st 1 one former",
            "second 2nd 2 two",
            "third 3rd 3 three",
            "fourth 4th 4 four",
            "fifth 5th 5 five",
            "sixth 6th 6 six",
            "seventh 7th 7 seven",
            "eighth 8th 8 eight",
            "ninth 9th 9 nine",
            "tenth 10th 10 ten",
        ),
        1,
    )
    for word in group.split(" ")
} | {"last": -1, "final": -1, "latter": -1}
RIGHT = re.compile(r"^(?:the )?right(?:[- ]hand)?(?: one| side)?$")
"""May be a "yes" as well as a side."""
SIDE = re.compile(
    r"(?:\b(?:on|to|at|in) )?\b(?:the |your )?\b(?:far |very )?"
    r"(?P<side>left(?:most)?|right(?:most)?|middle|center|centre)(?:[- ]hand)?(?: side)?\b(?! of)"
)
FROM_SIDE = re.compile(
    rf"\b(?:the )?(?P<number>{_NTH}|last)"
    r"(?: one)? from (?:the |your )?(?P<side>left|right)(?:[- ]hand)?(?: side)?\b"
)
PREPOSITION = re.compile(
    r"\b(?:on top of|on|in|inside|near|next to|beside|by|close to|under|behind|in front of|at|from"
    r"|left of|right of|to the left of|to the right of)\b"
)
UNCLEAR = re.compile(
    r"\b(?!forest|west|rest|chest|guest|vest|nest|nearest to|closest to)\w{2,}est\b(?! to)"
    r"|\b(?:clos|near|far|bigg|small|larg|tall|short|old|new|clean|light|dark|heavi|nic)er\b.*"
    r"|\b\w+ than\b.*|\b(?:more|less|most|least)\b|\b(?:far|farther|further|away) from\b.*"
    r"|\b(?:on |to |at )?my (?:left|right)\b.*"
    r"|\bmine\b|\byours\b|\b(?!it|that|what|there|let|he|she)\w+'s\b|\bbetween\b.*"
    r"|\b(?:first|last) (?:two|three|four|five|few|ones)\b|\b(?:that |which )?you (?:saw|found)\b.*"
    r"|\bopposite\b.*|\b(?:second|next|third) to (?:the )?last\b|\bsame\b"
    r"|\b(?:that |which )?(?:i|we|he|she|they|my \w+"
    r"(?= (?:uses?|used|bought|gave|has|had|likes?|made))) (?!want|mean|need|take|like)\w+.*"
    r"|\b(?:belongs|belonging)\b.*"
)
