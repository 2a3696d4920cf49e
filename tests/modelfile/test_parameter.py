"""A value of a model by its path: read, changed, described."""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from model_texts import FOUR_BAR
from vfife.errors import Fault, ModelError
from vfife.modelfile import dump, load, loads
from vfife.modelfile.parameter import Parameter, holds, numbers, with_values
from vfife.modelfile.read import line_at, lines_of
from vfife.modelfile.write import tables_of

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_numbers_are_those_of_the_text(path: Path) -> None:
    mechanism = load(path)
    assert tables_of(mechanism) == tomllib.loads(dump(mechanism))
    for name, value in numbers(mechanism).items():
        one = Parameter(mechanism, name)
        assert (one.path, one.get()) == (name, value)


def test_a_number_set_in_an_object_is_one_that_was_read() -> None:
    mechanism = loads(FOUR_BAR)
    for name, value in numbers(mechanism).items():
        if value:
            changed = Parameter(mechanism, name).set(0.99 * value)
            assert changed == loads(dump(mechanism), [(name, 0.99 * value)]), name


def test_a_parameter_describes_itself() -> None:
    gap = Parameter(loads(FOUR_BAR), "joint.coupler-follower.clearance")
    assert (gap.path, gap.unit, gap.limits, gap.get()) == ("joint.C.clearance", "m", "above 0 m", 2e-4)
    assert gap.set("0.5 mm").clearances["C"].clearance == 5e-4
    turns = Parameter(tomllib.loads(FOUR_BAR), "run.turns")
    assert turns.set(3).settings.turns == 3.0
    assert Parameter(loads(FOUR_BAR), "run.outputs").limits == "a whole number from 1 to 100000000"


def test_a_parameter_has_the_default_of_the_file() -> None:
    raw = tomllib.loads(FOUR_BAR)
    raw["joint"]["C"]["contact"] = {"law": "pereira"}
    for path, default in (
        ("run.outputs", 720), ("run.step", "auto"), ("joint.C.clearance", None),
        ("joint.C.contact.law", "lankarani-nikravesh"),
        ("joint.C.contact.restitution", 0.9), ("gravity", (0.0, 0.0)),
    ):  # fmt: skip
        found = Parameter(raw, path).default
        assert found == default, (path, found)
    assert Parameter(loads(FOUR_BAR), "joint.C.contact.restitution").default == 0.9


