"""Members of a study made many at once, where they differ in numbers alone; what cannot be made so is made one by one."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..assembly.assemble import assemble
from ..assembly.assembled import Assembly
from ..assembly.together import Together
from ..errors import VfifeError
from ..fields.members import Alone, Differing, members, spread
from ..kinematics.clear import clear
from ..kinematics.initial import driven_start
from ..model.mechanism import Mechanism
from ..model.validate import Checks, across
from ..simulation import comparable
from ..solvers.repeating import whole_outputs
from .columns import Column, Numbers, Unfit, column, table, together
from .ideals import peaks_of
from .member import Plan, Stepped, Wanted

FEW = 3  # members for which it is not worth while
DEEP = 6  # times that members are taken apart
MOST_IDEALS = 4096  # whose peaks are remembered
TROUBLE = (VfifeError, Unfit, Alone, ArithmeticError, np.linalg.LinAlgError)  # what members have that are to be made one by one
UNFORESEEN = "members are assembled one by one, which takes longer: side by side they met a fault of vfife"


class Kept(Protocol):
    """What was made of one of them alone."""

    @property
    def assembly(self) -> Assembly:
        """With the numbers of the model, but for what was given."""

    @property
    def ideal(self) -> Assembly | None:
        """Its ideal mechanism, where there is one to compare with."""

    @property
    def plan(self) -> Plan:
        """What is kept of it."""

    @property
    def reference(self) -> Mapping[str, float] | None:
        """The largest values of the ideal mechanism."""

    @property
    def through(self) -> bool:
        """Whether the ideal mechanism gets through its turns."""


@dataclass(frozen=True)
class Through:
    """Whether ideal mechanisms get through their turns: ``found`` looks at one; each has one of ``ways``, and ``known`` are those that do."""

    found: Callable[[Numbers, Mechanism], bool]
    ways: Callable[[Sequence[Numbers], Mechanism], list[tuple[Any, ...]]]
    known: set[Any]


@dataclass(frozen=True)
class _Asked:
    """Members that are to be made: the paths that they differ in and where these are, values (members, paths), numbers; nouns of all and of one."""

    paths: Sequence[str]
    columns: Sequence[Column]
    values: Any
    which: Sequence[int]
    mechanism: Mechanism
    one_of: Callable[[int], Mechanism]


@dataclass
class Batches:
    """Makes members of one mechanism; ``made`` makes one by itself."""

    base: Mechanism
    raw: dict[str, Any]
    wanted: Wanted
    made: Callable[[Numbers], Kept | None]
    of_play: Callable[[str], Any]
    through: Through
    columns: dict[str, Column | None] = field(default_factory=dict)
    models: dict[tuple[str, ...], Kept] = field(default_factory=dict)  # one made alone, by the paths that others may differ from it in
    peaks: dict[tuple[Any, ...], Mapping[str, float] | None] = field(default_factory=dict)

    def of(self, numbers: Sequence[Numbers], first: int) -> dict[int, Stepped]:
        """Those of some members, the number of the first being ``first``, that can be made together."""
        groups: dict[tuple[str, ...], list[int]] = {}
        for k, one in enumerate(numbers):
            groups.setdefault(tuple(one), []).append(k)
        found: dict[int, Stepped] = {}
        for paths, which in groups.items():
            columns = [self.column(path) for path in paths]
            if paths and None not in columns:
                for k, member in self._apart(paths, which, numbers, 0):
                    member.number = first + k
                    found[k] = member
        return found

    def column(self, path: str) -> Column | None:
        """Where a number is; None where that takes a reader of models."""
        if path not in self.columns:
            try:
                self.columns[path] = column(self.base, self.raw, path)
            except Unfit:
                self.columns[path] = None
        return self.columns[path]

    def _apart(self, paths: Sequence[str], which: Sequence[int], numbers: Sequence[Numbers], depth: int) -> Iterable[tuple[int, Stepped]]:
        """Members by number; those that are not to be treated alike are taken apart."""
        if len(which) < FEW or depth > DEEP:
            return []
        try:
            return self._made(paths, which, numbers)
        except Differing as apart:
            where = apart.where
            if where.shape != (len(which),) or where.all() or not where.any():
                where = np.arange(len(which)) < len(which) // 2
            parts = ([k for k, one in zip(which, where, strict=True) if one == side] for side in (True, False))
            return [found for part in parts for found in self._apart(paths, part, numbers, depth + 1)]
        except TROUBLE:
            return []
        except Exception as error:  # each made by itself is right whatever is wrong here
            unforeseen(error)
            return []

    def _made(self, paths: Sequence[str], which: Sequence[int], numbers: Sequence[Numbers]) -> list[tuple[int, Stepped]]:
        """Members made from one that is known, or where they are of another topology from the first of them."""
        columns = [one for path in paths if (one := self.column(path)) is not None]
        values, read = table(columns, paths, [numbers[k] for k in which])
        if len(read) < FEW:
            return []
        which = [which[k] for k in read]
        mechanism, one_of = together(self.base, columns, values)
        if across(Checks(mechanism)):
            raise Unfit
        asked = _Asked(paths, columns, values, which, mechanism, one_of)
        moved = tuple(path for path in paths if not self.of_play(path))
        if (known := self.models.get(moved)) is not None:
            with suppress(*TROUBLE):
                return self._from(known, asked)
        model = self.made({path: numbers[which[0]][path] for path in moved})
        if model is None or not model.through:
            return []
        found = self._from(model, asked)
        self.models[moved] = model
        return found

    def _from(self, model: Kept, asked: _Asked) -> list[tuple[int, Stepped]]:
        """Members made from one of them, or from one that is as they are but for its numbers."""
        met: dict[Any, Any] = {}
        references = self._references(model, asked, met)
        names = [name for name in references[0] or {} if name.endswith(".force.max")]
        if any(one is None or not one.keys() >= set(names) for one in references) and model.ideal is not None:
            return []
        expected = {name.removesuffix(".force.max"): members([one[name] for one in references if one is not None]) for name in names}
        turns: dict[str, Any] = {"turns": float(self.wanted.turns)}
        kit = Together(model.assembly, self.wanted.step, met, **turns)
        forces = {name: value.tolist() for name, value in expected.items()}
        found = []
        for k, assembly in enumerate(kit.assembled(asked.mechanism, len(asked.which), expected, one_of=asked.one_of)):
            if assembly is not None and whole_outputs(assembly.choice) is not None:
                again = partial(assemble, expected={name: value[k] for name, value in forces.items()}, **turns)
                found.append((asked.which[k], Stepped(asked.which[k], assembly, model.plan, references[k], again)))
        return found

    def _references(self, model: Kept, asked: _Asked, met: dict[Any, Any]) -> list[Mapping[str, float] | None]:
        """The largest values of the ideal mechanism of each; None where there is none to compare with."""
        moved = [k for k, path in enumerate(asked.paths) if not self.of_play(path)]
        paths, columns, values = [asked.paths[k] for k in moved], [asked.columns[k] for k in moved], asked.values[:, moved]
        if not moved:
            return [model.reference] * len(values)
        _, first, back = np.unique(np.ascontiguousarray(values).view(np.uint64), axis=0, return_index=True, return_inverse=True)
        rows, back = [tuple(values[k].tolist()) for k in first], back.reshape(-1)
        with told_of(back, None):
            through = self._through(paths, columns, rows, values[first], met)
        if not through.all():
            raise Differing(through[back])
        keys = [(tuple(paths), row) for row in rows]
        if model.ideal is not None:
            new = [k for k, key in enumerate(keys) if key not in self.peaks]
            self._ideal(model.ideal, columns, values[first[new]], [keys[k] for k in new], met)
        known = [self.peaks.get(key) for key in keys]
        return [known[k] for k in back]

    def _through(
        self, paths: Sequence[str], columns: Sequence[Column], rows: Sequence[tuple[float, ...]], values: Any, met: dict[Any, Any]
    ) -> NDArray[np.bool_]:
        """Which of them surely get through their turns; those that are not far from where they would not are looked at one by one."""
        numbers = [dict(zip(paths, row, strict=True)) for row in rows]
        mechanism, one_of = together(self.base, columns, values)
        ways = self.through.ways(numbers, mechanism)
        unknown = {way: k for k, way in enumerate(ways) if way not in self.through.known}
        if len(unknown) >= FEW:
            which = sorted(unknown.values())
            some = together(self.base, columns, values[which])[0]
            speeds = [driver.steady_speed for driver in some.drivers.values() if driver.moves]
            if len(speeds) == 1 and speeds[0] is not None:
                with suppress(*TROUBLE), told_of(which, len(rows)):
                    sure = clear(driven_start(some, met), spread(speeds[0], (len(which),)))
                    self.through.known.update(ways[k] for k, one in zip(which, sure, strict=True) if one)
        found = np.ones(len(rows), dtype=bool)
        for k, way in enumerate(ways):
            if way not in self.through.known:
                with suppress(VfifeError):
                    found[k] = False
                    found[k] = self.through.found(numbers[k], one_of(k))
        return found

    def _ideal(self, base: Assembly, columns: Sequence[Column], values: Any, keys: Sequence[Any], met: dict[Any, Any]) -> None:
        """Runs ideal mechanisms side by side."""
        if not keys:
            return
        mechanism, one_of = together(self.base, columns, values)
        if not comparable(mechanism):
            raise Unfit
        if len(keys) < FEW:
            found: list[Assembly | None] = []
            for k in range(len(keys)):
                own = one_of(k)
                found.append(assemble(own.ideal(), beside=own, turns=1.0))
        else:
            found = Together(base, None, met, turns=1.0).assembled(mechanism.ideal(), len(keys), one_of=lambda k: one_of(k).ideal())
        if any(one is None for one in found):
            raise Unfit
        while len(self.peaks) + len(keys) > MOST_IDEALS and self.peaks:
            del self.peaks[next(iter(self.peaks))]
        self.peaks |= dict(zip(keys, peaks_of([one for one in found if one is not None]), strict=True))


def unforeseen(error: Exception) -> None:
    """Tells of a fault that none of those that take part has foreseen."""
    warnings.warn(f"{UNFORESEEN}: {type(error).__name__}: {error}", RuntimeWarning, stacklevel=2)


@contextmanager
def told_of(which: Any, count: int | None) -> Iterator[None]:
    """Members that differ are told of by their places among more of them: ``which`` of ``count``, or those that each of all has."""
    try:
        yield
    except Differing as apart:
        where = apart.where[which] if count is None else np.ones(count, dtype=bool)
        if count is not None:
            where[which] = apart.where
        raise Differing(where) from None
