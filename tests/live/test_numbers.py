"""What a page computes is what Python computes: rows to the bit, measures to the bit, forces and energies to
round-off.
"""

import dataclasses

import numpy as np
import pytest

import mechanisms
from live.pages import bits_of, needs_node, page_of, run_by_node
from support import with_settings
from vfife import gallery, simulate
from vfife.compiler.runtime.runner import Runner
from vfife.live.page.page import BROWSER, page_with_sliders
from vfife.live.page.page_model import page_model
from vfife.live.page.patches import slider_patches
from vfife.live.page.payload import scratch_rows
from vfife.live.page.sliders import default_slides, parse_slides
from vfife.measures.forces import joint_force, joint_rows
from vfife.model.functions import turn_of
from vfife.model.mechanism import StartSettings
from vfife.modelfile import dump, loads
from vfife.solvers.record import recorded_rows

pytestmark = needs_node


def steps_of(assembly, outputs: int) -> np.ndarray:
    """Rows that Python keeps, shape (outputs, rows)."""
    kept = recorded_rows(assembly)
    runner = Runner(
        assembly.topology,
        assembly.state[:, None],
        assembly.tables,
        "data-driven",
        kept,
        parts=assembly.mechanism.settings.parts,
    )
    return np.concatenate([runner.advance(1, 1), runner.advance(assembly.choice.outputs_every, outputs - 1)])[
        :, :, 0
    ]


# A turn each: three loose joints with friction, a block with clearance, springs or gears with tables, an
# elastic
# link.
RUNS = {
    "four_bar_case_c": 721,
    "slider_crank_loose_guide": 61,
    "gear_train": 60,
    "elastic_pendulum": 30,
    "quick_return": 721,
    "scissor_lift": 20,
}


@pytest.mark.system("runs the page's text beside Python's")
@pytest.mark.parametrize("name", RUNS)
def test_the_page_steps_with_the_bits_of_python(name, tmp_path):
    mechanism = getattr(gallery, name)()
    page = page_of(mechanism)
    both = slider_patches(mechanism, []).base
    there = run_by_node(
        page, f"const [a, b] = step(new Setting(), {RUNS[name]}); return [bits(a), bits(b)];", tmp_path
    )
    for texts, assembly, outputs in zip(there, (both.assembly, both.ideal), (RUNS[name], 721), strict=True):
        if assembly is None:
            assert not texts
            continue
        ours = steps_of(assembly, outputs)
        width = ours.shape[1]  # behind these rows stand those that a page alone keeps
        found = bits_of(texts, width + len(scratch_rows(assembly.layout)))[:, :width]
        assert found.shape == ours.shape
        assert (found == np.ascontiguousarray(ours).view(np.uint64)).all()


def test_another_step_is_seen(tmp_path):
    """The comparison is of what the page holds: one number of its step changed by a part in 10^15 is another
    run.
    """
    mechanism = gallery.quick_return()
    same = run_by_node(page_of(mechanism), "return bits(step(new Setting(), 40)[0]);", tmp_path)
    other = run_by_node(
        page_of(mechanism),
        "return bits(step(new Setting(), 40)[0]);",
        tmp_path,
        lambda text: text.replace("(0.5)", "(0.50000000000000011)"),
    )
    assert same != other


TURNS = """
const setting = new Setting(), [rows, without] = step(setting, %d);
const reader = new Reader(own, setting.part("state"), setting);
const width = own.kept.length, data = Float64Array.from(rows);
const turns = new Turns(reader, perTurn, given.bodies);
for (let k = 0; k < data.length / width; k++) turns.take(data, k * width, k);
const last = data.length - width;
const start = reader.ledger(data, 0, true), end = reader.ledger(data, last);
const ideally = {};
if (ideal) {
  const other = new Reader(ideal, setting.part("ideal_state"), setting), more = Float64Array.from(without);
  const one = new Turns(other, ideal.perTurn, given.bodies);
  for (let k = 0; k < more.length / ideal.kept.length; k++) one.take(more, k * ideal.kept.length, k);
  Object.assign(ideally, one.done[0]);
}
const forces = Object.fromEntries(
  Object.keys(own.joints).map((name) => [name, reader.force(data, last, name)]));
const turned = Object.fromEntries(given.bodies.map((body) =>
  [body.name, [...reader.point(data, last, body.centre), ...reader.turn(data, last, body)]]));
return { turns: turns.shown, start, end, forces, turned, ideally };
"""


