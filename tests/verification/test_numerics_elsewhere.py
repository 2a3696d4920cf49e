"""The routines of ``vfife.numerics`` in code for other processors: the bits that they have here.

Code for AArch64 and for AVX-512 runs in emulated processors; that for a processor with no registers wider
than two numbers, and for AVX2, on any of today. Elimination, rotations and elementary functions are what
closes a mechanism, weighs it and finds its step, so a start is made there, too.
"""

from __future__ import annotations

import platform
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vfife
from emulated import arm, x86
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime import native
from vfife.compiler.runtime import native as compiling
from vfife.numerics import dense, elementwise, library, routine

pytestmark = pytest.mark.verify
X86 = platform.machine().lower() in ("x86_64", "amd64")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
OPTIMISED_CODE = native.optimised_code
HERE = {"baseline": "x86-64", "SSE4": "x86-64-v2", "AVX2": "x86-64-v3"}
AVX512 = "x86-64-v4"
SHAPES = [(1, 1), (3, 3), (7, 7), (12, 12), (13, 20), (20, 13), (24, 24)]
# What a compiler calls to fill or copy memory, which the emulated processor has no C library for.
MEMORY = """
define ptr @memset(ptr %to, i32 %value, i64 %count) {
  %byte = trunc i32 %value to i8
  br label %look
look:
  %k = phi i64 [ 0, %0 ], [ %next, %take ]
  %more = icmp ult i64 %k, %count
  br i1 %more, label %take, label %end
take:
  %place = getelementptr i8, ptr %to, i64 %k
  store i8 %byte, ptr %place
  %next = add i64 %k, 1
  br label %look
end:
  ret ptr %to
}
define ptr @memcpy(ptr %to, ptr %from, i64 %count) {
  br label %look
look:
  %k = phi i64 [ 0, %0 ], [ %next, %take ]
  %more = icmp ult i64 %k, %count
  br i1 %more, label %take, label %end
take:
  %source = getelementptr i8, ptr %from, i64 %k
  %byte = load i8, ptr %source
  %place = getelementptr i8, ptr %to, i64 %k
  store i8 %byte, ptr %place
  %next = add i64 %k, 1
  br label %look
end:
  ret ptr %to
}
"""


class Elsewhere:
    """Routines that are called at their addresses by an emulated processor."""

    def __init__(self, routine: Any, name: str, processor: Any) -> None:
        self.routine = routine
        address = routine.code.engine.get_function_address(f"entry_{name}")
        routine.function = lambda *arguments: processor.call(address, *arguments)
        processor.renewed()

    def __call__(self, *arguments: Any) -> None:
        self.routine(*arguments)


class Noted:
    """A routine that counts its calls."""

    def __init__(self, routine: Any) -> None:
        self.routine, self.calls = routine, 0

    def __call__(self, *arguments: Any) -> None:
        self.calls += 1
        self.routine(*arguments)


def routines(
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    head: str = "",
    machine: Any = None,
    change: Callable[[str], str] = str,
) -> dict[str, Any]:
    """All routines in code for a processor of this name, which no cache keeps."""
    monkeypatch.setattr(native, "processor", lambda: (name, ""))
    if machine is not None:
        monkeypatch.setattr(native, "machine", machine)
    monkeypatch.setattr(
        native, "optimised_code", lambda text, wide: OPTIMISED_CODE(head + change(text), wide)
    )
    monkeypatch.setattr(compiling.cache, "read", lambda file: None)
    monkeypatch.setattr(compiling.cache, "keep", lambda file, code: None)
    library.compiled.cache_clear()
    found = library.compiled()
    library.compiled.cache_clear()
    return found


