"""The start is in the run file: reading a run assembles nothing, and does not mind that blocks of the state
have come or gone since.
"""

import dataclasses
import mmap
import sqlite3
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

import vfife
from support import SQUARE, bits, four_bar, journal_in_bearing
from vfife import files
from vfife.assembly.assemble import assemble
from vfife.errors import ModelError, RunFileError
from vfife.job import cost
from vfife.kernels.blocks import BLOCKS
from vfife.measures.energy import ledger
from vfife.report.overview import certainty, uncertain
from vfife.report.trust import trust_lines
from vfife.simulation.start import RestoredStart
from vfife.solvers import record as records
from vfife.solvers.transient import run
from vfife.store.runfile import RunFile


@pytest.fixture(scope="module")
def result() -> vfife.Result:
    return vfife.simulate(
        four_bar(model="elastic", section=SQUARE, elements=2),
        duration=1e-4,
        step=1e-6,
        outputs=400,
        loop="data-driven",
    )


def refuse(*args: object, **kwargs: object) -> None:
    raise AssertionError("a run that is read is not assembled")


def test_the_assembly_comes_back_whole(
    result: vfife.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result.save(tmp_path / "run.sqlite")
    monkeypatch.setattr("vfife.assembly.assemble.assemble", refuse)
    again = vfife.load_result(tmp_path)
    for kept, was in (
        (again.record.assembly, result.record.assembly),
        (again.reference.record.assembly, result.reference.record.assembly),
    ):
        for name in (
            "choice",
            "bodies",
            "contacts",
            "ideals",
            "pivots",
            "springs",
            "contact_joints",
            "mobility",
            "notes",
        ):
            assert getattr(kept, name) == getattr(was, name), name
        kept_rows = [
            row for block in BLOCKS if block.role != "scratch" for row in was.layout.rows_of(block.name)
        ]
        assert (bits(kept.state[kept_rows]) == bits(was.state[kept_rows])).all()
        assert (bits(kept.tables) == bits(was.tables)).all()
    assert again.record.assembly.topology == result.record.assembly.topology
    assert again.data.identical(result.data)
    assert again.summary == result.summary


def test_a_run_goes_on_from_its_file(result: vfife.Result, tmp_path: Path) -> None:
    """To the bit as it goes on from memory: the state at the end, the names and the integers
    are all there.
    """
    mechanism, path = result.record.assembly.mechanism, tmp_path / "run.sqlite"
    with RunFile.create(path) as file:
        first = vfife.simulate(
            mechanism, duration=1e-4, step=1e-6, outputs=400, loop="data-driven", reference=False, file=file
        )
        first.finish(file)
    options = {"duration": 2e-5, "step": 1e-6, "outputs": 400, "loop": "data-driven", "reference": False}
    first.save(tmp_path / "saved.sqlite")
    one = vfife.simulate(mechanism, start=first, **options)
    for start in (tmp_path, tmp_path / "saved.sqlite"):
        assert (
            bits(vfife.simulate(mechanism, start=start, **options).record.rows) == bits(one.record.rows)
        ).all()


@pytest.mark.parametrize("change", ["a block that is gone", "a block that is new", "another order"])
def test_later_layouts_do_not_matter(result: vfife.Result, tmp_path: Path, change: str) -> None:
    """What another version's layout would be: blocks of the start and of the last state are found by their
    names.
    """
    path = tmp_path / "run.sqlite"
    result.save(path)
    with RunFile.open(path) as file:
        meta, (step, last) = file.meta, file.last_checkpoint()

    def changed(values: np.ndarray) -> dict[str, np.ndarray]:
        at = 0
        parts = {name: values[(at := at + count) - count : at] for name, count in meta["assembly"]["blocks"]}
        if change == "a block that is gone":
            return {"contact_colour": np.arange(3.0)} | parts
        if change == "a block that is new":
            return {name: part for name, part in parts.items() if name != "body_alpha_max"}
        return dict(reversed(parts.items()))

    start, state = changed(meta["start"]), changed(last)
    with RunFile(path, sqlite3.connect(path, isolation_level=None)) as file, file.transaction():
        file._put(
            {
                "start": np.concatenate(list(start.values())),
                "assembly": meta["assembly"]
                | {"blocks": [[name, len(values)] for name, values in start.items()]},
            }
        )
    with RunFile(path, sqlite3.connect(path, isolation_level=None)) as file:
        file.checkpoint(step, np.concatenate(list(state.values())))
    again = vfife.load_result(path)
    assert again.data.identical(result.data)
    for block in BLOCKS:
        if block.role in ("state", "memory"):
            rows = again.record.assembly.layout.rows_of(block.name)
            assert (bits(again.record.final[rows]) == bits(result.record.final[rows])).all()


def test_a_start_that_does_not_fit_is_told(result: vfife.Result, tmp_path: Path) -> None:
    path = tmp_path / "run.sqlite"
    result.save(path)
    with RunFile(path, sqlite3.connect(path, isolation_level=None)) as file, file.transaction():
        file._put({"start": np.zeros(3)})
    with pytest.raises(RunFileError, match="does not fit the model; run the model again"):
        vfife.load_result(path)


# ------------------------------------------------------------------------------------------------------------
# streaming


def test_rows_are_those_of_a_run_without_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In memory, and mapped where they are many: the same bits, also after the file is closed."""
    assembly = assemble(journal_in_bearing(), 1e-6, duration=2e-3, outputs=500)
    rows = run(assembly, loop="data-driven").rows
    for limit in (records.IN_MEMORY, 0):
        monkeypatch.setattr(records, "IN_MEMORY", limit)
        path = tmp_path / f"{limit}.sqlite"
        with RunFile.create(path) as file:
            record = run(assembly, loop="data-driven", file=file)
        assert not isinstance(record.source, np.ndarray)
        assert (bits(record.rows) == bits(rows)).all() and len(record.steps) == len(rows)


def test_rows_that_do_not_fit_into_memory_are_mapped(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a file, too: the same bits, in a temporary file that is gone with the result."""
    known = vfife.simulate(journal_in_bearing(), duration=2e-3, outputs=500, companions=0)
    monkeypatch.setattr(records, "IN_MEMORY", 100_000)
    found = vfife.simulate(journal_in_bearing(), duration=2e-3, outputs=500, companions=0)
    base = found.record.rows
    while isinstance(base, np.ndarray) and base.base is not None:
        base = base.base
    assert isinstance(base, mmap.mmap) and (bits(found.record.rows) == bits(known.record.rows)).all()
    assert found.measures == known.measures


def test_a_run_larger_than_half_of_the_memory_is_not_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cost, "physical_memory", lambda: 1_000_000)
    with pytest.raises(ModelError, match="of memory"):
        vfife.simulate(journal_in_bearing(), duration=2e-3, outputs=500, companions=0)
    monkeypatch.setattr(records, "IN_MEMORY", 100_000)
    monkeypatch.setattr("vfife.simulation.simulate.IN_MEMORY", 100_000)
    assert (
        len(vfife.simulate(journal_in_bearing(), duration=2e-3, outputs=500, companions=0).record.rows) == 501
    )
    monkeypatch.setattr(files, "free_bytes", lambda place: 200_000)
    with pytest.raises(ModelError, match="on a disk that has"):
        vfife.simulate(journal_in_bearing(), duration=2e-3, outputs=500, companions=0)


