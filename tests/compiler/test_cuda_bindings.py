"""NVIDIA's own bindings, with a library in the driver's place that has its functions and their signatures:
what the bindings make of our calls.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from fake_card import rows_on_card
from lane_models import one_clearance
from vfife.assembly.assemble import assemble
from vfife.compiler.backends import gpu
from vfife.compiler.runtime import native, ptx

driver = pytest.importorskip(
    "cuda.bindings.driver", reason="needs cuda-bindings, which the extra test brings on Linux"
)
pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or shutil.which("cc") is None, reason="needs Linux and a C compiler"
)
TESTS = Path(__file__).resolve().parents[1]
CHILD = """
import sys
sys.path.insert(0, {tests!r})
from cuda.bindings import driver
from fake_card import rows_on_card
from compiler.test_cuda_bindings import member
sys.stdout.buffer.write(rows_on_card(member(), driver).tobytes())
"""
ASKED = "from vfife.compiler.runtime.cuda import Card; Card()"


def member():
    return assemble(one_clearance(1), 2e-6, duration=2e-3, outputs=20, force_step=True)


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    """A folder with the library."""
    folder = tmp_path_factory.mktemp("driver")
    subprocess.run(
        [
            "cc",
            "-shared",
            "-fPIC",
            "-o",
            folder / "libcuda.so.1",
            Path(__file__).with_name("libcuda.c"),
            "-ldl",
        ],
        check=True,
    )
    return folder


def run(place: Path, code: str, **given: object) -> subprocess.CompletedProcess[bytes]:
    """A process in which that library is the driver."""
    said = {"VFIFE_CUDA": driver.CUDA_VERSION, "LD_LIBRARY_PATH": place} | given
    environment = os.environ | {name: str(value) for name, value in said.items()}
    return subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=False)


@pytest.mark.system("starts a process with a library in the driver's place")
def test_our_calls_reach_the_driver(place):
    """A member stepped by a kernel that the driver loads and launches: arguments, addresses and copies go
    through the bindings.
    """
    llvm = native._target()
    name, features = native.processor()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=name, features=features, opt=0, reloc="pic", codemodel="small"
    )
    text = gpu.module(member().topology, ptx.stream())
    (place / "step.o").write_bytes(machine.emit_object(llvm.parse_assembly(text)))
    subprocess.run(["cc", "-shared", "-o", place / "step.so", place / "step.o"], check=True)
    done = run(place, CHILD.format(tests=str(TESTS)), VFIFE_STEP=place / "step.so")
    assert done.returncode == 0, done.stderr.decode()
    assert done.stdout == rows_on_card(member()).tobytes()


@pytest.mark.system("starts processes")
def test_the_driver_that_is_not_there_and_the_one_that_is_too_old(place, tmp_path):
    for folder, given, words in (
        (place, {"VFIFE_CUDA": 11080}, "the NVIDIA driver is too old: it knows CUDA 11.8"),
        *([] if has_driver() else [(tmp_path, {}, "there is no NVIDIA driver on this machine")]),
    ):
        said = run(folder, ASKED, **given).stderr.decode().splitlines()[-1]
        assert said.startswith("vfife.errors.DeviceError: device cuda: ") and words in said, said


def has_driver() -> bool:
    """Whether this machine has a driver of NVIDIA's own."""
    try:
        driver.cuInit(0)
    except RuntimeError:
        return False
    return True
