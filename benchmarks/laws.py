"""What each normal contact law costs in a step of the generated loop, relative to Lankarani and Nikravesh's;
and the polynomial power.
"""

from __future__ import annotations

import ctypes
import dataclasses
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from limit import COMPILER
from measure import HERE, Options, Part, interleaved, table

from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.native import compiled
from vfife.compiler.runtime.runner import Runner
from vfife.compiler.trace.source import Gathered
from vfife.kernels.elementary import log, power
from vfife.laws import ContactLaw, Frictionless
from vfife.model.mechanism import Mechanism, StartSettings
from vfife.solvers.record import recorded_rows

LIBRARY = HERE / "limit" / "library.c"
REFERENCE = "lankarani-nikravesh"
LANES = (1, 4)
# Parameters without a default, by their names.
MEASURED = tuple((1e-6 * k, 1e9 * (1e-6 * k) ** 1.5) for k in range(9))  # m, N
GIVEN = {
    "stiffness": 1e9,
    "exponent": 1.5,
    "damping_coefficient": 1e3,
    "full_damping_depth": 1e-5,
    "loading": MEASURED,
}


def law_of(law: type[ContactLaw]) -> ContactLaw:
    """A law with its defaults, and a value for what has none."""
    needed = (field.name for field in dataclasses.fields(law) if field.default is dataclasses.MISSING)
    return law(**{name: GIVEN[name] for name in needed})  # type: ignore[arg-type]


def journal(law: ContactLaw) -> Mechanism:
    """A journal that lies in its bearing: in contact at every step, and nothing else to compute."""
    m = Mechanism("journal in bearing", gravity=(0.0, -9.81), start=StartSettings(journals="seated"))
    m.point("O", 0.0, 0.0)
    m.point_mass("journal", mass=1.0)
    m.clearance_joint(
        "J",
        "ground.O",
        "journal.center",
        clearance=2e-4,
        bearing_radius=0.01,
        contact=law,
        friction=Frictionless(),
    )
    return m


def stepping(law: ContactLaw, lanes: int, steps: int) -> Callable[[], float]:
    """Runs so many steps of the generated loop; ns per step and simulation."""
    a = assemble(journal(law), 1e-7, duration=1e-3, force_step=True)
    runner = Runner(
        a.topology,
        np.repeat(a.state[:, None], lanes, axis=1),
        np.repeat(a.tables[None, :], lanes, axis=0),
        "generated",
        recorded_rows(a),
    )
    runner.advance(10, 1)

    def run() -> float:
        began = time.perf_counter()
        runner.advance(steps, 1)
        return 1e9 * (time.perf_counter() - began) / steps / lanes

    return run


def library(folder: Path) -> dict[str, Callable[..., object]]:
    """The C library's power and logarithm over many values; empty without a C compiler."""
    if shutil.which(COMPILER) is None:
        return {}
    path = folder / "library.so"
    subprocess.run(
        [COMPILER, "-O3", "-march=native", "-shared", "-fPIC", str(LIBRARY), "-o", str(path), "-lm"],
        check=True,
    )
    loaded = ctypes.CDLL(str(path))
    calls: dict[str, Callable[..., object]] = {}
    for name, function in (("power", loaded.many_powers), ("log", loaded.many_logarithms)):
        function.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_long]
        function.restype = None
        calls[name] = lambda x, n, out, function=function: function(x.ctypes.data, n, out.ctypes.data, len(x))
    return calls


def elementary(
    x: np.ndarray, exponent: float, theirs: dict[str, Callable[..., object]]
) -> dict[str, Callable[[], float]]:
    """ns for one value of x**exponent by our polynomial, the C library and NumPy, and of our logarithm and
    the C library's.
    """
    out = np.zeros_like(x)
    gathered = Gathered()
    gathered.add(power)
    gathered.add(log)

    def timed(call: Callable[[], Any]) -> Callable[[], float]:
        def run() -> float:
            began = time.perf_counter()
            call()
            return 1e9 * (time.perf_counter() - began) / len(x)

        call()
        return run

    runs: dict[str, Callable[[], float]] = {}
    for name, text in (("power", "power(x[k], n)"), ("log", "log(x[k])")):
        body = (
            f"@jit\ndef many(x, n, out):\n    for k in range(len(x)):\n        out[k] = {text}\n   "
            " return 0\n"
        )
        many = compiled(f"{gathered.text()}\n\n{body}", "many", "f1 d f1")
        runs[name] = timed(lambda many=many: many(x, exponent, out))  # type: ignore[misc]
    for name, call in theirs.items():
        runs[f"{name}, C library"] = timed(lambda call=call: call(x, exponent, out))  # type: ignore[misc]
    runs["power, NumPy"] = timed(lambda: np.power(x, exponent, out=out))
    return runs


def measure(options: Options) -> Part:
    """All laws in one run, in turn, so that what slows the machine slows all alike."""
    part = Part()
    steps, rounds = (
        4000,
        30 if options.quick else 300,
    )  # short and many: each meets a quiet moment of the machine
    laws = {name: law_of(law) for name, law in sorted(ContactLaw.registry.items())}  # type: ignore[arg-type]
    best = interleaved(
        rounds, {(name, lanes): stepping(law, lanes, steps) for name, law in laws.items() for lanes in LANES}
    )  # type: ignore[misc]
    ratio = {(name, lanes): best[name, lanes] / best[REFERENCE, lanes] for name, lanes in best}  # type: ignore[index,misc,str-unpack]
    rows = [
        (name, *(value for n in LANES for value in (best[name, n], ratio[name, n])))
        for name in sorted(laws, key=lambda k: ratio[k, 1])
    ]
    heads = [head for n in LANES for head in (f"ns, {n} lane{'s' * (n > 1)}", "ratio")]
    part.tables.append(table("A step with one contact, per simulation", "law", *heads, rows=rows))
    for n in LANES:
        slowest = max(laws, key=lambda name: ratio[name, n])
        part.ratios[f"laws.slowest_{n}_lane{'s' * (n > 1)}"] = ratio[slowest, n]
        part.notes.append(f"slowest law in {n} lane{'s' * (n > 1)}: {slowest}")
    rng = np.random.default_rng(1)
    x = 10.0 ** rng.uniform(-9, -4, 100_000)
    with tempfile.TemporaryDirectory() as folder:
        times = interleaved(rounds, elementary(x, 0.1834, library(Path(folder))))
    error = max(abs(power(float(v), 0.1834) / float(v) ** 0.1834 - 1.0) for v in x[:20_000])
    part.tables.append(table("One value", "function", "ns", rows=sorted(times.items())))
    part.notes.append(
        f"largest relative difference between the polynomial power and the C library's: {error:.2g}"
    )
    if "power, C library" in times:
        part.ratios["laws.power_to_library"] = times["power"] / times["power, C library"]
    part.measured = {
        "ns_per_step": {f"{name}, {n}": value for (name, n), value in best.items()},
        "ns_per_value": times,
        "power_error": error,
    }  # type: ignore[misc]
    return part