@pytest.mark.system("measures the memory of a long run")
def test_memory_is_flat_as_a_run_grows(tmp_path: Path) -> None:
    """Ten times the outputs, of which a run without a file keeps all."""
    run(assemble(journal_in_bearing(), 1e-6, duration=1e-4, outputs=10), loop="data-driven")

    def largest(outputs: int) -> int:
        assembly = assemble(journal_in_bearing(), 1e-6, duration=1e-6 * outputs, outputs=outputs)
        with RunFile.create(tmp_path / f"{outputs}.sqlite") as file:
            tracemalloc.start()
            record = run(assembly, loop="data-driven", file=file)
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
        assert len(record.steps) == outputs + 1
        return peak

    width = 8 * len(
        run(assemble(journal_in_bearing(), 1e-6, duration=1e-6, outputs=1), loop="data-driven").row_numbers
    )
    few, many = largest(20_000), largest(200_000)
    assert 200_000 * width > 4 * many  # what the rows alone would take
    assert many < 1.5 * few + 2**23


LARGEST_MEMORY = """
import re, sys, vfife
from pathlib import Path
from vfife.store.runfile import RunFile
model, place, turns = vfife.load_model(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])
with RunFile.create(place / f"{turns}.sqlite", gather=0.25) as file:
    result = vfife.simulate(model, turns=turns, outputs=2880, reference=False, file=file)
    result.finish(file)
kilobytes = re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1]
print(result.record.rows.nbytes, 1024 * int(kilobytes))
"""


@pytest.mark.system("starts processes, and measures their memory")
@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_memory_hardly_grows_with_a_run_that_is_summarised(tmp_path: Path) -> None:
    """With a file, energies and cautions of all outputs included: 0.2 times what more rows take."""
    examples = Path(__file__).parents[2] / "examples"
    (few, small), (many, large) = (
        map(
            int,
            subprocess.run(
                [
                    sys.executable,
                    "-c",
                    LARGEST_MEMORY,
                    examples / "four_bar_case_c.toml",
                    tmp_path,
                    f"{turns}",
                ],
                check=True,
                capture_output=True,
                text=True,
            ).stdout.split(),
        )
        for turns in (10, 80)
    )
    assert many - few > 1.5e8 and large - small < 0.4 * (many - few)


