"""A mechanism and its ideal reference for a page: assembled with one step, all numbers in one vector."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...assembly.assemble import assemble
from ...assembly.assembled import Assembly
from ...compiler.trace.straight_line import estimated_lines
from ...errors import VfifeError
from ...laws.elasticity import elastic_energy
from ...model.mechanism import Mechanism
from ...modelfile import load
from ...simulation.result import Result
from ...simulation.start import comparable
from ...solvers.transient import LONGEST_STRAIGHT_LINE, choose_loop
from ...store.schemas import is_run_file

Array = NDArray[np.float64]
# Depths (m) at which the page knows the energy of a contact; between two of them it interpolates a power law.
DEPTHS = np.geomspace(1e-9, 1e-2, 29)
NO_ENERGY = -300.0  # common logarithm that stands for zero energy


@dataclass(frozen=True)
class PageModel:
    """An assembled mechanism and its assembled ideal reference, or None without a comparable one."""

    assembly: Assembly
    ideal: Assembly | None

    @cached_property
    def parts(self) -> dict[str, Array]:
        """Parts of the vector in order: states and tables of both, and numbers used only by drawings and the
        energy balance.
        """
        parts = {"state": start_state(self.assembly), "tables": self.assembly.tables}
        if self.ideal is not None:
            parts |= {"ideal_state": start_state(self.ideal), "ideal_tables": self.ideal.tables}
        return parts | {
            "turn": np.array([self.assembly.choice.turn or 0.0]),
            "plays": clearances(self.assembly),
            "energies": energies(self.assembly),
        }

    @cached_property
    def vector(self) -> Array:
        """All numbers that a slider may change, shape (n,)."""
        return np.concatenate(list(self.parts.values()))

    def same_kind(self, other: PageModel) -> bool:
        """Return whether another model has the same step functions and differs in numbers only."""
        if (self.ideal is None) != (other.ideal is None) or len(self.vector) != len(other.vector):
            return False
        pairs = [(self.assembly, other.assembly)] + (
            [(self.ideal, other.ideal)] if self.ideal and other.ideal else []
        )
        return all(
            first.topology == second.topology
            and (first.choice.outputs_every, first.choice.outputs)
            == (second.choice.outputs_every, second.choice.outputs)
            for first, second in pairs
        )


def start_state(assembly: Assembly) -> Array:
    """Return the state before the first step, shape (rows,), as a runner initialises it."""
    state = assembly.state.copy()
    state[assembly.layout["c"]] = 1.0
    return state


def clearances(assembly: Assembly) -> Array:
    """Return the clearance (m) of each contact, 0 for a joint without one, shape (contacts,)."""
    joints = assembly.mechanism.contacts
    return np.array([float(getattr(joints[name], "clearance", 0.0)) for name in assembly.contact_joints])


def energies(assembly: Assembly) -> Array:
    """Return the common logarithm of the elastic energy (J) of each contact at DEPTHS, shape (contacts *
    depths,).
    """
    logarithms = np.zeros((len(assembly.contacts), len(DEPTHS)))
    for index, name in enumerate(assembly.contact_joints):
        energy = elastic_energy(
            assembly.mechanism.contacts[name].contact, DEPTHS, assembly.contact_slots(index)
        )
        logarithms[index] = np.where(energy > 0.0, np.log10(np.maximum(energy, 10.0**NO_ENERGY)), NO_ENERGY)
    return logarithms.reshape(-1)


def model_of(path: Path, settings: list[tuple[str, str]]) -> tuple[Mechanism, float | None]:
    """Return the mechanism of a model file and None, or that of a run and its step (s). Raises ModelError or
    RunFileError.
    """
    if not (path.is_dir() or is_run_file(path)):
        return load(path, set=settings), None
    if settings:
        raise ValueError(
            "--set changes a model file, and this is a run; name its model, or move a slider in the page"
        )
    record = Result.load(path).record
    return record.assembly.mechanism, record.assembly.choice.step


def refuse_unfit(mechanism: Mechanism) -> None:
    """Raise VfifeError for a mechanism with nothing to run in a page."""
    if mechanism.settings.analysis == "static":
        raise VfifeError("a static analysis has no motion to run in a page; see vfife run and vfife plot")


def page_model(
    mechanism: Mechanism,
    step: float | None = None,
    ideal_step: float | None = None,
    *,
    force: bool = False,
    references: list[Assembly] | None = None,
) -> PageModel:
    """Return the assembled mechanism and reference, with the given steps (s) or automatic ones.

    ``references`` are ideal references assembled before; a matching one is reused, since clearances do not
    change it, and a new one is added. Raises ModelError and AssemblyError for a mechanism that cannot be run.
    """
    refuse_unfit(mechanism)
    assembly = assemble(mechanism, step, force_step=force)
    if choose_loop(assembly, "auto") != "generated":
        raise VfifeError(
            f"a page runs models whose step is written out, and that of this one is not: {why_not(assembly)}"
        )
    if not comparable(mechanism) or any(
        driver.steady_speed is None for driver in mechanism.drivers.values() if driver.moves
    ):
        return PageModel(assembly, None)
    without, references = mechanism.ideal(), [] if references is None else references
    for reference in references:
        if reference.mechanism == without and ideal_step in (None, reference.choice.step):
            return PageModel(assembly, reference)
    references.append(assemble(without, ideal_step, loop_of=mechanism, turns=1.0))
    return PageModel(assembly, references[-1])


def why_not(assembly: Assembly) -> str:
    """Return why a step is too large for straight-line code, with the numbers."""
    if assembly.topology.path_unit != 1:
        return f"its path units have {assembly.topology.path_unit} steps; leave path_unit at 1"
    lines, count = estimated_lines(assembly.topology), len(assembly.topology.frame_nodes)
    limit = f"{LONGEST_STRAIGHT_LINE:,} are the most, which is about 380 elements"
    return (
        f"it would have some {lines:,} lines, and {limit}; there are {count:,} here, so take fewer, or vfife"
        " run and vfife plot"
    )


def step_dividing_turn(assembly: Assembly, turn: float | None) -> float:
    """Return the step (s) that divides a turn of another mechanism, of period ``turn`` (s), into the same
    number of steps; without a crank the same step.
    """
    choice = assembly.choice
    return choice.step if turn is None or choice.turn is None else turn / round(choice.turn / choice.step)
