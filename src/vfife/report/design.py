"""Document of a design question: conclusion, a table of joints, cautions and the next commands."""

from __future__ import annotations

import math
from collections.abc import Iterator
from shlex import quote
from typing import TYPE_CHECKING, Any

from ..laws.materials import EXAMPLE_COEFFICIENT, EXAMPLE_LUBRICATION
from ..measures.catalogue import COUNTS_KEY, LAST, counts_of, differentiable, is_reduction
from ..measures.wear import SIDES
from ..model.surfaces import body_of, surface_words
from ..numerics.outward import DOWN, UP, rounded
from .amounts import percent, prefixed, quantities, turns_words
from .cautions import rebound_cautions
from .design_words import (
    MISSING,
    UNKNOWN,
    and_words,
    default_limit_words,
    difference_words,
    effect_difference,
    effect_range,
    effect_words,
    end,
    life_cautions,
    life_range,
    life_sentence,
    missing_parts,
    quantity_of,
    reference_words,
    sentence,
    words,
)
from .digits import NOT_DETERMINED
from .document import Bullets, Document, Facts, Figure, Paragraph, Part, Section, Table
from .fall_cautions import fall_remark
from .fits import fit_cautions, fit_sentence, fits_data
from .pages import model_parts
from .study import no_blows
from .trust import settling_options

if TYPE_CHECKING:
    from ..assessment.answer import Design, JointDesign, Life

IMPACT_MEASURES = (".approach_speed.max", ".impacts", ".impact_power.mean")
NO_LAW_CAUTION = "no caution says that the contact law decides this measure."
NO_MATTER = (
    1.0  # %; a clearance that changes the measure by no more over its tolerance does not matter for it
)
EQUAL = 0.02  # of an effect: clearances whose effects differ by less matter equally
SCATTERED = 0.01  # of a value: a larger difference between nearly equal machines is stated
# An example of a table of wear, with the coefficient of a bearing and of a journal.
TABLE = "wear = {{ bearing = {}, journal = {} }}"


def document(design: Design, model: str = "MODEL.toml") -> Document:
    """Return the answer on one page; ``model``: the file in the commands of the next steps."""
    answer, *remainder = sections(design, model)
    return Document([Section(answer.title, [*answer.parts, *remainder])], title(design), data(design))


def report(design: Design, model: str, drawing: Figure) -> Document:
    """Return the answer as a report: a drawing of the mechanism, the answer, its inputs and the model."""
    answer, *remainder = sections(design, model)
    mechanism = design.mechanism
    inputs = [Facts(list(request(design))), *model_parts(mechanism, mechanism.source)]
    first = Section(answer.title, [drawing, *answer.parts])
    return Document([first, *remainder, Section("Inputs", inputs)], title(design), data(design))


def title(design: Design) -> str:
    """Return the title of the answer."""
    return f"{design.name}: clearances, fits, life"


def request(design: Design) -> Iterator[tuple[str, str]]:
    """Yield what was asked, by name."""
    yield "Measure", f"{design.measure}, {words(design.measure)}"
    share = f"in {100.0 * design.share:g} % of machines"
    origin = f", {default_limit_words(design)}" if design.default_limit else ""
    yield "Limit", f"{quantity_of(design, design.limit)} {share}{origin}"
    averaged = f", means over the last {design.averaged}" if design.averaged > 1 else ""
    if counts_of(design.measure) == LAST:
        averaged = f", counted over the last{f' {design.averaged}' if design.averaged > 1 else ''}"
    yield "Turns", f"{design.turns} in each run{averaged}"
    if design.costs:
        yield "Relative costs", f"{design.costs} of a hole or a shaft"
    end_of_life = design.end_clearance
    yield "End of a life", "twice the clearance" if end_of_life is None else prefixed(end_of_life, "m")
    if design.wear is not None:
        for name, joint in design.wear.mechanism(0).contacts.items():
            if wear := joint.wear:
                sides = (
                    f"{surface_words(body_of(joint, side), side)} {getattr(wear, side)}" for side in SIDES
                )
                yield f"Wear of {name}", f"{', '.join(sides)} (1/Pa)"


