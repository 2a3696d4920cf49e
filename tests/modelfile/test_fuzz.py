"""Model texts with anything in them: a mechanism, or faults in sentences, soon; never a traceback, and no number that is none."""

from __future__ import annotations

import random
import time
from pathlib import Path

import pytest

import vfife
from vfife.errors import VfifeError
from vfife.modelfile import dump, loads

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))
VALUES = (
    "0", "-1", "1e300", "-1e308", "1e-300", "5e-324", "nan", "inf", "-inf", "true", '""', '"[/]"', '"1 m"', '"1e400 m"', '"1 m^1e9"', "[]", "[0]",
    "[1e308, -1e308]", "[[0, 0], [0, 0]]", "{}", "{ law = 3 }", "9" * 400, '"' + "m/" * 200 + 's"', "1979-05-27", '"ground.O"', '"$\\\\frac{1$"',
    "0x7fffffffffffffff", "-0.0", '"auto"', '"2*pi rad/s"', '"(1+1)**9**9 m"', "[1, [2, [3, [4]]]]",
)  # fmt: skip


def changed(text: str, chance: random.Random) -> str:
    """The text with some of its lines, values and signs changed."""
    lines = text.splitlines()
    for _ in range(chance.randint(1, 4)):
        k = chance.randrange(len(lines))
        kind = chance.randrange(5)
        if kind == 0 and "=" in lines[k]:
            lines[k] = f"{lines[k].partition('=')[0]}= {chance.choice(VALUES)}"
        elif kind == 1:
            lines[k] = ""
        elif kind == 2:
            lines.insert(k, chance.choice(lines))
        elif kind == 3 and lines[k]:
            at = chance.randrange(len(lines[k]))
            lines[k] = lines[k][:at] + chr(chance.choice((0, 9, 34, 36, 91, 123, 233, 8238, 65279, 128169, 46, 61))) + lines[k][at + 1 :]
        else:
            j = chance.randrange(len(lines))
            lines[k], lines[j] = lines[j], lines[k]
    return "\n".join(lines)


def fuzz(count: int, seed: int) -> tuple[int, float]:
    """Reads so many texts: how many were models, and the longest that one took (s)."""
    chance, models, longest = random.Random(seed), 0, 0.0
    texts = [path.read_text() for path in EXAMPLES]
    for _ in range(count):
        text = changed(chance.choice(texts), chance)
        began = time.perf_counter()
        try:
            mechanism = loads(text)
        except VfifeError as error:
            assert str(error)
        else:
            models += 1
            assert dump(loads(dump(mechanism))) == dump(mechanism)
        longest = max(longest, time.perf_counter() - began)
    return models, longest


def test_changed_models_are_models_or_told() -> None:
    models, longest = fuzz(400, 1)
    assert 20 < models < 380 and longest < 5.0


@pytest.mark.soak
def test_a_hundred_thousand_of_them() -> None:
    models, longest = fuzz(100_000, 2)
    assert models and longest < 10.0


@pytest.mark.parametrize("value", VALUES)
def test_anything_may_be_set(value: str) -> None:
    """What --set gives, for a place of each kind."""
    path = EXAMPLES[0].parent / "four_bar_case_c.toml"
    for place in ("joint.C.clearance", "run.step", "run.outputs", "body.coupler.length", "driver.crank.speed", "gravity", "name", "joint.C.kind"):
        try:
            vfife.load_model(path, set=[(place, value.strip('"'))])
        except VfifeError as error:
            assert str(error)