COMPARED = [
    ("four_bar_case_c", 1.0),
    ("slider_crank_loose_guide", 0.5),
    ("elastic_pendulum", None),
    ("beads", None),
    ("scissor_lift", None),
]


@pytest.mark.system("runs the page's numbers beside Python's")
@pytest.mark.parametrize(("name", "turns"), COMPARED)
def test_peaks_and_energies_are_those_of_a_run(name, turns, tmp_path):
    """Peaks from the extremes of every step: the same numbers; the ledger and forces at the end of the run to
    round-off.
    """
    mechanism = (
        with_settings(mechanisms.beads(), duration=0.004, outputs=80)
        if name == "beads"
        else getattr(gallery, name)()
    )
    result = simulate(mechanism, turns=turns, companions=0, loop="data-driven")
    record, measures = result.record, result.measures
    found = run_by_node(page_of(mechanism), TURNS % len(record.steps), tmp_path)
    (shown,) = found["turns"]
    for joint, force in shown["force"].items():
        assert force == measures[f"{joint}.force.max"]
    for body, torque in shown["torque"].items():
        assert torque == measures[f"{body}.torque.max"]
    for contact, depth in zip(record.assembly.contacts, shown["depth"], strict=True):
        assert depth == measures[f"{contact}.penetration.max"]
    for contact, began in zip(record.assembly.contacts, shown["began"], strict=True):
        assert began == measures[f"{contact}.impacts"]
    if result.reference is not None:
        for joint, force in found["ideally"]["force"].items():
            assert force == result.reference.measures[f"{joint}.force.max"]
    for k, joint in enumerate(joint_rows(record)):
        assert found["forces"][joint] == pytest.approx(joint_force(record)[-1, k], rel=1e-12, abs=1e-9)
    terms = result.ledger.terms
    names = {"kinetic": "kinetic", "strain": "strain", "contact": "contact", "spring": "spring",
        "lost in contacts": "contact_loss",
             "lost in friction": "friction_loss", "lost in damping": "damping_loss", "loads": "external",
             "drivers": "driver"}  # fmt: skip
    for here, there in names.items():
        assert found["end"][here] == pytest.approx(
            terms[there][-1], rel=2e-3 if here == "contact" else 1e-9, abs=1e-9 * result.ledger.largest
        )
        assert found["start"][here] == pytest.approx(
            terms[there][0], rel=1e-9, abs=1e-9 * result.ledger.largest
        )
    for k, body in enumerate(record.assembly.bodies):
        x, y, _, _, angle, rate = found["turned"][body]
        if not record.assembly.bodies[body].elements:
            assert (x, y) == pytest.approx(
                [result.channels[f"body_{axis}"].values[-1, k] for axis in "xy"], rel=1e-12, abs=1e-15
            )
        assert np.cos(angle) == pytest.approx(np.cos(result.channels["body_angle"].values[-1, k]), abs=1e-12)
        assert rate == pytest.approx(
            result.channels["body_angular_velocity"].values[-1, k], rel=1e-10, abs=1e-10
        )


def test_a_setting_of_the_page_is_the_model_with_these_values(tmp_path):
    """Sliders moved in the page: the numbers that it begins with, and the model that it hands out, are what
    Python makes of them.
    """
    mechanism = gallery.four_bar_case_b()
    slides = parse_slides(mechanism, ["joint.C.clearance=0.15..0.3mm", "driver.crank.speed=1200..1500rpm"])
    slides = [
        dataclasses.replace(
            slide, values=(slide.values[0], slide.values[slide.here], slide.values[-1]), here=1
        )
        for slide in slides
    ]
    page = page_of(mechanism, slides)
    positions = [0, 2]
    found = run_by_node(
        page,
        f"const one = new Setting({positions}); return [bits(one.vector), one.model, own.every];",
        tmp_path,
    )
    settings = [pair for slide, k in zip(slides, positions, strict=True) for pair in slide.changes(k)]
    wanted = loads(dump(mechanism), set=settings)
    assert loads(found[1]) == wanted
    fine = page_model(wanted, turn_of(wanted) / (wanted.settings.outputs * found[2]))
    assert (bits_of(found[0], 1)[:, 0] == fine.vector.view(np.uint64)).all()


