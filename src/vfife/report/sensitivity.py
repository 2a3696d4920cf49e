"""Documents on parameters: sensitivities, comparisons of laws, parameters identified from measured curves."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..measures.catalogue import unit_of
from ..measures.values import NOT_ESTIMATED
from ..numerics.outward import DOWN, UP, significant_range
from ..results.fit import NOT_DETERMINED
from .amounts import decimals, fixed_point, prefixed, quantities, quantity
from .design_words import and_words
from .document import Caution, Document, Paragraph, Part, Table, incomplete, paragraphs
from .fall_cautions import SEATED, fall_caution, fall_of

if TYPE_CHECKING:
    from ..measures.landings import Fall
    from ..results.derivatives import Effect, Sensitivity
    from ..results.fit import Fit, FitRecordValues, FitValue
    from ..studies.methods.compare import Comparison

SMALLEST = 1e-6  # per cent by one per cent: smaller effects are rounding
NEGLIGIBLE = 0.01  # share of the largest known effect: unknown effects that stay below it have no row
MEANINGLESS = 100.0  # per cent by one per cent: a range that reaches further says nothing
WIDE = 0.05  # share of the largest derivative of a measure: wider ranges get a note
CORRELATED, MOST_PAIRS = 0.5, 6
COMPARED = (  # numbers of a comparison: key, head, factor to the unit of the head, form without a range
    ("force", "force, N", 1.0, ",.6g"), ("lip_force", "change of F, %", 1.0, ".4g"),
    ("lip_acceleration", "change of a, %", 1.0, ".4g"), ("penetration", "deepest, µm", 1e6, ".4g"),
    ("impacts", "impacts", 1, ","), ("contact_share", "contact, %", 100.0, ".3g"),
)  # fmt: skip
# Loads in a comparison, and the change between laws from which on they are listed.
LOADS, CHANGED = (".force.max", ".moment.max", ".torque.max"), 0.05
# Remedies where no derivative was computed.
REMEDIES = (
    " More turns (--turns), vfife study over a range, or vfife design may answer; --companions 0 computes the"
    " derivatives of the run alone."
)
# Of the numbers of an interrupted answer.
UNCHECKED = "others are missing, and none is checked by finite changes or other steps."
NOTES = {
    "change": "* change for 1 %: the derivative does not describe it.",
    "unknown": (
        "? sign or order of magnitude not known: changes of 1 % differ with their direction or the size of"
        " the step, or changes of 0.1 % contradict them. These rows stand last, by the largest end of their"
        " range."
    ),
}


def sensitivity(result: Sensitivity, top: int = 8) -> Document:
    """Return a document of the ``top`` most influential parameters for each measure, and of as many whose
    influence is unknown and may be more than a hundredth of the largest.
    """
    rows: list[tuple[str, ...]] = []
    kinds: set[str] = set()
    for name, value in result.measures.items():
        if name in result.doubtful:
            rows.append((name, f"{value:.5g}", "not known: depends on the time step", "?", ""))
            continue
        effects = [
            effect for effect in result.effects(name) if max(abs(effect.low), abs(effect.high)) > SMALLEST
        ]
        unknown = [effect for effect in effects if effect.kind == "unknown"]
        effects = effects[: len(effects) - len(unknown)][:top]
        floor = NEGLIGIBLE * max((effect.size for effect in effects), default=0.0)
        effects += [effect for effect in unknown if effect.size > floor][:top]
        kinds |= {effect.kind for effect in effects}
        rows += [
            ((name, f"{value:.5g}") if k == 0 else ("", "")) + (effect.path, *effect_cells(effect))
            for k, effect in enumerate(effects)
        ]
    table = Table(("measure", "value", "number", "per cent by 1 %", "from, to"), rows, numbers=(1, 3, 4))
    texts = [
        f"Measures belong to the {result.part}, in SI units.",
        *(NOTES[kind] for kind in ("change", "unknown") if kind in kinds),
    ]
    blow: dict[str, Any] = {}
    if result.fall and (fallen := [name for name in result.measures if name in result.fall.measures]):
        blow["start_fall"] = {**dataclasses.asdict(result.fall), "measures": fallen}
        texts.insert(1, blow_of_start(result.fall, fallen))
    notes = (Caution(text, "note", aside=True) for text in _caveats(result))
    status = {} if result.complete else {"status": "interrupted"}
    left_out = {"refused": result.refused, "rounding": sorted(result.rounding)}
    data = {
        "model": result.mechanism,
        "part": result.part,
        **status,
        **blow,
        **left_out,
        "rows": result.rows(),
    }
    return Document(
        [*incomplete(result.progress, UNCHECKED), table, *paragraphs(texts), *notes],
        f"{result.mechanism}: what its measures depend on",
        data,
    )


def blow_of_start(fall: Fall, names: Sequence[str]) -> str:
    """Return a sentence on derivatives of measures that the fall of the journals at the start makes."""
    return (
        f"{', '.join(names)}: the value is that of the first {1e3 * fall.time:.3g} ms, in which the journals"
        f" of {and_words(list(fall.joints))} fall from the middle onto their bearings, and so are its"
        " derivatives: a machine that stands or runs has no such blow. Two turns or more of a crank leave it"
        f" out, and {SEATED} starts bearings without it."
    )


def _caveats(result: Sensitivity) -> list[str]:
    """Measures and parameters without a meaningful derivative, and wide ranges."""
    texts = []
    if result.doubtful:
        omitted, remedies = (", and none was computed", REMEDIES) if result.undetermined else ("", "")
        texts.append(
            f"runs with other time steps disagree on {', '.join(sorted(result.doubtful))}: derivatives of"
            f" these are meaningless{omitted}. A smaller --step may help, unless the motion is"
            f" chaotic.{remedies}"
        )
    if result.rounding:
        texts.append(
            "omitted as rounding errors relative to the largest value of their unit:"
            f" {', '.join(sorted(result.rounding))}."
        )
    wide = {
        name: spread
        for name in result.measures
        if name not in result.doubtful and (spread := result.spread(name)) > WIDE
    }
    if wide:
        widest = max(wide, key=wide.__getitem__)
        text = f"ranges of derivatives are up to {100.0 * wide[widest]:.0f} % of the largest wide ({widest})"
        texts.append(f"{text}: a smaller --step makes them narrower.")
    return texts + [
        f"{path}: {reason}" for path, reason in result.refused.items() if not reason.startswith("zero")
    ]


def effect_cells(effect: Effect) -> tuple[str, str]:
    """Return the value of an effect and its range; an empty range if both ends have the same digits."""
    span = (
        significant_range(effect.low, effect.high, 3)
        if effect.high > effect.low and len({f"{end:.3g}" for end in effect[2:]}) > 1
        else ""
    )
    if effect.kind == "unknown":
        return "?", span if max(abs(effect.low), abs(effect.high)) < MEANINGLESS else ""
    return f"{effect.value:+.3g}{' *' if effect.kind == 'change' else ''}", span


def comparison(result: Comparison, folder: str = "", files: Sequence[str] = ()) -> Document:
    """Return the document of one model under several laws; ``files`` are those in its ``folder``, if it has
    one.
    """
    rows = [
        (
            run["contact"],
            run["friction"],
            *(_number(run, key, scale, form) for key, _, scale, form in COMPARED),
            f"{run['energy_lost']:.4g}",
            f"{run['wall_s']:.2g}",
        )
        for run in result.rows
    ]
    heads = ("contact", "friction", *(head for _, head, _, _ in COMPARED), "lost, J", "wall, s")
    note = (
        f"Force and depth are the largest ({_part(result)}). Changes of F and a, LIP(F) and LIP(a), are the"
        " largest of a force and an angular acceleration by clearance, in per cent of those with ideal"
        " joints. Contact is the mean share of the time of the run."
    )
    parts: list[Part] = [
        *incomplete(result.progress, "the same comparison with its folder continues."),
        Table(heads, rows, numbers=range(2, 10), names=(0, 1)),
        *_ranges(result),
        Paragraph(note),
        *paragraphs(_fall(result)),
        *_loads(result),
        *([Paragraph(f"{folder} ({', '.join(files)})", lead="Folder: ")] if folder else []),
    ]
    title = f"{result.mechanism}: joint{'s' * (len(result.joints) > 1)} {', '.join(result.joints)}"
    return Document(parts, title, comparison_data(result) | {"folder": folder})


def _number(run: Mapping[str, Any], key: str, scale: float, form: str) -> str:
    """Return a number of a run; no digit is finer than its range."""
    if run[key] is None:
        return "-"
    value, width = scale * run[key], scale * (run.get(f"{key}.high", 0.0) - run.get(f"{key}.low", 0.0))
    if key == "impacts" or not 0.0 < width < math.inf:
        return format(value, form)
    return fixed_point(value, decimals(value, width))


def _ranges(result: Comparison) -> Iterator[Part]:
    """Yield the ranges of the numbers of all runs, and which numbers have none."""
    estimated = [entry for entry in COMPARED if any(f"{entry[0]}.low" in run for run in result.rows)]
    if not estimated:
        yield Paragraph(
            "Numerical uncertainty of these numbers: not estimated, because no run had companions."
            " Differences between laws may be errors of the step; --companions 3 (in Python companions=3)"
            " estimates them."
        )
        return
    rows = [
        (run["contact"], run["friction"], *(_range(run, key, scale) for key, _, scale, _ in estimated))
        for run in result.rows
    ]
    heads = ("contact", "friction", *(head for _, head, _, _ in estimated))
    yield Table(
        heads, rows, "Ranges by runs with other step sizes", numbers=range(2, len(heads)), names=(0, 1)
    )
    left = [
        head.split(",")[0] for key, head, _, _ in COMPARED if all(f"{key}.low" not in r for r in result.rows)
    ]
    yield Paragraph(f"Numerical uncertainty not estimated: {', '.join([*left, 'lost'])}.")


def loads_by_run(result: Comparison) -> dict[str, list[float | None]]:
    """Return the largest forces, moments and torques of each run, by measure: of the joints whose laws are
    compared, of all others, and of drivers.
    """
    names = dict.fromkeys(name for run in result.results for name in run.measures if name.endswith(LOADS))
    return {
        name: [float(run.measures[name]) if name in run.measures else None for run in result.results]
        for name in names
    }


def _loads(result: Comparison) -> Iterator[Part]:
    """Yield a table of the loads that the laws change by more than :data:`CHANGED`; no digit is finer than
    the range of a load.
    """
    rows = []
    for name, values in loads_by_run(result).items():
        finite = [value for value in values if value is not None]
        low, high, unit = min(finite), max(finite), unit_of(name)
        if high - low > CHANGED * high:
            widths = [getattr(run.measures.get(name), "width", 0.0) for run in result.results]
            cells = (
                "-" if value is None else prefixed(value, unit, max(1e-3 * high, width))
                for value, width in zip(values, widths, strict=True)
            )
            rows.append((name, *cells, f"{100.0 * (high - low) / high:.2g} %"))
    if rows:
        laws = [" ".join((run["contact"], run["friction"])) for run in result.rows]
        heads = ("load", *laws, "change")
        title = f"Loads that the laws change by more than {100.0 * CHANGED:g} %, of the largest"
        yield Table(heads, rows, title, numbers=range(1, len(heads)), names=(0,))
        yield Paragraph(
            "Only a measurement shows which law holds for a joint. A part that carries the largest value of"
            " its row carries the load by each of these laws; that by a law without damping may be several"
            " times the others, and the load of the machine may exceed them all."
        )


def _range(run: Mapping[str, Any], key: str, scale: float) -> str:
    """Return the range of a number of a run, rounded outwards to two digits of its width."""
    if f"{key}.low" not in run:
        return NOT_ESTIMATED
    low, high = scale * run[f"{key}.low"], scale * run[f"{key}.high"]
    if not high > low:
        return f"{low:,.6g}"
    places = decimals(max(abs(low), abs(high)), 0.1 * (high - low), significant=6, coarse_places=3)
    places = min(places, 0) if key == "impacts" else places
    # A change is not below -100 %, where hundreds or thousands would begin it.
    first = max(places, -2) if key.startswith("lip") else places
    return f"{fixed_point(low, first, DOWN)} to {fixed_point(high, places, UP)}"


def comparison_data(result: Comparison) -> dict[str, Any]:
    """Return a comparison as data."""
    return {
        "model": result.mechanism,
        "joints": list(result.joints),
        "planned": result.planned,
        "runs": result.rows,
        "loads": loads_by_run(result),
    }


def _fall(result: Comparison) -> list[str]:
    """Return a sentence on each run whose largest forces are those of the fall at the start."""
    sentences = []
    for row, run in zip(result.rows, getattr(result, "results", ()), strict=False):
        assembly = run.record.assembly
        if not run.record.static and (fall := fall_of(run)):
            text = fall_caution(fall, assembly.mechanism, assembly.choice.turn is not None)
            sentences.append(f"{row['contact']} with {row['friction']}: {text}")
    return sentences


def _part(result: Comparison) -> str:
    """Return the part of the runs over which measures are taken."""
    parts = list(dict.fromkeys(run["part"] for run in result.rows))
    return (
        parts[0]
        if len(parts) == 1
        else "; ".join(f"{run['contact']} with {run['friction']}: {run['part']}" for run in result.rows)
    )


def identification(fit: Fit) -> Document:
    """Return a document of identified values, residuals of each curve, and parameters that the data cannot
    determine.
    """
    rows = []
    for value in fit.values:
        sure = all(map(math.isfinite, value.ends or (value.low, value.high)))
        limits = quantities(value.low, value.high, value.unit) if sure and value.known else "-"
        error = quantity(value.error, value.unit) if math.isfinite(value.error) else "-"
        if value.exceeds_bounds:
            error, limits = "-", NOT_DETERMINED
        bounds = quantities(*value.bounds, value.unit, exact=True) + (", at one" if value.at_bound else "")
        mark = "" if value.determined or not sure else " ?"
        rows.append(
            (
                value.name,
                quantity(value.value, value.unit) + mark,
                error,
                limits if value.known else "not known",
                bounds,
            )
        )
    curves = [
        (
            c.channel,
            f"{c.record}, {c.head}" if c.record else c.head,
            f"{100.0 * c.share:.3g} %",
            "" if c.factor == 1.0 else f"{c.factor:.4g}",
            f"{c.level:.4g}" if c.level else "",
        )
        for c in fit.curves
    ]
    confidence = f"{100.0 * fit.confidence:g} % confidence"
    parts: list[Part] = [
        *incomplete(fit.progress, "values have no errors, and another search may end elsewhere."),
        Table(("parameter", "value", "±, 1 σ", confidence, "bounds"), rows, numbers=(1, 2)),
        Table.numeric(("curve", "column", "left", "factor", "level"), curves, texts=2),
        *(
            [Table(("record", "left", "of its own"), [record_row(record) for record in fit.records])]
            if fit.records
            else []
        ),
        *paragraphs([_ends(fit), _correlations(fit)]),
        *(Caution(f"{text}.", "not determined", aside=True) for text in (*fit.undetermined, *fit.splits)),
        *paragraphs(fit.remarks),
        *(Caution(f"{text}.", "note", aside=True) for text in fit.notes),
    ]
    return Document(parts, f"{fit.mechanism} fitted to {fit.data}", fit.json())


def _ends(fit: Fit) -> str:
    """Return from where to where parameters whose confidence is not known fit nearly as well."""
    parts = []
    for value in (*fit.values, *(value for record in fit.records for value in record.values)):
        if value.ends:
            span = quantities(value.ends[0], value.ends[1], value.unit)
            parts.append(f"{value.name} fits nearly as well from {span}")
    return f"Confidence is not known: {'; '.join(parts)}; values outside may fit, too." if parts else ""


def record_row(record: FitRecordValues) -> tuple[str, str, str]:
    """Return a record, what is left of it, and its own numbers with their errors."""
    values = (
        f"{value.name} = {quantity(value.value, value.unit)}{_error(value)}"
        + (" (at a bound)" if value.at_bound else "")
        for value in record.values
    )
    return record.name, f"{100.0 * record.residual:.3g} %", ", ".join(values)


def _error(value: FitValue) -> str:
    """Return the error of a number of a record, as it stands behind it."""
    if value.exceeds_bounds:
        return f" ({NOT_DETERMINED})"
    return f" ± {quantity(value.error, value.unit)}" if math.isfinite(value.error) else " (error not known)"


def _correlations(fit: Fit) -> str:
    """Return the strongest correlations between parameters."""
    pairs = [
        (fit.correlation[i, j], a.name, b.name)
        for i, a in enumerate(fit.values)
        for j, b in enumerate(fit.values)
        if i < j
    ]
    strong = [
        f"{a} and {b} {value:+.2f}"
        for value, a, b in sorted(pairs, key=lambda pair: -abs(pair[0]))
        if abs(value) >= CORRELATED
    ]
    return f"Correlated: {'; '.join(strong[:MOST_PAIRS])}." if strong else ""
