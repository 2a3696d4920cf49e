"""One compilation of the data-driven loop for all tests, which can do all laws of the package.

The package compiles that loop for the common laws and those of a model. Among the models of the tests that
would be three compilations of some seconds each, all of one text. What tells them apart is the choice between
laws, so a model finds its own among more of them here: the same bits. `make verify` leaves the package as it
is.
"""

import contextlib
import dataclasses
import os
import tempfile
from collections.abc import Iterator

from vfife.compiler.runtime import loops
from vfife.compiler.runtime.loops import DataDriven
from vfife.kernels.topology import Topology
from vfife.laws import ContactLaw, FrictionLaw, Law


def all_forms(base: type[Law]) -> tuple[type[Law], ...]:
    """Forms of the package's own laws."""
    own = {law.form() for law in base.registry.values() if law.__module__.startswith("vfife.")}
    return tuple(sorted(own, key=lambda form: f"{form.__module__}.{form.__qualname__}"))


ALL = all_forms(ContactLaw), all_forms(FrictionLaw)


def widened(topology: Topology) -> Topology:
    """The topology among all laws of the package; as it is where it has others."""
    contact, friction = ALL
    if not {*topology.contact_laws, *topology.friction_laws} <= {*contact, *friction}:
        return topology
    return dataclasses.replace(
        topology,
        contact_laws=contact,
        friction_laws=friction,
        contact_form=tuple(contact.index(topology.contact_laws[k]) for k in topology.contact_form),
        friction_form=tuple(friction.index(topology.friction_laws[k]) for k in topology.friction_form),
    )


def compiled_already(topology: Topology) -> bool:
    """Whether the one data-driven loop of a test run can do a topology."""
    contact, friction = ALL
    return loops.DataDriven is ForAllLaws and {*topology.contact_laws, *topology.friction_laws} <= {
        *contact,
        *friction,
    }


@contextlib.contextmanager
def one_at_a_time() -> Iterator[None]:
    """While one process compiles, the others of a test run wait and find it compiled."""
    if os.name != "posix":
        yield
        return
    import fcntl

    with open(os.path.join(tempfile.gettempdir(), f"vfife-tests-{os.getuid()}"), "w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


class ForAllLaws(DataDriven):
    """The data-driven loop, compiled for all laws."""

    def __init__(self, topology: Topology, lanes: int, interpret: bool) -> None:
        if interpret:
            super().__init__(topology, lanes, interpret)
            return
        with one_at_a_time():
            super().__init__(widened(topology), lanes, interpret)
