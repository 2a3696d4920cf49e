"""Which particle, element, function and joint has which number: a mechanism walked through in its order."""

from __future__ import annotations

from ..errors import VfifeError
from ..kernels.topology import CURRENT, REFERENCE
from ..kinematics.drives import kinematic_drivers, pivot_of
from ..kinematics.pins import local_point
from ..model.functions import Polynomials
from ..model.lumping import Mesh, is_elastic, mesh, rigid_properties
from ..model.mechanism import Mechanism
from .assembled import BodyMap

STRAINS = {"current": CURRENT, "reference": REFERENCE}
Side = tuple[str, str]
Place = tuple[int, tuple[float, float]]


class Numbering:
    """Particles, elements and functions in their order; particle 0 is the ground."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.bodies: dict[str, BodyMap] = {}
        self.meshes: dict[str, Mesh] = {}
        self.free: list[int] = []
        self.driven: list[str] = []
        self.elements: list[tuple[int, int]] = []
        self.releases: list[int] = []
        self.strains: list[int] = []
        self.functions: list[Polynomials] = []
        self.arguments: list[tuple[int, int, int]] = []
        self.travels: dict[int, tuple[float, ...]] = {}
        self.count = 1
        drivers = kinematic_drivers(mechanism)
        self.pivots = {name: pivot_of(mechanism, name) for name in drivers}
        for row, name in enumerate(mechanism.bodies):
            self._body(name, row, name in drivers)

    def _body(self, name: str, row: int, driven: bool) -> None:
        body = self.mechanism.bodies[name]
        mass, center, inertia = rigid_properties(body)
        pivot = next((side for side in self.pivots[name].sides if side[0] == name), None) if driven else None
        nodes = dict.fromkeys(body.points, 0)
        count = 1
        if is_elastic(body):
            self.meshes[name] = mesh(body)
            nodes, count = self.meshes[name].pins, len(self.meshes[name].mass)
        particles = tuple(range(self.count, self.count + count))
        self.count += count
        held = None
        if pivot is not None:
            held = particles[nodes.get(pivot[1], 0)]
            self.driven.append(name)
        self.free += particles if held is None else [p for p in particles if p != held]
        first = len(self.elements)
        if name in self.meshes:
            pairs = self.meshes[name].nodes + particles[0]
            self.elements += zip(pairs[:, 0].tolist(), pairs[:, 1].tolist(), strict=True)
            self.releases += self.meshes[name].release
            self.strains += [STRAINS[self.meshes[name].strain]] * len(pairs)
        reference = center if pivot is None else local_point(self.mechanism, pivot)
        self.bodies[name] = BodyMap(
            name, body.model, particles, tuple(range(first, len(self.elements))), row,
            len(self.driven) - 1 if driven else None, reference, mass, inertia, center, dict(body.points),
            {pin: particles[k] for pin, k in nodes.items()},
        )  # fmt: skip

    def place(self, side: Side) -> Place:
        """Particle that carries a pin, and the pin's place in the particle's frame (m)."""
        point = local_point(self.mechanism, side)
        if side[0] == "ground":
            return 0, point
        where = self.bodies[side[0]]
        if where.elements:
            if side[1] not in where.nodes:
                known = ", ".join(where.nodes)
                raise VfifeError(f"pin {side[0]}.{side[1]}: this {where.model} body has pins at {known} only; make it rigid, or split it there")
            return where.nodes[side[1]], (0.0, 0.0)
        return where.particles[0], (point[0] - where.reference[0], point[1] - where.reference[1])

    def particle(self, body: str) -> int:
        """Particle that stands for a body where its angle is meant: its one, or the first; 0 for the ground."""
        return 0 if body == "ground" else self.bodies[body].particles[0]

    def held(self, name: str) -> int:
        """Particle of a driven body whose rotation is prescribed."""
        pivot = next(side for side in self.pivots[name].sides if side[0] == name)
        return self.bodies[name].nodes.get(pivot[1], self.bodies[name].particles[0])

    def function(self, polynomials: Polynomials, argument: tuple[int, int, int] = (0, 0, 0)) -> int:
        """Index of a function of time, or of the angle or speed between two particles."""
        self.functions.append(polynomials)
        self.arguments.append(argument)
        return len(self.functions) - 1
