"""Rows of constraints of rigid systems that differ in numbers alone: phi, G and gamma of all cases of a batch
at once.

What a row measures, which way it pulls and on which lever is the text of the step,
:mod:`vfife.kernels.constraint`, run on arrays; gamma comes from the same text, run on numbers that carry
their derivatives in time. Each entry is the same sum of the same terms in a batch of any size, so a case has
the bits that it has alone. Positions are (..., cases, bodies, 3) with (x, y, theta) of centres of mass in m
and rad, the ground first; the axis of the cases is missing where there is one system, and further axes come
before it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from copy import copy
from functools import lru_cache
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels import constraint, geometry
from ..kernels.constraint import Guide
from ..kernels.topology import ACROSS_LINE, ALONG_LINE, ON_PATH, PINNED, SPACED, UNPLACED
from ..model.rows import AcrossGuide, AlongGuide, Coincide, FixedDistance, OnPath
from ..numerics.elementwise import sincos
from .constraints import Constraint
from .linalg import DENSE, Matrix, matrix

Array = NDArray[np.float64]
Places = NDArray[np.intp]

PLACE_KINDS = {
    type(None): UNPLACED,
    Coincide: PINNED,
    AcrossGuide: ACROSS_LINE,
    AlongGuide: ALONG_LINE,
    FixedDistance: SPACED,
    OnPath: ON_PATH,
}
SIGNS = np.array([[-1.0], [1.0]])  # of what a row measures, on bodies a and b
GUESS_DISTANCE = 1e-9  # of the length of a massless link whose pins a first guess puts in one place


class Taylor:
    """value + rate t + second t^2/2, of plain numbers or of arrays of them; comparisons are those of the
    values.
    """

    __array_ufunc__ = None  # so that arrays leave what they do with it to it
    __slots__ = ("rate", "second", "value")

    def __init__(self, value: Any, rate: Any = 0.0, second: Any = 0.0) -> None:
        self.value, self.rate, self.second = value, rate, second

    def __add__(self, other: Any) -> Taylor:
        o = other if isinstance(other, Taylor) else Taylor(other)
        return Taylor(self.value + o.value, self.rate + o.rate, self.second + o.second)

    __radd__ = __add__

    def __neg__(self) -> Taylor:
        return Taylor(-self.value, -self.rate, -self.second)

    def __sub__(self, other: Any) -> Taylor:
        o = other if isinstance(other, Taylor) else Taylor(other)
        return Taylor(self.value - o.value, self.rate - o.rate, self.second - o.second)

    def __rsub__(self, other: Any) -> Taylor:
        return taylor(other) + -self

    def __mul__(self, other: Any) -> Taylor:
        a, b = self, other if isinstance(other, Taylor) else Taylor(other)
        return Taylor(
            a.value * b.value,
            a.rate * b.value + a.value * b.rate,
            a.second * b.value + 2.0 * a.rate * b.rate + a.value * b.second,
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Taylor:
        b = taylor(other)
        value = self.value / b.value
        rate = (self.rate - value * b.rate) / b.value
        return Taylor(value, rate, (self.second - 2.0 * rate * b.rate - value * b.second) / b.value)

    def __rtruediv__(self, other: Any) -> Taylor:
        return taylor(other) / self

    def __abs__(self) -> Taylor:
        return self if self.value >= 0.0 else -self

    def part(self, index: Any) -> Taylor:
        """Select entries of the three arrays."""
        return Taylor(self.value[index], self.rate[index], self.second[index])

    def __lt__(self, other: Any) -> Any:
        return self.value < taylor(other).value

    def __le__(self, other: Any) -> Any:
        return self.value <= taylor(other).value

    def __gt__(self, other: Any) -> Any:
        return self.value > taylor(other).value

    def __ge__(self, other: Any) -> Any:
        return self.value >= taylor(other).value


def taylor(number: Any) -> Taylor:
    """Convert a plain number to a constant with zero derivatives."""
    return number if isinstance(number, Taylor) else Taylor(number)


def sqrt(number: Any) -> Any:
    """Square root of a plain number, of an array of them, or of one with derivatives."""
    if not isinstance(number, Taylor):
        return np.sqrt(number) if hasattr(number, "shape") else math.sqrt(number)
    value = sqrt(number.value)
    half = 0.5 / value
    rate = half * number.rate
    return Taylor(value, rate, half * (number.second - 2.0 * rate * rate))


def lifted(*modules: ModuleType) -> Any:
    """Return the functions of kernels with a square root that also differentiates; they call one another."""
    space: dict[str, Any] = {}
    for module in modules:
        space |= vars(module)
    functions: dict[str, Callable[..., Any]] = {}
    for name, value in list(space.items()):
        if isinstance(value, FunctionType):
            functions[name] = FunctionType(value.__code__, space, name, value.__defaults__)
    space |= {**functions, "math": SimpleNamespace(sqrt=sqrt)}
    return SimpleNamespace(**functions)


KERNEL = lifted(geometry, constraint)  # arm, lever, guide_row and relative_turn, as the step has them


class Group(NamedTuple):
    """Constraints [k] with a place of one kind: their numbers, first rows, and where blocks of bodies a and b
    are are [rows, 2, k].
    """

    owner: Places
    row: Places
    blocks: Places


class Pattern(NamedTuple):
    """Where the entries of G are, constraint by constraint, row by row, body by body: blocks of (x, y, turn);
    those of the ground are left out.
    """

    bodies: Places  # [3, constraints]: a, b and c
    rows: Places
    columns: Places
    owner: Places  # body of each entry that is a turn, 0 of others
    repeated: bool  # whether two entries share a place
    groups: tuple[tuple[int, Group], ...]
    turns: Places
    turn_rows: Places
    turn_entries: Places  # [3, turns]
    size: int  # rows


@lru_cache(maxsize=64)
def pattern(ties: tuple[tuple[int, int, int, int, bool], ...]) -> Pattern:
    """Locate the entries of constraints in the sparse Jacobian, each (body a, b and c, kind of its place row,
    whether it has a rotation row).
    """
    rows: list[int] = []
    columns: list[int] = []
    groups: dict[int, list[tuple[int, int, list[list[int]]]]] = {}
    turns: list[tuple[int, int, list[int]]] = []
    row, beyond_last = 0, -3  # behind the last entry lies one more block, which takes what is of the ground
    for k, (a, b, c, kind, turn) in enumerate(ties):
        blocks: list[list[int]] = []
        first = row
        for _ in range((2 if kind == PINNED else 0 if kind == UNPLACED else 1) + turn):
            blocks.append([])
            for body in (a, b, c):
                blocks[-1].append(len(rows) if body else beyond_last)
                rows += (row,) * 3 if body else ()
                columns += range(3 * body - 3, 3 * body) if body else ()
            row += 1
        if kind != UNPLACED:
            groups.setdefault(kind, []).append(
                (k, first, [block[:2] for block in blocks[: 2 if kind == PINNED else 1]])
            )
        if turn:
            turns.append((k, row - 1, [entry + 2 for entry in blocks[-1]]))
    bodies = np.array(ties, dtype=np.intp).reshape(-1, 5)[:, :3].T
    owners = np.array(columns, dtype=np.intp) // 3 + 1
    places = set(zip(rows, columns, strict=True))
    numbered = np.array([(k, at, *entries) for k, at, entries in turns], dtype=np.intp).reshape(-1, 5).T
    return Pattern(
        bodies, np.array(rows, dtype=np.intp), np.array(columns, dtype=np.intp),
        np.where(np.arange(len(owners)) % 3 == 2, owners, 0),
        len(places) < len(rows), tuple((kind, _group(kind, members)) for kind, members in groups.items()),
        numbered[0], numbered[1], numbered[2:], row,
    )  # fmt: skip


def _group(kind: int, members: list[tuple[int, int, list[list[int]]]]) -> Group:
    owner, row, blocks = zip(*members, strict=True)
    places = np.array(blocks, dtype=np.intp).reshape(len(owner), -1, 2)
    return Group(np.array(owner, dtype=np.intp), np.array(row, dtype=np.intp), np.moveaxis(places, 0, -1))


class Aims(NamedTuple):
    """What rows keep: places along guides and lengths (m), and angles (rad), both (..., constraints)."""

    place: Array
    turn: Array


class ConstraintRows:
    """The rows of constraints, of which each case has its own numbers: phi [r] (m), G [r, 3(n-1)] in (x, y, l
    theta), gamma [r] (m/s2).

    ``reach`` (..., n) divides turns and ``lengths`` (..., k) multiplies rows of angles, both in m.
    """

    def __init__(
        self, cases: Sequence[Sequence[Constraint]], lengths: Array, reach: Array, single: bool = False
    ) -> None:
        first, self.cases, self.single = cases[0], cases, single
        numbers = np.array([[tie.numbers for tie in case] for case in cases], dtype=float).reshape(
            len(cases), len(first), 11
        )
        numbers = np.moveaxis(numbers[0] if single else numbers, -1, 0)
        self.points = (
            np.stack([*numbers[:4:2]], axis=-2),
            np.stack([*numbers[1:4:2]], axis=-2),
        )  # x and y, (..., 2, constraints) of bodies a and b
        self.direction = numbers[4:6]
        self.ratio, self.speed, self.acceleration = numbers[8:]
        self.aims, self.lengths, self.reach = Aims(numbers[6], numbers[7]), lengths, reach
        ties = tuple(
            (tie.body_a, tie.body_b, tie.body_c, PLACE_KINDS[type(tie.place)], tie.turn is not None)
            for tie in first
        )
        self.pattern = pattern(ties)
        self.columns = 3 * reach.shape[-1] - 3
        self.arms = np.where(
            self.pattern.owner > 0, reach[..., self.pattern.owner], 1.0
        )  # of entries that are turns
        self.constant = self._constant()

    def _constant(self) -> Array:
        """Entries that no position changes: of pins along x and y, and of turns."""
        result = np.zeros((*self.lengths.shape[:-1], len(self.pattern.rows) + 3))
        for kind, group in self.pattern.groups:
            for side, sign in ((0, -1.0), (1, 1.0)):
                for axis in (0, 1) if kind == PINNED else ():
                    result[..., group.blocks[axis, side] + axis] = sign
        turns = self.pattern.turns
        length, ratio = self.lengths[..., turns], self.ratio[..., turns]
        for entries, value in zip(
            self.pattern.turn_entries, (-length * ratio, length, -length * (1.0 - ratio)), strict=True
        ):
            result[..., entries] = value
        return result

    def aimed(self, first: int, aims: Array) -> Aims:
        """Return the prescribed values with ``aims`` (..., d) (rad, m) in the constraints from
        ``first`` on.
        """
        shape = np.broadcast_shapes((*aims.shape[:-1], len(self.cases[0])), self.aims.turn.shape)
        place, turn = self.aims.place, np.empty(shape)
        turn[...] = self.aims.turn
        turn[..., first:] = aims
        travels = [k for k, tie in enumerate(self.cases[0][first:]) if isinstance(tie.place, AlongGuide)]
        if travels:
            place = np.broadcast_to(place, shape).copy()
            place[..., [first + k for k in travels]] = np.broadcast_to(aims, turn[..., first:].shape)[
                ..., travels
            ]
        return Aims(place, turn)

    def at(self, position: Array, aims: Aims | None = None) -> tuple[Array, Array]:
        """phi (..., r) and the entries of G (..., entries) at positions (..., n, 3)."""
        aims = self.aims if aims is None else aims
        bodies, turns = self.pattern.bodies[:2], self.pattern.turns
        x, y, angles = position[..., 0], position[..., 1], position[..., 2]
        s, c = sincos(angles)
        cosine, sine = c[..., bodies], s[..., bodies]
        arm = KERNEL.arm(cosine, sine, *self.points)
        place = x[..., bodies], y[..., bodies]
        pin_x, pin_y = place[0] + arm[0], place[1] + arm[1]
        ex, ey = pin_x[..., 1, :] - pin_x[..., 0, :], pin_y[..., 1, :] - pin_y[..., 0, :]
        lead = ex.shape[:-1]
        phi, entries = np.zeros((*lead, self.pattern.size)), np.empty((*lead, self.constant.shape[-1]))
        entries[...] = self.constant
        # Kind by kind: all pins, then all guides of a sort. The order of constraints does not matter, since
        # each has entries and rows of its own.
        for kind, (owner, row, blocks) in self.pattern.groups:
            arm_x, arm_y, gap = arm[0][..., owner], arm[1][..., owner], (ex[..., owner], ey[..., owner])
            if kind == PINNED:
                phi[..., row], phi[..., row + 1] = gap
                entries[..., blocks[0] + 2] = KERNEL.lever(arm_x, arm_y, 1.0, 0.0) * SIGNS
                entries[..., blocks[1] + 2] = KERNEL.lever(arm_x, arm_y, 0.0, 1.0) * SIGNS
                continue
            measured, nx, ny = self._placed(kind, owner, (cosine[..., 0, owner], sine[..., 0, owner]), *gap)
            phi[..., row] = measured - aims.place[..., owner]
            arm_x[..., 0, :] = (
                arm_x[..., 1, :] + place[0][..., 1, owner] - place[0][..., 0, owner]
            )  # the foot of the journal's pin, on body a
            arm_y[..., 0, :] = arm_y[..., 1, :] + place[1][..., 1, owner] - place[1][..., 0, owner]
            nx, ny = nx[..., None, :], ny[..., None, :]
            for axis, value in enumerate((nx, ny, KERNEL.lever(arm_x, arm_y, nx, ny))):
                entries[..., blocks[0] + axis] = value * SIGNS
        if len(turns):
            angle = angles[..., self.pattern.bodies[:, turns]]
            turned = KERNEL.relative_turn(
                angle[..., 0, :], angle[..., 1, :], self.ratio[..., turns], angle[..., 2, :]
            )
            phi[..., self.pattern.turn_rows] = self.lengths[..., turns] * (turned - aims.turn[..., turns])
        return phi, entries[..., :-3] / self.arms + 0.0

    def _placed(
        self, kind: int, owner: Places, face: tuple[Array, Array], ex: Array, ey: Array
    ) -> tuple[Array, Array, Array]:
        """Evaluate the place rows of one kind (m), with their directions in space."""
        if kind == ON_PATH:
            result = [
                self._on_path(owner, at, *(value[at] for value in (*face, ex, ey)))
                for at in np.ndindex(ex.shape)
            ]
            return tuple(np.array(result, dtype=float).reshape(*ex.shape, 3)[..., k] for k in range(3))  # type: ignore[return-value]
        if kind == SPACED:
            ex = np.where(
                (ex == 0.0) & (ey == 0.0), GUESS_DISTANCE * self.aims.place[..., owner], ex
            )  # any direction leads apart
        return KERNEL.guide_row((), Guide(kind, 0, 0, *self.direction[..., owner]), *face, ex, ey)  # type: ignore[no-any-return]

    def _on_path(self, owner: Places, at: tuple[int, ...], *gap: Any) -> tuple[Any, Any, Any]:
        """Evaluate the row of a pin in a curved slot. ``gap``: direction of the bearing's body, and the
        journal's pin seen from the bearing's pin.
        """
        pieces, count = self.cases[0 if self.single else at[-2]][owner[at[-1]]].pieces
        return KERNEL.guide_row(pieces, Guide(ON_PATH, 0, count, 1.0, 0.0), *gap)  # type: ignore[no-any-return]

    def gamma(self, position: Array, velocity: Array) -> Array:
        """- dG/dt v (..., r), and the accelerations of drives: second derivatives of phi with all
        accelerations zero, turned round.
        """
        a, b, _ = self.pattern.bodies
        s, c = sincos(position[..., 2])
        ends = []
        for side, body in enumerate((a, b)):
            cosine, sine, w = c[..., body], s[..., body], velocity[..., body, 2]
            face = Taylor(cosine, -sine * w, -cosine * w * w), Taylor(sine, cosine * w, -sine * w * w)
            x, y = (
                Taylor(position[..., body, axis], velocity[..., body, axis], np.zeros_like(w))
                for axis in (0, 1)
            )
            arm = KERNEL.arm(*face, *(point[..., side, :] for point in self.points))
            ends.append((x + arm[0], y + arm[1], face))
        (ax, ay, face_a), (bx, by, _) = ends
        ex, ey = bx - ax, by - ay
        result = np.zeros((*ex.value.shape[:-1], self.pattern.size))
        for kind, (owner, row, _) in self.pattern.groups:
            gap = [coordinate.part((..., owner)) for coordinate in (*face_a, ex, ey)]
            if kind == PINNED:
                result[..., row], result[..., row + 1] = -gap[2].second, -gap[3].second
            elif kind == ON_PATH:
                for at in np.ndindex(gap[0].value.shape):
                    result[(*at[:-1], row[at[-1]])] = -self._on_path(
                        owner, at, *(coordinate.part(at) for coordinate in gap)
                    )[0].second
            else:
                guide = Guide(kind, 0, 0, *self.direction[..., owner])
                result[..., row] = -KERNEL.guide_row((), guide, *gap)[0].second
        return result + self.accelerated()

    def accelerated(self) -> Array:
        """Return the accelerations that drivers prescribe (m/s², rad/s²), zero in other rows."""
        return self._of_drives(self.acceleration)

    def rate(self) -> Array:
        """Return the velocities that drivers prescribe (m/s, rad/s), zero in other rows."""
        return self._of_drives(self.speed)

    def _of_drives(self, values: Array) -> Array:
        result, row = np.zeros((*self.lengths.shape[:-1], self.pattern.size)), -1
        for k, tie in enumerate(self.cases[0]):
            row += tie.size
            if tie.driven:
                result[..., row] = (self.lengths[..., k] if tie.turns else 1.0) * values[..., k]
        return result

    def dense(self, entries: Array) -> Array:
        """G (..., r, 3(n-1)) from its entries, those of one place summed up in their order."""
        result = np.zeros((*entries.shape[:-1], self.pattern.size, self.columns))
        if self.pattern.repeated:
            np.add.at(result, (..., self.pattern.rows, self.pattern.columns), entries)  # type: ignore[arg-type]
        else:
            result[..., self.pattern.rows, self.pattern.columns] = entries
        return result

    def matrix(self, entries: Array) -> Matrix:
        """G of one system: dense, or sparse where it is large."""
        if self.columns <= DENSE:
            return self.dense(entries)
        return matrix(entries, self.pattern.rows, self.pattern.columns, (self.pattern.size, self.columns))

    def matrices(self, entries: Array) -> Any:
        """G of cases: [cases, r, 3(n-1)], or where they are large an array of the sparse matrix of the one
        case.
        """
        if self.columns <= DENSE:
            return self.dense(entries)
        result = np.empty(1, dtype=object)
        result[0] = self.matrix(entries[0])
        return result

    def select(self, chosen: NDArray[np.bool_] | None) -> ConstraintRows:
        """Select some of the cases; with None, make one system a batch of one."""
        result = copy(self)
        result.points = self.points[0][chosen], self.points[1][chosen]
        result.direction = self.direction[:, chosen]
        for name in ("ratio", "speed", "acceleration", "lengths", "arms", "reach", "constant"):
            setattr(result, name, getattr(self, name)[chosen])
        result.aims = Aims(*(aims[chosen] for aims in self.aims))
        result.cases = (
            self.cases if chosen is None else [self.cases[k] for k in np.flatnonzero(chosen).tolist()]
        )
        result.single = False
        return result

    def directions(self, entries: Array) -> list[Array]:
        """Directions in space (..., rows, 2) in which the rows of the place of each constraint pull at its
        body b.
        """
        result = [np.zeros((0, 2))] * len(self.cases[0])
        for _, group in self.pattern.groups:
            for k, blocks in zip(group.owner.tolist(), np.moveaxis(group.blocks, -1, 0), strict=True):
                side = 1 if self.pattern.bodies[1, k] else 0  # the ground has no entries
                result[k] = entries[..., blocks[:, side, None] + np.arange(2)] * (1.0 if side else -1.0)
        return result


def measured(travel: Constraint, position: Array) -> float:
    """Where the point of body b is along the guide of a travel without an aim (m), at a position [n, 3]."""
    return float(
        ConstraintRows([[travel]], np.ones(1), np.ones(len(position)), single=True).at(position)[0][0]
    )
