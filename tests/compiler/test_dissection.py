"""The order of elimination: chains from both ends, trees without a neighbour more, forces that do not depend
on it.
"""

import dataclasses

import numpy as np
import pytest

from support import four_bar
from vfife.assembly.assemble import assemble
from vfife.compiler.trace.graph import elimination_order
from vfife.solvers.transient import run


def eliminated(joints, order):
    """How many joints wait for one another, and how many pairs of them meet: those that share a body, and
    those that elimination adds.
    """
    beside = {j: {k for k in order if k != j and set(joints[j]) & set(joints[k])} for j in order}
    waits, pairs = dict.fromkeys(order, 1), 0
    for joint in order:
        pairs += len(beside[joint])
        for other in beside[joint]:
            beside[other] = (beside[other] | beside[joint]) - {joint, other}
            waits[other] = max(waits[other], waits[joint] + 1)
    return max(waits.values(), default=0), pairs


def chain(count):
    """Joint k holds bodies k - 1 and k; the first and the last hold one each."""
    return [tuple(body for body in (k - 1, k) if 0 <= body < count - 1) for k in range(count)]


def narrow(joints, order):
    """Sum over the joints of how far back the first one that it meets lies."""
    place = {joint: k for k, joint in enumerate(order)}
    return sum(
        place[j] - min([place[j], *(place[k] for k in order if set(joints[j]) & set(joints[k]))])
        for j in order
    )


@pytest.mark.parametrize("count", [0, 1, 2, 3, 6, 11, 40])
def test_a_chain_is_eliminated_from_both_ends(count):
    """Half as many joints wait for one another, none meets another one, and the profile is longer by one
    joint's rows alone.
    """
    joints = chain(count)
    order = elimination_order(joints)
    assert sorted(order) == list(range(count))
    assert eliminated(joints, order) == (
        count // 2 + (1 if count else 0) if count > 2 else count,
        max(count - 1, 0),
    )
    assert narrow(joints, order) <= 1.5 * max(count - 1, 0)


@pytest.mark.parametrize(
    ("joints", "order"),
    [
        ([(1,), (2,), (3,)], (0, 1, 2)),
        # The first pass takes 0, 4, 1, 3 and 2: the chain from 0 to 1 comes before that from 4 to 3.
        (chain(5), (0, 1, 4, 3, 2)),
        # It takes 0, 3, 1 and 2: of the joints that wait for none, 3 comes before 1, which waits for 0.
        (chain(4), (3, 0, 1, 2)),
    ],
    ids=["alone", "odd", "even"],
)
def test_ties_go_to_the_joint_with_the_lower_number(joints, order):
    assert elimination_order(joints) == order


@pytest.mark.parametrize("seed", range(8))
def test_trees_get_no_neighbours_and_others_no_more_than_in_their_own_order(seed):
    rng = np.random.default_rng(seed)
    tree = [(int(rng.integers(0, body)), body) if body else (0,) for body in range(30)]
    order = elimination_order(tree)
    waiting, pairs = eliminated(tree, order)
    others = eliminated(tree, rng.permutation(len(tree)).tolist())
    closed = [*tree, *[tuple(sorted(rng.choice(30, 2, replace=False).tolist())) for _ in range(5)]]
    assert pairs <= others[1] and waiting <= eliminated(tree, range(30))[0]
    assert eliminated(closed, elimination_order(closed))[1] <= eliminated(closed, range(35))[1]


def test_forces_do_not_depend_on_the_order_in_which_joints_are_given():
    """To rounding, over a twentieth of a turn: the ends of the chain of three joints change places."""
    found = []
    for names in ("ABCD", "CADB"):
        model = four_bar("")
        mixed = dataclasses.replace(model, joints={name: model.joints[name] for name in names})
        record = run(assemble(mixed, 2e-5, duration=2e-3, outputs=20), loop="generated")
        forces = record.block("joint_fx"), record.block("joint_fy")
        order = [record.assembly.ideals.index(name) for name in "BCD"]
        found.append(np.stack([force[:, order] for force in forces]))
    assert np.allclose(*found, rtol=1e-8, atol=1e-8 * np.abs(found[0]).max())