@pytest.fixture
def code_for(monkeypatch) -> Iterator[Callable[..., None]]:
    """Has the routines run as code for another processor from then on."""

    def use(kind: str, change: Callable[[str], str] = str) -> None:
        if kind == "AArch64":
            head = (
                f'target triple = "{arm.TRIPLE}"\ntarget datalayout = "{arm.machine().target_data}"\n{MEMORY}'
            )
            processor = arm.processor()
            found = routines(monkeypatch, arm.NAME, head, arm.machine, change)
            found = {name: Elsewhere(one, name, processor) for name, one in found.items()}
        elif kind == "AVX-512":
            processor = x86.processor()
            found = routines(monkeypatch, AVX512, MEMORY, change=change)
            found = {name: Elsewhere(one, name, processor) for name, one in found.items()}
        else:
            found = routines(monkeypatch, HERE[kind], change=change)
        monkeypatch.undo()
        # Each routine notes its calls, so that a test which runs other code than it means fails.
        noted = {name: Noted(one) for name, one in found.items()}
        monkeypatch.setattr(routine, "_routines", lambda: noted)
        in_use.extend(noted.values())

    in_use: list[Noted] = []
    yield use
    library.compiled.cache_clear()
    assert any(one.calls for one in in_use), "no routine ran in the code for another processor"


def kinds() -> list[Any]:
    """Processors, and whether this machine can stand in for them."""
    off = pytest.mark.skipif(not X86, reason="asks for x86 processors")
    return ["AArch64", *(pytest.param(one, marks=off) for one in (*HERE, "AVX-512"))]


def answers() -> dict[str, bytes]:
    """What the routines come to for matrices and numbers of all sizes, to the bit."""
    rng = np.random.default_rng(7)
    found: dict[str, Any] = {}
    for rows, columns in SHAPES:
        a = (rng.random((2, rows, columns)) - 0.5) * (1.0 + 99.0 * rng.random((2, rows, 1)))
        b, shape = rng.random((2, columns)), f"{rows} x {columns}"
        found |= {f"svd {shape} {k}": one for k, one in enumerate(dense.svd(a))}
        found |= {f"qr {shape} {k}": one for k, one in enumerate(dense.qr(a))}
        found[f"times {shape}"], found[f"product {shape}"] = (
            dense.times(a, b),
            dense.product(a, np.swapaxes(a, -1, -2)),
        )
        if rows == columns:
            found[f"solve {shape}"] = dense.solve(a, b)
            found |= {
                f"eigh {shape} {k}": one for k, one in enumerate(dense.eigh(a + np.swapaxes(a, -1, -2)))
            }
            found[f"eigenvalue_sizes {shape}"] = dense.eigenvalue_sizes(a)
    x = np.concatenate([(rng.random(200) - 0.5) * 10.0**power for power in range(-6, 6)])
    with np.errstate(over="ignore"):
        found["sin"], found["cos"] = elementwise.sincos(x)
        found["exp"] = elementwise.exp(np.clip(x, -700.0, 700.0))
        found["log"], found["power"] = elementwise.log(np.abs(x)), elementwise.power(np.abs(x), 1.37)
        found["atan2"], found["hypot"] = elementwise.atan2(x, x[::-1]), elementwise.hypot(x, x[::-1])
    return {name: np.ascontiguousarray(one).tobytes() for name, one in found.items()}


@pytest.mark.parametrize("kind", kinds())
def test_routines_have_the_same_bits_in_code_for(kind, code_for):
    here = answers()
    code_for(kind)
    there = answers()
    assert [name for name in here if here[name] != there[name]] == []


@pytest.mark.parametrize("kind", kinds())
@pytest.mark.parametrize("name", ["four_bar_case_c", "slider_crank_loose_guide", "williams_toggle"])
def test_a_start_has_the_same_bits_in_code_for(kind, name, code_for):
    """Masses, the closed position, bounds of the step, tables."""
    mechanism = vfife.load_model(EXAMPLES / f"{name}.toml")
    here = assemble(mechanism)
    code_for(kind)
    there = assemble(mechanism)
    assert (here.state.tobytes(), here.tables.tobytes(), here.choice) == (
        there.state.tobytes(),
        there.tables.tobytes(),
        there.choice,
    )


@pytest.mark.parametrize(
    "kind",
    ["AArch64", pytest.param("AVX-512", marks=pytest.mark.skipif(not X86, reason="asks for x86 processors"))],
)
def test_a_fused_product_would_move_the_bits(kind, code_for):
    """What the tests above would see if the code were allowed it: the emulated processors have it."""
    here = answers()
    code_for(kind, lambda text: re.sub(r"\b(fmul|fadd|fsub) double", r"\1 contract double", text))
    there = answers()
    assert sum(here[name] != there[name] for name in here) > len(here) // 2
