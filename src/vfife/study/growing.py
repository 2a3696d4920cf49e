"""A study file that grows as members are asked for: what it has is told, what it has not is computed and kept first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import VfifeError
from ..model.mechanism import Mechanism
from ..results.studyfile import WHAT, StudyFile, hash_of
from ..solvers.status import Status
from .carry import Runner, Told, asked_of, carry_out, same_question
from .plan import Plan

Numbers = Mapping[str, float | str]


class BrokenOff(Exception):
    """A study was interrupted; what ended is kept."""


class Growing:
    """Members of a study by their numbers. ``runner`` and ``told`` are those of :func:`~vfife.study.carry.carry_out`."""

    def __init__(
        self, file: StudyFile, base: Mechanism, *, workers: int | None = None, runner: Runner | None = None, told: Told | None = None
    ) -> None:
        self.file, self.base, self.workers, self.runner, self.told = file, base, workers, runner, told
        self.known: dict[str, Mapping[str, float] | None] = {}
        self.read()

    def read(self) -> None:
        """Takes what the file has."""
        outcomes = self.file.outcomes()
        for one in self.file.members():
            if (outcome := outcomes.get(one.number)) is not None and outcome["hash"] == one.hash:
                self.known[one.hash] = outcome["measures"] if outcome["status"] == Status.COMPLETE else None

    def __call__(self, numbers: Sequence[Numbers]) -> list[Mapping[str, float] | None]:
        """Measures of members, None of those that failed. Raises BrokenOff after Ctrl-C, StorageError where nothing can be kept."""
        asked = [hash_of(one) for one in numbers]
        if new := [one for one, name in zip(numbers, asked, strict=True) if name not in self.known]:
            self.file.add(new, self.file.meta[WHAT])
            if not carry_out(self.file, self.base, workers=self.workers, runner=self.runner, told=self.told):
                raise BrokenOff
            self.read()
        return [self.known[name] for name in asked]


def grown(path: Path, plan: Plan, base: Mechanism, name: str, *, replace: bool = False) -> StudyFile:
    """The study file of a plan without members of its own, made or gone on with. Raises VfifeError where another study is there."""
    asked: dict[str, Any] = asked_of(plan, base, name)
    if not path.exists() or replace:
        return StudyFile.create(path, asked, [])
    file = StudyFile.write(path)
    if why := same_question(file, asked):
        file.close()
        raise VfifeError(f"{path}: the study in this file {why}; name another file, or replace it")
    return file