def test_sliders_of_which_one_moves_at_a_time_do_so_in_the_page(tmp_path):
    """A seated start: every position of every slider has the numbers of its own, and moving one puts the
    others of its group back.
    """
    mechanism = gallery.four_bar_case_c()
    mechanism.start = StartSettings(journals="seated")
    slides = [
        dataclasses.replace(one, values=one.values[-2:] + (one.values[one.here],), here=2)
        for one in default_slides(mechanism)[:4]
    ]
    slides = [
        dataclasses.replace(
            one, values=tuple(sorted(one.values)), here=sorted(one.values).index(one.values[2])
        )
        for one in slides
    ]
    found = slider_patches(mechanism, slides)
    assert [group.singly for group in found.groups] == [True]
    there = run_by_node(
        page_with_sliders(found),
        """
        const every = given.slides.flatMap(
          (slide, s) => slide.values.map((_, k) => new Setting().with(s, k)));
        return every.map((one) => [one.positions, bits(one.vector), one.with(0, 0).positions, one.model]);
        """,
        tmp_path,
    )
    assert len(there) == sum(len(slide.values) for slide in found.slides)
    for positions, numbers, after, model in there:
        assert (bits_of(numbers, 1)[:, 0] == found.vector(positions).view(np.uint64)).all()
        assert after == [0, *(slide.here for slide in found.slides[1:])]
        assert model == found.model_file(positions)


def test_names_of_javascript_are_names_like_others(tmp_path):
    mechanism = gallery.four_bar_case_b()
    strange = ("constructor", "__proto__", "toString", "7")
    mechanism.joints = {
        new: dataclasses.replace(joint, name=new)
        for new, joint in zip(strange, mechanism.joints.values(), strict=True)
    }
    result = simulate(mechanism, turns=0.1, companions=0, reference=False, loop="data-driven")
    page = page_of(mechanism, step=result.record.assembly.choice.step)
    found = run_by_node(
        page,
        TURNS.replace("shown, start", "shown.map((one) => Object.entries(one.force)), start")
        % len(result.record.steps),
        tmp_path,
    )
    assert dict(found["turns"][0]) == {name: result.measures[f"{name}.force.max"] for name in strange}


def test_the_slider_of_a_tight_clearance_reaches_that_of_a_worn_pin() -> None:
    from types import SimpleNamespace

    from vfife.live.page.sliders import clearance_shares

    tight = SimpleNamespace(clearance=17e-6, bearing_radius=8e-3)
    low, high = clearance_shares(tight)
    assert low == 0.1 and high * 17e-6 == pytest.approx(2e-4)
    assert clearance_shares(SimpleNamespace(clearance=1e-4, bearing_radius=1e-3)) == (0.1, 2.5)
    assert clearance_shares(SimpleNamespace(clearance=1e-4)) == (0.1, 2.5)


def test_ranges_of_the_table_have_the_digits_in_which_their_ends_differ(tmp_path) -> None:
    """Two ends are never the same text; what differs in the fifth digit alone is one number."""
    tables = (BROWSER / "tables.js").read_text("utf-8")
    texts = run_by_node(
        page_of(gallery.four_bar_case_b()),
        f"""{tables}
        return [[1401.2, 1403.9], [1403.1, 1403.2], [999.7, 1001], [120, 130], [0, 12]]
          .map((ends) => rangeText(ends, "N"))
          .concat([rangeText([3, 5], "1"), rangeText([7, 7], "N"), endsText(3.201, 3.204, percent)]);""",
        tmp_path,
    )
    expected = ["1.401 … 1.404 kN", "1.403 kN", "0.9997 … 1.001 kN", "120 … 130 N", "0 … 12 N", "3 … 5", ""]
    assert texts == [*expected, "+3.201 % … +3.204 %"]
