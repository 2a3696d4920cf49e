"""Identify parameters of a contact law from measured force over penetration: stiffness, exponent, and
restitution if unloading was measured.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import Fault, ModelError, VfifeError, suggestion
from ..laws import ContactLaw, Pair
from ..measures.impact import free_impact
from ..model.readers import read_law
from ..modelfile.paths import parsed
from ..results.fit import Fit, FitCurve
from ..schema import Measure, value_of
from ..studies.spec.distributions import sobol
from .measurements import csv_text, factor, numbers, split, table
from .parameters import FitParameter
from .step_uncertainty import confidence_of, fit_values

Array = NDArray[np.float64]
SURFACES = Pair(0.01, 2e-4, 0.02)  # those of `vfife laws`, for laws that need some
UNITS = {"penetration": "m", "force": "N", "loading": "N", "unloading": "N"}  # of columns
STIFFNESS_RANGE = 1e3  # ratio of the bounds of a stiffness to its first guess
LARGEST = 9e13  # bare number in a model
STARTS = 8
# Two searches agree if their costs differ by this share; a cost below the second one for each sample cannot
# be improved.
AGREEMENT, EXACT = 1e-4, 1e-6
RESTITUTION = "restitution"
# Of a slow curve: what acts by the rate alone has no effect.
STATIC = {"damping_coefficient": 0.0, "effective_mass": 1.0}
UNLOADING = 0.05  # of the largest penetration: a curve that comes back by less has no unloading
STEPS = 120  # of an impact, to its largest penetration
SPEED_CORRECTIONS = 3  # of the speed of an impact that goes as deep as the data


@dataclasses.dataclass(frozen=True)
class Loop:
    """Force over penetration (m, N) while the surfaces approach, and while they part; the latter may be
    empty.
    """

    loading: tuple[Array, Array]
    unloading: tuple[Array, Array]
    name: str = "curve"

    @property
    def deepest(self) -> float:
        """The largest penetration (m)."""
        return float(max(self.loading[0].max(), self.unloading[0].max(initial=0.0)))


def fit_law(
    law: str, data: str | Path | Loop, given: Mapping[str, Any] | None = None, *, pair: Pair = SURFACES,
    confidence: float = 0.95,
    seed: int = 0,
) -> Fit:  # fmt: skip
    """Fit a contact law to a measured curve: a CSV file with penetration and force in the order of
    measurement, or with the columns penetration, loading and unloading.

    Parameters that have no default, or that the law derives from the surfaces (a stiffness, an exponent), are
    identified, and with unloading the restitution: that of a free impact as deep as the data. ``given`` fixes
    parameters. Raises ModelError and VfifeError.
    """
    began = time.monotonic()
    loop = data if isinstance(data, Loop) else loop_of(Path(data))
    kind = law_of(law)
    holder = {
        "law": kind.name,
        **{key: parsed(value) if isinstance(value, str) else value for key, value in (given or {}).items()},
    }
    unloads = len(loop.unloading[0]) > 0
    if not unloads:
        holder = {
            name: value
            for name, value in (STATIC | {"full_damping_depth": 0.1 * loop.deepest}).items()
            if name in names_of(kind)
        } | holder
    parameters = law_parameters(kind, holder, loop, unloads)
    if not parameters:
        raise VfifeError(
            f'the law "{law}" has no parameter that this curve'
            f" determines{'' if unloads else ', without unloading'}; name another"
        )
    speeds = [1.0]
    scale = max(float(loop.loading[1].std()), 1e-300)
    measured = np.concatenate([loop.loading[1], loop.unloading[1]])

    def law_at(shares: Array) -> ContactLaw:
        values = {
            parameter.name: parameter.value(float(x)) for parameter, x in zip(parameters, shares, strict=True)
        }
        candidate, faults = read_law("contact", {**holder, **values})
        if candidate is None or not isinstance(candidate, ContactLaw):
            raise ModelError(faults, f'law "{law}"')
        return candidate

    def residuals(shares: Array) -> Array:
        left: Array = (forces(law_at(shares), pair, loop, speeds) - measured) / scale
        return left

    best, ends = best_search(residuals, parameters, seed)
    share = best.x
    parts = [part for part in np.split(best.fun, [len(loop.loading[0])]) if len(part) > 2]
    uncertainty = confidence_of(parts, parameters, share, best.jac, len(parameters), confidence)
    model = forces(law_at(share), pair, loop, speeds)
    return Fit(
        f"law {kind.name}", loop.name, "complete",
        fit_values(parameters, share, uncertainty.errors, uncertainty.limits, [True] * len(parameters)),
        uncertainty.correlation, uncertainty.directions,
        0.0, 0.0, "penetration", fit_curves(loop, model), ends, 0, 0,
        "differences", uncertainty.autocorrelation, confidence, time.monotonic() - began,
    )  # fmt: skip


def fit_curves(loop: Loop, model: Array) -> list[FitCurve]:
    """Return the measured and the computed forces (N), first of loading and then of unloading, if it was
    measured.
    """
    count = len(loop.loading[0])
    curves = [
        FitCurve("loading", "force", "N", "penetration", loop.loading[0], loop.loading[1], model[:count])
    ]
    if len(loop.unloading[0]):
        curves.append(
            FitCurve(
                "unloading", "force", "N", "penetration", loop.unloading[0], loop.unloading[1], model[count:]
            )
        )
    return curves


def names_of(law: type[ContactLaw]) -> set[str]:
    """Names of the parameters of a law."""
    return {field.name for field in dataclasses.fields(law)}


def law_of(law: str) -> type[ContactLaw]:
    """Return the law with this name. Raises VfifeError if there is none, or it is a table."""
    registry = ContactLaw.known()
    if law not in registry:
        raise VfifeError(f"there is no contact law {law!r}: {suggestion(law, registry, 'name one of them')}")
    if registry[law].tabled:  # type: ignore[attr-defined]
        raise VfifeError(
            'the law "table" takes measured points as they are: name the file in the model, loading ='
            ' "curve.csv"'
        )
    return registry[law]  # type: ignore[return-value]


def law_parameters(
    law: type[ContactLaw], fixed: Mapping[str, Any], loop: Loop, unloads: bool
) -> list[FitParameter]:
    """Return the parameters to identify: the fields without a default that are not fixed, and the restitution
    if unloading was measured. Each has bounds about a first guess.
    """
    parameters = []
    for field in dataclasses.fields(law):
        quantity = value_of(field)
        has_no_default = field.default is None or field.default is dataclasses.MISSING
        if (
            field.name in fixed
            or not isinstance(quantity, Measure)
            or not (has_no_default or (unloads and field.name == RESTITUTION))
        ):
            continue
        limits = (quantity.above if quantity.above is not None else quantity.low, quantity.high)
        if field.name == RESTITUTION or (limits[0] is not None and limits[1] is not None):
            low, high = limits[0] or 0.01, limits[1] or 1.0
        elif field.name == "stiffness":
            guess = float(loop.loading[1].max()) / loop.deepest ** exponent_of(law)
            wide = STIFFNESS_RANGE * (STIFFNESS_RANGE if "exponent" in names_of(law) else 1.0)
            low, high = guess / wide, min(guess * wide, LARGEST)
        elif unloads and field.name == "damping_coefficient":
            size = float(loop.loading[1].max())
            low, high = 1e-3 * size, 1e3 * size
        else:
            remedy = f"give it, as in --set {field.name}=..."
            raise VfifeError(
                f'the law "{law.name}" needs {field.name}, which a curve of force over penetration does not'
                f" determine; {remedy}"
            )
        unit = str(field.metadata.get("unit", "1"))
        parameters.append(FitParameter(field.name, (field.name,), unit, low, high))
    return parameters


def exponent_of(law: type[ContactLaw]) -> float:
    """Exponent of a law's force, from the unit of its stiffness; 1.5 if the exponent is a parameter."""
    unit = next(
        (
            str(field.metadata.get("unit", ""))
            for field in dataclasses.fields(law)
            if field.name == "stiffness"
        ),
        "",
    )
    text = unit.partition("^")[2]
    try:
        return float(text)
    except ValueError:
        return 1.0 if unit == "N/m" else 1.5


