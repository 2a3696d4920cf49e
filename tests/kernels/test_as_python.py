"""The kernels as they stand, run as plain Python: the bits of the compiled loop, and every line of them under
a debugger or a coverage tool.

What is compiled is a text gathered from these functions, so no tool sees the functions themselves at work;
here they are called.
"""

from pathlib import Path

import numpy as np
import pytest

import vfife
from choice import default_cases
from lane_models import worn_bars
from mechanisms import beads, every_drive, every_law, everything, geared_ring
from support import bits, journal_in_bearing, with_settings
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import bounds, limited_rows
from vfife.compiler.runtime.runner import Runner
from vfife.compiler.trace.source import Gathered, dispatch, films, regimes
from vfife.compiler.trace.tables import tables
from vfife.kernels import advance, contact, contact_forces
from vfife.solvers.record import recorded_rows

FOLDER = Path(__file__).resolve().parents[2] / "examples"
# Steps before those that are compared, in which bodies come to touch.
AHEAD, COMPARED = 200, 20


EXAMPLES = (
    "elastic_pendulum",
    "four_bar_case_c",
    "gear_train",
    "scissor_lift",
    "slider_crank_loose_guide",
    "squeezer",
)
CASES = {name: vfife.load_model(FOLDER / f"{name}.toml") for name in EXAMPLES}
CASES |= {
    "ring": geared_ring(),
    "beads": beads(),
    "worn": worn_bars(1),
    "touching soon": journal_in_bearing(clearance=2e-6),
}
CASES["coarse"] = with_settings(vfife.load_model(FOLDER / "four_bar_ideal.toml"), step=2.5e-4)
CASES |= {"every kind": everything(), "every law": every_law(), "every drive": every_drive()}


def written(text: str, gathered: Gathered, name: str):
    """A function that the generator writes, over the functions of the laws themselves."""
    space = dict(gathered.origin)
    exec(text, space)
    return space[name]


@pytest.fixture
def laws(monkeypatch: pytest.MonkeyPatch):
    """Puts the laws of a topology where the compiled text has them."""

    def put(topology) -> None:
        gathered = Gathered()
        for kind, known in (("contact", topology.contact_laws), ("friction", topology.friction_laws)):
            monkeypatch.setattr(
                contact, f"{kind}_law", written(dispatch(kind, known, gathered), gathered, f"{kind}_law")
            )
        monkeypatch.setattr(
            contact,
            "friction_regime",
            written(regimes(topology.friction_laws, gathered), gathered, "friction_regime"),
        )
        monkeypatch.setattr(
            contact_forces, "film_law", written(films(topology.contact_laws, gathered), gathered, "film_law")
        )

    return put


@pytest.mark.parametrize(
    "name",
    default_cases(
        CASES,
        lambda name: name in ("every kind", "every drive", "worn", "beads", "touching soon"),
        "steps in the interpreter",
    ),
)
def test_functions_give_the_bits_of_the_gathered_text(name, laws):
    mechanism = CASES[name]
    long = mechanism.settings.duration or mechanism.settings.turns
    assembly = assemble(mechanism, duration=None if long else 1e-3)
    laws(assembly.topology)
    kept = recorded_rows(assembly)
    out_of_phase = np.array([0.5])
    state = assembly.state[:, None].copy()
    runner = Runner(assembly.topology, state, assembly.tables[None], "interpreted", kept, shares=out_of_phase)
    integers, layout, size = tables(assembly.topology)
    low, high = bounds(assembly)
    limited, broken = (limited_rows(assembly), np.stack([low, high], axis=1).reshape(-1)), np.zeros(1)
    functions, extremes = np.asarray(assembly.tables).reshape(-1), np.array(layout.of("extreme"))
    numbers = np.array([1, 1, layout.rows, 8, 1])
    for n0 in (0, COMPARED + AHEAD):
        ours, out = np.zeros(size), np.zeros((COMPARED, len(kept), 1))
        ours[: layout.rows] = runner.states[:, 0]
        copies = (np.zeros(size), np.zeros(layout.rows), np.zeros(3), functions, integers.tolist(), numbers)
        memory = advance.Memory(ours, *copies, out_of_phase, kept, extremes, *limited, broken)
        advance.advance(memory, 1, 1, n0, 1, COMPARED, out.reshape(-1))
        assert broken == 0.0
        assert (bits(runner.advance(1, COMPARED)) == bits(out)).all(), n0
        assert (bits(runner.states[:, 0]) == bits(ours[: layout.rows])).all(), n0
        if not n0:
            runner.advance(AHEAD, 1)
