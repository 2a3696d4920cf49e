"""Settings that make one machine compute like others: kernels of BLAS, instructions of NumPy and of the C
library, lanes, cores, versions.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OLDEST = ROOT / ".venv-oldest" / "bin" / "python"
X86 = platform.machine().lower() in ("x86_64", "amd64")
# Kernels of OpenBLAS by the processors that they are written for, from SSE3 to AVX-512; all sum in other
# orders.
KERNELS = (
    ("Prescott", "Nehalem", "Sandybridge", "Haswell", "SkylakeX")
    if X86
    else ("ARMV8", "NEOVERSEN1", "THUNDERX2T99")
)
# Functions of the C library that have a variant with fused products or with wide registers.
GLIBC = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable,-AVX512F"
FEATURES = """
import json
try:
    from numpy._core import _multiarray_umath as umath
except ImportError:
    from numpy.core import _multiarray_umath as umath
print(json.dumps([name for name in umath.__cpu_dispatch__ if umath.__cpu_features__.get(name)]))
"""


@dataclass(frozen=True)
class Setting:
    """One way to make this machine another one: variables of its environment, words of the script, and the
    Python that runs it.
    """

    name: str
    variables: dict[str, str] = field(default_factory=dict)
    words: tuple[str, ...] = ()
    python: str = sys.executable
    compiles: bool = False  # steps of its own: it need not wait until the first setting has compiled them

    def joined(self, other: Setting) -> Setting:
        """Return this setting with the variables and words of another one beside its own."""
        name, variables = f"{self.name}, {other.name}", {**self.variables, **other.variables}
        compiles = self.compiles or other.compiles
        return Setting(name, variables, (*self.words, *other.words), self.python, compiles)


def features(python: str = sys.executable) -> list[str]:
    """Instructions of this processor that NumPy has own code for."""
    done = subprocess.run([python, "-c", FEATURES], capture_output=True, text=True, check=True)
    found: list[str] = json.loads(done.stdout)
    return found


def settings() -> list[Setting]:
    """All of them; the first changes nothing. Two changes share a process where each has one of its own
    elsewhere, too, or could hide nothing. Code for a kind of processor goes with the kernel of BLAS for that
    kind: either of them that changes an answer is seen.
    """
    library = Setting("C library without AVX2 and FMA", {"GLIBC_TUNABLES": GLIBC} if X86 else {})
    numpy = Setting(
        f"NumPy without {', '.join(features())}", {"NPY_DISABLE_CPU_FEATURES": " ".join(features())}
    )
    threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    one_core = Setting("1 core, 1 thread of BLAS", threads, ("--cores", "1"))
    beside = (  # what goes with which kernel of BLAS
        (KERNELS[0], library), (KERNELS[1], library), (KERNELS[1], numpy), (KERNELS[2], numpy),
        (KERNELS[-2], one_core), (KERNELS[-1], Setting("8 cores", words=("--cores", "8"))),
        *((kernel, Setting(f"processor {name}", words=("--processor", name), compiles=True))
          for name, kernel in processors().items()),
    )  # fmt: skip
    found = [Setting("as it is")]
    for name in KERNELS:
        setting = Setting(f"BLAS kernel {name}", {"OPENBLAS_CORETYPE": name})
        for kernel, other in beside:
            setting = setting.joined(other) if kernel == name else setting
        found.append(setting)
    found.append(Setting("other libraries", words=("--other-libraries",)))
    if OLDEST.exists():
        found.append(Setting("oldest NumPy", python=str(OLDEST), compiles=True))
        without = {
            "NPY_DISABLE_CPU_FEATURES": " ".join(features(str(OLDEST))),
            "OPENBLAS_CORETYPE": KERNELS[1],
        }
        found.append(
            Setting("oldest NumPy without its own code for this processor", without, python=str(OLDEST))
        )
    return found


def processors() -> dict[str, str]:
    """Kinds of x86 processor that this one can stand in for, with registers of two, four and eight numbers,
    and the kernel of BLAS that such a processor has.
    """
    flags = set(Path("/proc/cpuinfo").read_text().split()) if Path("/proc/cpuinfo").exists() else set()
    kinds: dict[str, tuple[str, set[str]]] = {
        "x86-64": ("Prescott", set()),
        "x86-64-v3": ("Haswell", {"avx2"}),
        "x86-64-v4": ("SkylakeX", {"avx512f", "avx512dq", "avx512vl"}),
    }
    return {name: kernel for name, (kernel, needed) in kinds.items() if X86 and needed <= flags}


def carried_out(
    setting: Setting, folder: Path, names: list[str] | None = None, options: list[str] | None = None
) -> subprocess.Popen[str]:
    """The process that carries out the commands under a setting; its answers come into the folder."""
    words = [setting.python, str(Path(__file__).with_name("commands.py")), str(folder), *setting.words]
    words += [f"--name={name}" for name in names or ()] + [f"--option={word}" for word in options or ()]
    return subprocess.Popen(
        words,
        env={**os.environ, **setting.variables},
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
    )


def answers(process: subprocess.Popen[str], folder: Path) -> dict[str, dict[str, object]]:
    """What the process found, once it has ended. Raises RuntimeError with what it said where it failed."""
    said = process.communicate()[1]
    if process.returncode:
        raise RuntimeError(f"the commands failed, with exit code {process.returncode}:\n{said}")
    found: dict[str, dict[str, object]] = json.loads((folder / "answers.json").read_text())
    return found
