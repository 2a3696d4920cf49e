"""Data-driven = generated in 1, 2, 4 and 8 lanes = interpreted = JavaScript, to the bit, on runs rich in
contacts, tables, drivers and frames.
"""

import json
import shutil
import subprocess
from functools import cache

import numpy as np
import pytest

from choice import default_cases
from lane_models import (
    LANES,
    cylinder,
    elastic_bars,
    journals,
    machinery,
    one_clearance,
    rigid_bars,
    swing,
    two_particle_bars,
    worn_bars,
)
from support import CONTACT_LAWS, bits, lanes
from vfife.assembly.assemble import assemble
from vfife.assembly.assembled import Assembly
from vfife.compiler.backends import javascript
from vfife.compiler.runtime.loops import python_line
from vfife.kernels.blocks import BLOCKS

EIGHT = tuple(k % LANES for k in range(8))


# model, step, steps between outputs, outputs, outputs to interpret
RUNS = {
    rigid_bars: (2e-6, 100, 120, 10),
    worn_bars: (2e-6, 100, 120, 8),
    two_particle_bars: (1e-6, 100, 120, 10),
    one_clearance: (2e-6, 100, 120, 8),
    elastic_bars: (1e-6, 50, 60, 8),
    swing: (4e-6, 50, 60, 12),
    journals: (1e-6, 100, 60, 8),
    machinery: (4e-6, 50, 60, 10),
    cylinder: (4e-6, 50, 80, 8),
}


@cache
def assembled(model, lane: int = 0) -> Assembly:
    """Lane ``lane`` of a model, each with its own step."""
    return assemble(model(lane), RUNS[model][0] * (1 - 0.05 * lane), duration=1e-3, force_step=True)


@cache
def computed(model, loop: str, width: int) -> tuple[np.ndarray, tuple[str, ...]]:
    """Rows of so many lanes, all state and extremes, and the rows' names; each lane has its own parameters
    and step.
    """
    _, every, outputs, interpreted = RUNS[model]
    assemblies = [assembled(model, lane) for lane in EIGHT[:width]]
    runner = lanes(assemblies, loop)
    start = runner.advance(1, 1)
    rows = runner.advance(every, interpreted if loop == "interpreted" else outputs)
    layout = assemblies[0].layout
    names = {
        row: name
        for name, where in ((block.name, layout[block.name]) for block in BLOCKS)
        for row in where.tolist()
    }
    return np.concatenate([start, rows]), tuple(names.get(int(row), "wide") for row in runner.row_numbers)


def differing(ours: np.ndarray, theirs: np.ndarray, names: tuple[str, ...]) -> set[str]:
    """Names of the rows whose bits differ anywhere."""
    return {names[k] for k in np.flatnonzero((bits(ours) != bits(theirs)).any(axis=(0, 2)))}


@pytest.mark.parametrize(
    "model",
    default_cases(
        RUNS, lambda model: model in (journals, worn_bars, machinery), "steps a long text in the interpreter"
    ),
    ids=lambda model: model.__name__,
)
def test_the_generated_text_is_data_driven(model):
    """The straight line run as plain Python, without compilation: its lines, their order and the steps that
    the whole step takes.
    """
    rows, names = computed(model, "data-driven", LANES)
    _, every, _, outputs = RUNS[model]
    runner = lanes([assembled(model)], "interpreted")
    runner.take = python_line(runner.topology)(runner.memory)
    plain = np.concatenate([runner.advance(1, 1), runner.advance(every, outputs)])
    assert differing(plain, rows[: len(plain), :, :1], names) == set()


@pytest.mark.parametrize(
    "width", default_cases([1, 2, 4, 8], lambda width: width == 4, "compiles every model in every width")
)
@pytest.mark.parametrize("model", RUNS, ids=lambda model: model.__name__)
def test_lanes_are_data_driven_each(model, width):
    """Whatever the width and whatever happens beside it."""
    rows, names = computed(model, "data-driven", LANES)
    found, _ = computed(model, "generated", width)
    assert differing(found, rows[:, :, list(EIGHT[:width])], names) == set()


SCRIPT = """
const {{S, T, count, outputs, kept, extremes}} = {given};
const numbers = (bits) => new Float64Array(BigUint64Array.from(bits.map(BigInt)).buffer);
const state = numbers(S), tables = numbers(T), size = kept.length;
const rows = new Float64Array((outputs + 1) * size);
const room = (length) => new Float64Array(length);
const memory = [
  state, room(state.length), room(state.length), room(3), tables, [], [1, 1, state.length, 8, 1000], room(1),
  kept, extremes, [], [], room(1),
];
advance(memory, 1, 1000, 0, 1, 1, rows.subarray(0, size));
advance(memory, 1, 999, 1, count, outputs, rows.subarray(size));
const bits = Array.from(new BigUint64Array(rows.buffer), String);
console.log(JSON.stringify(Array.from({{ length: outputs + 1 }}, (_, m) =>
  bits.slice(m * size, (m + 1) * size))));
"""


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node, which runs JavaScript")
@pytest.mark.parametrize(
    "model",
    default_cases(RUNS, lambda model: model in (cylinder, worn_bars), "starts a process"),
    ids=lambda model: model.__name__,
)
def test_javascript_is_data_driven(model, tmp_path):
    """The text that a page would run, in the engine of a browser."""
    rows, names = computed(model, "data-driven", LANES)
    _, every, outputs, _ = RUNS[model]
    runner = lanes([assembled(model)], "interpreted")

    def text(values):
        return [str(int(x)) for x in np.ascontiguousarray(values).view(np.uint64)]

    given = {
        "S": text(runner.S), "T": text(runner.functions), "count": every, "outputs": outputs,
        "kept": runner.row_numbers.tolist(),
        "extremes": runner.extremes.tolist(),
    }  # fmt: skip
    path = tmp_path / "run.js"
    path.write_text(javascript.module(runner.topology) + SCRIPT.format(given=json.dumps(given)))
    found = subprocess.run(["node", str(path)], capture_output=True, text=True, check=True).stdout
    there = np.array([[int(x) for x in row] for row in json.loads(found)], dtype=np.uint64).view(np.float64)[
        :, :, None
    ]
    assert there.shape[0] == outputs + 1
    assert differing(there, rows[:, :, :1], names) == set()


