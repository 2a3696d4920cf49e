"""The golden cases in every width, number of threads and kind of processor: the hashes that are kept, to the
sign of a zero.

Code for a processor without vectors wider than two numbers, and for one with AVX2, runs on any of today. Code
with AVX-512 runs where there is such a processor, and in an emulated one elsewhere; code for AArch64, with
the two lanes of its registers, in an emulated one.
"""

import platform
import re
import subprocess
import sys
from collections.abc import Iterable
from functools import partial
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest

from emulated import arm, loading, x86
from support import four_bar
from vfife.assembly.assemble import assemble
from vfife.compiler.backends.modules import module
from vfife.compiler.runtime import loops, native
from vfife.compiler.runtime.cuda import Card
from vfife.errors import DeviceError
from vfife.numerics import library
from vfife.solvers.ensemble import ensemble
from vfife.solvers.transient import run

TESTS = Path(__file__).resolve().parents[1]
spec = spec_from_file_location("golden", TESTS / "golden" / "test_golden.py")
golden = module_from_spec(spec)
spec.loader.exec_module(golden)

pytestmark = pytest.mark.verify
X86 = pytest.mark.skipif(
    platform.machine().lower() not in ("x86_64", "amd64"), reason="asks for x86 processors"
)
OBJECT_CODE = native.object_code
FUSED = re.compile(r"\bvfn?m(add|sub)")
# What LLVM calls them: the first of their line, with SSE4, with AVX2 (and fused products, which nobody may
# use), with AVX-512.
BASELINE, SSE4, AVX2, AVX512 = "x86-64", "x86-64-v2", "x86-64-v3", "x86-64-v4"


def forgotten() -> None:
    """No step is there already, nor a piece of one."""
    loops.straight_line.cache_clear()


@pytest.fixture
def code_for(monkeypatch):
    """Has steps compiled for another processor of this kind."""

    library.compiled()  # the start is closed by this processor

    def use(name: str) -> None:
        monkeypatch.setattr(native, "processor", lambda: (name, ""))
        forgotten()

    yield use
    forgotten()


@pytest.mark.parametrize("lanes", [2, 4, 8])
@pytest.mark.parametrize("name", golden.RICH)
def test_any_width(name, lanes):
    """A run with so many lanes, companions in the others."""
    assert golden.digest(name, "generated", companions=lanes - 1) == golden.known(name)


@X86
@pytest.mark.parametrize("processor", [BASELINE, SSE4, AVX2])
@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
def test_any_processor(processor, lanes, code_for):
    if processor == AVX2 and "+avx2" not in native.processor()[1]:
        pytest.skip("this processor has no AVX2")
    code_for(processor)
    names = golden.RICH if lanes in (1, 4) else ("four_bar_case_c", "two_particle_bars", "every law")
    found = {name: golden.digest(name, "generated", companions=lanes - 1) for name in names}
    assert found == {name: golden.known(name) for name in names}


@X86
@pytest.mark.parametrize("name", golden.RICH)
def test_the_text_with_avx_512(name, code_for):
    """Vectors of eight numbers, and no product fused with a sum."""
    code_for(AVX512)
    text = module(golden.start(name).topology, 8)
    assembly = native.machine().emit_assembly(native._target().parse_assembly(text))
    assert len(re.findall(r"\bvmulpd\b.*%zmm", assembly)) > 20
    assert not FUSED.search(assembly)


@pytest.fixture
def eight_wide(code_for, monkeypatch):
    """Steps run in a processor with registers of eight numbers: this one, or an emulated one."""
    here = native.widest() == 8
    code_for(AVX512)
    if not here:
        x86.processor()
        monkeypatch.setattr(loops, "straight", loading(x86.processor))


@X86
@pytest.mark.parametrize("name", golden.RICH)
def test_code_with_avx_512(name, eight_wide):
    assert golden.digest(name, "generated", companions=7) == golden.known(name)


MEMBERS = [four_bar("BCD", clearance=2e-4 * (1 + 0.05 * k)) for k in range(12)]