def sections(design: Design, model: str) -> list[Section]:
    """Return conclusion, cautions and next steps."""
    heads = (
        "joint", "clearance", "larger by", "effect", "from, to", "rank correlation", "from, to", "ISO fit",
        "clearance of the fit", "life, turns", "from, to",
    )  # fmt: skip
    caption = f"Effect of a larger clearance on {words(design.measure)}, fits, lives"
    rows = [row(design, joint) for joint in design.joints]
    used = [k for k, cells in enumerate(zip(*rows, strict=True)) if any(cells)]
    fit = used.index(heads.index("ISO fit"))
    table = Table(
        [heads[k] for k in used], [tuple(cells[k] for k in used) for cells in rows], caption, names=(0, fit)
    )
    parts: list[Part] = [Paragraph(text) for text in (*interruption(design), *conclusion(design))]
    parts.append(table)
    return [
        Section("Conclusion", parts),
        Section("Cautions", [Bullets(list(cautions(design)))]),
        Section("Next steps", [Bullets(list(next_steps(design, model)))]),
    ]


def row(design: Design, joint: JointDesign) -> tuple[str, ...]:
    """Return the row of a joint."""
    life, limits = joint.life, joint.limits
    clearance = quantities(*limits, "m", exact=True) if limits else ""
    lasts = MISSING
    if life is not None:
        turns = turns_words(life.turns) if life.determined else NOT_DETERMINED
        lasts = turns if math.isfinite(life.turns) else "no wear"
    span = "" if life is None else life_range(life)
    effect, span_of_effect = effect_cells(design, joint)
    if not unknown(joint) and joint.effect and (difference := effect_difference(design, joint.effect)):
        effect = f"{effect}, {difference}"
    growth = f"+{prefixed(joint.growth, 'm')}" if effect else ""
    return (
        joint.name, prefixed(joint.clearance, "m"), growth, effect, span_of_effect,
        *rank_cells(design, joint), joint.fit or fit_reason(design, joint), clearance, lasts, span,
    )  # fmt: skip


def effect_cells(design: Design, joint: JointDesign) -> tuple[str, str]:
    """Return the effect of more clearance and its range, also of one whose sign is not known; nothing where
    clearances are ranked instead and no effect has a range.
    """
    effect = joint.effect
    if effect is None or not has_range(joint):
        return ("" if design.ranks and not any(map(has_range, design.joints)) else UNKNOWN), ""
    return UNKNOWN if unknown(joint) else effect_words(design, effect), effect_range(design, effect)


def rank_cells(design: Design, joint: JointDesign) -> tuple[str, str]:
    """Return the rank correlation with the clearance and its range, where clearances are ranked."""
    if joint.rank is None or not shows_ranks(design):
        return "", ""
    return f"{joint.rank.value:+.2f}", rank_range(joint.rank.low, joint.rank.high)


def rank_range(low: float, high: float) -> str:
    """Return the range of a rank correlation, its ends rounded outwards."""
    return f"{rounded(low, 2, DOWN):+.2f} to {rounded(high, 2, UP):+.2f}"


def shows_ranks(design: Design) -> bool:
    """Return whether clearances are ranked by correlation: the effect of one at least is not known, or has
    the other sign than its rank correlation.
    """
    return any(unknown(joint) or contradicted(joint) for joint in design.joints)


def unknown(joint: JointDesign) -> bool:
    """Return whether the effect of a larger clearance is not known."""
    return joint.effect is None or joint.effect.kind == "unknown"


def has_range(joint: JointDesign) -> bool:
    """Return whether the effect of a larger clearance has a range: its sign may still be unknown."""
    return joint.effect is not None and math.isfinite(joint.effect.high - joint.effect.low)


def contradicted(joint: JointDesign) -> bool:
    """Return whether the rank correlation over the fits has visibly the other sign than the effect."""
    if unknown(joint) or joint.effect is None or joint.rank is None:
        return False
    return joint.rank.visible and joint.rank.value * joint.effect.value < 0.0


def fit_reason(design: Design, joint: JointDesign) -> str:
    """Return why a joint has no fit, in two words."""
    if joint.name not in design.letters:
        return "as in the model" if design.mechanism.contacts[joint.name].nominal_size else "no fit"
    if design.allocation is not None:
        return "none"
    return "not computed"


def conclusion(design: Design) -> Iterator[str]:
    """Yield sentences: which clearance matters, which fits keep the limit, which joint wears first; over
    which turns knocks are counted.
    """
    yield clearance_sentence(design)
    yield fit_sentence(design)
    yield life_sentence(design)
    yield from count_sentence(design)


def count_sentence(design: Design) -> Iterator[str]:
    """Yield over which turns contacts are counted, for a measure of them."""
    subject, turns = sentence(words(design.measure)), f"{design.turns} turns of each machine"
    if counts_of(design.measure) == LAST:
        begin = design.turns - design.averaged + 1
        part = f"turn {begin}" if begin == design.turns else f"turns {begin} to {design.turns}"
        yield (
            f"{subject} is that of {part} of the {turns}: contacts at the start of a run, where the"
            " journals fall onto their bearings, are not counted (vfife run states the hardest knock there)."
        )
    elif not differentiable(design.measure):
        yield f"{subject} is that of all {turns}, the fall of the journals at their start included."


