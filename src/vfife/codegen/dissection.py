"""The order in which joints are eliminated from the equations of the reactions.

From the last joint of a chain to the first, a pivot waits for the one before it, and so does each row of both substitutions. From both ends to the
middle (Babuška 1972) half as many wait, with the same operations; in a tree all leaves begin at once. That is the order of least degree (Tinney and
Walker 1967), of joints alike the one that waits least: no joint then gets more neighbours than it needs to have.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence


def elimination_order(joints: Sequence[Sequence[int]]) -> tuple[int, ...]:
    """Joints, each given by the free bodies that it joins, in the order of their elimination, those that wait for one another side by side."""
    at: dict[int, set[int]] = {}
    for joint, bodies in enumerate(joints):
        for body in bodies:
            at.setdefault(body, set()).add(joint)
    beside = [set().union(*(at[body] for body in bodies)) - {joint} for joint, bodies in enumerate(joints)]
    waits = [0] * len(joints)
    after: list[list[int]] = [[] for _ in joints]  # joints of which this is the next that waits for them
    roots: list[int] = []
    place: dict[int, int] = {}
    ready = [(len(others), 0, joint) for joint, others in enumerate(beside)]
    heapq.heapify(ready)
    eliminated: list[int] = []
    while ready:
        degree, waited, joint = heapq.heappop(ready)
        if joint in place or (degree, waited) != (len(beside[joint]), waits[joint]):
            continue
        place[joint] = len(eliminated)
        eliminated.append(joint)
        for other in beside[joint]:
            beside[other] |= beside[joint]
            beside[other] -= {joint, other}
            waits[other] = max(waits[other], waits[joint] + 1)
            heapq.heappush(ready, (len(beside[other]), waits[other], other))
    for joint in eliminated:
        later = min(beside[joint], key=place.__getitem__, default=None)
        (roots if later is None else after[later]).append(joint)
    return _behind(roots, after)


def _behind(roots: list[int], after: list[list[int]]) -> tuple[int, ...]:
    """Every joint behind all that it waits for, and these one chain after the other: a profile is as narrow as it can be then."""
    found: list[int] = []
    waiting = roots[::-1]
    seen: set[int] = set()
    while waiting:
        joint = waiting[-1]
        if joint in seen:
            found.append(waiting.pop())
        else:
            seen.add(joint)
            waiting += after[joint][::-1]
    return tuple(found)
