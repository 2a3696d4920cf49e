"""Cases of a study on the workers of a cluster: batches of texts and numbers go to dask.distributed, numbers
come back.

dask assigns batches to workers and runs those of a dead worker again. What is left to do here: batches of two
seconds, so that Ctrl-C loses little; cases whose batch took several workers with it are run one at a time
with nothing beside them, so that the one to blame is known.
"""

from __future__ import annotations

import dataclasses
import logging
import math
import queue
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from ...compiler.runtime.cache import sources
from ...errors import VfifeError
from ...laws.stored import law_entries as stored_laws
from ...laws.user import load_laws
from ...model.mechanism import Mechanism
from ...model.surfaces import surfaces
from ...modelfile import dump, loads
from ..spec.plan import CaseSpec
from .cases import on_device, run_cases
from .outcome import Outcome

Numbers = Mapping[str, float | str]
Runner = Callable[..., Iterator[tuple[int, Outcome]]]
LOADED: dict[str, str] = {}  # texts of user laws that this process has loaded, by their files


@dataclass(frozen=True)
class BatchTask:
    """What all batches of a study share, as texts and numbers: the model, the fields of ``CaseSpec``, files
    and texts of user laws, the step.
    """

    model: str
    spec: dict[str, Any]
    laws: tuple[tuple[str, str], ...]
    step: str

    @classmethod
    def of(cls, base: Mechanism, spec: CaseSpec) -> BatchTask:
        """Return the task of a study."""
        laws = stored_laws(
            [
                (law, surfaces(base, joint))
                for joint in base.contacts.values()
                for law in (joint.contact, joint.friction)
            ]
        )
        return cls(
            dump(base),
            dataclasses.asdict(spec),
            tuple((str(law["file"]), str(law["text"])) for law in laws),
            sources().decode(),
        )


class BatchResult(NamedTuple):
    """The outcome of each case of a batch, and the time that the batch took (s)."""

    outcomes: list[dict[str, Any]]
    seconds: float


Work = Callable[[BatchTask, Sequence[Numbers], int | None], BatchResult]


def run_batch(task: BatchTask, numbers: Sequence[Numbers], lanes: int | None = None) -> BatchResult:
    """Run cases in one thread of a worker. Raises VfifeError where its vfife has another text of the step,
    which may have other bits.
    """
    start = time.monotonic()
    # Results of different texts must not be mixed, so the hash of kernels, compiler and laws is compared, not
    # the version number: a worker with edited sources has the same number.
    if sources().decode() != task.step:
        from ... import __version__

        problem = f"a worker has another text of the step (vfife {__version__})"
        raise VfifeError(f"{problem}; install the same vfife on all workers")
    for file, text in task.laws:
        load(file, text)
    outcomes = dict(run_cases(loads(task.model), numbers, CaseSpec.of(task.spec), workers=1, lanes=lanes))
    return BatchResult(
        [dataclasses.asdict(outcomes[k]) for k in range(len(numbers))], time.monotonic() - start
    )


def load(file: str, text: str) -> None:
    """Load user laws from the text that came with a task, once a process."""
    if LOADED.get(file) != text:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / Path(file).name
            path.write_text(text, encoding="utf-8")
            load_laws(path)
        LOADED[file] = text


EXTRA = 'a cluster is reached by dask.distributed, which is not installed here: pip install "vfife[cluster]"'
DEATHS = 2  # workers of a local cluster that a batch may take with it before its cases are run one at a time
SECONDS = 2.0  # that a batch should take: most of what Ctrl-C loses, and far more than sending it costs
FIRST = 8  # cases of a batch before the time of one is known
AHEAD = 2  # batches at the workers for each of their threads: one runs while the next is on its way
LOOK = 0.25  # s between two looks at the workers while no batch ends
PATIENCE = 60.0  # s without any worker
HAND_OVER = 1.0  # s to fetch a result; its worker may have died since


class Batch(NamedTuple):
    """Cases at the workers; ``alone`` where no other batch is."""

    cases: list[int]
    future: Any
    alone: bool


