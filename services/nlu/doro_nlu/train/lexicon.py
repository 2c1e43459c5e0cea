"""Words for the generator: nouns, values, connectors. Written for this project."""

from __future__ import annotations


def _list(text: str) -> tuple[str, ...]:
    return tuple(" ".join(word.split()) for word in text.split(",") if word.strip())


AI2THOR = _list(
    """
    alarm clock, aluminum foil, apple, apple slice, arm chair, armchair, baseball bat, basketball,
    bath towel, bathtub, bathtub basin, bed, blinds, book, boots, bottle, bowl, box, bread, bread
    slice, butter knife, cabinet, candle, cart, cd, cell phone, chair, cloth, coffee machine, coffee
    table, counter top, countertop, credit card, cup, curtains, desk, desk lamp, desktop, dining
    table, dish sponge, dog bed, drawer, dresser, dumbbell, egg, faucet, floor, floor lamp,
    footstool, fork, fridge, garbage bag, garbage can, hand towel, hand towel holder, house plant,
    kettle, key chain, knife, ladle, laptop, laundry hamper, lettuce, light switch, microwave,
    mirror, mug, newspaper, ottoman, painting, pan, paper towel, paper towel roll, pen, pencil,
    pepper shaker, pillow, plate, plunger, poster, pot, potato, remote control, room decor, safe,
    salt shaker, scrub brush, shelf, shelving unit, shower curtain, shower door, shower glass,
    shower head, side table, sink, sink basin, soap bar, soap bottle, sofa, spatula, spoon, spray
    bottle, statue, stool, stove burner, stove knob, table top decor, teddy bear, television, tennis
    racket, tissue box, toaster, toilet, toilet paper, toilet paper hanger, tomato, towel, towel
    holder, tv stand, vacuum cleaner, vase, watch, watering can, window, wine bottle, lettuce slice,
    potato slice, tomato slice
    """
)
COCO = _list(
    """
    person, bicycle, car, motorcycle, airplane, bus, train, truck, boat, traffic light, fire
    hydrant, stop sign, parking meter, bench, bird, cat, dog, horse, sheep, cow, elephant, bear,
    zebra, giraffe, backpack, umbrella, handbag, tie, suitcase, frisbee, skis, snowboard, sports
    ball, kite, baseball bat, baseball glove, skateboard, surfboard, tennis racket, bottle, wine
    glass, cup, fork, knife, spoon, bowl, banana, apple, sandwich, orange, broccoli, carrot, hot
    dog, pizza, donut, cake, chair, couch, potted plant, bed, dining table, toilet, tv, laptop,
    mouse, remote, keyboard, cell phone, microwave, oven, toaster, sink, refrigerator, book, clock,
    vase, scissors, teddy bear, hair drier, toothbrush
    """
)
HOUSEHOLD = _list(
    """
    air conditioner, air freshener, album, apron, ashtray, backscratcher, bag, ball, band aid,
    baking sheet, baking tray, basket, bat, bath mat, bath robe, battery, bean bag, beer, beer
    bottle, beer can, bell, belt, bib, bin, binder, bird cage, blanket, blender, board game, bolt,
    bookend, bouquet, bracelet, breadbox, briefcase, broom, brush, bucket, bulb, butter, butter
    dish, button, calculator, calendar, camera, can, can opener, candle holder, candlestick, candy,
    candy bar, cap, card, cards, carton, casserole dish, cassette, cereal, cereal box, charger,
    chessboard, chess set, chopsticks, cigarette, clipboard, coat, coat hanger, coaster, coffee,
    coffee cup, coffee maker, coffee mug, coffee pot, coin, coke, coke can, colander, comb,
    computer, computer mouse, computer monitor, cookbook, cookie, cookie jar, cooler, cork screw,
    corkscrew, cotton ball, crayon, crib, cucumber, cupcake, curling iron, cushion, cutting board,
    detergent, diaper, dice, dictionary, dish, dish rack, dish soap, dish towel, dishcloth, doll,
    doll house, door mat, doormat, drill, drone, drum, duster, dust pan, dustpan, duvet, dvd, dvd
    player, earphones, earring, easel, eggplant, electric razor, envelope, eraser, extension cord,
    eye glasses, fan, feather duster, figurine, file, fire extinguisher, first aid kit, fish bowl,
    flashlight, flask, flower, flower pot, flowers, flute, folder, food processor, football, frame,
    frisbee, fruit, fruit bowl, frying pan, funnel, garlic press, glass, glasses, globe, glove,
    gloves, glue, glue stick, goblet, grapes, grater, grapefruit, guitar, hair brush, hair dryer,
    hammer, hand sanitizer, handkerchief, hat, headphones, headset, helmet, high heels, hoodie, hole
    punch, honey, ice cream, ice cube tray, ink pen, ipad, iron, ironing board, jacket, jam, jar,
    jeans, jewelry box, jigsaw puzzle, journal, jug, juice, juice box, ketchup, ketchup bottle, key,
    keys, keyboard, kitchen scale, kitchen towel, knife block, knitting needle, lamp, lamp shade,
    lantern, leash, lemon, lens, letter, letter opener, lid, lighter, lime, lip balm, lipstick,
    loaf, lotion, lotion bottle, lunch box, magazine, magnet, magnifying glass, makeup bag, mango,
    marker, mask, measuring cup, measuring tape, medicine, medicine bottle, melon, microphone,
    microscope, milk, milk carton, mitten, mixer, mixing bowl, modem, moisturizer, mop, mouse pad,
    mousetrap, muffin, mushroom, mustard, nail, nail clipper, nail file, nail polish, napkin,
    napkins, necklace, needle, notebook, notepad, nut, object, item, thing, oil bottle, olive oil,
    onion, oven mitt, packet, padlock, paint brush, paint can, pajamas, pants, paper, paper bag
    holder, paper clip, parcel, passport, peach, peanut butter, pear, peeler, pencil case, pencil
    sharpener, pepper, pepper grinder, pepper mill, perfume, phone, phone charger, photo, photo
    album, photo frame, piano, picture, picture frame, pie, piggy bank, pill, pill bottle,
    pineapple, pitcher, pizza box, pizza cutter, place mat, plant, plant pot, play station, pliers,
    plum, polo shirt, popcorn, postcard, present, printer, pudding, puppet, purse, puzzle, rag,
    radio, rain coat, razor, record, record player, rice cooker, ring, robe, rolling pin, rope,
    router, rubber band, rubber duck, rug, ruler, salad, salad bowl, salt, salt and pepper shaker,
    sandal, sauce pan, saucepan, saucer, saw, scale, scarf, screw, screwdriver, sewing kit, shampoo,
    shampoo bottle, shaving cream, sheet, shell, shirt, shoe, shoe box, shoes, shopping bag, shorts,
    shovel, skillet, skirt, sleeping bag, slipper, slippers, smart phone, smartphone, smoke
    detector, snack, sneaker, snow globe, soap, soap dish, soap dispenser, soccer ball, sock, socks,
    soda, soda can, soup bowl, speaker, spice, spice jar, spice rack, sponge, stamp, stapler, sticky
    note, stethoscope, strainer, straw, string, stuffed animal, sugar, sugar bowl, sun hat,
    sunglasses, sweater, sword, syringe, t-shirt, tablecloth, tablet, tape, tape dispenser, tape
    measure, tea, tea bag, tea cup, tea kettle, tea towel, teacup, teapot, teaspoon, telephone,
    thermometer, thermos, thread, tin opener, tissue, tissues, toaster oven, tongs, tool box,
    toolbox, toothpaste, toothpick, torch, toy, toy car, toy truck, tray, trophy, trousers, trumpet,
    tumbler, tv remote, tweezers, umbrella stand, usb stick, vacuum, vegetable, video game, vinyl,
    violin, waffle maker, wallet, water, water bottle, water jug, watermelon, weight, whisk,
    whistle, wig, wok, wooden spoon rest, wrapping paper, wrench, wrist watch, xbox controller,
    yarn, yoga mat, yogurt, zucchini, avocado, ladder, pear, salad fork, steak knife, chef 's knife,
    ping pong paddle, cup cake, desk organizer, bar stool, lounge chair, rocking chair, office
    chair, dining chair, dining room chair, kitchen chair, folding chair, high chair, love seat,
    loveseat, end table, night stand, nightstand, bedside table, console table, kitchen table, work
    bench, coat rack, book case, bookcase, bookshelf, book shelf, shoe rack, wardrobe, chest, bunk
    bed, couch, futon, recliner, bench, sofa bed, tv, television set, monitor, game console, washing
    machine, dishwasher, dryer, fireplace, heater, radiator, gas stove, wall clock, clothes basket,
    laundry basket, waste basket, wastebasket, recycling bin, trash can, trash bin, trashcan,
    dustbin, baby bottle, baby monitor, pet bowl, dog bowl, dog toy, cat litter box, cat toy, cereal
    bowl, ramekin, serving spoon, serving tray, cake stand, cake tin, pastry brush, tart, croissant,
    bagel, toast, cheese, ham, sausage, chicken, steak, fish, shrimp, noodles, pasta, rice, cracker,
    chips, chocolate, chocolate bar, energy drink, lemonade, wine, whiskey bottle, decanter, carafe,
    kiwi, cherry, strawberry, blueberry, raspberry, pumpkin, cabbage, celery, garlic, ginger,
    spinach, bell pepper, sweet potato, coconut, fob, key fob, disc, disk, compact disc, notecard,
    cardigan, rag doll, wash cloth, washcloth, wash rag, toilet brush, toilet roll, cotton swab, tea
    light, jewel, stand mixer, hand mixer, mixing spoon, bowling pin, gift, handle brush, iphone,
    ipod, kindle, lego brick, block, brick, pebble, rock, stick, container, cylinder, canister, tub,
    tube, vial, crate, pallet, sack, satchel, tote bag, duffel bag, gym bag, sleeping mask, knee
    pad, hockey stick, golf club, golf ball, hand weight, barbell, jump rope, exercise ball, walking
    stick, cane, crutch, wheelchair, heating pad, hot water bottle
    """
)
PLACES = _list(
    """
    table, desk, shelf, counter, kitchen counter, dining table, coffee table, side table, end table,
    night stand, nightstand, bedside table, dresser, cabinet, cupboard, drawer, bed, sofa, couch,
    chair, arm chair, bench, stool, ottoman, floor, rug, carpet, ground, sink, stove, stove top,
    oven, microwave, fridge, refrigerator, freezer, dishwasher, toaster, bookshelf, bookcase, book
    shelf, window, window sill, windowsill, door, wall, corner table, tv stand, tv, television,
    lamp, floor lamp, fireplace, mantle, mantel, bath tub, bathtub, tub, toilet, toilet tank,
    bathroom sink, bathroom counter, trash can, garbage can, garbage, bin, trash, basket, box, bag,
    crate, closet, wardrobe, pantry, rack, towel rack, shelving unit, tray, plant, island, kitchen
    island, table top, tabletop, countertop, counter top, work bench, piano, console, hutch, vanity,
    ledge, stand, safe, hamper, laundry basket, washing machine, coffee maker, coffee machine,
    computer, laptop, monitor, mirror, radiator, kitchen table, dining room table, office desk,
    office chair, recliner, love seat, ice chest, wine rack, hook, curtain, headboard, entertainment
    center, chest of drawers, balcony door, fish tank, bird cage, staircase, stairs, steps, arm
    rest, pillow, place mat, cutting board
    """
)
ROOMS = _list(
    """
    kitchen, living room, bedroom, bathroom, dining room, office, study, hallway, hall, corridor,
    garage, basement, attic, laundry room, lounge, library, balcony, guest room, guest bedroom,
    master bedroom, kids room, playroom, entrance, storage room, conference room, lab, lobby,
    restroom, room, house, apartment, den, family room, garden, closet, pantry, ground floor, first
    floor, second floor, level 2, level 1, upper floor, entertainment room, livingroom, studio,
    meeting room, utility room, break room, bath
    """
)
SURFACES = _list(
    """
    table, desk, counter, bed, sofa, couch, chair, shelf, dresser, dining table, coffee table, side
    table, night stand, nightstand, stove, floor, kitchen counter, countertop, kitchen table,
    cabinet, island, tv stand, bench
    """
)
MASS_OF = _list(
    """
    glass, cup, mug, bowl, plate, slice, piece, loaf, head, bar, roll, bottle, can, jar, box, bag,
    pack, packet, pair, set, bunch, pile, stack, carton, tube, chunk, wedge, bucket, basket, sheet,
    deck, tin, jug, pitcher
    """
)
MASS = _list(
    """
    water, milk, juice, coffee, tea, soup, rice, fruit, apple, bread, potato, tomato, lettuce,
    cabbage, soap, toilet paper, paper towels, paper towel, wine, beer, cereal, cookies, chocolate,
    scissors, keys, glasses, shoes, socks, cards, books, papers, flowers, grapes, bananas, cheese,
    cake, pizza, lotion, paint, chips, sugar, flour, tape, tissues, tissue, honey, butter, cutlery,
    towels, plates, batteries, pens, pencils, headphones, gloves
    """
)
OF_FIXED = _list(
    """
    chest of drawers, set of keys, bar of soap, roll of toilet paper, glass of water, loaf of bread
    """
)
COMPOUND_MODIFIERS = _list(
    """
    kitchen, coffee, tea, dining room, living room, bathroom, bedroom, office, garden, baby, kids,
    computer, soup, salad, dinner, dessert, wine, beer, water, milk, juice, fruit, cake, flower,
    pencil, pen, key, shoe, coat, toy, dog, cat, fish, bird, travel, sports, tennis, baseball, golf,
    gym, school, picture, photo, wall, desk, floor, ceiling, table, bath, hand, dish, soap, hair,
    tooth, face, tool, paint, sewing, jewelry, camera, phone, laptop, tablet, game, music, guitar,
    reading, writing, cooking, baking, serving, mixing, measuring, cutting, washing, cleaning,
    laundry, storage, trash, recycling, garbage, paper clip, spice, pepper, salt, sugar, honey, oil,
    vinegar, ketchup, medicine, pill, first aid, emergency, christmas, birthday, halloween, winter,
    summer, rain, patio, lawn, camping, picnic, lunch, breakfast, snack, candy, cookie, bread,
    butter, cheese, egg, potato, tomato
    """
)
COMPOUND_HEADS = _list(
    """
    bowl, cup, mug, plate, glass, bottle, jar, box, bag, basket, bin, can, case, tray, rack, stand,
    holder, hook, shelf, table, chair, lamp, clock, mat, rug, towel, cloth, brush, sponge, book,
    magazine, card, pad, pen, knife, spoon, fork, opener, grinder, shaker, dispenser, maker,
    machine, cleaner, charger, cover, pot, pan, kettle, bed, blanket, cushion, pillow, frame,
    mirror, toy, ball, doll, hat, coat, jacket, shirt, glove, shoe, boot, container
    """
)
PLURAL_ONLY = frozenset(
    _list(
        """
    scissors, skis, blinds, curtains, boots, keys, shoes, socks, slippers, glasses, eye glasses,
    jeans, pants, trousers, shorts, pajamas, headphones, earphones, sunglasses, tongs, pliers,
    tweezers, chopsticks, gloves, cards, flowers, napkins, tissues, grapes, noodles, chips, high
    heels, stairs, steps
    """
    )
)
COLORS = _list(
    """
    red, green, blue, yellow, white, black, brown, gray, grey, orange, pink, purple, silver, gold,
    golden, beige, cyan, magenta, turquoise, violet, maroon, navy, teal, tan, cream, olive,
    lavender, crimson, scarlet, indigo, aqua, ivory, khaki, mauve, peach, rose, ruby, amber,
    burgundy, charcoal, lilac, mint, mustard, salmon, plum, lime, fuchsia, auburn, coral, ochre,
    emerald, sapphire, blonde, rust, reddish, greenish, bluish, yellowish, brownish, greyish,
    pinkish, off-white, dark, teal
    """
)
BASE_COLORS = COLORS[:16]
SHADES = _list(
    """
    dark, light, bright, pale, deep, navy, sky, neon, pastel, royal, forest, olive, mint, hot, lime
    """
)
MATERIALS = _list(
    """
    wooden, wood, plastic, metal, metallic, glass, ceramic, leather, paper, cardboard, steel,
    stainless steel, iron, cast iron, aluminum, aluminium, copper, brass, bronze, porcelain, clay,
    stone, marble, granite, concrete, cotton, wool, woolen, silk, linen, denim, velvet, suede,
    fabric, cloth, rubber, silicone, bamboo, wicker, rattan, straw, crystal, chrome, tin, vinyl,
    nylon, polyester, foam, fur, canvas, oak, pine, mahogany, teak, walnut, plywood, styrofoam, wax,
    cork, enamel, acrylic, terracotta, felt, felted, plush, jute, china, titanium
    """
)
COMMON_MATERIALS = MATERIALS[:12]
ADJECTIVES = _list(
    """
    small, large, big, little, tiny, huge, tall, short, long, wide, narrow, thick, thin, round,
    square, rectangular, oval, circular, triangular, curved, flat, deep, shallow, heavy,
    lighter, old, new, modern, antique, vintage, ancient, dirty, clean, empty, full, half-full,
    broken, cracked, chipped, open, closed, opened, folded, rolled, wet, dry, hot, cold, warm,
    chilled, heated, cooked, washed, rinsed, microwaved, cleaned, warmed,
    frozen, sliced, cut, fresh, rotten, ripe, raw, sharp, dull, soft, hard,
    shiny, smooth, rough, fluffy, striped, spotted, dotted, checkered, plaid, patterned, floral,
    polka dot, plain, fancy, elegant, simple, cheap, expensive, nice, beautiful, ugly, cute, cozy,
    comfortable, favorite, favourite, other, second, first, third, last, left, right, top, bottom,
    middle, upper, lower, front, back, left-most, rightmost, leftmost, closest, nearest, furthest,
    far, nearby, spare, extra, same, whole, half, lit, burning, stuffed, upholstered, decorative,
    portable, digital, electric, electronic, foldable, adjustable, king-size, queen-size, single,
    double, twin, medium, medium-sized, small-sized, oversized, mini, giant, slim, low, high,
    sturdy, worn, used, unused, dusty, rusty, steaming, delicious, tasty, sweet, sealed, opaque,
    clear, transparent, see-through, colorful, multicolored
    """
)
PARTS = _list(
    """
    handle, handles, lid, top, base, bottom, rim, legs, leg, cover, case, stripes, stripe, label,
    cap, frame, door, seat, back, cushion, shade, straps, strap, edges, trim, print, letters, logo,
    pattern, dots, buttons, screen, blade, spout, cord, ribbon, wheels, drawers, tiles, wall, stem,
    petals, spots, flowers, arms
    """
)
ON = _list(
    """
    on, on, on, on, on, on, on top of, on top of, atop, upon, on the top of, on the edge of, on the
    left side of, on the right side of, on the side of, on the back of, on the front of, on the
    corner of, on the far side of, on the top right of, on the top left of, on the back left of,
    on the front edge of, on the right edge of, on the left end of, on the bottom of, on the front
    right of, on the other side of, on the end of, on the surface of
    """
)
NEAR = _list(
    """
    near, near, near, near, near to, next to, next to, next to, next to, beside, beside, by, by,
    close to, close to, closest to, nearest to, nearest, to the left of, to the right of, on the
    left of, on the right of, left of, right of, at the left of, at the right of, to the left side
    of, to the right side of, in front of, in front of, behind, between, in between, across from,
    opposite, opposite to, against, facing, adjacent to, alongside, to the immediate right of, just
    in front of, on the right hand side of, near the edge of, near the center of, near the back of,
    close to the edge of, on the left hand side of, besides, at the side of
    """
)
AT = _list(
    """
    in, in, in, in, inside, inside of, inside, within, at, from, from, from, from, off, off of, off
    of, out of, under, under, underneath, below, beneath, above, over, in the corner of, at the end
    of, at the top of, at the bottom of, in the middle of, in the center of, from the middle of,
    from the top of, from inside, at the edge of, in the back of, from the side of, from the left
    side of, in the front of, at the foot of, at the corner of, from the edge of, from the back of,
    out from, from off, from off of, from out of
    """
)
FROM_ON = _list("from on top of, from on, from atop, from on top of, from upon")
FROM_NEAR = _list(
    """
    from behind, from next to, from beside, from near, from in front of, from between, from by
    """
)
FROM_AT = _list(
    """
    from under, from underneath, from inside, from inside of, from below, from within, from in
    """
)