def best_search(
    residuals: Callable[[Array], Array], parameters: Sequence[FitParameter], seed: int
) -> tuple[Any, list[tuple[float, tuple[float, ...]]]]:
    """Return the best of searches from several starts, and the minima of all."""
    from scipy.optimize import least_squares

    minima = []
    for start in (np.full(len(parameters), 0.5), *sobol(STARTS, len(parameters), seed)):
        minimum = least_squares(
            residuals,
            np.clip(start, 1e-3, 0.999),
            bounds=(0.0, 1.0),
            diff_step=1e-5,
            xtol=1e-8,
            ftol=1e-8,
            max_nfev=40,
        )
        minima.append(minimum)
        minima.sort(key=lambda minimum: float(minimum.cost))
        exact = minima[0].cost <= EXACT * len(minima[0].fun)
        if exact or (len(minima) > 1 and minima[1].cost <= (1.0 + AGREEMENT) * minima[0].cost):
            break  # two searches came to one point, or one to the curve itself
    return minima[0], [
        (float(minimum.cost), tuple(float(s.value(x)) for s, x in zip(parameters, minimum.x, strict=True)))
        for minimum in minima
    ]


def forces(law: ContactLaw, pair: Pair, loop: Loop, speeds: list[float]) -> Array:
    """Compute the forces (N) of the law at the penetrations of a loop: elastic ones, or with unloading those
    of a free impact of the same depth.

    speeds: the speed (m/s) of the last impact, from which the search for the next speed starts;
        updated
    """
    if not len(loop.unloading[0]):
        p = law.parameters(pair)
        return np.array([law.force(max(float(depth), 0.0), 0.0, p)[0] for depth in loop.loading[0]])
    speed = speeds[0]
    impact = free_impact(law, pair, 1.0, speed, STEPS)
    for _ in range(SPEED_CORRECTIONS):
        if abs(impact.deepest / loop.deepest - 1.0) < 1e-6 or not impact.deepest > 0.0:
            break
        speed *= (loop.deepest / impact.deepest) ** (
            0.5 * (1.0 + max(law.exponent_at(0.5 * impact.deepest, pair), 1.0))
        )
        impact = free_impact(law, pair, 1.0, speed, STEPS)
    speeds[0] = speed
    turn = int(np.argmax(impact.penetration))
    up = np.interp(loop.loading[0], impact.penetration[: turn + 1], impact.force[: turn + 1])
    down = np.interp(loop.unloading[0], impact.penetration[turn:][::-1], impact.force[turn:][::-1])
    return np.concatenate([up, down])