@dataclass
class Batches:
    """The cases of a study on a cluster: those that wait, those at the workers (by key of their future), and
    suspects of having killed one.
    """

    client: Any
    submit: Callable[[list[int]], Any]  # future of a batch of these cases
    waiting: deque[int]
    suspects: deque[int] = field(default_factory=deque)
    running: dict[str, Batch] = field(default_factory=dict)
    done: queue.SimpleQueue[str] = field(default_factory=queue.SimpleQueue)  # keys of batches that have ended
    latest_worker: float = field(default_factory=time.monotonic)  # when there was a worker
    case_seconds: float = math.nan

    @property
    def left(self) -> bool:
        """Whether any case has not ended."""
        return bool(self.waiting or self.suspects or self.running)

    def threads(self) -> int:
        """Count the threads of all workers. Raises VfifeError where the scheduler does not answer, or no
        worker has been there for a minute.
        """
        try:
            count: int = sum(self.client.nthreads().values())
        except Exception as error:  # of the network, of its time-outs, of a client that was closed by either
            raise scheduler_error(self.client, error) from None
        moment = time.monotonic()
        if count:
            self.latest_worker = moment
        elif moment - self.latest_worker > PATIENCE:
            problem = f"the cluster has had no worker for {PATIENCE:g} s"
            raise VfifeError(f"{problem}; start some, and give the same command to go on")
        return count

    def send(self) -> None:
        """Send batches until all threads have enough to do; suspects last, one at a time.

        dask blames a death on every batch that the dead worker had, also on one that only waited there. Run
        alone, a suspect can be blamed for its own deaths only.
        """
        threads = self.threads()
        while self.waiting and len(self.running) < AHEAD * threads:
            # A batch is as long as SECONDS allow, but no longer than an equal share of what waits: towards
            # the end batches become small, so that no thread idles while another has a long one.
            fair = math.ceil(len(self.waiting) / (AHEAD * threads))
            size = FIRST if math.isnan(self.case_seconds) else round(SECONDS / max(self.case_seconds, 1e-6))
            self._send([self.waiting.popleft() for _ in range(max(1, min(size, fair)))])
        if self.suspects and not self.running and not self.waiting:
            self._send([self.suspects.popleft()], alone=True)

    def _send(self, cases: list[int], alone: bool = False) -> None:
        future = self.submit(cases)
        self.running[future.key] = Batch(cases, future, alone)
        future.add_done_callback(lambda future: self.done.put(future.key))

    def outcomes(self) -> Iterator[tuple[int, Outcome]]:
        """Wait for a batch to end, and return the outcomes of its cases; none where the wait was in vain."""
        try:
            key = self.done.get(timeout=LOOK)
        except queue.Empty:
            return
        # dask has assigned the batch to other workers after each death and gives up with KilledWorker. Every
        # other error is either one of ours, which every batch would raise, or one of the connection.
        batch = self.running.pop(key)
        try:
            result: BatchResult = batch.future.result(timeout=HAND_OVER)
        except TimeoutError:  # its worker has much to do, or is gone: then dask runs the batch again
            self.running[key] = batch
            self.done.put(key)
        except imported().KilledWorker as error:
            if not batch.alone:
                self.suspects.extend(batch.cases)
            else:
                yield (
                    batch.cases[0],
                    Outcome(
                        status="killed",
                        reason=f"{error.allowed_failures + 1} workers died while they ran it alone",
                    ),
                )
        except VfifeError:
            raise
        except Exception as error:
            if "cancelled" in type(error).__name__.lower() or self.client.status != "running":
                raise scheduler_error(self.client, error) from None
            raise VfifeError(
                f"a worker cannot run a batch: {first_line(error)}; it needs the same vfife as this machine"
            ) from error
        else:
            self.case_seconds = result.seconds / len(batch.cases)
            yield from zip(batch.cases, (Outcome(**fields) for fields in result.outcomes), strict=True)

    def cancel(self) -> None:
        """Cancel what is at the workers."""
        if self.running and self.client.status == "running":
            self.client.cancel([batch.future for batch in self.running.values()])


@dataclass(frozen=True)
class ClusterRunner:
    """Runs cases as :func:`~vfife.studies.engine.cases.run_cases` does, on the workers that a ``client`` of
    dask reaches.
    """

    client: Any
    work: Work = run_batch

    def __call__(
        self,
        base: Mechanism,
        numbers: Sequence[Numbers],
        spec: CaseSpec,
        *,
        workers: int | None = None,
        lanes: int | None = None,
        stop: threading.Event | None = None,
    ) -> Iterator[tuple[int, Outcome]]:
        """Yield the outcome of each case, in any order. ``workers`` has no meaning here.

        A case that killed its workers while nothing ran beside it has the status "killed". Raises VfifeError
        where the scheduler is lost or no worker has come for a minute, and what a worker reports that cannot
        run a batch at all.
        """
        task, stop = BatchTask.of(base, spec), stop or threading.Event()

        def submit(cases: list[int]) -> Any:
            return self.client.submit(self.work, task, [dict(numbers[k]) for k in cases], lanes, pure=False)

        batches = Batches(self.client, submit, deque(range(len(numbers))))
        try:
            while not stop.is_set() and batches.left:
                batches.send()
                yield from batches.outcomes()
        finally:
            batches.cancel()