def clearance_sentence(design: Design) -> str:
    """Return which clearance matters most: of those whose effects are all known, and none contradicts the
    rank correlation over the fits; that none matters where each changes little.
    """
    certain = [joint for joint in design.joints if not unknown(joint)]
    uncertain = [joint.name for joint in design.joints if joint not in certain]
    subject = f"{words(design.measure)} {reference_words(design)}"
    opposite = [joint.name for joint in certain if contradicted(joint)]
    if not opposite and (text := indifference(design, subject)):
        return text
    if not certain:
        return ranking_sentence(design, subject)
    decisive = max(certain, key=lambda joint: abs(joint.effect.value) if joint.effect else 0.0)
    value, span = effect_cells(design, decisive)
    growth, name = prefixed(decisive.growth, "m"), decisive.name
    beginning = f"The clearance of {name} matters most: {growth} more"
    if equals := equal_joints(certain, decisive):
        beginning = (
            f"The clearances of {and_words(equals)} matter most, about equally: {growth} more of {name}"
        )
    if uncertain or opposite:
        beginning = f"{growth} more clearance of {name}"
    ends = [f"the effect of {and_words(uncertain)} is {UNKNOWN}"] if uncertain else []
    if opposite:
        ends.append(
            "which clearance matters most is not known, because over the fits the rank correlation with"
            f" {and_words(opposite)} has the other sign"
        )
    if opposite and design.sample is not None and design.sample.count:
        ends[-1] += ": over these machines it lies between {} and {}".format(*machine_range(design))
    change = f"{value} ({span})"
    if decisive.effect and (difference := effect_difference(design, decisive.effect)):
        change += f", {difference}"
    change += f" at clearances of {neighbour_words(decisive)}"
    return f"{'; '.join([f'{beginning} changes {subject} by {change}', *ends])}."


def neighbour_words(joint: JointDesign) -> str:
    """Return the least and the largest clearance of the machines that an effect comes from."""
    return quantities(joint.clearance - joint.growth, joint.clearance + joint.growth, "m", exact=True)


def equal_joints(joints: list[JointDesign], decisive: JointDesign) -> list[str]:
    """Return the joints whose effects are as large as that of the ``decisive`` one, which is one of them,
    within their ranges or :data:`EQUAL`; none where no other is.
    """
    if decisive.effect is None:
        return []
    smallest_size = (1.0 - EQUAL) * min(abs(decisive.effect.low), abs(decisive.effect.high))
    names = [
        joint.name
        for joint in joints
        if joint.effect and max(abs(joint.effect.low), abs(joint.effect.high)) >= smallest_size
    ]
    return names if len(names) > 1 else []


def indifference(design: Design, subject: str) -> str:
    """Return that no clearance matters, if none changes the measure by more than :data:`NO_MATTER` over its
    tolerance, and machines within the limits of the fits (those that rank, without fits) differ by no more.

    The effect of a growth of the clearance is continued as a line over the width of the tolerance; without a
    fit it is that of the growth. A coordinate is compared with its difference from the ideal mechanism.
    """
    unit = 0.01 * design.scale if design.by_difference else 1.0
    changes = []
    for joint in design.joints:
        width = joint.limits[1] - joint.limits[0] if joint.limits else 0.0
        size = (
            max(abs(joint.effect.low), abs(joint.effect.high))
            if joint.effect and has_range(joint)
            else math.inf
        )
        changes.append(size * max(1.0, width / joint.growth))
    values, allowed = design.values_within_limits.tolist(), 0.01 * NO_MATTER * design.scale
    if not values and design.sample is not None and design.sample.count:
        values = list(design.sample.span)
    if max(changes) > NO_MATTER * unit or (values and max(values) - min(values) > allowed):
        return ""
    parts = {True: "over the tolerance of its fit", False: "with the larger clearance of the table"}
    kinds = {joint.limits is not None for joint in design.joints}
    over = " or ".join(text for fitted, text in parts.items() if fitted in kinds)
    single = f"The clearance of {design.joints[0].name} does not matter for {subject}: it"
    beginning = single if len(changes) == 1 else f"None of the clearances matters for {subject}: each"
    largest = percent(math.ceil(100.0 * max(changes)) / 100.0)
    if design.by_difference:
        largest = difference_words(max(changes), design.unit, 0.1 * max(changes), UP)
    return f"{beginning} changes it by at most {largest} {over}."


