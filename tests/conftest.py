"""No test is judged by time, and laws that a test registers do not stay."""

import functools
import gc
import os
from collections.abc import Iterator
from pathlib import Path

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
    if "not verify" in config.option.markexpr:
        loops.DataDriven = ForAllLaws


class Backward(pytest.Dir):
    """A folder whose last file comes first."""

    def collect(self) -> Iterator[pytest.Item | pytest.Collector]:
        """Yield the files and folders of this folder, the last name first."""
        return reversed(list(super().collect()))  # type: ignore[call-overload, no-any-return]


def collects_backward(config: pytest.Config) -> bool:
    """Return whether this process is the second of two that collect all tests."""
    worker: str = getattr(config, "workerinput", {}).get("workerid", "gw0")
    return int(worker[2:]) % 2 == 1 and config.args_source is pytest.Config.ArgsSource.TESTPATHS


def pytest_collect_directory(path: Path, parent: pytest.Collector) -> pytest.Dir | None:
    """Let every second process begin with the last file.

    Each process imports all test modules. In a new checkout the first import rewrites and compiles a module,
    three quarters of what collection takes (15 of 20 s of processor time). Processes that begin at opposite
    ends meet in the middle, and from there each reads what the other has compiled.
    """
    if collects_backward(parent.config) and not (path / "__init__.py").exists():
        return Backward.from_parent(parent, path=path)
    return None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put tests that were collected backward into the order of all processes, which is that of names."""
    if collects_backward(config):
        items.sort(key=lambda item: item.path.parts)


def pytest_collection_finish() -> None:
    """Keep the collector from going through six thousand tests and their modules again and again, which takes
    a fifth of the processor time of a test run.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 20, 20)


@pytest.fixture
def only_built_in_laws() -> Iterator[None]:
    """Laws of a test do not stay in the registries, which other tests go through."""
    before = dict(ContactLaw.registry), dict(FrictionLaw.registry)
    yield
    for law, kept in zip((ContactLaw, FrictionLaw), before, strict=True):
        law.registry.clear()
        law.registry.update(kept)