def first_line(error: BaseException) -> str:
    """Return the first line of an error's message, the name of its class where it has none."""
    return (str(error).splitlines() or [type(error).__name__])[0]


def scheduler_error(client: Any, error: BaseException) -> VfifeError:
    """Return the error of a scheduler that no longer answers."""
    address = getattr(getattr(client, "scheduler", None), "address", "the cluster")
    problem = f"the scheduler of {address} is lost ({first_line(error)})"
    return VfifeError(f"{problem}; complete cases are kept, and the same command continues with the rest")


def imported() -> ModuleType:
    """Return dask.distributed. Raises VfifeError where it is not installed."""
    try:
        import distributed
    except ImportError:
        raise VfifeError(EXTRA) from None
    module: ModuleType = distributed
    return module


# Loggers of tracebacks for what is reported here in a sentence.
NOISY = "asyncio", "distributed", "distributed.client"
# Workers leave Ctrl-C to the process that asked.
DEAF = "import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"
TRACKER = "ignore:resource_tracker:UserWarning"
ANSWER = 10.0  # s that a scheduler has to answer


@contextmanager
def cluster(address: str, processes: int | None = None) -> Iterator[ClusterRunner]:
    """Connect to the cluster whose scheduler is at an address, or start ``processes`` on this machine, one a
    core, for "local".

    Raises VfifeError without dask.distributed, and where no scheduler answers.
    """
    distributed = imported()
    with ExitStack() as stack:
        for name in NOISY:
            stack.enter_context(silence(name))
        try:
            if address == "local":
                client = stack.enter_context(
                    distributed.Client(stack.enter_context(local_cluster(distributed, processes)))
                )
            else:
                client = stack.enter_context(distributed.Client(address, timeout=ANSWER))
        except (OSError, TimeoutError, ValueError) as error:
            remedy = "start one with `dask scheduler`, check the address, or take --cluster local"
            raise VfifeError(
                f"cluster {address}: no scheduler answers there ({first_line(error)}); {remedy}"
            ) from None
        yield ClusterRunner(client)


@contextmanager
def silence(name: str) -> Iterator[None]:
    """Silence a logger."""
    logger = logging.getLogger(name)
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(level)


@contextmanager
def local_cluster(distributed: ModuleType, count: int | None) -> Iterator[Any]:
    """Start a cluster of processes on this machine, one a core without a ``count``.

    dask starts a process again that is gone. By default it gives up after 15 s, which a busy machine may
    need.
    """
    import dask

    settings = {
        "distributed.deploy.lost-worker-timeout": "1h",
        "distributed.scheduler.allowed-failures": DEATHS - 1,
    }
    arguments: dict[str, Any] = {
        "threads_per_worker": 1,
        "processes": True,
        "dashboard_address": "127.0.0.1:0",
        "memory_limit": 0,
    }
    arguments |= {"n_workers": count, "silence_logs": "CRITICAL", "preload": [DEAF]}
    with quiet_tracker(), dask.config.set(settings), distributed.LocalCluster(**arguments) as local:
        yield local


@contextmanager
def quiet_tracker() -> Iterator[None]:
    """Keep multiprocessing's resource tracker from warning of leaked semaphores.

    After Ctrl-C workers end at once and leave their semaphores to the tracker, which removes them. It starts
    with the filters of warnings that :data:`sys.warnoptions` has.
    """
    sys.warnoptions.append(TRACKER)
    try:
        yield
    finally:
        sys.warnoptions.remove(TRACKER)


@dataclass(frozen=True)
class Resources:
    """What cases run on: ``workers`` threads, or processes of a local cluster, with ``lanes`` in each; the
    address of a ``cluster``, or a ``device``. Raises ValueError where both are given, DeviceError for a
    device that cannot be used.
    """

    workers: int | None = None
    lanes: int | None = None
    cluster: str | None = None
    device: str | None = None

    def __post_init__(self) -> None:
        if self.cluster is not None and self.device is not None:
            sources = f"cluster {self.cluster} and device {self.device}"
            raise ValueError(
                f"{sources} exclude each other: workers of a cluster have no card; leave out one of them"
            )
        on_device(self.device)

    @contextmanager
    def runner(self) -> Iterator[Runner | None]:
        """Yield what runs cases: a cluster, a device, or None for threads of this process. Raises as
        :func:`cluster` does.
        """
        with (
            nullcontext(on_device(self.device))
            if self.cluster is None
            else cluster(self.cluster, self.workers) as runner
        ):
            yield runner


THREADS = Resources()  # of this process, one a core