def ranking_sentence(design: Design, subject: str) -> str:
    """Return which clearance matters most by rank correlation, where no effect of a small change is known."""
    reason = design.missing.get("sensitivity")
    ranks = sorted(design.ranks.items(), key=lambda pair: -abs(pair[1].value))
    if not ranks:
        if reason:
            return f"Which clearance matters is {UNKNOWN}: {end(reason)}"
        reason = "runs with slightly different clearances or time steps disagree even on its sign"
        return f"No clearance has a known effect on {subject}: {reason}."
    machines = f"{design.sample.count if design.sample else 0:,} machines"
    visible = [(name, rank) for name, rank in ranks if rank.visible]
    low, high = machine_range(design)
    if not visible:
        return (
            f"No clearance visibly affects {subject}: its rank correlations with all of them over {machines}"
            f" include 0, and in these machines it varies from {low} to {high}."
        )
    name, first = visible[0]
    sure_size = min(abs(first.low), abs(first.high))
    ties = [rival for rival, rank in ranks[1:] if max(abs(rank.low), abs(rank.high)) > sure_size]
    text = (
        f"The clearance of {name} matters most for {subject}: their rank correlation over {machines} is"
        f" {first.value:+.2f} ({rank_range(first.low, first.high)})"
    )
    sign = ", less with more clearance" if first.value < 0.0 else ""
    rivals = f", but {and_words(ties)} may matter as much" if ties else ""
    return (
        f"{text}{sign}{rivals}. In these machines, whose clearances vary from the finest to the coarsest fit,"
        f" it lies between {low} and {high}."
    )


def machine_range(design: Design) -> tuple[str, str]:
    """Return the least and largest value of the measure over the machines that rank the clearances."""
    low, high = design.sample.span if design.sample else (None, None)
    return quantity_of(design, low), quantity_of(design, high)


def interruption(design: Design) -> Iterator[str]:
    """Yield which parts of an interrupted answer are missing; the life may be there in part."""
    if not design.complete:
        missing = f": {missing_parts(design)}" if design.missing else ""
        yield f"The computation was interrupted: parts are missing{missing}."


def cautions(design: Design) -> Iterator[str]:
    """Yield what the numbers assume."""
    yield from value_cautions(design)
    yield from effect_cautions(design)
    if design.allocation is not None:
        yield from fit_cautions(design, design.allocation)
    if design.wear is not None:
        yield from life_cautions(design, design.wear)


def value_cautions(design: Design) -> Iterator[str]:
    """Yield how the measure of a machine is taken and whether it repeats."""
    answer = design.sensitivity
    if design.sensitive:
        subject = "Runs with other time steps" if answer is not None else "Machines that hardly differ"
        yield (
            f"{subject} disagree on {words(design.measure)}: the motion is sensitive, and fits"
            " keep the limit for the turns that were simulated; more turns (--turns) increase the certainty."
        )
    if design.measure.endswith(IMPACT_MEASURES):
        yield no_blows(design.measure)
    yield from rebound_cautions(design.mechanism, [design.measure])
    if design.measure.endswith((".force.max", ".torque.max")):
        yield "The page has no knocks and no cautions of these machines: vfife run states both."
        if design.law_caution is not None:
            yield f"In a run of the model: {design.law_caution or NO_LAW_CAUTION}"
    low, high = design.nominal_range or (0.0, 0.0)
    if design.nominal is not None and high - low > SCATTERED * design.scale:
        yield (
            f"The value with the clearances of the model, {quantity_of(design, design.nominal)}, is the mean"
            f" of machines whose clearances differ by 0.02 %, which have {quantity_of(design, low)} to"
            f" {quantity_of(design, high)}."
        )
    if not differentiable(design.measure):
        return  # the conclusion has the turns
    begin, subject = design.turns - design.averaged + 1, sentence(words(design.measure))
    if design.averaged > 1:
        verb = "that of" if is_reduction(design.measure) else "the mean over"
        yield f"{subject} is {verb} turns {begin} to {design.turns} of each machine."
    elif design.turns == 1:
        yield (
            f"{subject} is that of the first turn of each machine, which begins with the start of the run."
            f" {fall_remark(design.mechanism, True)}".rstrip()
        )