def loop_of(path: Path) -> Loop:
    """Read a measured loop from a CSV file. Raises ModelError with all faults."""
    faults: list[Fault] = []
    heads, rows = table(csv_text(path, faults), faults)
    columns = {name.lower(): (k, unit) for k, (name, unit) in enumerate(map(split, heads))}
    chosen = {name: columns[name] for name in UNITS if name in columns}
    if not faults and ("penetration" not in chosen or not {"force", "loading"} & chosen.keys()):
        remedy = suggestion("penetration", columns, 'begin with a line such as "penetration (um), force (N)"')
        faults.append(
            Fault(
                "line 1", "a column is missing", ", ".join(heads), "penetration, and force or loading", remedy
            )
        )
    factors = {
        k: factor(unit, UNITS[name], f"line 1, column {k + 1}", faults) for name, (k, unit) in chosen.items()
    }
    values = numbers(rows, heads, sorted(factors), faults)
    if faults:
        raise ModelError(faults, str(path))
    columns_si = {name: factors[k] * values[k] for name, (k, _) in chosen.items()}
    depth, force = (
        columns_si["penetration"],
        columns_si["force"] if "force" in columns_si else columns_si["loading"],
    )
    if "unloading" in columns_si:
        return Loop((depth, force), (depth, columns_si["unloading"]), path.name)
    turn = int(np.argmax(depth))
    unloads = depth[turn:].min() < (1.0 - UNLOADING) * depth[turn]
    empty = np.zeros(0)
    loading = (depth[: turn + 1], force[: turn + 1]) if unloads else (depth, force)
    if not depth.max() > 0.0 or not force.max() > 0.0 or math.isclose(float(np.ptp(depth)), 0.0):
        raise ModelError(
            [
                Fault(
                    "data",
                    "there is no penetration",
                    "",
                    "penetrations and forces above 0",
                    "check signs and columns",
                )
            ],
            str(path),
        )
    return Loop(loading, (depth[turn:], force[turn:]) if unloads else (empty, empty), path.name)
