"""What a worker of a cluster does: a batch of members, from texts and numbers to numbers, and nothing else."""

from __future__ import annotations

import dataclasses
import logging
import math
import queue
import sys
import tempfile
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from ...compiler.runtime.cache import sources
from ...errors import VfifeError
from ...laws.stored import kept as kept_laws
from ...laws.user import load_laws
from ...model.mechanism import Mechanism
from ...model.surfaces import surfaces
from ...modelfile import dump, loads
from .cases import Outcome, Wanted, on_device, run_members

Numbers = Mapping[str, float | str]
LOADED: dict[str, str] = {}  # texts of own laws that this process has loaded, by their files


@dataclass(frozen=True)
class Question:
    """What is the same for all members, as texts and numbers: the model, what is wanted, own laws as files
    and texts, the text of the step.
    """

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
    own = kept_laws(
        [(law, surfaces(base, joint)) for joint in joints for law in (joint.contact, joint.friction)]
    )
    laws = {str(one["file"]): str(one["text"]) for one in own}
    return Question(dump(base), dataclasses.asdict(wanted), tuple(laws.items()), sources().decode())


def run_batch(asked: Question, numbers: Sequence[Numbers], lanes: int | None = None) -> Answer:
    """Runs members one thread wide; none, to be ready for some. Raises VfifeError where this worker would
    step otherwise than who asks.
    """
    start = time.monotonic()
    if sources().decode() != asked.step:
        from ... import __version__

        raise VfifeError(
            f"a worker has another text of the step (vfife {__version__}); install the same vfife on all"
            " workers"
        )
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


EXTRA = 'a cluster is reached by dask.distributed, which is not installed here: pip install "vfife[cluster]"'
TRIES = 3  # workers that a member may take with it
SECONDS = 2.0  # that a batch should take
FIRST = 8  # members of the first batches
LOOK = 0.25  # s between looks at who is there
PATIENCE = 60.0  # s without any worker
HAND_OVER = 1.0  # s that are waited for what a worker has

Work = Callable[[Question, Sequence[Numbers], int | None], Answer]


@dataclass
class Batch:
    """Members that are at a worker."""

    members: list[int]
    worker: str
    future: Any