@pytest.fixture
def alone():
    """What members are by themselves, in this processor's own code."""
    return [
        run(assemble(one, 4e-6, turns=1, outputs=40), loop="data-driven").rows.tobytes() for one in MEMBERS
    ]


@X86
def test_members_with_avx_512(alone, eight_wide):
    """Members that begin and end on their own in eight lanes."""
    assert [
        one.last.rows.tobytes()
        for one in ensemble(MEMBERS, step=4e-6, turns=1, outputs=40, lanes=8, workers=1)
    ] == alone


@X86
def test_a_fused_product_would_move_the_bits(eight_wide, monkeypatch):
    """What the tests above would see if the code were allowed it: they do compute with what the emulated
    processor has.
    """
    loosely = partial(re.sub, r"\b(fmul|fadd|fsub) <8 x double>", r"\1 contract <8 x double>")
    monkeypatch.setattr(native, "object_code", lambda text, *effort: OBJECT_CODE(loosely(text), *effort))
    monkeypatch.setattr(native.cache, "read", lambda name: None)
    monkeypatch.setattr(native.cache, "keep", lambda name, code: None)
    assert golden.digest("four_bar_case_b", "generated", companions=7) != golden.known("four_bar_case_b")


@pytest.fixture
def aarch64(monkeypatch):
    """Steps run in an emulated processor of telephones and of newer Macs."""
    arm.processor()
    library.compiled()
    for name, value in {
        "processor": lambda: (arm.NAME, ""),
        "machine": arm.machine,
        "object_code": arm.object_code,
    }.items():
        monkeypatch.setattr(native, name, value)
    monkeypatch.setattr(loops, "straight", loading(arm.processor))
    forgotten()
    yield
    forgotten()


@pytest.mark.parametrize("lanes", [1, 2])
@pytest.mark.parametrize("name", golden.RICH)
def test_code_for_aarch64(name, lanes, aarch64):
    assert golden.digest(name, "generated", companions=lanes - 1) == golden.known(name)


@pytest.mark.parametrize("name", [name for name in golden.RICH if name not in golden.ON_CARD])
def test_a_card_at_its_addresses(name):
    assert golden.digest_on_card(name) == golden.known(name)


@pytest.mark.parametrize("name", golden.RICH)
def test_a_card_of_this_machine(name):
    """Where there is one; all of these passed on an NVIDIA H100."""
    try:
        there = Card()
    except DeviceError as error:
        pytest.skip(str(error))
    assert golden.digest_on_card(name, there.driver) == golden.known(name)


CHILD = """
import sys
sys.path[:0] = [{tests!r}, {tests!r} + "/golden"]
from one_loop import ForAllLaws
from vfife.compiler.runtime import loops, native
loops.DataDriven = ForAllLaws
native.processor = lambda: ({name!r}, "")
import test_golden
for name in test_golden.RICH:
    print(test_golden.digest(name, "data-driven"))
"""


@X86
def test_the_data_driven_loop_for_the_first_processor_of_its_line():
    child = [sys.executable, "-c", CHILD.format(tests=str(TESTS), name=BASELINE)]
    found = subprocess.run(child, capture_output=True, text=True, check=True).stdout.split()
    assert found == [golden.known(name) for name in golden.RICH]


@pytest.mark.parametrize("workers", range(1, 9))
def test_any_number_of_threads(workers):
    """Sixteen members with clearances of their own, four lanes at a time."""

    def rows(members: Iterable[int], **how) -> np.ndarray:
        made = [four_bar("BCD", clearance=2e-4 * (1 + 0.05 * k)) for k in members]
        return np.stack([one.last.rows for one in ensemble(made, step=4e-6, turns=1, outputs=40, **how)])

    found = rows(range(16), lanes=4, workers=workers)
    assert found[[0, 15]].tobytes() == rows((0, 15), lanes=1, workers=1).tobytes()
    assert not np.signbit(found[found == 0.0]).any()
