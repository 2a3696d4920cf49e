"""The straight-line step of one topology, in one or more lanes, written from the trace of the data-driven loop."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from ..kernels.arrays import PARTICLE, Layout
from ..kernels.polynomial import polynomial
from ..kernels.step import argument
from ..kernels.topology import ALONG, FREE, TIME, Topology
from .graph import tables
from .schedule import Line, woven
from .source import Gathered, data_driven
from .trace import Rows, Symbol, Tape, either, text, traced


def known_rows(topology: Topology, layout: Layout) -> dict[int, float]:
    """Rows whose value follows from the topology: what never moves, and what a body without arms does not feel."""
    known: dict[int, float] = {}
    free, driven, armed, bound = set(topology.free), set(topology.driven), set(topology.trig), set(topology.bound)
    for i in range(topology.particles):
        base = layout.record("particle", i)
        if i in bound:
            known |= {base + getattr(PARTICLE, name): 0.0 for name in ("vu", "vv", "vw", "s", "sn")}
            known |= {base + getattr(PARTICLE, name): 1.0 for name in ("c", "cn")}
        if topology.weightless:
            known |= {base + getattr(PARTICLE, name): 0.0 for name in ("load_x", "load_y", "load_m")}
        if i not in free:
            known |= {base + getattr(PARTICLE, name): 0.0 for name in ("inverse_mass", "inverse_inertia", "u", "v", "ax", "ay")}
        if i not in free | driven:
            known |= {base + getattr(PARTICLE, name): 0.0 for name in ("x", "y", "theta", "w", "aw", "xn", "yn", "tn")}
    if topology.weightless:
        known |= {layout.row(f"driven_weight_{axis}", k): 0.0 for k in range(len(topology.driven)) for axis in "xy"}
    known |= _on_particles(topology, layout, armed)
    return known


def _on_particles(topology: Topology, layout: Layout, armed: set[int]) -> dict[int, float]:
    """Arms of joints and springs that are zero because the particle itself is the pin; offsets of joints that have none."""
    known: dict[int, float] = {}
    pairs = (
        ("contact", "bearing"),
        ("contact", "journal"),
        ("joint", "bearing"),
        ("joint", "journal"),
        ("spring", "first"),
        ("spring", "second"),
    )
    for kind, side in pairs:
        for joint, body in enumerate(getattr(topology, f"{kind}_{side}")):
            if body not in armed and body != 0:
                known |= {layout.row(f"{kind}_{side}_{axis}", joint): 0.0 for axis in "xy"}
    for joint, (place, turn) in enumerate(topology.held):
        if place != ALONG and turn == FREE:
            known[layout.row("joint_offset", joint)] = 0.0
    return known


def trace(topology: Topology) -> tuple[list[Line], dict[int, str], str]:
    """Lines of one step, the name to store in each row after it, and the condition under which it is left to the data-driven loop."""
    integers, layout, _ = tables(topology)
    tape = Tape()
    space = traced(data_driven(topology.contact_laws, topology.friction_laws), tape)
    rows = Rows(tape, known_rows(topology, layout), set(layout.of("state", "memory", "extreme")))
    space["step"](rows, [int(value) for value in integers], Symbol(tape, "n"), False)
    stores = rows.stores()
    rare: Any = False
    for condition in tape.rare:
        rare = either(rare, condition)
    lines = tape.needed([*stores.values(), rare])
    return lines, {row: text(value) for row, value in stores.items()}, text(rare) if tape.rare else ""


def _preparation(topology: Topology, layout: Layout, lanes: int) -> list[str]:
    """Functions, evaluated before the lanes: a search in a table is no straight line."""
    if not topology.function_start:
        return []
    out = [f"for w in range({lanes}):", f"    dt = S[{layout.row('step') * lanes} + w]"]
    for f, start in enumerate(topology.function_start):
        value, rate, second, after = (layout.row(f"function_{name}", f) * lanes for name in ("value", "rate", "acceleration", "next"))
        table = f"w * (len(T) // {lanes}) + {start}"
        kind, x = _argument(topology, layout, lanes, f)
        out.append(f"    S[{value} + w], S[{rate} + w], S[{second} + w] = polynomial(T, {table}, {x})")
        following = f"polynomial(T, {table}, (n + 1) * dt)[0]" if kind == TIME else f"S[{value} + w]"
        out.append(f"    S[{after} + w] = {following}")
    return out


def _argument(topology: Topology, layout: Layout, lanes: int, f: int) -> tuple[int, str]:
    """Kind and text of what a function depends on: ``argument`` of the data-driven loop, spelled out."""
    kind, *bodies = topology.function_argument[f] if topology.function_argument else (TIME, 0, 0)
    i, j = (layout.record("particle", p) for p in bodies)
    return kind, argument(_Spelled(lanes), kind, i, j, _Text("n * dt"), _Text("dt")).text


class _Text:
    """A number of the run as the text that it is in one lane."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __add__(self, other: _Text) -> _Text:
        return _Text(f"({self.text} + {other.text})")

    def __sub__(self, other: _Text) -> _Text:
        return _Text(f"({self.text} - {other.text})")

    def __mul__(self, other: _Text) -> _Text:
        return _Text(f"({self.text} * {other.text})")

    def __rmul__(self, other: float) -> _Text:
        return _Text(f"({other!r} * {self.text})")


