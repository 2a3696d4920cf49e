"""No test is judged by time; laws that a test registers do not stay; files that take long begin first."""

import gc
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from one_loop import ForAllLaws
from vfife.codegen import runner
from vfife.laws import ContactLaw, FrictionLaw

# The first two compile the data-driven loop, each for another set of laws, and those after them find it compiled; then what takes long, so
# that no process is left alone with it at the end.
FIRST = (
    "codegen/test_loops.py", "physics/test_random_mechanisms.py", "plots/test_figures_of_all_kinds.py", "examples/test_examples.py",
    "paper/test_paper_independent.py", "paper/test_paper.py", "examples/test_gallery.py", "laws/test_friction_laws.py",
    "laws/test_friction_solutions.py", "differential/test_against_equations.py", "modelfile/test_modelfile_roundtrip.py",
    "laws/test_own_laws.py", "codegen/test_cache.py", "cli/test_run.py", "results/test_result.py", "laws/test_contact_laws.py",
)  # fmt: skip

settings.register_profile("calm", deadline=None)
settings.load_profile("calm")


def pytest_configure(config: pytest.Config) -> None:
    """Files keep their order among processes; by itself xdist begins with those of most tests."""
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False
    if "not verify" in config.option.markexpr:
        runner.DataDriven = ForAllLaws


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Puts the files of ``FIRST`` first, in its order."""
    rank = {name: k for k, name in enumerate(FIRST)}
    items.sort(key=lambda item: rank.get("/".join(Path(item.path).parts[-2:]), len(rank)))


def pytest_collection_finish() -> None:
    """What four thousand tests are made of stays: the collector need not look at it again and again."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def only_built_in_laws() -> Iterator[None]:
    """Laws of a test do not stay in the registries, which other tests go through."""
    before = dict(ContactLaw.registry), dict(FrictionLaw.registry)
    yield
    for law, kept in zip((ContactLaw, FrictionLaw), before, strict=True):
        law.registry.clear()
        law.registry.update(kept)