@dataclass
class Spread:
    """Members waiting, those at workers, and what is known of both."""

    client: Any
    question: Question
    numbers: Sequence[Mapping[str, float | str]]
    lanes: int | None
    work: Work
    waiting: deque[int] = field(default_factory=deque)
    alone: deque[int] = field(default_factory=deque)  # had a worker that died, so they go one by one
    running: dict[str, Batch] = field(default_factory=dict)
    deaths: Counter[int] = field(default_factory=Counter)
    done: queue.SimpleQueue[str] = field(default_factory=queue.SimpleQueue)
    threads: dict[str, int] = field(default_factory=dict)
    ready: set[str] = field(default_factory=set)  # workers that have imported what a batch needs
    looked: float = -math.inf
    seen: float = field(default_factory=time.monotonic)
    each: float = math.nan  # s that a member takes

    def __post_init__(self) -> None:
        self.waiting.extend(range(len(self.numbers)))
        self.look()

    @property
    def left(self) -> bool:
        """Whether any member has not ended."""
        return bool(self.waiting or self.alone or any(batch.members for batch in self.running.values()))

    def look(self) -> None:
        """Asks who is there. Raises VfifeError where the scheduler does not answer, or nobody has been there
        for long.
        """
        try:
            self.threads = dict(self.client.nthreads())
        except Exception as error:  # of the network, of its time-outs, of a client that was closed by either
            raise lost(self.client, error) from None
        self.looked = time.monotonic()
        if self.threads:
            self.seen = self.looked
        elif self.looked - self.seen > PATIENCE:
            raise VfifeError(
                f"the cluster has had no worker for {PATIENCE:g} s; start some, and give the same command to"
                " go on"
            )

    def submit(self) -> None:
        """Gives every free thread a batch, but to a new worker an empty one first: if it ends while it
        begins, no member is to blame.
        """
        busy = Counter(batch.worker for batch in self.running.values())
        for worker, threads in self.threads.items():
            for _ in range(threads - busy[worker] if worker in self.ready else 1 - busy[worker]):
                if worker not in self.ready or (members := self.next()):
                    self.give(worker, members if worker in self.ready else [])

    def give(self, worker: str, members: list[int]) -> None:
        """Gives a batch to a worker."""
        asked = [dict(self.numbers[k]) for k in members]
        future = self.client.submit(self.work, self.question, asked, self.lanes, workers=[worker], pure=False)
        self.running[future.key] = Batch(members, worker, future)
        future.add_done_callback(lambda future: self.done.put(future.key))

    def next(self) -> list[int]:
        """The members of the next batch: as many as take the seconds it should, and no more than leave every
        thread a few batches.
        """
        if self.alone:
            return [self.alone.popleft()]
        fair = math.ceil(len(self.waiting) / (2 * max(1, sum(self.threads.values()))))
        size = FIRST if math.isnan(self.each) else max(1, round(SECONDS / max(self.each, 1e-6)))
        return [self.waiting.popleft() for _ in range(min(size, max(fair, 1), len(self.waiting)))]

    def ended(self) -> Iterator[tuple[int, Outcome]]:
        """Waits a while for batches that end, and looks after those whose workers are gone."""
        keys = list[str]()
        with suppress(queue.Empty):
            keys.append(self.done.get(timeout=LOOK))
        while not self.done.empty():
            keys.append(self.done.get())
        for key in keys:
            if key in self.running:
                yield from self.outcomes(self.running.pop(key))
        if time.monotonic() - self.looked > LOOK or not keys:
            self.look()
        for key in [key for key, batch in self.running.items() if batch.worker not in self.threads]:
            yield from self.died(self.running.pop(key))

    def outcomes(self, batch: Batch) -> Iterator[tuple[int, Outcome]]:
        """What a batch came to; a worker may be gone before it could say so."""
        try:
            answer: Answer = batch.future.result(timeout=HAND_OVER)
        except (TimeoutError, imported().TimeoutError):
            self.look()
            if batch.worker in self.threads:  # it has much to do
                self.running[batch.future.key] = batch
                self.done.put(batch.future.key)
            else:
                yield from self.died(batch)
        except imported().KilledWorker:
            yield from self.died(batch)
        except VfifeError:
            raise
        except Exception as error:
            if "cancelled" in type(error).__name__.lower() or self.client.status != "running":
                raise lost(self.client, error) from None
            said = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise VfifeError(
                f"worker {batch.worker} cannot run a batch: {said}; it needs the same vfife as this machine"
            ) from error
        else:
            self.ready.add(batch.worker)
            if batch.members:
                self.each = answer.seconds / len(batch.members)
            for member, outcome in zip(batch.members, answer.outcomes, strict=True):
                yield member, Outcome(**outcome)

    def died(self, batch: Batch) -> Iterator[tuple[int, Outcome]]:
        """A batch whose worker is gone: its members are tried one by one, but for one that has taken three."""
        batch.future.cancel()
        self.ready.discard(batch.worker)
        for member in batch.members:
            self.deaths[member] += 1
            if self.deaths[member] < TRIES or len(batch.members) > 1:
                self.alone.append(member)
            else:
                yield (
                    member,
                    Outcome(status="killed", reason=f"{self.deaths[member]} workers died while they ran it"),
                )

    def cancel(self) -> None:
        """Takes back what is at workers."""
        if self.running and self.client.status == "running":
            self.client.cancel([batch.future for batch in self.running.values()])


def lost(client: Any, error: BaseException) -> VfifeError:
    """What is said when the scheduler is gone."""
    where = getattr(getattr(client, "scheduler", None), "address", "the cluster")
    said = (str(error).splitlines() or [type(error).__name__])[0]
    return VfifeError(
        f"the scheduler of {where} is lost ({said}); what has ended is kept, and the same command goes on"
        " with the rest"
    )


def imported() -> ModuleType:
    """dask.distributed. Raises VfifeError where it is not installed."""
    try:
        import distributed
    except ImportError:
        raise VfifeError(EXTRA) from None
    module: ModuleType = distributed
    return module


NOISY = (
    "asyncio",
    "distributed",
    "distributed.client",
)  # tell with tracebacks what is told here in sentences
DEAF = "import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"  # Ctrl-C is for who asks
TRACKER = "ignore:resource_tracker:UserWarning"
ANSWER = 10.0  # s that a scheduler has to answer

Runner = Callable[..., Iterator[tuple[int, Outcome]]]


