"""No test is judged by time, and laws that a test registers do not stay."""

import functools
import gc
import os
from collections.abc import Iterator

import pytest
import typer.testing
from hypothesis import settings

from one_loop import ForAllLaws
from vfife.compiler.runtime import loops
from vfife.laws import ContactLaw, FrictionLaw
from vfife.store import connections

# The examples of a property are the same in every run, so that chance fails no test; `make soak` draws others
# each time, and prints what failed.
settings.register_profile(
    "calm", deadline=None, derandomize=os.environ.get("VFIFE_EXAMPLES") != "all", print_blob=True
)
settings.load_profile("calm")


def pytest_configure(config: pytest.Config) -> None:
    """Share the command line and the data-driven loop among all tests, and write files without waiting for
    the disk.
    """
    typer.testing._get_command = functools.cache(
        typer.testing._get_command
    )  # a thousand tests use the command line
    # No test takes the power away: a write need not reach the disk before the test goes on, which takes 10 ms
    # each time.
    connections.SYNCHRONOUS, os.fsync = "OFF", lambda file: None
    gc.disable()  # until the tests are collected: what is imported and rewritten till then stays
    if "not verify" in config.option.markexpr:
        loops.DataDriven = ForAllLaws


def pytest_collection_finish() -> None:
    """Keep the collector from going through six thousand tests and their modules again and again, which takes
    a fifth of the processor time of a test run.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 20, 20)
    gc.enable()


@pytest.fixture
def only_built_in_laws() -> Iterator[None]:
    """Laws of a test do not stay in the registries, which other tests go through."""
    before = dict(ContactLaw.registry), dict(FrictionLaw.registry)
    yield
    for law, kept in zip((ContactLaw, FrictionLaw), before, strict=True):
        law.registry.clear()
        law.registry.update(kept)