@pytest.mark.system("steps in the interpreter")
@pytest.mark.parametrize("model", RUNS, ids=lambda model: model.__name__)
def test_interpreted_is_data_driven(model):
    rows, names = computed(model, "data-driven", LANES)
    plain, _ = computed(model, "interpreted", 1)
    assert differing(plain, rows[: len(plain), :, :1], names) == set()


@pytest.mark.parametrize("model", RUNS, ids=lambda model: model.__name__)
def test_the_runs_are_worth_comparing(model):
    """Numbers all finite; lanes differ; contacts begin, end, dissipate and rub in the part that is
    interpreted, too.
    """
    rows, names = computed(model, "data-driven", LANES)
    assert np.isfinite(rows).all()
    last = rows[-1][rows[-1].any(axis=1)]
    assert all((last[:, lane] != last[:, 0]).mean() > 0.5 for lane in range(1, LANES))

    def block(name: str) -> np.ndarray:
        return rows[:, [k for k, other in enumerate(names) if other == name]]

    if model is not elastic_bars:
        interpreted = RUNS[model][3]
        assert (block("contact_onsets")[interpreted, :, 0] >= 1).any()
        again = block("contact_onsets")[-1] >= 2
        assert (
            again.any(axis=0) if model is machinery else again.all(axis=0)
        ).any()  # a journal in oil never touches
        assert (block("contact_damping_work")[interpreted, :, 0] > 0).any()
        assert (block("contact_friction_work")[interpreted, :, 0] > 0).any()
        assert (block("contact_slowness") == 0).any() and (block("contact_slowness")[1:] > 0).any()
    if model is two_particle_bars:
        assert (block("contact_friction_work")[-1, :2] > 0).all() and (
            block("contact_friction_work")[:, 2] == 0
        ).all()
    if model in (elastic_bars, two_particle_bars):
        assert np.abs(block("frame_moment_1")[-1]).min() > 0
    if model is swing:
        assert all(
            np.abs(block(name)[-1]).min() > 0 for name in ("external_work", "damping_work", "driven_work")
        )


def test_the_machinery_is_at_work():
    """Springs, the stop, the gear, the guide and the film carry forces; functions over angle and speed
    change.
    """
    rows, names = computed(machinery, "data-driven", LANES)
    at = {name: [k for k, other in enumerate(names) if other == name] for name in set(names)}
    assert (np.abs(rows[:, at["spring_moment"]]).max(axis=(0, 2)) > 0).sum() == 2
    assert np.abs(rows[-1, at["spring_fx"]]).max() > 0 and np.abs(rows[-1, at["joint_moment"]]).max() > 0
    assert (np.ptp(rows[:, at["function_value"]], axis=0) > 0).sum(axis=0).tolist() == [
        3
    ] * LANES  # that of the constant load does not change
    assert (np.abs(rows[-1, at["contact_friction_force"]]) > 0).any()


def test_every_contact_law_is_among_them():
    chosen = {type(joint.contact) for lane in range(LANES) for joint in journals(lane).clearances.values()}
    assert chosen == set(CONTACT_LAWS)


def test_a_run_in_pieces_is_one_run():
    """Advancing by 1, 7 and 592 steps gives the state that 600 steps give, in either loop."""
    for loop in ("data-driven", "generated"):
        whole, pieces = (lanes([assembled(rigid_bars)], loop) for _ in range(2))
        whole.advance(600, 1)
        for count in (1, 7, 592):
            pieces.advance(count, 1)
        state = [k for k in range(whole.layout.rows) if k in set(whole.layout.of("state"))]
        assert (bits(whole.states[state]) == bits(pieces.states[state])).all()


@pytest.mark.parametrize("parts", [1, 8])
@pytest.mark.parametrize("loop", ["data-driven", "generated"])
def test_extremes_are_those_of_the_steps_since_the_last_output(loop, parts):
    """Every step recorded against every fortieth: the extreme of an interval is the largest of its steps, no
    more, and less only within a step.
    """
    a = assembled(rigid_bars)
    every, some = (lanes([a], loop, parts).advance(count, 1200 // count)[:, :, 0] for count in (1, 40))
    column = {int(row): k for k, row in enumerate(lanes([a], loop).row_numbers)}

    def of(rows: np.ndarray, name: str) -> np.ndarray:
        return rows[:, [column[row] for row in a.layout[name].tolist()]]

    force = of(every, "contact_normal_force") ** 2 + of(every, "contact_friction_force") ** 2
    largest = {
        "contact_force_squared_max": force,
        "contact_penetration_max": np.maximum(of(every, "contact_penetration"), 0.0),
        "body_alpha_max": np.abs(of(every, "body_alpha")),
        "driven_torque_max": np.abs(of(every, "driven_torque")),
    }
    for name, values in largest.items():
        assert (of(some, name) == of(every, name).reshape(30, 40, -1).max(axis=1)).all(), name
        assert (of(every, name) >= values).all(), name
        assert parts > 1 or (of(every, name) == values).all(), name
    assert (np.diff(of(some, "body_alpha_max")[:, 2]) < 0).any()
