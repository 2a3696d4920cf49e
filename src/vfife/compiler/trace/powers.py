"""Powers with a literal whole or half exponent, written as products and square roots.

``x ** 2.5`` calls the ``pow`` of a C library, whose last bits differ between machines and which no vector
loop has. Every reader of a function's text therefore receives ``x * x * math.sqrt(x)`` in its place: Python,
straight-line code of all widths, JavaScript and graphics cards compute this same product, from left to right.
A negative exponent is 1 divided by the product. Other exponents remain, and the language of laws refuses
them.
"""

from __future__ import annotations

import ast
import copy

LARGEST_EXPONENT = 8.0  # a product of more factors is longer, and less accurate, than ``power``
LARGEST_PRODUCT = 500  # nodes: the base is repeated, so that powers of powers grow fast


class Powers(ast.NodeTransformer):
    """Replace powers with a literal exponent that is a multiple of 1/2."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """Replace a power of this kind, after those within it."""
        self.generic_visit(node)
        return product(node) or node if isinstance(node.op, ast.Pow) else node

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.stmt:
        """Replace ``x **= c`` by an assignment of the product."""
        self.generic_visit(node)
        if not isinstance(node.op, ast.Pow) or not isinstance(node.target, ast.Name):
            return node
        name = ast.copy_location(ast.Name(node.target.id, ast.Load()), node)
        value = product(ast.copy_location(ast.BinOp(name, node.op, node.value), node))
        return ast.copy_location(ast.Assign([node.target], value), node) if value else node


def exponent(node: ast.expr) -> float | None:
    """Return the value of a literal exponent such as ``2``, ``-1.5`` or ``3 / 2``; None for any other."""
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return float(min(node.value, 2**53))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        value = exponent(node.operand)
        return None if value is None else -value
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div):
        numerator, denominator = exponent(node.left), exponent(node.right)
        return numerator / denominator if numerator is not None and denominator else None
    return None


def product(node: ast.BinOp) -> ast.expr | None:
    """Return a power as a product with its root as last factor; None if it has to stay as it is.

    A whole literal to the power of another is a whole number, which Python computes exactly.
    """
    value, base = exponent(node.right), node.left
    if not value or abs(value) > LARGEST_EXPONENT or value % 0.5:
        return None
    if all(
        isinstance(operand, ast.Constant) and type(operand.value) is int for operand in (base, node.right)
    ):
        return None
    times = int(abs(value))
    factors = [copy.deepcopy(base) for _ in range(times)]
    if value % 1.0:
        root = ast.Attribute(ast.Name("math", ast.Load()), "sqrt", ast.Load())
        factors.append(ast.Call(root, [copy.deepcopy(base)], []))
    if len(factors) * sum(1 for _ in ast.walk(base)) > LARGEST_PRODUCT:
        return None
    result = factors[0]
    for factor in factors[1:]:
        result = ast.BinOp(result, ast.Mult(), factor)
    if value < 0.0:
        result = ast.BinOp(ast.Constant(1.0), ast.Div(), result)
    return ast.fix_missing_locations(ast.copy_location(result, node))