def effect_cautions(design: Design) -> Iterator[str]:
    """Yield what effects and rank correlations mean."""
    if shows_ranks(design) and design.ranks:
        machines = design.sample.count if design.sample else 0
        yield (
            "Rank correlations are partial (the effect of the other clearances is removed), with 95 %"
            f" confidence, over {machines} machines whose clearances vary from the finest to the"
            " coarsest fit; +1 or -1 means that the clearance alone decides."
        )
    if any(map(has_range, design.joints)):
        yield (
            'An effect is that of a clearance larger by the column "larger by", the mean over five clearances'
            " from so much less than in the model to that of the model. Its range covers these five and two"
            f" time steps; clearances elsewhere may have another effect. It is {UNKNOWN} if its sign differs"
            " among the five."
        )
        if reason := design.missing.get("sensitivity"):
            yield f"Derivatives do not confirm these effects: {end(reason)}"
    elif design.sensitivity is not None:
        yield (
            f"Effects of larger clearances are {UNKNOWN}: runs with slightly different clearances or time"
            " steps disagree on them."
        )
    elif reason := design.missing.get("sensitivity"):
        yield f"Effects of small changes are {UNKNOWN}: {end(reason)}"


def next_steps(design: Design, model: str) -> Iterator[str]:
    """Yield commands that go further."""
    if len(design.values_within_limits) and (largest := design.clearances_of_largest):
        changes = " ".join(
            f"--set {quote(f'joint.{name}.clearance={1e6 * size:.6g} um')}" for name, size in largest.items()
        )
        command = f"vfife run {quote(model)} --turns {design.turns} {changes}"
        yield f"{command}   (cautions of the machine with the largest value)"
    if shows_ranks(design):
        options = settling_options(design.turns)
        yield f"vfife run {model} {options}   (does the motion repeat? then: vfife design --turns N)"
    if not design.measure.endswith(IMPACT_MEASURES):
        first = next(iter(design.mechanism.contacts))
        contact = f"{first}.1" if design.mechanism.contacts[first].is_guide else first
        command = f"vfife design {quote(model)} --of {quote(f'{contact}.approach_speed.max')}"
        yield f"{command}   (the same for knocks, which this page does not have)"
    if differentiable(design.measure) and not is_reduction(design.measure) and not design.sensitive:
        command = f"vfife sensitivity {quote(model)} --of {quote(design.measure)}"
        yield f"{command}   (the effect of all other numbers)"
    else:
        yield (
            f'vfife study STUDY.toml   (other numbers: model = "{model}", measures = ["{design.measure}"]'
            f"{f', {COUNTS_KEY}' if counts_of(design.measure) == LAST else ''} and a table [vary])"
        )
    yield "vfife study allocate STUDY.toml   (own costs, letters and tolerances; 99 % of machines)"
    if not (joint := design.joint_to_wear):
        yield f"vfife wear {model} --turns 1e7   (profiles of worn surfaces, force over life)"
        return
    aim = "For lives" if design.wear is None else "For vfife wear, which shows worn profiles and forces"
    trial = f", or try one for all: vfife design {model} --wear {EXAMPLE_COEFFICIENT.split()[0]}"
    example = "" if design.wear else f" ({EXAMPLE_LUBRICATION})"
    yield (
        f"{aim}: add {wear_table(design)}{example} with the coefficients of your materials (vfife materials)"
        f" below [joint.{joint}] and other joints of {model}{'' if design.wear else trial}"
    )


def wear_table(design: Design) -> str:
    """Return an example of a table of wear, with the coefficients that were simulated."""
    contacts = {} if design.wear is None else design.wear.mechanism(0).contacts
    wear = next((joint.wear for joint in contacts.values() if joint.wear), None)
    sides = (EXAMPLE_COEFFICIENT,) * 2 if wear is None else (wear.bearing, wear.journal)
    return TABLE.format(*(f'"{side}"' if isinstance(side, str) else f'"{side:g} 1/Pa"' for side in sides))


def data(design: Design) -> dict[str, Any]:
    """Return the answer as data, in SI units; effects in per cent, those on coordinates in SI units."""
    joints = {
        joint.name: {
            "clearance": joint.clearance,
            "growth": joint.growth,
            "effect": None if joint.effect is None else joint.effect._asdict(),
            "fit": joint.fit,
            "fit_clearance": joint.limits,
            "life": None if joint.life is None else life_data(design, joint.life),
            "rank": None if joint.rank is None else joint.rank._asdict(),
        }
        for joint in design.joints
    }
    return {
        "model": design.name, "status": "complete" if design.complete else "interrupted",
        "measure": design.measure, "value": design.value, "ideal": design.ideal,
        "effect_unit": design.unit if design.by_difference else "%", "limit": design.limit,
        "default_limit": design.default_limit, "share": design.share, "joints": joints, **fits_data(design),
        "missing": dict(design.missing), "conclusion": list(conclusion(design)),
    }  # fmt: skip


def life_data(design: Design, life: Life) -> dict[str, Any]:
    """Return a life as data."""
    return {**life._asdict(), "hours": life.turns * design.turn / 3600.0}
