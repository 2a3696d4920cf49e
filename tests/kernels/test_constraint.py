"""How bodies in ideal joints answer to a contact: with the reactions that come with it, so that the joints
stay closed.
"""

import numpy as np
import pytest

from vfife.compiler.trace.tables import tables
from vfife.kernels.arrays import CONSTRAINT, CONSTRAINT_INDEX, CONTACT, CONTACT_INDEX, HEADER, PARTICLE
from vfife.kernels.constraint import Row, apply_response, joint_compliance, levers
from vfife.kernels.contact_forces import apply_contact_force
from vfife.kernels.factors import factor, fill
from vfife.kernels.topology import LOCKED, PINNED, Topology
from vfife.laws import Frictionless, LankaraniNikravesh

H, NORMAL, FRICTION = 2e-5, 300.0, -80.0


def test_velocities_and_forces_change_as_one():
    """By M^-1 f h with the contact's forces and the reactions, in directions that the joints allow; along n
    and t as the compliance has it.
    """
    topology = Topology(
        particles=4, free=(1, 2, 3), trig=(1, 2, 3), joint_bearing=(0, 0, 2), joint_journal=(1, 3, 3),
        joint_place=(PINNED,) * 3, joint_turn=(0, 0, LOCKED), contact_bearing=(1,), contact_journal=(2,),
        contact_form=(0,), friction_form=(0,),
        contact_laws=(LankaraniNikravesh,), friction_laws=(Frictionless,),
    )  # fmt: skip
    integers, layout, rows = tables(topology)
    S, I = [0.0] * rows, integers.tolist()
    rng = np.random.default_rng(7)
    for i in range(4):
        base = layout.record("particle", i)
        angle = float(rng.uniform(-1.0, 1.0)) if i else 0.0
        values = {"x": 0.2 * i, "y": 0.1 * i, "theta": angle, "c": np.cos(angle), "s": np.sin(angle)}
        values |= {"inverse_mass": 0.5 + 0.2 * i, "inverse_inertia": 2.0 + i} if i else {}
        for name, value in values.items():
            S[base + getattr(PARTICLE, name)] = float(value)
    for k in range(3):
        for name in ("bearing_x", "bearing_y", "journal_x", "journal_y"):
            S[layout.row(f"joint_{name}", k)] = float(rng.uniform(-0.3, 0.3))
    levers(S, I)
    fill(S, I)
    factor(S, I, 0.0)
    r = I[HEADER.contact]
    j, b, k = I[r], I[r + CONTACT_INDEX.bearing], I[r + CONTACT_INDEX.journal]
    for name, value in {"nx": 0.6, "ny": 0.8, "jn": 0.11, "jt": -0.07, "bn": 0.05, "bt": 0.13}.items():
        S[j + getattr(CONTACT, name)] = value
    gn, gt, gm = joint_compliance(S, I, b, k, Row(0.6, 0.8, 0.05, 0.11), Row(-0.8, 0.6, 0.13, -0.07))
    apply_contact_force(S, j, b, k, NORMAL, FRICTION)
    apply_response(S, I, H, NORMAL, FRICTION)
    bodies = [layout.record("particle", i) for i in (1, 2, 3)]
    for i in bodies:
        felt = [S[i + name] for name in (PARTICLE.fx, PARTICLE.fy, PARTICLE.mz)]
        inverse = [S[i + PARTICLE.inverse_mass]] * 2 + [S[i + PARTICLE.inverse_inertia]]
        moved = [S[i + name] for name in (PARTICLE.vu, PARTICLE.vv, PARTICLE.vw)]
        assert moved == pytest.approx(H * np.array(felt) * inverse, rel=1e-11)
    for m in range(I[HEADER.constraint_count]):
        at = I[HEADER.constraint] + CONSTRAINT_INDEX.SIZE * m
        q, p, n = (
            I[at + CONSTRAINT_INDEX.row],
            I[at + CONSTRAINT_INDEX.bearing],
            I[at + CONSTRAINT_INDEX.journal],
        )
        along = S[q + CONSTRAINT.nx] * (S[n + PARTICLE.vu] - S[p + PARTICLE.vu]) + S[q + CONSTRAINT.ny] * (
            S[n + PARTICLE.vv] - S[p + PARTICLE.vv]
        )
        assert along + S[q + CONSTRAINT.jk] * S[n + PARTICLE.vw] - S[q + CONSTRAINT.jb] * S[
            p + PARTICLE.vw
        ] == pytest.approx(0.0, abs=1e-16)
    ru, rv = S[k + PARTICLE.vu] - S[b + PARTICLE.vu], S[k + PARTICLE.vv] - S[b + PARTICLE.vv]
    rate = 0.6 * ru + 0.8 * rv + 0.11 * S[k + PARTICLE.vw] - 0.05 * S[b + PARTICLE.vw]
    slip = 0.6 * rv - 0.8 * ru - 0.07 * S[k + PARTICLE.vw] - 0.13 * S[b + PARTICLE.vw]
    assert (rate, slip) == pytest.approx(
        (H * (gm * FRICTION - gn * NORMAL), H * (gt * FRICTION - gm * NORMAL)), rel=1e-11
    )
