"""Members on the workers of a cluster of dask.distributed, a batch of a second or two at a time; nothing is lost with a worker.

Who asks keeps one batch on each thread of each worker, and no more. So when a worker is gone, it is known which members it had: they are tried
again one by one, and a member that takes its worker with it three times is given up. A member has the same bits wherever it runs.
"""

from __future__ import annotations

import logging
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from types import ModuleType
from typing import Any

from ..errors import VfifeError
from ..model.mechanism import Mechanism
from .batch import Numbers, question, run_batch
from .engine import Outcome, Wanted, on_device
from .spreading import Spread, Work, imported

NOISY = ("asyncio", "distributed", "distributed.client")  # tell with tracebacks what is told here in sentences
DEAF = "import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"  # Ctrl-C is for who asks
TRACKER = "ignore:resource_tracker:UserWarning"
ANSWER = 10.0  # s that a scheduler has to answer

Runner = Callable[..., Iterator[tuple[int, Outcome]]]


@contextmanager
def cluster(address: str, processes: int | None = None) -> Iterator[Runner]:
    """A way to run members as :func:`~vfife.study.engine.run_members` does, on the cluster whose scheduler is at an address, or on ``processes``
    of this machine, one a core, for "local". Raises VfifeError without dask.distributed, and where nobody answers at the address.
    """
    distributed = imported()
    with ExitStack() as stack:
        for name in NOISY:
            stack.enter_context(silence(name))
        try:
            if address == "local":
                client = stack.enter_context(distributed.Client(stack.enter_context(processes_here(distributed, processes))))
            else:
                client = stack.enter_context(distributed.Client(address, timeout=ANSWER))
        except (OSError, TimeoutError, ValueError) as error:
            remedy = "start one with `dask scheduler`, check the address, or take --cluster local"
            raise VfifeError(f"cluster {address}: no scheduler answers there ({str(error).splitlines()[0]}); {remedy}") from None
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
    """A cluster of processes of this machine, one a core unless told. One that is gone is begun again, however long that takes: after 15 s it would
    not be missed any more, and a machine with much to do may need longer."""
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

    After Ctrl-C workers end at once and leave their semaphores to that process, the resource tracker of multiprocessing, which
    removes them and warns of a leak that is none. It starts with the filters of warnings that :data:`sys.warnoptions` has.
    """
    sys.warnoptions.append(TRACKER)
    try:
        yield
    finally:
        sys.warnoptions.remove(TRACKER)


def elsewhere(address: str | None, device: str | None) -> Runner | None:
    """What runs members on a device, None without one.

    Raises ValueError where a cluster is given as well, DeviceError for a card that cannot be used.
    """
    if address is not None and device is not None:
        raise ValueError(f"cluster {address} and device {device} exclude each other: workers of a cluster have no card; leave out one of them")
    return on_device(device)


@contextmanager
def joined(address: str | None, processes: int | None = None, otherwise: Runner | None = None) -> Iterator[Runner | None]:
    """:func:`cluster` where an address is given; where not, what runs members ``otherwise``, or None, for this process alone."""
    if address is None:
        yield otherwise
        return
    with cluster(address, processes) as runner:
        yield runner


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
    """Outcomes of members as they come from a cluster, in any order, each once. ``workers`` has no meaning here.

    A member that three workers died of has the status "killed". Raises VfifeError where the scheduler is lost or no worker has come for a minute,
    and what a worker says that cannot run a batch at all.
    """
    spread = Spread(client, question(base, wanted), numbers, lanes, work)
    stop = stop or threading.Event()
    try:
        while not stop.is_set() and spread.left:
            spread.submit()
            yield from spread.ended()
    finally:
        spread.cancel()
