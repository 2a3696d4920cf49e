"""Inputs made up at random, many of each kind: model texts, ``--set``, quantities, run files, files of the
cache.

Of each it is known what may come of it: a mechanism that is written and read alike, a number, the bytes that
were written; or a fault in words, soon. Never a traceback, a number that is none, or another number than the
one that was written.
"""

from __future__ import annotations

import math
import os
import random
import time
import traceback
from collections.abc import Callable
from pathlib import Path

import numpy as np

import vfife
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime import cache
from vfife.errors import RunFileError, VfifeError
from vfife.modelfile import dump, loads
from vfife.store.runfile import RunFile
from vfife.units import number

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.toml"))
VALUES = (
    "0", "-1", "1e300", "-1e308", "1e-300", "5e-324", "nan", "inf", "-inf", "true", '""', '"[/]"', '"1 m"',
    '"1e400 m"', '"1 m^1e9"', "[]", "[0]", "[1e308, -1e308]", "[[0, 0], [0, 0]]", "{}", "{ law = 3 }",
    "9" * 400, '"' + "m/" * 200 + 's"', "1979-05-27", '"ground.O"', '"$\\\\frac{1$"',
    "0x7fffffffffffffff", "-0.0", '"auto"', '"2*pi rad/s"', '"(1+1)**9**9 m"', "[1, [2, [3, [4]]]]",
)  # fmt: skip
SIGNS = (0, 9, 34, 36, 91, 123, 233, 8238, 65279, 128169, 46, 61)
PLACES = (
    "joint.C.clearance", "run.step", "run.outputs", "body.coupler.length", "driver.crank.speed", "gravity",
    "name", "joint.C.kind", "run.turns", "joint.C.contact", "joint.C.contact.law", "body.coupler.elements",
    "body.coupler.model", "ground.A", "material.steel.density", "start.mode",
)  # fmt: skip
WORDS = (
    "1", "2.5", "-", "+", "*", "/", "^", "**", "(", ")", "pi", "e", "e9", " ", "m", "mm", "N", "kg", "s",
    "rad", "deg", "rpm", "Pa", "G", "%", "°", ".", "µ", "inf", "nan", "0", "9" * 30, "²", "·", "_", "m^1.5",
    "inch",
)  # fmt: skip
SOON = 10.0  # s; most take a thousandth, and a busy machine some more


def changed(text: str, chance: random.Random) -> str:
    """The text with some of its lines, values and signs changed."""
    lines = text.splitlines()
    for _ in range(chance.randint(1, 4)):
        k = chance.randrange(len(lines))
        kind = chance.randrange(6)
        if kind == 0 and "=" in lines[k]:
            lines[k] = f"{lines[k].partition('=')[0]}= {chance.choice(VALUES)}"
        elif kind == 1:
            lines[k] = ""
        elif kind == 2:
            lines.insert(k, chance.choice(lines))
        elif kind == 3 and lines[k]:
            at = chance.randrange(len(lines[k]))
            lines[k] = lines[k][:at] + chr(chance.choice(SIGNS)) + lines[k][at + 1 :]
        elif kind == 4 and "=" in lines[k]:  # another size, as by a wrong prefix
            lines[k] = (
                f"{lines[k].partition('=')[0]}="
                f" {chance.choice((1, -1)) * 10.0 ** chance.randint(-12, 12) * chance.randint(1, 9)!r}"
            )
        else:
            j = chance.randrange(len(lines))
            lines[k], lines[j] = lines[j], lines[k]
    return "\n".join(lines)


def meant(error: Exception) -> bool:
    """Whether an error is raised on purpose, with words: one of the package's own, or a ValueError from a
    line of it that raises.
    """
    last = traceback.extract_tb(error.__traceback__)[-1]
    own = (
        isinstance(error, ValueError) and "vfife" in last.filename and (last.line or "").startswith("raise ")
    )
    return bool(str(error).strip()) and (isinstance(error, VfifeError) or own)


def model_texts(count: int, seed: int, assembled: bool = False) -> int:
    """How many of so many texts were models; with ``assembled`` also put together, as vfife check does."""
    chance, models = random.Random(seed), 0
    texts = [path.read_text() for path in EXAMPLES]
    for _ in range(count):
        text = changed(chance.choice(texts), chance)
        began = time.process_time()
        try:
            mechanism = loads(text)
            models += 1
            assert dump(loads(dump(mechanism))) == dump(mechanism)
            if assembled:
                assembly = assemble(mechanism)
                assert np.isfinite(assembly.state).all() and 0.0 < assembly.choice.step < math.inf, text
        except Exception as error:
            if not meant(error):
                raise AssertionError(f"{type(error).__name__}: {error}; of the text\n{text}") from error
        assert time.process_time() - began < SOON, text
    return models


def overrides(count: int, seed: int) -> int:
    """How many of so many ``--set`` were taken."""
    chance, taken = random.Random(seed), 0
    text = EXAMPLES[[path.stem for path in EXAMPLES].index("four_bar_case_c")].read_text()
    for _ in range(count):
        path = chance.choice(PLACES)
        if chance.random() < 0.3:
            parts = path.split(".")
            parts[chance.randrange(len(parts))] = chance.choice(
                ("", "x", "0", "-1", "C", "crank", "[/]", "\x00", "\u202e", "law", "*")
            )
            path = ".".join(parts)
        value = (
            chance.choice(VALUES).strip('"')
            if chance.random() < 0.6
            else "".join(chance.choices(WORDS, k=chance.randint(1, 6)))
        )
        try:
            mechanism = loads(text, set=[(path, value)])
            taken += 1
            assert dump(loads(dump(mechanism))) == dump(mechanism)
        except VfifeError as error:
            assert str(error).strip(), (path, value)
        except Exception as error:
            raise AssertionError(f"{type(error).__name__}: {error}; of --set {path!r}={value!r}") from error
    return taken