class _Spelled:
    """The array S, each row by the name it goes by in a lane."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes

    def __getitem__(self, row: int) -> _Text:
        return _Text(f"S[{row * self.lanes} + w]")


@lru_cache(maxsize=32)
def straight_line(topology: Topology, lanes: int) -> str:
    """Text with ``advance(S, T, n0, count, done, out, kept, extremes, spare)`` for S of shape ((rows + 1) * lanes,) and n0 + done > 0.

    It returns the number of steps done, short of all where the next one must be taken by the data-driven loop.
    """
    if topology.path_unit != 1:
        raise ValueError("path units of several steps use the data-driven loop")
    lines, stores, rare = trace(topology)
    layout = Layout(topology)
    preparation = _preparation(topology, layout, lanes)
    gathered = Gathered()
    if preparation:
        gathered.add(polynomial)
    body = _run(lines, stores, rare, preparation, lanes, layout.rows)
    return "\n\n".join([*gathered.texts.values(), body, ADVANCE.format(lanes=lanes)])


ADVANCE = """@jit
def advance(S, T, n0, count, done, out, kept, extremes, spare):
    while done < out.shape[0] * count:
        m = done // count
        inside = done - m * count
        if inside == 0:
            for q in extremes:
                for w in range({lanes}):
                    S[q * {lanes} + w] = 0.0
        some = min(128, count - inside)
        for q in range(len(spare)):
            spare[q] = S[q]
        clean = run(S, T, n0 + done, some)
        if clean < some:
            for q in range(len(spare)):
                S[q] = spare[q]
            run(S, T, n0 + done, clean)
            return done + clean
        done += some
        if inside + some == count:
            for q in range(out.shape[1]):
                for w in range({lanes}):
                    out[m, q, w] = S[kept[q] * {lanes} + w]
    return done
"""


def _run(lines: list[Line], stores: dict[int, str], rare: str, preparation: list[str], lanes: int, end: int) -> str:
    """All of a step in one loop over lanes, which the compiler turns into vector instructions; True in row ``end`` stops the run."""
    out = ["@jit", "def run(S, T, n0, count):", "    for n in range(n0, n0 + count):"]
    out += [f"        {line}" for line in preparation]
    out += [f"        for w in range({lanes}):"]
    out += [f"            {line}" for line in woven(lines, stores, lanes)]
    if rare:
        out += [f"            S[{end * lanes} + w] = 1.0 if {rare} else 0.0"]
        flags = " + ".join(f"S[{end * lanes + w}]" for w in range(lanes))
        out += [f"        if {flags} > 0.0:", "            return n - n0"]
    return "\n".join([*out, "    return count"]) + "\n"
