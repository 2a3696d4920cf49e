"""What a worker of a cluster does: a batch of members, from texts and numbers to numbers, and nothing else."""

from __future__ import annotations

import dataclasses
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..codegen.cache import sources
from ..errors import VfifeError
from ..laws.stored import kept as kept_laws
from ..laws.user import load_laws
from ..model.mechanism import Mechanism
from ..model.surfaces import surfaces
from ..modelfile import dump, loads
from .engine import Outcome, Wanted, run_members

Numbers = Mapping[str, float | str]
LOADED: dict[str, str] = {}  # texts of own laws that this process has loaded, by their files


@dataclass(frozen=True)
class Question:
    """What is the same for all members, as texts and numbers: the model, what is wanted, own laws as files and texts, the text of the step."""

    model: str
    wanted: dict[str, Any]
    laws: tuple[tuple[str, str], ...]
    step: str


@dataclass(frozen=True)
class Answer:
    """What a batch came to, an outcome for each of its members, and how long it took (s)."""

    outcomes: list[dict[str, Any]]
    seconds: float


def question(base: Mechanism, wanted: Wanted) -> Question:
    """The question of a study."""
    joints = base.contacts.values()
    own = kept_laws([(law, surfaces(base, joint)) for joint in joints for law in (joint.contact, joint.friction)])
    laws = {str(one["file"]): str(one["text"]) for one in own}
    return Question(dump(base), dataclasses.asdict(wanted), tuple(laws.items()), sources().decode())


def run_batch(asked: Question, numbers: Sequence[Numbers], lanes: int | None = None) -> Answer:
    """Runs members one thread wide; none, to be ready for some. Raises VfifeError where this worker would step otherwise than who asks."""
    start = time.monotonic()
    if sources().decode() != asked.step:
        from .. import __version__

        raise VfifeError(f"a worker has another text of the step (vfife {__version__}); install the same vfife on all workers")
    for file, text in asked.laws:
        load(file, text)
    if not numbers:
        loads(asked.model)
        return Answer([], time.monotonic() - start)
    wanted = Wanted.of(asked.wanted)
    found: dict[int, Outcome] = dict(run_members(loads(asked.model), numbers, wanted, workers=1, lanes=lanes))
    return Answer([dataclasses.asdict(found[k]) for k in range(len(numbers))], time.monotonic() - start)


def load(file: str, text: str) -> None:
    """Loads laws of the user's own from the text that came with the question, once a process."""
    if LOADED.get(file) != text:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / Path(file).name
            path.write_text(text, encoding="utf-8")
            load_laws(path)
        LOADED[file] = text
