"""Signs in a trace: they go through products and quotients to a sum that takes them in, and no bit changes."""

import operator

import numpy as np
import pytest

from support import four_bar
from vfife.assembly.assemble import assemble
from vfife.codegen.straight_line import trace
from vfife.codegen.trace import Symbol, Tape

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
DOES = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "neg": operator.neg, "abs": abs}


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