def quantities(count: int, seed: int) -> int:
    """How many of so many texts were numbers with units: finite ones, and the same with spaces
    around them.
    """
    chance, numbers = random.Random(seed), 0
    for _ in range(count):
        text, unit = (
            "".join(chance.choices(WORDS, k=chance.randint(1, 7))),
            chance.choice(("m", "N", "s", "rad", "rad/s", "1", "N/m^1.5")),
        )
        try:
            value = number(text, unit)
        except VfifeError as error:
            assert str(error).strip(), text
            continue
        except Exception as error:
            raise AssertionError(
                f"{type(error).__name__}: {error}; of the quantity {text!r} in {unit}"
            ) from error
        assert math.isfinite(value) and number(f" {text} ", unit) == value, (text, unit, value)
        numbers += 1
    return numbers


def damage(whole: bytes, chance: random.Random) -> bytes:
    """Bytes with bits flipped, parts cut out, overwritten, doubled or exchanged, or the end missing."""
    data = bytearray(whole)
    for _ in range(chance.randint(1, 3)):
        at, size = chance.randrange(len(data)), chance.choice((1, 4, 100, 512, 4096))
        kind = chance.randrange(6)
        if kind <= 1:
            data[at] ^= 1 << chance.randrange(8)
        elif kind == 2:
            data[at : at + size] = chance.randbytes(min(size, len(data) - at))
        elif kind == 3:
            data[at : at + size] = bytes(min(size, len(data) - at))
        elif kind == 4:
            other = chance.randrange(len(data))
            data[at : at + size] = data[other : other + size]
        else:
            del data[max(at, 1) :]
    return bytes(data)


def run_files(count: int, seed: int, path: Path, changed: Path) -> int:
    """How many of so many damaged copies of a run file could be read; what they give is what was written, or
    is told to be missing.
    """
    chance, readable = random.Random(seed), 0
    whole = path.read_bytes()
    with RunFile.open(path) as file:
        (steps, rows), meta, last, events = file.outputs(), file.meta, file.last_checkpoint(), file.events
    at = {int(step): k for k, step in enumerate(steps)}
    for k in range(count):
        changed.write_bytes(damage(whole, chance))
        try:
            with RunFile.open(changed) as file:
                (some, own), said, state, noted, lost = (
                    file.outputs(),
                    file.meta,
                    file.last_checkpoint(),
                    file.events,
                    file.damaged_parts,
                )
        except RunFileError as error:
            assert str(error).strip()
            continue
        except Exception as error:
            raise AssertionError(
                f"{type(error).__name__}: {error}; of the damaged run file {k} of seed {seed}"
            ) from error
        assert np.array_equal(own, rows[[at[int(step)] for step in some]]) if len(some) else True, (k, seed)
        assert len(some) == len(steps) or lost, (k, seed)
        assert all(
            np.array_equal(value, meta[key]) if isinstance(value, np.ndarray) else value == meta[key]
            for key, value in said.items()
        ), (k, seed)
        assert set(said) == set(meta) or lost, (k, seed)
        assert state is None or last is None or state[0] != last[0] or np.array_equal(state[1], last[1]), (
            k,
            seed,
        )
        assert set(noted) <= set(events), (k, seed)
        readable += 1
    return readable


def results(count: int, seed: int, path: Path, changed: Path) -> int:
    """How many of so many damaged copies gave a result; its numbers are those of the whole one where nothing
    is said to be missing.
    """
    chance, whole, given = random.Random(seed), path.read_bytes(), 0
    measures = vfife.load_result(path).measures
    for k in range(count):
        changed.write_bytes(damage(whole, chance))
        try:
            result = vfife.load_result(changed)
            found = result.measures
        except VfifeError as error:
            assert str(error).strip()
            continue
        except Exception as error:
            raise AssertionError(
                f"{type(error).__name__}: {error}; of the damaged result {k} of seed {seed}"
            ) from error
        assert result.record.damaged_parts or found == measures, (k, seed)
        given += 1
    return given


def cached(count: int, seed: int, folder: Path) -> int:
    """How many of so many damaged files of the cache were read as if they were whole: those that are."""
    chance, same = random.Random(seed), 0
    name, content = f"step-{'0' * 40}.o", chance.randbytes(2000)
    cache.keep(name, content)
    whole = (folder / name).read_bytes()
    assert cache.read(name) == content
    for _ in range(count):
        data = damage(whole, chance)
        (folder / name).write_bytes(data)
        found = cache.read(name)
        assert found == (content if data == whole else None)
        same += found is not None
        if not (folder / name).exists():
            cache.keep(name, content)
    os.remove(folder / name) if (folder / name).exists() else None
    return same


FUZZERS: dict[str, Callable[..., int]] = {
    "model texts": model_texts,
    "overrides": overrides,
    "quantities": quantities,
}
