"""Fixed words for the slots of the frames; all of them are O."""

from __future__ import annotations


def lines(text: str) -> tuple[str, ...]:
    return tuple(" ".join(item.split()) for item in text.split("|"))


WORDS: dict[str, tuple[str, ...]] = {
    "lead": lines("""take|lead|guide|bring|walk|direct|navigate|drive|accompany|escort"""),
    "onoff": lines("""on|off|on|off|up|down|over|around"""),
    "inspect": lines("""examine|look at|inspect|check|read|hold|see|view|take|study|find"""),
    "light": lines(
        """by the light of a lamp|by the light of the tall lamp|by lamplight|with the lamp|
        under the light of the lamp|using the light of a lamp|by lamp light|by the lamp light|
        in the light|by the light of the desk lamp|by a lit lamp|in the lamp light|
        by turning on the floor lamp|while turning on a lamp|under the light of the desk lamp"""
    ),
    "doing": lines(
        """sleeping|standing|sitting|lying|eating grass|parked|flying|hanging|growing|waiting|
        walking|running|playing|resting|leaning|filled with things|placed upside down|turned on|
        looking at the camera|folded|seen from above|drinking|jumping|floating|shining|burning"""
    ),
    "verb": lines(
        """pick up|pick up|pick up|grab|take|get|bring|fetch|find|find|look for|search for|locate|
        retrieve|collect|hand me|give me|pass me|show me|point to|point at|remove|lift|carry|
        hold|get me|find me|fetch me|identify|detect|spot|reach for|go get|take out|pull out|
        lift up|select|choose|gather|seek|deliver|obtain|touch|inspect|examine|check|clean|wash|
        acquire|recover|look at|pull|seize|snatch|pickup|grasp|catch|procure|hold up|go fetch|
        look out for|go find|come back with|transport|go and get|help me get|track down"""
    ),
    "bring": lines(
        """bring me|bring|bring over|get me|hand me|hand over|fetch me|give me|pass me|pass|
        bring back|deliver|bring us|bring her|carry over|send me|bring to me|return|grab me|
        get us"""
    ),
    "pick": lines("""pick|pick|pick|take|lift|bring|hold"""),
    "put": lines(
        """put|place|move|set|drop|leave|put down|lay|throw|store|hang|return|transfer|stack|
        insert|relocate|position|slide|rest|place|put"""
    ),
    "put2": lines(
        """put|place|move|set|drop|leave|lay|throw|store|hang|return|and put|and place"""
    ),
    "act": lines(
        """turn on|turn off|switch on|switch off|close|open|clean|wipe|wash|touch|shut|slice|cut|
        heat|rinse|empty|fill|cook|chill|activate|push|pull|water|dust|use|unplug|plug in|press|
        break|fold|make"""
    ),
    "open": lines("""open|close|shut|unlock|lock|turn on|turn off|switch on|start|stop|activate"""),
    "need": lines(
        """need|want|would like|'d like|am looking for|have to find|want you to bring|
        need you to find|want you to pick up|require|would love|want to see|
        would like you to bring me|wish to have"""
    ),
    "pol": lines(
        """|||||||please|please|can you|could you|can you please|could you please|would you|
        will you|i want you to|i need you to|i would like you to|please can you|robot ,|hey ,|
        ok ,|would you mind to|kindly|may you please|hey robot , can you|i 'd like you to|
        you should|try to|could you kindly|okay robot , please|just|can you go and|go and|
        help me|first ,|then"""
    ),
    "end": lines(
        """|||||.|.|.|.|please|, please|!|?|please .|for me|for me .|, thanks|now|quickly|to me|
        . thanks|right now|, will you|, robot|again|asap|if you can|, would you ?|, thank you|!|
        as soon as possible"""
    ),
    "where_end": lines("""?|?||."""),
    "voc": lines(
        """robot|hey robot|ok robot|john ,|alexa ,|michael|dear robot ,|hello ,|excuse me ,|
        tiago ,|r2"""
    ),
    "person": lines(
        """me|my daughter|mom|him|us|the guests|my friend|the old man|john|dinner|breakfast|later|
        you"""
    ),
    "person2": lines(
        """man|guy with the red hoodie|woman|person in blue|child|robot|girl next to the door"""
    ),
    "hand": lines("""left hand|right hand|hand|gripper|arm|right arm"""),
    "adv": lines(
        """carefully|quickly|slowly|gently|again|first|now|with care|immediately|too|as well|
        together"""
    ),
    "lost": lines(
        """i lost|i can 't find|i cannot find|i 'm looking for|i am looking for|i need|i want|
        have you seen|did you see|i forgot|i would like|i 'd like to have|we need|i dropped|
        let me have|i 'll take|i like"""
    ),
    "where": lines(
        """where is|where 's|where are|do you know where i put|where did i leave|where can i find|
        do you see|can you see|is there|are there|have you got|what about|how about|which is"""
    ),
    "ask": lines(
        """can you see|do you see|is there|are there|did you find|have you found|do we have|
        can i have|may i have"""
    ),
    "count": lines("""there are|i see|we have"""),
    "before": lines(
        """before you leave|before going to the kitchen|after you turn around|when you are done|
        once the door is open|while holding the tray|and nothing else|as you walk by the table"""
    ),
    "why": lines(
        """i am thirsty ,|i 'm hungry ,|it is dark ,|i want to read ,|we are having dinner ,|
        the guests are here ,|i spilled water on the floor ,|my hands are dirty so|it is cold ,|
        to clean the table ,|since i am tired ,|i want to write a letter .|for the soup ,|
        i have a headache ,|the kitchen is a mess ,|it is raining ,|before lunch ,|as i said ,|
        when you have time ,|i am in the bedroom .|dinner is ready ,"""
    ),
    "tail": lines(
        """bring it|bring it to me|bring it here|give it to me|take it to the kitchen|
        put it on the table|place it in the sink|put it in the white bin|bring it to the sofa|
        wash it|clean it|throw it away|heat it|come back|
        bring it to the red chair in the living room|put it next to the lamp|turn on the lamp|
        turn on the light|close the door|fetch it|pick it up|take it|get it|hand it to me|
        drop it in the trash can|cool it in the fridge|rinse it in the sink|
        place them on the counter|put them away|bring them|show it to me|
        look at it under the light|turn around|tell me|wait|leave it there|put it back|
        set it down on the desk|put it inside the drawer|carry it to the black table|
        place it on top of the dresser near the bed|slice it|turn to the left|turn off the tv|
        let me know|bring me that|give me that|heat it in the microwave|put it under the faucet|
        hand it over|take a picture|keep it in the wooden box|move to the couch"""
    ),
    "side": lines(
        """open the fridge|open the microwave|open the drawer|turn on the lamp|turn on the light|
        turn around|turn left|open the white cabinet|open the door|open the box|close the door|
        turn right|look down|look up|take two steps forward|turn to the right|
        open the left drawer|shut the microwave|wait a few seconds|open the refrigerator door|
        open the safe|step back|turn the faucet on|close the cabinet|close the fridge"""
    ),
    "go": lines(
        """take two steps forward then turn right|take a step to the left|
        take three steps|go to the kitchen|go to the bedroom|walk to the table|
        go to the white table|
        move to the counter|turn left and walk to the sink|go into the living room|
        turn around and go to the bed|head to the bathroom|walk over to the couch|
        go back to the desk|navigate to the office|turn right|go straight|walk forward|
        turn around|take a few steps to the left|go upstairs|go to level 2|
        go to the room with the desk|turn to face the stove|approach the red sofa|
        enter the garage|go to the room at the end of the hall|walk towards the door|
        move forward|step to the right of the bed|go over to the lamp by the window|
        turn left to face the fridge|cross the room|come to the dining room|
        drive to the hallway|leave the room|go near the couch|move closer to the dresser|
        make a left at the door|walk to the front of the sofa|go to the bathroom on level 2|
        look around|go to the kitchen on the first floor|go downstairs|proceed to the shelf|
        turn left , go to the black table|turn around , walk across the room , turn left|
        go to the wooden dresser"""
    ),
    "ego": lines(
        """in front of you|on the left|on the right|to your left|to your right|closest to you|
        behind you|over there|on the far right|nearest to you|in the middle|in the back|
        at the very top|here|on your right|near me"""
    ),
    "link": lines(
        """that is|which is|sitting|lying|standing|placed|hanging|that sits|located|laying|
        that stands|resting|positioned|leaning|parked|mounted|shown|seen|that are|kept|
        that is placed|stacked|floating|lies|stands|sits"""
    ),
    "nth": lines(
        """first|second|third|last|other|left|right|middle|bigger|smaller|closest|nearest|same|
        next|fourth"""
    ),
    "no": lines(
        """|||no ,|yes ,|yes|no|i mean|please|ok ,|hmm ,|well ,|sorry ,|actually ,|i want|i meant"""
    ),
    "chat": lines(
        """thank you very much|thank you so much|what is your name|many thanks|nice work|
        hello|hi there|how are you|thank you|thanks a lot|what time is it|stop|
        wait|never mind|
        forget it|yes|no|ok|okay|what can you do|tell me a joke|good morning|who are you|
        come here|follow me|what is the weather like|i don't know|both of them|either|
        any of them|whatever|cancel|that is right|the other one|all of them|nothing|neither|
        i love you|how old are you|sing a song|be careful|go away|hurry up|what do you mean|
        it does not matter|you choose|say that again|i am tired|this is great|
        connect to the internet|what is going on|do it again|that is wrong|not this one|
        it is nice today|why|help|good night|see you later"""
    ),
    "foreign": lines(
        """bring mir die rote tasse|hole den roten becher vom tisch|finde das bett|
        gib mir bitte das buch|apporte moi la tasse rouge|trouve le lit|
        donne-moi le livre sur la table|prends la bouteille dans la cuisine|tráeme la taza roja|
        busca la cama|dame el libro de la mesa|por favor trae la botella azul|
        portami la tazza rossa|trova il letto|dammi il libro sul tavolo|
        traga-me a xícara vermelha|encontre a cama|breng me de rode beker|zoek het bed|
        geef mij het boek|hämta den röda koppen|przynieś mi czerwony kubek|
        принеси мне красную чашку|请把红色的杯子给我|
        赤いカップを持ってきて|빨간 컵을 가져와|أحضر لي الكوب الأحمر|
        मुझे लाल कप लाओ|wo ist meine brille|où est mon téléphone|dónde está el teléfono|
        kannst du mir den stuhl bringen|nimm die flasche neben dem kühlschrank|
        mets la pomme dans le bol|pon la manzana en el plato"""
    ),
}

FOREIGN_PARTS = lines(
    """der|die|das|ein|eine|und|ich|mir|bitte|auf|dem|tisch|stuhl|rote|blaue|le|
    la|les|une|et|moi|sur|dans|chaise|verte|el|los|una|y|por|favor|silla|
    mesa|roja|en|il|lo|un|e|sedia|tavolo|rosso|een|het|de|op|tafel|stoel|
    bringe|hole|nimm|apporte|prends|trae|busca|porta|prendi|jest|och|ett|med|
    til|ikke|kan|jag|du|er|ist|nicht|lorem|ipsum|dolor|sit|amet|consectetur|
    adipiscing|elit|sed|do|eiusmod|tempor|incididunt"""
)
