"""Values of options: the model with its changes, quantities with units, and settings of a run."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import Fault, LawError
from ..laws.user import load_laws
from ..schema import Measure, Value
from ..units import assignments, is_bare, unit_fault
from .options import LengthOptions, ModelOptions
from .signals import ENDING
from .terminal import tell

if TYPE_CHECKING:
    from ..model.mechanism import Mechanism

COMMA = re.compile(r",(?![^(]*\))")  # none within brackets


def overrides(texts: Iterable[str] | None) -> list[tuple[str, str]]:
    """Return paths and values of ``--set``."""
    return list(assignments("--set", texts, 'joint.C.clearance="0.5 mm"'))


def separated(texts: Iterable[str] | None, mechanism: Mechanism) -> list[str]:
    """Return the names of an option that is repeated, or has several with commas between them.

    Commas in the brackets of a function do not count, and none do where a name of the model has one.
    """
    parts = (mechanism.bodies, mechanism.joints, mechanism.springs, mechanism.gears, mechanism.loads)
    if any("," in name for group in (*parts, mechanism.drivers, mechanism.points) for name in group):
        return list(texts or ())
    names = [name.strip() for text in texts or () for name in COMMA.split(text)]
    return [name for name in names if name]


def take_laws(files: Iterable[Path] | None) -> list[str]:
    """Load the files of ``--laws`` and return the names of the laws that they define."""
    names: list[str] = []
    for file in dict.fromkeys(files or ()):
        try:
            names += [law.name for law in load_laws(file)]
        except LawError as error:
            raise ValueError(f"--laws {error}") from None
    return names


def read_model(path: Path, texts: Iterable[str] | None, laws: Iterable[Path] | None = None) -> Mechanism:
    """Return the mechanism of a model file with the values of ``--set`` and the laws of ``--laws``."""
    from ..modelfile import load

    take_laws(laws)
    return load(path, set=overrides(texts))


def value_of_option(name: str, field: Value, text: Any) -> Any:
    """Return the value of an option by the type of a field, a bare number in SI units. Raises ValueError."""
    try:
        return field.take(text, written=True)
    except Fault as fault:
        raise ValueError(str(Fault(f"{name} {text}", fault.what, "", fault.limit, fault.remedy))) from None


def positive(name: str, text: str | None, unit: str) -> Any:
    """Return a quantity above zero of an option; None stays None."""
    return None if text is None else value_of_option(name, Measure(unit, above=0.0), text)


def clearance_limit(text: str | None, mechanism: Mechanism) -> Any:
    """Return the length (m) of ``--clearance``, the limit of a worn clearance; None stays None. Raises
    ValueError for a number without a unit that is far from the clearances of the model.
    """
    length = positive("--clearance", text, "m")
    sizes = [joint.clearance for joint in mechanism.clearances.values() if joint.clearance]
    if fault := unit_fault("--clearance", text, "m", max(sizes, default=None), "the largest clearance"):
        raise ValueError(str(fault))
    return length


def force_limit(text: str | None, mechanism: Mechanism) -> Any:
    """Return the force (N) of ``--force``; None stays None. Raises ValueError for a number without a unit
    that is far from the forces of the ideal mechanism.
    """
    force = positive("--force", text, "N")
    if text is not None and is_bare(text):
        from ..simulation.start import examination

        largest = max(examination(mechanism).expected.values(), default=None)
        if fault := unit_fault("--force", text, "N", largest, "the largest force of the ideal mechanism"):
            raise ValueError(str(fault))
    return force


def with_options(mechanism: Mechanism, options: LengthOptions, **settings: Any) -> Mechanism:
    """Return the mechanism with the run settings of the options (None: not given), so that its model file is
    that of the run.
    """
    from ..solvers.arguments import SHARED, RunArguments

    texts = {name: getattr(options, name) for name in ("step", "turns", "duration", "companions")} | settings
    texts = {name: text for name, text in texts.items() if text is not None}
    if {"turns", "duration"} <= texts.keys():
        raise ValueError("--turns and --duration exclude each other; give one of them")
    if str(texts.get("companions", "")).isdecimal():
        texts["companions"] = int(texts["companions"])
    values = {name: value_of_option(f"--{name}", SHARED[name], text) for name, text in texts.items()}
    return RunArguments(**values).in_settings(mechanism)


def mechanism_of(options: ModelOptions) -> Mechanism:
    """Return the mechanism of the model file with the values of ``--set`` and the laws of ``--laws``, and
    print the cautions about it, which answers of :func:`read_model` contain.
    """
    mechanism = read_model(options.model, options.set_, options.laws)
    tell_cautions(mechanism)
    return mechanism


def tell_cautions(mechanism: Mechanism) -> None:
    """Print the cautions about the numbers and connections of a mechanism on standard error."""
    from ..assembly.missing_joints import missing_joints
    from ..model.validation.plausibility import contradictions, suspects

    for caution in (*missing_joints(mechanism), *suspects(mechanism), *contradictions(mechanism)):
        tell("warning", caution)
        ENDING.cautions.append(caution)