@contextmanager
def cluster(address: str, processes: int | None = None) -> Iterator[Runner]:
    """A way to run members as :func:`~vfife.studies.engine.cases.run_members` does, on the cluster whose
    scheduler is at an address, or on ``processes`` of this machine, one a core, for "local". Raises
    VfifeError without dask.distributed, and where nobody answers at the address.
    """
    distributed = imported()
    with ExitStack() as stack:
        for name in NOISY:
            stack.enter_context(silence(name))
        try:
            if address == "local":
                client = stack.enter_context(
                    distributed.Client(stack.enter_context(processes_here(distributed, processes)))
                )
            else:
                client = stack.enter_context(distributed.Client(address, timeout=ANSWER))
        except (OSError, TimeoutError, ValueError) as error:
            remedy = "start one with `dask scheduler`, check the address, or take --cluster local"
            raise VfifeError(
                f"cluster {address}: no scheduler answers there ({str(error).splitlines()[0]}); {remedy}"
            ) from None
        yield lambda base, numbers, wanted, **more: on_cluster(client, base, numbers, wanted, **more)


@contextmanager
def silence(name: str) -> Iterator[None]:
    """A logger that says nothing meanwhile."""
    logger = logging.getLogger(name)
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(before)


@contextmanager
def processes_here(distributed: ModuleType, count: int | None) -> Iterator[Any]:
    """A cluster of processes of this machine, one a core unless told. One that is gone is begun again,
    however long that takes: after 15 s it would not be missed any more, and a machine with much to do may
    need longer.
    """
    import dask

    with (
        quiet_tracker(),
        dask.config.set({"distributed.deploy.lost-worker-timeout": "1h"}),
        distributed.LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            processes=True,
            dashboard_address="127.0.0.1:0",
            memory_limit=0,
            silence_logs="CRITICAL",
            preload=[DEAF],
        ) as local,
    ):
        yield local


@contextmanager
def quiet_tracker() -> Iterator[None]:
    """Let the process that removes semaphores of ended processes do so without a word.

    After Ctrl-C workers end at once and leave their semaphores to that process, the resource tracker of
    multiprocessing, which removes them and warns of a leak that is none. It starts with the filters of
    warnings that :data:`sys.warnoptions` has.
    """
    sys.warnoptions.append(TRACKER)
    try:
        yield
    finally:
        sys.warnoptions.remove(TRACKER)


@dataclass(frozen=True)
class Resources:
    """What members run on: ``workers`` threads, or processes of a local cluster, with ``lanes`` in each; the
    address of a ``cluster``, or a ``device``. Raises ValueError where both are given, DeviceError for a
    device that cannot be used.
    """

    workers: int | None = None
    lanes: int | None = None
    cluster: str | None = None
    device: str | None = None

    def __post_init__(self) -> None:
        if self.cluster is not None and self.device is not None:
            given = f"cluster {self.cluster} and device {self.device}"
            raise ValueError(
                f"{given} exclude each other: workers of a cluster have no card; leave out one of them"
            )
        on_device(self.device)

    @contextmanager
    def runner(self) -> Iterator[Runner | None]:
        """What runs members: a cluster while this is entered, a device, or None for this process alone.
        Raises as :func:`cluster` does.
        """
        with (
            nullcontext(on_device(self.device))
            if self.cluster is None
            else cluster(self.cluster, self.workers)
        ) as runner:
            yield runner


THREADS = Resources()  # of this process, one a core


def on_cluster(
    client: Any,
    base: Mechanism,
    numbers: Sequence[Numbers],
    wanted: Wanted,
    *,
    workers: int | None = None,
    lanes: int | None = None,
    stop: threading.Event | None = None,
    work: Work = run_batch,
) -> Iterator[tuple[int, Outcome]]:
    """Outcomes of members as they come from a cluster, in any order, each once. ``workers`` has no meaning
    here.

    A member that three workers died of has the status "killed". Raises VfifeError where the scheduler is lost
    or no worker has come for a minute, and what a worker says that cannot run a batch at all.
    """
    spread = Spread(client, question(base, wanted), numbers, lanes, work)
    stop = stop or threading.Event()
    try:
        while not stop.is_set() and spread.left:
            spread.submit()
            yield from spread.ended()
    finally:
        spread.cancel()
