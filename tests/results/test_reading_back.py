"""A run that is read from its file is the run that was written: for every kind of joint, spring, driver and
load, and for every mechanism of the gallery.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vfife
from model.test_kinds import CASES
from results.killed import kill_at, killed_run, paced, same, write
from support import bits
from vfife import gallery
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.modelfile import dump
from vfife.solvers.arguments import RunArguments

STATIC = {
    name for name in gallery.__all__ if getattr(gallery, name)().settings.analysis == "static"
}  # without steps
STEPS = 400


def same_assembly(one: Assembly, other: Assembly) -> None:
    """Every field, also those that a later version adds, and what is derived from them."""
    for field in dataclasses.fields(Assembly):
        first, second = getattr(one, field.name), getattr(other, field.name)
        if isinstance(first, np.ndarray):
            assert first.shape == second.shape and (bits(first) == bits(second)).all(), field.name
        elif field.name == "mechanism":
            assert dump(first) == dump(second)
        elif field.name != "layout":  # it follows from the topology
            assert first == second, field.name
    assert one.contact_paths == other.contact_paths
    assert len(other.contact_paths) == len(other.contacts)


def same_result(one: vfife.Result, other: vfife.Result) -> None:
    same_assembly(one.record.assembly, other.record.assembly)
    assert dict(one.measures) == dict(other.measures)
    assert str(one.measures) == str(other.measures)
    assert one.data.identical(other.data)


def walk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mechanism: Any, asked: RunArguments) -> None:
    """Write a run, read it, and continue one that was killed."""
    result = write(tmp_path / "whole.sqlite", mechanism, asked, reference=False)
    same_result(result, vfife.load_result(tmp_path / "whole.sqlite"))
    paced(monkeypatch, 50)
    restore = kill_at(monkeypatch, 5)
    assert killed_run(tmp_path / "run.sqlite", mechanism, asked, reference=False)
    restore()
    again = vfife.resume(tmp_path / "run.sqlite")
    same(tmp_path / "whole.sqlite", tmp_path / "run.sqlite")
    assert dict(again.measures) == dict(result.measures)


@pytest.mark.parametrize(("make", "kind"), CASES, ids=[kind for _, kind in CASES])
def test_every_kind_is_read_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, make: Any, kind: str
) -> None:
    walk(
        tmp_path,
        monkeypatch,
        make(kind),
        RunArguments(duration=4e-3, step=1e-5, outputs=20, loop="data-driven", force_step=True),
    )


@pytest.mark.parametrize("name", sorted(set(gallery.__all__) - STATIC))
def test_every_mechanism_of_the_gallery_is_read_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    mechanism = getattr(gallery, name)()
    step = assemble(mechanism).choice.step
    walk(
        tmp_path,
        monkeypatch,
        mechanism,
        RunArguments(duration=STEPS * step, step=step, outputs=20, loop="data-driven"),
    )


@pytest.mark.parametrize("name", sorted(STATIC))
def test_every_static_analysis_is_read_back(tmp_path: Path, name: str) -> None:
    few = {"elements": 8, "drops": [1e-3, 2e-3]} if name in ("williams_toggle", "lee_frame") else {}
    result = vfife.simulate(getattr(gallery, name)(**few), file=tmp_path / "run.sqlite")
    same_result(result, vfife.load_result(tmp_path / "run.sqlite"))
