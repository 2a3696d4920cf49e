"""No test is judged by time; laws that a test registers do not stay; files that take long begin first."""

import functools
import gc
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer.testing
from hypothesis import settings

from one_loop import ForAllLaws
from vfife.codegen import runner
from vfife.laws import ContactLaw, FrictionLaw
from vfife.results import opening

# The first compiles the data-driven loop, for some seconds where it is not in the cache yet. Then what takes long, longest first, so that no
# process is left alone with it at the end.
FIRST = (
    "codegen/test_loops.py", "live/test_browser.py", "plots/test_figures_of_all_kinds.py", "cli/test_names.py", "study/test_derivatives.py",
    "cli/test_run.py", "identification/test_identification.py", "verification/test_verification.py", "kinematics/test_passage.py",
    "differential/test_against_equations.py", "verification/test_published_statics.py", "plots/test_figures.py", "study/test_batches.py",
    "examples/test_examples.py", "laws/test_random_laws.py", "laws/test_language.py",
    "results/test_fuzz.py", "results/test_runfile.py", "physics/test_random_mechanisms.py", "paper/test_paper.py",
    "results/test_resume.py", "results/test_result.py", "cli/test_signals_while_computing.py", "physics/test_machinery.py",
    "laws/test_own_laws.py", "cli/test_ended.py", "cli/test_map.py", "codegen/test_cache.py", "modelfile/test_modelfile_roundtrip.py",
    "laws/test_contact_laws.py", "cli/test_compare.py", "maps/test_basins.py", "architecture/test_imports.py",
    "codegen/test_friction_in_loops.py", "laws/test_friction_laws.py", "cli/test_new_and_schema.py", "examples/test_gallery.py",
    "report/test_document.py", "cli/test_searches.py", "kernels/test_as_python.py", "codegen/test_ptx.py", "study/test_engine.py",
    "physics/test_ideal_joints.py", "study/test_cluster.py", "golden/test_golden.py", "model/test_kinds.py", "modelfile/test_fuzz.py",
    "cli/test_check_and_laws.py", "cli/test_storage.py", "maps/test_maps.py", "laws/test_friction_solutions.py", "solvers/test_ensemble.py",
    "physics/test_prescribed_motions.py", "results/test_other_systems.py", "cli/test_mistakes.py", "results/test_killed_processes.py",
    "cli/test_wear.py", "codegen/test_tangent.py", "study/test_study_store.py", "cli/test_plot.py", "report/test_reach.py",
    "cli/test_sensitivity.py", "physics/test_beams.py", "cli/test_study.py", "plots/test_film.py", "physics/test_curved_slot.py",
    "cli/test_start_up.py", "physics/test_lubricated_journal.py", "verification/test_ranges_hold_the_truth.py", "cli/test_signals.py",
    "physics/test_sticking.py", "analysis/test_chaos.py", "physics/test_convergence.py", "results/test_export.py", "codegen/test_threads.py",
)  # fmt: skip

# Files that go to one process: those of a browser, which takes four seconds to start and to end, those that parse all texts,
# and those that look at the same runs.
TOGETHER = (("live/",), ("architecture/",), ("examples/test_gallery.py", "plots/test_figures_of_all_kinds.py"))

# The examples of a property are the same in every run, so that chance fails no test; `make soak` draws others each time, and prints what failed.
settings.register_profile("calm", deadline=None, derandomize=os.environ.get("VFIFE_EXAMPLES") != "all", print_blob=True)
settings.load_profile("calm")


def pytest_configure(config: pytest.Config) -> None:
    """Files keep their order among processes; by itself xdist begins with those of most tests."""
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False
    typer.testing._get_command = functools.cache(typer.testing._get_command)  # the command line, which a thousand tests ask, is put together once
    # Nobody takes the power away: what a test writes need not be on the disk before it goes on, which takes a hundredth of a second each time.
    opening.SYNCHRONOUS, os.fsync = "OFF", lambda file: None
    if "not verify" in config.option.markexpr:
        runner.DataDriven = ForAllLaws


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """In the place of ``--dist loadfile``: files are handed out whole, and those of ``TOGETHER`` go to one process."""
    if config.getvalue("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.split("::", 1)[0]
            return next((group[0] for group in TOGETHER if any(part in file for part in group)), file)

    return Scheduling(config, log)


class FromTheEnd(pytest.Dir):
    """A folder whose last file is read first."""

    def collect(self) -> list[pytest.Item | pytest.Collector]:
        return [*super().collect()][::-1]


def pytest_collect_directory(path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Every other process begins at the end: pytest rewrites each file's assertions and keeps them, so two that meet in the middle do it once."""
    worker = getattr(parent.config, "workerinput", {}).get("workerid", "gw0")
    return FromTheEnd.from_parent(parent, path=path) if int(worker[2:]) % 2 else None


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """What thousands of tests are made of stays: the collector need not look at it as it comes, and seldom at what comes after it."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()
        gc.set_threshold(20_000, 10, 10)


def pytest_sessionfinish() -> None:
    """One last look at what nobody needs; pytest takes ten, at all that is left."""
    gc.collect()
    gc.freeze()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Puts the files of ``FIRST`` first, in its order, and all others in one order, wherever a process began."""
    rank = {name: k for k, name in enumerate(FIRST)}
    items.sort(key=lambda item: (rank.get("/".join(item.path.parts[-2:]), len(rank)), item.path))


@pytest.fixture
def only_built_in_laws() -> Iterator[None]:
    """Laws of a test do not stay in the registries, which other tests go through."""
    before = dict(ContactLaw.registry), dict(FrictionLaw.registry)
    yield
    for law, kept in zip((ContactLaw, FrictionLaw), before, strict=True):
        law.registry.clear()
        law.registry.update(kept)
