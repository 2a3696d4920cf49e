"""A case that is assembled in a batch has the bits that it has alone, whatever changes between the cases."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from choice import default_cases
from vfife import gallery
from vfife.errors import VfifeError
from vfife.kinematics.batch import Structures
from vfife.laws.contact import Hertz, LankaraniNikravesh, Liu, Pereira
from vfife.laws.elasticity import FEWEST_LAWS, on_arrays, tangent, tangents
from vfife.model.bodies import Section
from vfife.model.mechanism import Mechanism
from vfife.modelfile.parameter import Parameter
from vfife.studies.engine.cases import CaseModel, Cases
from vfife.studies.spec.plan import CaseSpec

# Mechanism, path, and factors of the base's value. Some factors leave links that cannot reach, journals that
# start too deep, an arm or a mass of zero, another branch, or another number of steps or corrections.
VARIED: tuple[tuple[str, str, tuple[float, ...]], ...] = (
    ("four_bar_case_b", "body.coupler.length", (1.0, 0.99, 1.02, 0.2, 1.5, 4.0, 0.999, 0.7)),
    ("four_bar_case_b", "body.coupler.angle", (1.0, 0.0, -1.0, 0.5, 3.0)),
    ("four_bar_case_b", "body.coupler.mass", (1.0, 1e-6, 1e3, 2.0, 0.0)),
    ("four_bar_case_b", "driver.crank.speed", (1.0, -1.0, 0.01, 30.0, 0.0)),
    ("four_bar_case_c", "joint.C.clearance", (1.0, 2.0, 100.0, 0.1)),
    ("compressor", "body.rod.length", (1.0, 1.01, 0.2, 0.3, 2.0, 0.99)),
    ("compressor", "body.rod.center_at", (1.0, 0.0, 3.0, 0.5)),
    ("compressor", "joint.big-end.clearance", (1.0, 3.0, 900.0, 0.5)),
    ("compressor", "body.piston.mass", (1.0, 0.1, 10.0)),
    ("elastic", "body.coupler.length", (1.0, 1.01, 0.98)),
    ("jansen_leg_loose", "body.crank.length", (1.0, 1.01, 0.99)),
    ("scotch_yoke", "body.crank.length", (1.0, 1.1)),
    ("slider_crank_loose_pin", "body.crank.length", (1.0, 1.1, 5.0, 0.9)),
    ("six_bar_press", "body.rod.length", (1.0, 1.01, 0.99)),
    ("quick_return", "body.crank.length", (1.0, 1.05, 3.0)),
    ("gear_train", "gear.first-stage.ratio", (1.0, 1.5, 3.0)),
)


def elastic() -> Mechanism:
    """A four-bar with a coupler of two frame elements and one loose joint."""
    base: Mechanism = gallery.four_bar_case_b()
    coupler: Any = base.bodies["coupler"]
    soft = dataclasses.replace(coupler, model="elastic", elements=2, section=Section.square(4e-4))
    return dataclasses.replace(base, bodies={**base.bodies, "coupler": soft})


def varied(name: str, path: str, factors: Sequence[float]) -> tuple[Mechanism, list[dict[str, float | str]]]:
    base = elastic() if name == "elastic" else getattr(gallery, name)()
    value = Parameter(base, path).get()
    return base, [{path: value * factor} for factor in factors]


def contents(result: Any) -> tuple[Any, ...]:
    """Everything that a case consists of, to be compared to the bit."""
    if not isinstance(result, CaseModel):
        return type(result), str(result)
    assembly = result.assembly
    parts = {
        field.name: getattr(assembly, field.name)
        for field in dataclasses.fields(assembly)
        if field.name not in ("state", "tables", "layout", "mechanism")
    }
    mechanism = dataclasses.replace(assembly.mechanism, source=None)
    recorded = result.plan.recorded.tolist(), result.plan.handed.tolist()
    return assembly.state.tobytes(), assembly.tables.tobytes(), parts, mechanism, result.reference, recorded


@pytest.mark.parametrize(
    "case",
    default_cases(
        VARIED,
        lambda one: one[0] in ("four_bar_case_b", "compressor") and "length" in one[1],
        "assembles mechanisms of many kinds",
    ),
)
def test_a_batch_is_its_cases_alone(case: tuple[str, str, Sequence[float]]) -> None:
    base, numbers = varied(*case)
    spec = CaseSpec(("*",), 1)
    results = Cases(base, spec).make_all(numbers)
    alone = [Cases(base, spec).make_all([own])[0] for own in numbers]
    assert [contents(one) for one in results] == [contents(one) for one in alone]
    # In another order, and among copies of itself, a case is the same.
    turned = Cases(base, spec).make_all(numbers[::-1] + numbers)
    assert [contents(one) for one in turned] == [contents(one) for one in [*alone[::-1], *alone]]


def test_lengths_of_a_four_bar_change_validity_and_steps() -> None:
    """So that the comparison above compares more than one kind of case."""
    base, numbers = varied(*VARIED[0])
    results = Cases(base, CaseSpec(("*",), 1)).make_all(numbers)
    faults = [one for one in results if isinstance(one, VfifeError)]
    steps = {one.assembly.choice.outputs_every for one in results if isinstance(one, CaseModel)}
    assert 0 < len(faults) < len(results) and len({*map(str, faults)}) == len(faults)
    assert len(steps) > 1


def test_structures_differ_in_kinds_signs_and_zeros_alone() -> None:
    base, structures = gallery.four_bar_case_b(), Structures()
    length, angle = Parameter(base, "body.coupler.length"), Parameter(base, "body.coupler.angle")

    def number(mechanism: Mechanism) -> tuple[int, ...]:
        return structures.mechanism(mechanism)

    assert number(length.set(0.3)) == number(base) == number(length.set(0.25))
    different = [base, angle.set(0.0), angle.set(-0.3), dataclasses.replace(base, gravity=(0.0, -9.81))]
    assert len({number(mechanism) for mechanism in different}) == len(different)


@pytest.mark.parametrize("restitution", [0.0001, 0.5, 1.0])
def test_tangents_side_by_side_are_those_one_by_one(restitution: float) -> None:
    rng = np.random.default_rng(3)
    law = LankaraniNikravesh(restitution=restitution)
    slots = [(float(k), law.damping_factor) for k in 10.0 ** rng.uniform(3.0, 14.0, 4 * FEWEST_LAWS)]
    forces = [float(f) for f in 10.0 ** rng.uniform(-12.0, 18.0, len(slots))]
    assert on_arrays(type(law), len(law.slots)) is not None
    expected = [tangent(law, own, force) for own, force in zip(slots, forces, strict=True)]
    assert tangents([law] * len(slots), slots, forces) == expected


def test_a_law_is_calculated_on_arrays_if_it_is_arithmetic() -> None:
    """As the operations of its step say, whatever version of Python compiled its text."""
    sides = {law: on_arrays(law, count) is not None for law, count in ((Hertz, 2), (Liu, 3), (Pereira, 3))}
    assert sides == {Hertz: True, Liu: True, Pereira: False}  # which chooses between two forms of contact
    liu, slots = Liu(), [(1e9 * k, 1e-4, 1.0) for k in range(1, FEWEST_LAWS + 1)]
    forces = [10.0**k for k in range(-2, FEWEST_LAWS - 2)]
    expected = [tangent(liu, own, force) for own, force in zip(slots, forces, strict=True)]
    assert tangents([liu] * len(slots), slots, forces) == expected
