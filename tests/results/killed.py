"""Runs that are killed at a moment of their own, and whether two run files say the same."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vfife
from support import bits
from vfife.compiler.runtime.runner import Runner
from vfife.simulation.simulate import prepare, run_prepared
from vfife.solvers import interrupts
from vfife.solvers.arguments import RunArguments
from vfife.solvers.companion_lanes import SynchronisedLanes
from vfife.store.runfile import RunFile


class Killed(BaseException):
    """The end of a process, as far as one test goes."""


def write(
    path: Path, mechanism: vfife.Mechanism, asked: RunArguments, reference: bool = True
) -> vfife.Result:
    prepared = prepare(mechanism, asked, reference)
    with RunFile.create(path, prepared.run_meta) as file:
        result = run_prepared(prepared, file=file)
        result.finish(file)
    return result


def kill_at(monkeypatch: pytest.MonkeyPatch, call: int) -> Callable[[], None]:
    """The process ends at a call of the loop; what it gives back takes the fault away."""
    loops, calls = {kind: kind.advance for kind in (Runner, SynchronisedLanes)}, []

    def killing(advance: Callable[..., Any]) -> Callable[..., Any]:
        def killed(self: Any, *args: Any, **how: Any) -> Any:
            calls.append(1)
            if len(calls) == call:
                raise Killed
            return advance(self, *args, **how)

        return killed

    def restore() -> None:
        for kind, advance in loops.items():
            monkeypatch.setattr(kind, "advance", advance)

    for kind, advance in loops.items():
        monkeypatch.setattr(kind, "advance", killing(advance))
    return restore


def paced(monkeypatch: pytest.MonkeyPatch, steps: int) -> None:
    """So many steps a call on every machine: by the clock, a fast one would come to its end before the call
    at which it is killed.
    """
    monkeypatch.setattr(
        interrupts.ChunkSize, "steps", property(lambda self: steps, lambda self, value: None), raising=False
    )


def killed_run(path: Path, mechanism: vfife.Mechanism, asked: RunArguments, reference: bool = True) -> bool:
    """A run that is killed: what was not committed is gone. False where it came to its end before."""
    prepared = prepare(mechanism, asked, reference)
    file = RunFile.create(path, prepared.run_meta)
    try:
        run_prepared(prepared, file=file).finish(file)
    except Killed:
        return True
    finally:
        file._connection.close()
    return False


def same(one: Path, other: Path) -> None:
    """All that two run files say, except times of the clock."""
    with RunFile.open(one) as a, RunFile.open(other) as b:
        steps, rows = a.outputs()
        again, others = b.outputs()
        assert np.array_equal(steps, again) and (bits(rows) == bits(others)).all()
        assert not a.damaged_parts and not b.damaged_parts
        first, second = a.latest(), b.latest()
        assert first is not None and second is not None and first.step == second.step
        assert (bits(first.values) == bits(second.values)).all()
        beside, others_beside = a.companions(), b.companions()
        if beside is not None:
            assert others_beside is not None and beside[0] == others_beside[0]
            window = np.isin(others_beside[1], beside[1])
            assert (
                bits(beside[2][np.isin(beside[1], others_beside[1])]) == bits(others_beside[2][window])
            ).all()
        told = [
            {key: value for key, value in file.meta.items() if not isinstance(value, np.ndarray)}
            for file in (a, b)
        ]
        for one_told in told:
            for key in ("created", "finished", "wall"):
                one_told.pop(key)
            for key in ("wall_s", "ns_per_step"):
                one_told["summary"].pop(key)
        assert told[0] == told[1]


def arch() -> vfife.Mechanism:
    m = vfife.Mechanism("arch", gravity=(0.0, -9.81))
    m.point("O", 0.0, 0.0)
    m.link(
        "rod",
        length=1.0,
        mass=2.0,
        angle=-0.5,
        model="elastic",
        elements=3,
        section=vfife.bodies.Section.square(1e-4),
    )
    m.weld("J", "ground.O", "rod.start")
    m.settings = vfife.Settings(analysis="static", load_factors=(0.2, 0.5, 1.0))
    return m


def full_at(call: int) -> Callable[..., None]:
    """What writes a row, on a disk that is full at one of its calls."""
    insert, calls = RunFile.insert, []

    def full(file: RunFile, table: str, *values: Any) -> None:
        calls.append(1)
        if len(calls) == call:
            raise sqlite3.OperationalError("database or disk is full")
        insert(file, table, *values)

    return full
