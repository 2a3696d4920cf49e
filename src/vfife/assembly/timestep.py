"""The largest step that stays stable, what sets it, and the step a run takes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from ..errors import StepError
from ..kernels.arrays import Layout
from ..kernels.topology import Topology
from ..laws.elasticity import elastic_energy, tangent
from ..model.functions import turn_of
from ..model.mechanism import Mechanism
from .assembled import StepChoice

if TYPE_CHECKING:
    from .entities import Touch

Array = NDArray[np.float64]

SAFETY = 0.9
CONTACT_STEPS = 80  # steps in half a period of the stiffest contact
TURN_STEPS = 3600  # steps a turn where nothing else limits them
MOST_STEPS = 10**15  # time is the number of the step times its size: beyond, it would no longer be exact


def element_limits(layout: Layout, state: Array, topology: Topology) -> tuple[Array, Array]:
    """Stable steps (s) of each element, axial and bending.

    Mass of a node is shared among its elements in the ratio of their stiffness, so each bound holds for the whole (Irons and Treharne 1971):
    axial w^2 = sum over both nodes of K/m, K the sum of EA/l there. Bending of particles with rotary inertia: the symmetric and the
    antisymmetric mode, EI/l and 3 EI/l with the rotations, 12 EI/l^3 with the translations, added.
    """
    nodes = np.array(topology.frame_nodes, dtype=int).reshape(-1, 2)
    inverse = state[layout["reference_inverse_length"]]
    axial = state[layout["frame_axial_stiffness"]] * inverse
    release = np.array(topology.frame_release)
    bend = np.where(
        release == 0,
        state[layout["frame_bending_stiffness"]] * inverse,
        np.where(release == 3, 0.0, 0.75 * state[layout["frame_bending_stiffness"]] * inverse),
    )
    im, ii = state[layout["particle_inverse_mass"]], state[layout["particle_inverse_inertia"]]

    def at_nodes(stiffness: Array) -> Array:
        total = np.zeros(topology.particles)
        for column in (0, 1):
            np.add.at(total, nodes[:, column], stiffness)
        return total

    def both(values: Array) -> Array:
        return np.asarray(values[nodes].sum(axis=1))

    stretch = both(at_nodes(axial) * im)
    sway = both(at_nodes(12.0 * bend * inverse**2) * im)
    turn = both(at_nodes(4.0 * bend) * ii)
    with np.errstate(divide="ignore"):
        return 2.0 / np.sqrt(stretch), 2.0 / np.sqrt(sway + turn)


def joint_mobility(layout: Layout, state: Array, topology: Topology, index: int) -> float:
    """Largest inverse mass (1/kg) that a clearance joint can meet in any direction."""
    total = 0.0
    for side, bodies in (("bearing", topology.contact_bearing), ("journal", topology.contact_journal)):
        body = bodies[index]
        arm = state[layout.row(f"contact_{side}_x", index)] ** 2 + state[layout.row(f"contact_{side}_y", index)] ** 2
        total += state[layout.row("particle_inverse_mass", body)] + arm * state[layout.row("particle_inverse_inertia", body)]
    return total


def contact_limits(touches: Sequence[Touch], layout: Layout, state: Array, topology: Topology, expected: Mapping[str, float]) -> dict[str, float]:
    """Stable step (s) of each contact at the tangent of its law under twice the force it is expected to carry."""
    limits = {}
    for index, touch in enumerate(touches):
        joint = touch.joint
        row = layout.row("contact_slots", index)
        slots = tuple(float(v) for v in state[row : row + len(joint.contact.slots)])
        mobility = joint_mobility(layout, state, topology, index)
        force = 2.0 * expected.get(joint.name, 0.0) or _impact_force(joint, slots, state, layout, mobility)
        stiffness = tangent(joint.contact, slots, force)[1]
        limits[touch.name] = 2.0 / math.sqrt(stiffness * mobility) if mobility > 0.0 else math.inf
    return limits


def spring_limits(layout: Layout, state: Array, topology: Topology, names: Sequence[str] = ()) -> list[tuple[str, float]]:
    """Stable step (s) of each spring: its stiffness on the inverse masses of its two bodies, arms included."""
    found = []
    for index, (first, second) in enumerate(zip(topology.spring_first, topology.spring_second, strict=True)):
        row = layout.row("spring_stiffness", index)
        straight, turning = float(state[row : row + 2].max()), float(state[row + 2])
        total, spin = 0.0, 0.0
        for side, body in (("first", first), ("second", second)):
            arm = state[layout.row(f"spring_{side}_x", index)] ** 2 + state[layout.row(f"spring_{side}_y", index)] ** 2
            inverse = state[layout.row("particle_inverse_inertia", body)]
            total += state[layout.row("particle_inverse_mass", body)] + arm * inverse
            spin += inverse
        square = straight * total + turning * spin
        if square > 0.0:
            found.append((f"spring {names[index] if names else index + 1}", 2.0 / math.sqrt(square)))
    return found


def arm_limits(layout: Layout, state: Array, topology: Topology, names: Sequence[str]) -> list[tuple[str, float]]:
    """Steps (s) beyond which an ideal joint far outside a light body's radius of gyration k is no longer closed by one correction.

    The correction turns the body's arm r by what it would be worth at the present angle; the error grows where (w dt)^2 r^2/k^2 is not small. The
    bound, a sixth of k/(r w) at the fastest turning of the start, was found by trial.
    """
    spin = float(np.abs(state[layout["particle_w"]]).max(initial=0.0))
    found = []
    for k, name in enumerate(names):
        for side, bodies in (("bearing", topology.joint_bearing), ("journal", topology.joint_journal)):
            mass, inertia = (float(state[layout.row(f"particle_inverse_{kind}", bodies[k])]) for kind in ("mass", "inertia"))
            arm = math.hypot(*(state[layout.row(f"joint_{side}_{axis}", k)] for axis in "xy"))
            if mass > 0.0 and inertia > 0.0 and arm * spin > 0.0:
                found.append((f"small inertia on an arm at joint {name}", math.sqrt(mass / inertia) / (6.0 * arm * spin)))
    return sorted(found, key=lambda entry: entry[1])[:1]


def _impact_force(joint: object, slots: tuple[float, ...], state: Array, layout: Layout, mobility: float) -> float:
    """Force of an impact at the largest speed in the mechanism, where no ideal reaction is known."""
    speed = max(float(np.hypot(state[layout["particle_u"]], state[layout["particle_v"]]).max()), 0.1)
    energy = 0.5 * speed**2 / max(mobility, 1e-12)
    depth = 1e-9
    law = joint.contact  # type: ignore[attr-defined]
    while float(elastic_energy(law, np.array([depth]), slots)[0]) < energy and depth < 1.0:
        depth *= 1.1
    return float(law.force(depth, 0.0, slots)[0])


def choose_step(
    mechanism: Mechanism,
    layout: Layout,
    state: Array,
    topology: Topology,
    touches: Sequence[Touch],
    step: float | str | None,
    expected: Mapping[str, float] | None,
    owners: Sequence[str] = (),
    ideals: Sequence[str] = (),
    *,
    turns: float | None = None,
    duration: float | None = None,
    outputs: int | None = None,
    force_step: bool = False,
    free: int = 0,
) -> StepChoice:
    """The step, its limits, and the number of steps and outputs.

    "auto" takes 0.9 of the stable step, at most 1/80 of half a period of the stiffest contact, and divides a turn into whole steps; where ``free``
    motions are left to a driven mechanism, they have a period of their own, which may be shorter than a turn. Raises
    StepError for a larger one than stable unless ``force_step``.
    """
    if mechanism.settings.analysis == "static":
        return static_choice(mechanism)
    limits = _limits(touches, layout, state, topology, expected or {}, owners, tuple(mechanism.springs))
    limits += arm_limits(layout, state, topology, ideals)
    stable, culprit = min(((value, name) for name, value in limits), default=(math.inf, "nothing"))
    turn = turn_of(mechanism)
    settings = mechanism.settings
    length = _length(mechanism, turns, duration, turn)
    wanted: float | Literal["auto"] | str = settings.step if step is None else step
    per = outputs or settings.outputs
    if wanted == "auto":
        largest = SAFETY * stable
        for name, value in contact_limits(touches, layout, state, topology, expected or {}).items():
            accurate = 0.5 * math.pi * value / CONTACT_STEPS
            largest, culprit = min((largest, culprit), (accurate, f"joint {name}, {CONTACT_STEPS} steps in half a period of its contact"))
        own = _time_scale(mechanism, layout, state, length) if free or not turn else math.inf
        default = (min(turn or math.inf, own) / TURN_STEPS, f"{TURN_STEPS} steps a turn" if turn and turn <= own else "the motion itself")
        largest, culprit = min((largest, culprit), default)
        chunk = turn or length / max(1, round(length / (turn or length)))
        every = max(1, math.ceil(chunk / per / largest * (1.0 - 1e-12)))
        size = chunk / (per * every)
    else:
        size = float(wanted)
        if size > SAFETY * stable and not force_step:
            raise StepError(
                f"a step of {size:.4g} s is too large: {culprit} allows {stable:.4g} s, and {SAFETY} of it ({SAFETY * stable:.4g} s) is the most "
                f'that is taken; use "auto" or a smaller step, or force it if you know better (--force-step)'
            )
        every = _divisor(max(1, round((turn or length) / size)), per)
    every = min(every, max(1, math.ceil(length / size * (1.0 - 1e-9))))  # a run may be shorter than the time between two outputs of a turn
    count = max(1, math.ceil(length / size / every * (1.0 - 1e-9)))
    if not every * count <= MOST_STEPS:
        raise StepError(
            f"a run of {length:.4g} s in steps of {size:.4g} s takes {length / size:.1e} of them, and no run does more than {MOST_STEPS:.0e}; "
            f"the step was {f'chosen for {culprit}' if wanted == 'auto' else 'given'}: check the units of lengths, masses, stiffnesses and speeds"
        )
    return StepChoice(size, stable, culprit, wanted == "auto", tuple(limits), turn, every, count)


def static_choice(mechanism: Mechanism) -> StepChoice:
    """One step for each load factor, and no limit: the iterations of a static analysis have a step of their own."""
    return StepChoice(1.0, math.inf, "fictitious masses", True, (), None, 1, len(mechanism.settings.load_factors))


def _limits(
    touches: Sequence[Touch],
    layout: Layout,
    state: Array,
    topology: Topology,
    expected: Mapping[str, float],
    owners: Sequence[str],
    springs: Sequence[str],
) -> list[tuple[str, float]]:
    limits = [(f"contact of joint {name}", value) for name, value in contact_limits(touches, layout, state, topology, expected).items()]
    limits += spring_limits(layout, state, topology, springs)
    if topology.frame_nodes:
        for kind, steps in zip(("axial", "bending"), element_limits(layout, state, topology), strict=True):
            worst = int(np.argmin(steps))
            if math.isfinite(steps[worst]):
                owner = owners[worst] if owners else "the model"
                number = worst - owners.index(owner) + 1 if owners else worst + 1
                limits.append((f"element {number} of {owner} ({kind})", float(steps[worst])))
    return limits


def _length(mechanism: Mechanism, turns: float | None, duration: float | None, turn: float | None) -> float:
    settings = mechanism.settings
    if turns is None and duration is None:
        turns, duration = settings.turns, settings.duration
    if duration is not None:
        return duration
    if turn is None:
        if turns is not None:
            raise ValueError("a run of so many turns needs a driver; give a duration in seconds instead")
        return 1.0
    return (2.0 if turns is None else turns) * turn


def _divisor(per_turn: int, outputs: int) -> int:
    """Steps between outputs: a divisor of the steps of a turn, so that a turn holds whole intervals, near what is asked for."""
    wanted = max(1, round(per_turn / outputs))
    if wanted > 100_000:
        return wanted
    near = sorted(range(max(1, wanted // 2), 2 * wanted + 1), key=lambda every: abs(every - wanted))
    return next((every for every in near if per_turn % every == 0), wanted)


def _time_scale(mechanism: Mechanism, layout: Layout, state: Array, length: float) -> float:
    """A period (s) to be resolved where no crank gives one: size over the largest speed, or the root of size over gravity."""
    size = max([math.hypot(*pin) for body in mechanism.bodies.values() for pin in body.points.values()] + [1e-3])
    gravity = math.hypot(*mechanism.gravity)
    speed = float(np.hypot(state[layout["particle_u"]], state[layout["particle_v"]]).max())
    spin = float(np.abs(state[layout["particle_w"]]).max())
    scales = [2.0 * math.pi * math.sqrt(size / gravity)] if gravity else []
    scales += [2.0 * math.pi * size / speed] if speed else []
    scales += [2.0 * math.pi / spin] if spin else []
    return min([*scales, length])
