"""Paths of straight pieces and arcs without corners: circles, and polylines with rounded corners."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...kernels.geometry import from_path
from ...numerics.scalar import atan2, cos, distance, sin, tan

Point = tuple[float, float]
Rows = tuple[float, ...]
SHARPEST = math.radians(175.0)  # turn of a corner, beyond which its arc would lie nowhere near it


@dataclass(frozen=True)
class Piece:
    """A piece from ``begin`` to ``end`` (m) with unit tangents at both and a ``curvature`` (1/m), positive to
    the left.

    ``opens`` and ``closes``: whether the piece is limited at its beginning and end; else it continues beyond
    it.
    """

    begin: Point
    tangent: Point
    curvature: float
    end: Point
    end_tangent: Point
    opens: bool = True
    closes: bool = True

    def numbers(self) -> Rows:
        """Return the piece as the kernels read it."""
        gate = self.end_tangent if self.closes else (0.0, 0.0)
        return (*self.begin, *self.tangent, self.curvature, 1.0 if self.opens else 0.0, *self.end, *gate)

    def mirrored(self) -> Piece:
        """Return the piece with y reversed."""
        begin, tangent, end, last = (
            (x, -y) for x, y in (self.begin, self.tangent, self.end, self.end_tangent)
        )
        return Piece(begin, tangent, -self.curvature, end, last, self.opens, self.closes)

    def points(self, share: float = 0.1) -> list[Point]:
        """Return points on the piece at most ``share`` rad of arc apart, including its ends."""
        turn = atan2(_cross(self.tangent, self.end_tangent), _dot(self.tangent, self.end_tangent))
        if self.curvature == 0.0:
            return [self.begin, self.end]
        if not self.opens and not self.closes:
            turn = math.copysign(2.0 * math.pi, self.curvature)
        elif turn * self.curvature < 0.0:
            turn = -turn  # half a circle, whose turn has either sign
        count, (x, y), (tx, ty), r = (
            max(2, math.ceil(abs(turn) / share)),
            self.begin,
            self.tangent,
            1.0 / self.curvature,
        )
        angles = [turn * k / count for k in range(count + 1)]
        return [
            (x + r * (sin(a) * tx - (1.0 - cos(a)) * ty), y + r * (sin(a) * ty + (1.0 - cos(a)) * tx))
            for a in angles
        ]


@dataclass(frozen=True)
class Path:
    """A sequence of pieces, each beginning with the end point and tangent of the one before."""

    pieces: tuple[Piece, ...]

    def numbers(self) -> list[Rows]:
        """Return all pieces as the kernels read them."""
        return [piece.numbers() for piece in self.pieces]

    def mirrored(self) -> Path:
        """Return the path with y reversed: left becomes right."""
        return Path(tuple(piece.mirrored() for piece in self.pieces))

    def points(self) -> list[Point]:
        """Return a polyline close to the path."""
        return [point for piece in self.pieces for point in piece.points()]

    def distance(self, x: float, y: float) -> float:
        """Return the distance (m) of a point from the path, positive on its left."""
        return self.nearest(x, y)[0]

    def nearest(self, x: float, y: float) -> tuple[float, float, float]:
        """Return the distance (m) of a point from the path, positive on its left, and the left normal of the
        path at the nearest point.
        """
        distance, nx, ny = from_path(
            [number for piece in self.numbers() for number in piece], 0, len(self.pieces), x, y
        )
        return float(distance), float(nx), float(ny)

    @property
    def sharpest(self) -> float:
        """Smallest radius (m) of its arcs, infinite if all pieces are straight."""
        return min((1.0 / abs(piece.curvature) for piece in self.pieces if piece.curvature), default=math.inf)


def circle(centre: Point, radius: float) -> Path:
    """Return an anticlockwise circle, whose left is inside: one unlimited piece."""
    start = (centre[0] + radius, centre[1])
    return Path((Piece(start, (0.0, 1.0), 1.0 / radius, start, (0.0, 1.0), opens=False, closes=False),))


def polyline(points: tuple[Point, ...], fillet: float) -> Path:
    """Return straight pieces through ``points``, each corner replaced by an arc of radius ``fillet`` (m) that
    is tangent to both.

    A pin cannot pass a corner without an impact; on an arc its force is finite. First and last piece continue
    beyond their ends. Raises ValueError for coinciding points, for a corner that turns back, and for a fillet
    longer than its pieces.
    """
    if len(points) < 2:
        raise ValueError(f"a path needs two points at least, not {len(points)}; give more")
    tangents, lengths = [], []
    for number, (a, b) in enumerate(zip(points, points[1:], strict=False), start=1):
        length = distance(a, b)
        if not 0.0 < length < math.inf:
            raise ValueError(
                f"points {number} and {number + 1} of the path, {a} and {b}, make no straight piece; leave"
                " one of them out"
            )
        tangents.append(((b[0] - a[0]) / length, (b[1] - a[1]) / length))
        lengths.append(length)
    turns = [atan2(_cross(t, u), _dot(t, u)) for t, u in zip(tangents, tangents[1:], strict=False)]
    cut = [0.0, *(_arc_length_share(turn, fillet, number) for number, turn in enumerate(turns, start=2)), 0.0]
    pieces, last = [], len(lengths) - 1
    for k, (length, t) in enumerate(zip(lengths, tangents, strict=True)):
        if cut[k] + cut[k + 1] > length * (1.0 + 1e-12):
            raise ValueError(
                f"the fillets of {fillet:.4g} m take {cut[k] + cut[k + 1]:.4g} m of the {length:.4g} m"
                f" between points {k + 1} and {k + 2} of the path; take a smaller fillet, or points farther"
                " apart"
            )
        begin, end = _moved(points[k], t, cut[k]), _moved(points[k + 1], t, -cut[k + 1])
        pieces.append(Piece(begin, t, 0.0, end, t, opens=k > 0, closes=k < last))
        if k < last and turns[k] != 0.0:
            arc_end = _moved(points[k + 1], tangents[k + 1], cut[k + 1])
            pieces.append(Piece(end, t, math.copysign(1.0 / fillet, turns[k]), arc_end, tangents[k + 1]))
    return Path(tuple(pieces))


def _arc_length_share(turn: float, fillet: float, number: int) -> float:
    """Return the length (m) that the arc of a corner takes from each adjacent piece."""
    if abs(turn) > SHARPEST:
        raise ValueError(
            f"the path turns back at point {number}, by {math.degrees(abs(turn)):.4g} degrees; at most 175"
            " can be rounded; move the point"
        )
    if turn and not fillet > 0.0:
        raise ValueError(
            f"the path has a corner at point {number} and no fillet to round it; give it a radius above 0 m"
        )
    return fillet * tan(0.5 * abs(turn))


def _moved(point: Point, direction: Point, way: float) -> Point:
    return point[0] + way * direction[0], point[1] + way * direction[1]


def _cross(a: Point, b: Point) -> float:
    return a[0] * b[1] - a[1] * b[0]


def _dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1]
