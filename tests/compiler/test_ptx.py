"""The step as PTX, and as NVIDIA's assembler makes machine code of it: nothing fused, roots and quotients
rounded as IEEE 754 asks, few spills.

ptxas and nvdisasm come with the extra ``test`` on Linux; no card is needed.
"""

from __future__ import annotations

import importlib.util
import re
import subprocess
from collections import Counter
from pathlib import Path

import pytest

from support import four_bar, journal_in_bearing
from vfife.assembly.assemble import assemble
from vfife.compiler.backends import gpu
from vfife.compiler.runtime.ptx import ptx, stream

ARITHMETIC = re.compile(r"^\s+((?:fma|mad|mul|add|sub|div|sqrt|rcp|ex2|neg|abs)\.\S*f64)", re.M)


def nvidia(name: str) -> Path:
    """A program among NVIDIA's packages; they are namespaces without a module that could be imported."""
    spec = importlib.util.find_spec("nvidia")
    for folder in spec.submodule_search_locations if spec else ():
        for path in Path(folder).glob(f"*/bin/{name}"):
            return path
    pytest.skip(
        f"needs {name}: pip install nvidia-cuda-nvcc-cu12 nvidia-cuda-nvdisasm, which the extra test brings"
        " on Linux"
    )


def text_of(mechanism) -> str:
    return gpu.module(assemble(mechanism, 1e-6, duration=1e-3).topology, stream())


def assembled(program: str, capability: int, folder: Path) -> str:
    """What ptxas says of each function; the machine code lies in the folder."""
    (folder / "step.ptx").write_text(program)
    command = [
        nvidia("ptxas"),
        "-v",
        f"-arch=sm_{capability}",
        folder / "step.ptx",
        "-o",
        folder / "step.cubin",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stderr


def machine_code(folder: Path) -> Counter[str]:
    """Instructions by name."""
    found = subprocess.run(
        [nvidia("nvdisasm"), "-c", folder / "step.cubin"], capture_output=True, text=True, check=True
    ).stdout
    return Counter(re.findall(r"/\*[0-9a-f]{4,}\*/\s+(?:@!?U?P\w+\s+)?([A-Z][A-Z0-9]*)", found))


@pytest.mark.parametrize(
    ("mechanism", "capability"),
    [(four_bar("BCD"), 70), (journal_in_bearing(), 80), (journal_in_bearing(), 90)],
    ids=["70", "80", "90"],
)
def test_ptx_has_the_operations_of_the_text(mechanism, capability):
    """One instruction for one, rounded to nearest: of ``mul.rn`` and ``add.rn`` the assembler may make no
    fused product.

    LLVM says two of them in another way: a quotient of one is a reciprocal, twice a number its sum with
    itself.
    """
    text = text_of(mechanism)
    found = Counter(ARITHMETIC.findall(ptx(text, capability)))
    asked = Counter(re.findall(r"= (fadd|fsub|fmul|fdiv|call double @llvm\.\w+)", text))
    assert {name.removesuffix(".f64").removesuffix(".rn") for name in found} <= {
        "mul",
        "add",
        "sub",
        "div",
        "rcp",
        "sqrt",
        "neg",
        "abs",
    }
    assert all(name.endswith(".rn.f64") or name in ("neg.f64", "abs.f64") for name in found), found
    assert (
        sum(found[f"{name}.rn.f64"] for name in ("mul", "add", "sub"))
        == asked["fmul"] + asked["fadd"] + asked["fsub"]
    )
    assert found["div.rn.f64"] + found["rcp.rn.f64"] == asked["fdiv"] > 0
    assert found["sqrt.rn.f64"] == asked["call double @llvm.sqrt"] > 0


@pytest.mark.system("assembles code for a card")
def test_registers_and_spills(tmp_path):
    """Case c on an H100: its lean step has the whole state in registers and puts aside 1.0 kB of what they do
    not hold, as ptxas 12.9 has it.
    """
    said = assembled(ptx(text_of(four_bar("BCD"))), 90, tmp_path)
    (registers,) = re.findall(r"Used (\d+) registers", said)
    stores, loads = map(
        int, re.findall(r"for fast_steps\n.*?(\d+) bytes spill stores, (\d+) bytes spill loads", said)[0]
    )
    assert int(registers) <= 255
    assert stores <= 1100 and loads <= 920, "1004 and 820 when this was measured"
    assert {
        name for name, size in re.findall(r"for (\w+)\n.*?(\d+) bytes spill stores", said) if int(size) > 200
    } == {"fast_steps"}


@pytest.mark.system("assembles code for a card")
def test_machine_code_fuses_nothing(tmp_path):
    """Quotients and roots are made of fused products inside, which is how IEEE's rounding is had there; a
    text without them has none.

    Were the text to allow it, there would be hundreds.
    """
    text = (
        text_of(journal_in_bearing())
        .replace("fdiv double", "fsub double")
        .replace("call double @llvm.sqrt", "call double @llvm.fabs")
    )
    assembled(ptx(text), 90, tmp_path)
    found = machine_code(tmp_path)
    assert found["DMUL"] > 50 and found["DADD"] > 50 and not found["DFMA"], found
    assembled(ptx(re.sub(r"\b(fadd|fsub|fmul) double", r"\1 contract double", text)), 90, tmp_path)
    assert machine_code(tmp_path)["DFMA"] > 20


def test_one_text_for_all_cards(tmp_path):
    """What is written for a card of 2017 is assembled for it; above, for one of 2022."""
    program = ptx(text_of(journal_in_bearing()))
    assert re.search(r"^\.version 6\.0$", program, re.M) and re.search(r"^\.target sm_70$", program, re.M)
    assert "0 bytes spill stores" in assembled(program, 70, tmp_path)
