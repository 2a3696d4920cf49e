"""The machine code of a step is packed and has no fused product, on this machine and on others: either would
cost a factor or a bit, silently.
"""

import platform
import re
from collections import Counter

import llvmlite.binding as llvm
import pytest

from support import SQUARE, four_bar, journal_in_bearing
from vfife.assembly.assemble import assemble
from vfife.compiler.backends import modules
from vfife.compiler.backends.modules import module, pieces
from vfife.compiler.runtime import native

ARITHMETIC = re.compile(r"^v?(add|sub|mul|div|sqrt|min|max)(sd|pd)$")
FUSED = re.compile(r"\bv?fn?m(add|sub|la|ls)|\bfma\b", re.M)
X86 = pytest.mark.skipif(
    platform.machine().lower() not in ("x86_64", "amd64"), reason="reads x86 instructions"
)


def text(mechanism, width: int, directions: int = 0) -> str:
    return module(assemble(mechanism, 1e-6, duration=1e-3).topology, width, directions)


def listing(text: str, triple: str = "", processor: str = "") -> str:
    """Assembly of a text for this machine or another."""
    machine = native.machine()
    module = llvm.parse_assembly(text)
    if triple:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
        machine = llvm.Target.from_triple(triple).create_target_machine(cpu=processor, opt=native.EFFORT)
        module.triple, module.data_layout = triple, str(machine.target_data)
    return machine.emit_assembly(module)


def instructions(assembly: str, function: str) -> Counter[str]:
    """Instructions of a function."""
    (body,) = re.findall(rf"^{function}:\n(.*?)^\.Lfunc_end", assembly, re.M | re.S)
    return Counter(re.findall(r"^\s+([a-z]\w+)", body, re.M))


@X86
@pytest.mark.parametrize(
    "mechanism", [four_bar("BCD"), four_bar("BCD", "two-particle", section=SQUARE)], ids=["rigid", "frames"]
)
@pytest.mark.parametrize("function", ["fast_steps", "full_step"])
def test_four_lanes_are_packed(mechanism, function):
    """Nothing is added, multiplied, divided or rooted lane by lane, and nothing is called."""
    assembly = listing(text(mechanism, 4))
    found = instructions(assembly, function)
    scalar = {name: count for name, count in found.items() if ARITHMETIC.match(name) and name.endswith("sd")}
    packed = {name: count for name, count in found.items() if ARITHMETIC.match(name) and name.endswith("pd")}
    assert sum(packed.values()) > 300, found
    assert not scalar
    assert packed.keys() >= {"vsqrtpd", "vdivpd"} or packed.keys() >= {"sqrtpd", "divpd"}
    assert not {name for name in found if name.startswith("call")}
    assert not FUSED.search(assembly), "a fused product changes bits from machine to machine"


@pytest.mark.system("compiles for another processor")
@X86
def test_derivatives_are_not_fused_where_the_processor_could():
    """They would be other numbers on a processor that cannot; a processor with AVX2 can."""
    assembly = listing(text(four_bar("BCD"), 4, directions=1), "x86_64-unknown-linux-gnu", "x86-64-v3")
    assert instructions(assembly, "fast_steps")["vmulpd"] > 300
    assert not FUSED.search(assembly)


@X86
@pytest.mark.parametrize("hurried", [False, True])
@pytest.mark.parametrize("width", [1, 2, 4])
def test_a_step_is_compiled_in_two_pieces(width, hurried, monkeypatch):
    """The second, where long, has the same operations with least effort, and none is fused for that. The
    driver is that of all steps.
    """
    monkeypatch.setattr("vfife.compiler.backends.modules.SHORT", 0 if hurried else 4000)
    topologies = [
        assemble(mechanism, 1e-6, duration=1e-3).topology
        for mechanism in (journal_in_bearing(), four_bar("BC"))
    ]
    one, other = (pieces(topology, width) for topology in topologies)
    assert one.frequent != other.frequent
    assert one.hurried == hurried
    made = native.machine(native.LEAST_EFFORT if hurried else native.EFFORT).emit_assembly(
        llvm.parse_assembly(one.rare)
    )
    assert sum(instructions(made, "full_step")[name] for name in ("vmulsd", "mulsd", "vmulpd", "mulpd")) > 20
    assert not FUSED.search(made)
    defined = [
        set(re.findall(r"^define (?!internal)[^@]*@(\w+)\(", piece, re.M))
        for piece in (*one[:2], modules.processor_driver())
    ]
    assert defined == [
        {"fast_steps", "functions"},
        {"full_step", "resize"},
        {"advance", "stream", "polynomial"},
    ]
    assert defined[0] | defined[1] == set(
        re.findall(r"^define [^@]*@(\w+)\(", module(topologies[0], width), re.M)
    )


@X86
def test_the_reading_tells_packed_from_scalar():
    """A step in one lane is scalar: what the test above would see if the compiler gave up."""
    found = instructions(listing(text(journal_in_bearing(), 1)), "fast_steps")
    assert found["vmulsd"] + found["mulsd"] > 20 and found["vsqrtsd"] + found["sqrtsd"] >= 1


@pytest.mark.parametrize(
    ("triple", "processor", "products"),
    [
        ("x86_64-unknown-linux-gnu", "x86-64-v4", r"\bvmulpd\b.*zmm"),
        ("aarch64-unknown-linux-gnu", "neoverse-n1", r"\bfmul\b"),
        ("wasm32-unknown-unknown", "", r"\bf64\.mul\b"),
        ("nvptx64-nvidia-cuda", "sm_90", r"\bmul\.rn\.f64\b"),
    ],
)
def test_other_machines_get_the_same_operations(triple, processor, products):
    """The same text for graphics cards, telephones and the web: products and sums of their
    own, none fused.
    """
    width = 8 if "x86" in triple else 1
    assembly = listing(text(journal_in_bearing(), width), triple, processor)
    assert len(re.findall(products, assembly)) > 20
    assert not FUSED.search(assembly)


def test_a_fused_product_would_be_seen():
    """If the text allowed it, these machines would fuse."""
    loose = (
        text(journal_in_bearing(), 1)
        .replace("fadd double", "fadd fast double")
        .replace("fmul double", "fmul fast double")
    )
    for triple, processor in (
        ("x86_64-unknown-linux-gnu", "x86-64-v3"),
        ("aarch64-unknown-linux-gnu", ""),
        ("nvptx64-nvidia-cuda", "sm_90"),
    ):
        assert FUSED.search(listing(loose, triple, processor)), triple
