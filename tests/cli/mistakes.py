"""Twenty-six mistakes as people make them in model files: the file, what the sentence has to say, and whether
it is refused or a caution.
"""

from __future__ import annotations

from vfife.cli.commands.new import templates

FOUR_BAR, SLIDER_CRANK = (templates()[name].read_text() for name in ("four-bar", "slider-crank"))
FAULT, CAUTION = True, False


def changed(text: str, old: str, new: str) -> str:
    """The file with its first ``old`` exchanged; the mistake must not miss it."""
    assert old in text, old
    return text.replace(old, new, 1)


def bar(old: str, new: str) -> str:
    """The four-bar with one mistake."""
    return changed(FOUR_BAR, old, new)


def without(text: str, table: str) -> str:
    """The file without a table and what belongs to it."""
    head, _, rest = text.partition(f"[{table}]")
    assert rest, table
    after = rest.find("\n[")
    return head + (rest[after + 1 :] if after >= 0 else "")


PUSH = (
    '[load.gas]\nat = "block.center"\nforce = ["-1 kN", 0]\ntimes = ["0 s", "20 ms", "10 ms"]\nfactors = [0,'
    " 1, 0]\n"
)

MISTAKES: dict[str, tuple[str, list[str], bool]] = {
    # Typos of keys, tables and names.
    "key misspelt": (
        bar('length = "280 mm"', 'lenght = "280 mm"'),
        ["[body.coupler] lenght", "length"],
        FAULT,
    ),
    "table misspelt": (bar("[joint.C.contact]", "[joint.C.contakt]"), ["contakt", "contact"], FAULT),
    "body misspelt in a joint": (
        bar('"crank.end"', '"cranck.end"'),
        ["[joint.B] bearing", "there is no body 'cranck'", "crank.end"],
        FAULT,
    ),
    "pin that is not there": (
        bar('"coupler.end"', '"coupler.middle"'),
        ["[joint.C] bearing", "coupler has no pin 'middle'", "coupler.end"],
        FAULT,
    ),
    "law misspelt": (
        bar('law = "lankarani-nikravesh"', 'law = "lankarani"'),
        ["[joint.C.contact] law", "lankarani-nikravesh"],
        FAULT,
    ),
    "kind that is none": (
        bar('kind = "clearance"', 'kind = "hinge"'),
        ["[joint.C] kind", "hinge", "clearance"],
        FAULT,
    ),
    "driver of no body": (
        bar("[driver.crank]", "[driver.wheel]"),
        ["[driver.wheel]", "there is no body 'wheel'"],
        FAULT,
    ),
    # Units and numbers.
    "quotes forgotten": (bar('length = "280 mm"', "length = 280 mm"), ["line 21", "TOML", "quotes"], FAULT),
    "decimal comma": (
        bar('"0.1 mm"', '"0,1 mm"'),
        ["[joint.C] clearance", "a comma", "decimal point"],
        FAULT,
    ),
    "mass for a length": (
        bar('length = "280 mm"', 'length = "280 kg"'),
        ["[body.coupler] length", "280 kg", "mm"],
        FAULT,
    ),
    "metres for millimetres": (
        bar('length = "280 mm"', 'length = "280 m"'),
        ["body.coupler.length is 280 m", "280 mm?"],
        FAULT,
    ),
    "radians for degrees": (
        bar('angle = "50 deg"', "angle = 50"),
        ["body.coupler.angle is 50 rad", "50 deg?"],
        CAUTION,
    ),
    "unit that is none": (bar('"300 rpm"', '"300 rmp"'), ["[driver.crank] speed", "rmp", "rpm"], FAULT),
    "negative mass": (
        bar('mass = "1.0 kg"', 'mass = "-1.0 kg"'),
        ["[body.coupler] mass", "-1.0 kg", "negative"],
        FAULT,
    ),
    "restitution of more than one": (
        bar("restitution = 0.9", "restitution = 9"),
        ["[joint.C.contact] restitution", "9"],
        FAULT,
    ),
    "play larger than the pin": (
        bar('"0.1 mm"', '"10 mm"'),
        ["[joint.C] clearance", "10 mm", "bearing_radius"],
        FAULT,
    ),
    # What is missing, or there twice.
    "driver forgotten": (without(FOUR_BAR, "driver.crank"), ["[run] turns", "nothing is driven"], FAULT),
    "pivot of the crank forgotten": (
        without(FOUR_BAR, "joint.A"),
        ["[driver.crank]", "one ideal joint to the ground"],
        FAULT,
    ),
    "last joint forgotten": (
        without(FOUR_BAR, "joint.D"),
        ["The chain is open", "rocker.start", "ground.D", "forgotten?"],
        CAUTION,
    ),
    "body on nothing": (
        FOUR_BAR + '\n[body.spare]\nlength = "50 mm"\nmass = "0.1 kg"\n',
        ["Body spare is not connected"],
        CAUTION,
    ),
    "two drivers": (
        FOUR_BAR + '\n[driver.second]\nbody = "crank"\nspeed = "100 rpm"\n',
        ["[driver.second]", "crank already", "contradict"],
        FAULT,
    ),
    "table out of order": (
        SLIDER_CRANK + "\n" + PUSH,
        ["[load.gas] times", "must ascend", "number 3"],
        FAULT,
    ),
    # Mechanisms that cannot be.
    "coupler too short to turn": (
        bar('length = "280 mm"', 'length = "130 mm"'),
        ["jams at crank angle 112", "joint C opens", "50 mm", "coupler at least 180 mm (now 130 mm)"],
        FAULT,
    ),
    "pivots too far apart": (
        bar('"300 mm"', '"3000 mm"'),
        ["joints stay open, C by 2400 mm", "cannot reach one another"],
        FAULT,
    ),
    "change point": (
        bar('length = "280 mm"', 'length = "180 mm"'),
        ["singular position", "crank angle 180°", "two ways"],
        CAUTION,
    ),
    "mirror image": (
        bar('angle = "50 deg"', 'angle = "-50 deg"'),
        ["coupler from -50°", "mirror image?"],
        CAUTION,
    ),
}
