"""Signs in a trace: they go through products and quotients to a sum that takes them in, and no
bit changes.
"""

import operator
import re

import numpy as np
import pytest

from support import four_bar
from vfife.assembly.assemble import assemble
from vfife.compiler.backends.llvm import full_step, operators
from vfife.compiler.trace.straight_line import trace
from vfife.compiler.trace.tape import Operation, Symbol, Tape, Trace

FUNCTIONS = {
    "sum": (lambda x, y, z: (-x) + z, 0),
    "sum from the right": (lambda x, y, z: z + (-x), 0),
    "difference": (lambda x, y, z: z - (-x), 0),
    "difference of an opposite": (lambda x, y, z: z - -(x + y), 0),
    "product": (lambda x, y, z: z + (-x) * y, 0),
    "product from the right": (lambda x, y, z: z - x * (-y), 0),
    "both factors": (lambda x, y, z: (-x) * (-y), 0),
    "quotient": (lambda x, y, z: z - (-x) / (-y) + z / (-x), 0),
    "magnitude": (lambda x, y, z: abs((-x) * y), 0),
    "twice": (lambda x, y, z: -(x * -y), 0),
    "factor of minus one": (lambda x, y, z: z + -1.0 * x * y, 0),
    "nothing takes it in": (lambda x, y, z: (-x) * y, 1),
}
DOES = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "neg": operator.neg,
    "abs": abs,
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_signs_go_to_sums_and_change_no_bit(name):
    function, signs = FUNCTIONS[name]
    tape = Tape()
    result = function(*(tape.load(row) for row in range(3)))
    operations = tape.needed([result])
    assert sum(operation.operator == "neg" for operation in operations) == signs
    for x, y, z in np.random.default_rng(5).normal(0.0, 3.0, (200, 3)).tolist():
        values = {"v0": x, "v1": y, "v2": z}
        for made, does, operands in operations:
            values[made] = DOES[does](*(values[o] if isinstance(o, str) else o for o in operands))
        assert isinstance(result, Symbol) and values[result.name] == function(x, y, z)


def test_a_step_has_next_to_no_signs_of_its_own():
    """Levers of joints have one each, and all their products; a sum takes in each of them."""
    operations = trace(assemble(four_bar(""), 1e-4).topology).operations
    assert sum(operation.operator == "neg" for operation in operations) < 0.02 * len(operations)


@pytest.mark.parametrize("chip", ["aarch64-linux-gnu", "nvptx64-nvidia-cuda"])
def test_a_choice_between_a_number_and_zero_is_no_minimum(chip):
    """These processors have a minimum of -0.0 and 0.0 that is -0.0, where `x if x < 0.0 else 0.0` is 0.0."""
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    choices = [Operation("t0", "<", ("v1", 0.0)), Operation("t1", "select", ("t0", "v1", 0.0))]
    choices += [Operation("t2", ">", ("v2", 0.0)), Operation("t3", "select", ("t2", "v2", 0.0))]
    for width in (1, 2) if chip.startswith("aarch64") else (1,):
        module = llvm.parse_assembly(
            operators(width) + "\n" + full_step(Trace(tuple(choices), {0: "t1", 3: "t3"}), width, False, True)
        )
        module.triple = chip
        machine = llvm.Target.from_triple(chip).create_target_machine(
            cpu="sm_70" if chip.startswith("nvptx") else "", opt=1
        )
        text = machine.emit_assembly(module)
        assert not re.search(r"^\s+(fminn?m?|fmaxn?m?|min|max)\b", text, re.M), text
        assert re.search(r"fcsel|selp|bif|bit|bsl|and", text)
