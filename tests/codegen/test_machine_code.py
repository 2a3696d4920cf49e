"""The machine code of four lanes is packed: one scalar operation or call left in the loop costs a factor, silently."""

import platform
import re
from collections import Counter

import pytest

from support import SQUARE, four_bar, journal_in_bearing
from vfife.assembly.assemble import assemble
from vfife.codegen import compile as compiling
from vfife.codegen.python import straight_line

SIGNATURE = "int64(float64[::1], float64[::1], int64, int64)"
ARITHMETIC = re.compile(r"^v?(add|sub|mul|div|sqrt|min|max)(sd|pd)$")


def instructions(body: str, folder) -> Counter[str]:
    """Instructions of the function ``run`` of a text, without the wrapper by which Python calls it."""
    path = folder / "step.py"
    path.write_text(compiling.HEADER.replace("cache=True, ", "") + compiling.named(body, "run"))
    run = compiling.load(path).run
    run.compile(SIGNATURE)
    (listing,) = run.inspect_asm().values()
    functions = re.findall(r"^(_ZN\S+):\n(.*?)^\.Lfunc_end", listing, re.M | re.S)
    (native,) = [text for name, text in functions if "cpython" not in name and "3run" in name]
    return Counter(re.findall(r"^\s+([a-z]\w+)", native, re.M))


@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="reads x86 instructions")
@pytest.mark.parametrize("mechanism", [four_bar("BCD"), four_bar("BCD", "two-particle", section=SQUARE)], ids=["rigid", "frames"])
def test_four_lanes_are_packed(mechanism, tmp_path):
    """Nothing is added, multiplied, divided or rooted lane by lane; what is left adds the four flags of a rare step, once a step."""
    topology = assemble(mechanism, 1e-6, duration=1e-3).topology
    found = instructions(straight_line(topology, 4), tmp_path)
    scalar = {name: count for name, count in found.items() if ARITHMETIC.match(name) and name.endswith("sd")}
    packed = {name: count for name, count in found.items() if ARITHMETIC.match(name) and name.endswith("pd")}
    assert sum(packed.values()) > 300, found
    assert sum(scalar.values()) <= 3, scalar
    assert packed.keys() >= {"vsqrtpd", "vdivpd"} or packed.keys() >= {"sqrtpd", "divpd"}
    assert not {name for name in found if name.startswith("call")}
    assert not {name for name in found if re.match(r"^vfn?m(add|sub)", name)}, "a fused product changes bits from machine to machine"


@pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="reads x86 instructions")
def test_the_reading_tells_packed_from_scalar(tmp_path):
    """A step in one lane is scalar: what the test above would see if the compiler gave up."""
    topology = assemble(journal_in_bearing(), 1e-6, duration=1e-3).topology
    found = instructions(straight_line(topology, 1), tmp_path)
    assert found["vmulsd"] + found["mulsd"] > 20 and found["vsqrtsd"] + found["sqrtsd"] >= 1