def test_pieces_of_a_mapped_record_have_the_bits_of_the_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Columns in the same layout, on which sums depend, and energies counted from the first output."""
    path, options = tmp_path / "run.sqlite", {"duration": 2e-3, "outputs": 500, "companions": 0}
    whole = vfife.simulate(journal_in_bearing(), **options)
    energies = ledger(whole.record).terms
    monkeypatch.setattr("vfife.store.run_reader.READ_IN_MEMORY", 0)
    monkeypatch.setattr("vfife.store.run_reader.PIECE_BYTES", 5_000)
    monkeypatch.setattr(records, "PIECE_BYTES", 7_000)
    monkeypatch.setattr("vfife.measures.energy.PIECE", 60)
    with RunFile.create(path) as file:
        pieces = vfife.simulate(journal_in_bearing(), **options, file=file)
    assert records.mapping_of(pieces.record.rows) is not None
    assert records.mapping_of(whole.record.rows) is None
    for name in ("particle_x", "contact_penetration"):
        known, found = whole.record.block(name), pieces.record.block(name)
        assert (bits(found) == bits(known)).all() and found.strides == known.strides
        assert (bits(pieces.record.last(name)) == bits(known[-1])).all()
    for name, values in energies.items():
        assert (bits(pieces.ledger.terms[name]) == bits(values)).all(), name
    assert list(pieces.ledger.terms) == list(energies) and pieces.measures == whole.measures


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> tuple[vfife.Result, vfife.Result, vfife.Result]:
    """Three turns of the template, three that go on from their file, and six in one run."""
    model = vfife.load(Path(vfife.__file__).parent / "modelfile" / "templates" / "four-bar.toml")
    folder = tmp_path_factory.mktemp("parts")
    first = vfife.simulate(model, turns=3)
    first.save(folder / "first.sqlite")
    second = vfife.simulate(model, turns=3, start=folder / "first.sqlite")
    return first, second, vfife.simulate(model, turns=6, step=first.record.assembly.choice.step)


def test_companions_go_on_from_those_of_the_former_run(parts) -> None:
    """Ranges of a second part are those of the same turn in one run: three turns of errors are in them."""
    first, second, whole = parts
    assert second.record.assembly.choice.step == first.record.assembly.choice.step
    assert second.summary["trust"]["tried"] == []  # no step makes companions agree that differ at the start
    assert second.summary["trust"]["sensitive"] and whole.summary["trust"]["sensitive"]
    for name in ("A.force.max", "B.force.max", "C.force.max", "D.force.max"):
        part, one = second.measures[name], whole.measures[name]
        assert float(part) == pytest.approx(float(one), rel=1e-3)
        assert part.high - part.low == pytest.approx(one.high - one.low, rel=0.25), name
        assert part.high - part.low > 0.05 * part
    assert second.summary["trust"]["former"] == {"included": True}
    assert "companions go on from those of the run before" in " ".join(trust_lines(second.summary))
    assert "not included" not in certainty(second.summary)


def test_a_run_file_has_the_starts_of_companions(parts, tmp_path: Path) -> None:
    """A run that is killed before its first checkpoint starts its companions where it did."""
    _, second, _ = parts
    second.save(tmp_path / "second.sqlite")
    again = vfife.load_result(tmp_path / "second.sqlite")
    lasting = records.lasting_rows(second.record.assembly.layout)
    starts, kept = (result.record.assembly.companion_states[lasting] for result in (second, again))
    assert starts.shape[1] == 3 and not np.array_equal(starts[:, 0], starts[:, 1])
    assert np.array_equal(bits(kept), bits(starts))
    retried = RestoredStart(again.record, {"turns": 3.0}, {}, started=True).assemble(None)
    assert np.array_equal(bits(retried.companion_states[lasting]), bits(starts))


def test_errors_of_a_former_run_that_are_left_out_are_said(parts) -> None:
    """Without the states of its companions, a run that goes on says that errors of the former one are left
    out, and so does the run that goes on from it.
    """
    first, _, _ = parts
    model = first.record.assembly.mechanism
    alone = vfife.simulate(model, turns=1, companions=0)
    second = vfife.simulate(model, turns=1, start=alone)
    third = vfife.simulate(model, turns=1, start=second)
    for result in (second, third):
        former = result.summary["trust"]["former"]
        assert not former["included"] and former["measure"] == ""  # that of the first is not known
        assert "errors of the run that it goes on from (" in certainty(result.summary)
        assert "are not included" in " ".join(trust_lines(result.summary))
    assert uncertain(second.summary) and not certainty(second.summary).startswith("Reliable")


def test_a_run_that_goes_on_from_a_sensitive_one_is_not_reliable(parts) -> None:
    """The former run is known to be sensitive, and its companions have no states: its error is a number."""
    _, second, _ = parts
    lost = vfife.Result(dataclasses.replace(second.record, checkpoint=None), arguments=second.arguments)
    third = vfife.simulate(second.record.assembly.mechanism, turns=1, start=lost)
    former = third.summary["trust"]["former"]
    assert former["sensitive"] and former["apart"] == second.summary["trust"]["apart"]
    assert third.record.assembly.companion_states is None
    assert f"{former['apart']:.2%}"[0] in certainty(third.summary) and uncertain(third.summary)
    assert f"at {former['measure']}) are not included" in certainty(third.summary)