def test_a_parameter_knows_its_line(tmp_path: Path) -> None:
    text = FOUR_BAR
    file = tmp_path / "four_bar.toml"
    file.write_text(text, encoding="utf-8")
    lines = text.splitlines()
    mechanism = load(file)
    gap = Parameter(mechanism, "joint.C.clearance")
    assert lines[(gap.line or 0) - 1].startswith("clearance") and "[joint.C]" in lines[: gap.line]
    assert Parameter(loads(text), "joint.C.clearance").line is None
    assert lines[(Parameter(mechanism, "joint.C.axial_length").line or 0) - 1] == "[joint.C]"


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_key_has_its_line(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    lines, written = lines_of(text), text.splitlines()

    def keys(value: object, at: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
        for key, inner in value.items() if isinstance(value, dict) else ():
            yield from keys(inner, (*at, key)) if isinstance(inner, dict) else [(*at, key)]

    for key in keys(tomllib.loads(text)):
        assert str(key[-1]) in written[(line_at(lines, key) or 0) - 1], key


def test_lines_of_a_text_with_strings_and_lists_over_several_lines() -> None:
    text = '''# a = 1
name = "x = 1 # no [table]"
note = """
[joint.A]
b = 2 """
[body."my bar"]
pins = [ # one
  [0.0, 1.0],
  ["]", '[']
]
"a.b".c = 3
'''
    expected = {
        ("name",): 2,
        ("note",): 3,
        ("body", "my bar"): 6,
        ("body", "my bar", "pins"): 7,
        ("body", "my bar", "a.b", "c"): 11,
    }
    assert lines_of(text) == expected


def test_a_fault_of_a_file_has_its_line_and_one_that_was_set_has_none() -> None:
    text = FOUR_BAR.replace('clearance = "', 'clearance = "-')
    with pytest.raises(ModelError) as refused:
        loads(text, file="bar.toml")
    line = next(number for number, one in enumerate(text.splitlines(), 1) if one.startswith('clearance = "-'))
    assert refused.value.faults[0].line == line and str(refused.value).startswith(
        f"bar.toml, line {line}, [joint."
    )
    with pytest.raises(ModelError) as refused:
        loads(FOUR_BAR, [("joint.C.clearance", -1)], file="bar.toml")
    assert refused.value.faults[0].line is None and str(refused.value).startswith(
        "bar.toml, [joint.C] clearance (given by set)"
    )


def test_many_values_of_a_parameter_are_set_at_once() -> None:
    mechanism = loads(FOUR_BAR)
    for path, values in (
        ("joint.C.clearance", [1e-4, "0.3 mm"]),
        ("material.steel.density", [7000.0, 7500.0]),
    ):
        parameter = Parameter(mechanism, path)
        assert parameter.set_many(values) == [parameter.set(value) for value in values]
    first, second = Parameter(mechanism, "joint.C.clearance").set_many([1e-4, 3e-4])
    assert first.bodies is second.bodies is mechanism.bodies
    with pytest.raises(ModelError, match="has 2 faults"):
        Parameter(mechanism, "joint.C.clearance").set_many([-1.0, 1e-4, "1 kg"])


def test_several_values_are_set_together() -> None:
    mechanism = loads(FOUR_BAR)
    found = with_values(
        mechanism, {"joint.C.clearance": "0.5 mm", "material.steel.density": 7000, "body.crank.mass": 2.0}
    )
    assert found.clearances["C"].clearance == 5e-4
    assert found == loads(
        FOUR_BAR, [("joint.C.clearance", 5e-4), ("material.steel.density", 7000), ("body.crank.mass", 2.0)]
    )
    assert found != mechanism


def test_a_value_that_cannot_be_is_refused() -> None:
    mechanism = loads(FOUR_BAR)
    with pytest.raises(ValueError, match="negative"):
        Parameter(mechanism, "joint.C.clearance").set("-1 mm")
    with pytest.raises(ModelError, match="negative"):
        Parameter(mechanism, "material.steel.density").set(-1.0)
    with pytest.raises(Fault, match="clearance"):
        Parameter(mechanism, "joint.C.clearence")
    with pytest.raises(Fault, match="not a number"):
        Parameter(mechanism, "joint.C.contact").read(1.0)


def test_numbers_of_shared_materials_and_other_values_are_held_by_no_object() -> None:
    mechanism = loads(FOUR_BAR)
    assert holds(mechanism, "joint.C.clearance", 2e-4)
    assert not holds(mechanism, "joint.C.clearance", 3e-4)
    assert not holds(mechanism, "material.steel.density", 7800.0)
    assert not holds(dataclasses.replace(mechanism, joints={}), "joint.C.clearance", 2e-4)


@pytest.mark.parametrize("path", ["velocity.0", "velocity.2", "position.1"])
def test_elements_of_lists_exist_where_the_model_has_the_default(path: str) -> None:
    """As paths of objects and of tables: both give the same mechanism."""
    mechanism = loads(FOUR_BAR)
    key, place = path.split(".")
    changed = Parameter(mechanism, f"body.coupler.{path}").set(0.25)
    assert changed == loads(dump(mechanism), [(f"body.coupler.{path}", 0.25)])
    values = getattr(changed.bodies["coupler"], key)
    assert values == tuple(0.25 * (k == int(place)) for k in range(len(values)))
    assert Parameter(mechanism, f"body.coupler.{path}").unit == (
        "rad/s" if path == "velocity.2" else "m/s" if key == "velocity" else "m"
    )


def test_a_list_without_an_element_of_a_number_is_refused() -> None:
    with pytest.raises(Fault, match="body.coupler.velocity is a list of 3"):
        Parameter(tables_of(loads(FOUR_BAR)), "body.coupler.velocity.3")
    assert Parameter(loads(FOUR_BAR), "body.coupler.velocity").elements == [
        f"body.coupler.velocity.{k}" for k in range(3)
    ]
