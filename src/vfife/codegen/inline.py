"""Writes the functions of a gathered text into the one that calls them.

Numba compiles each function by itself before it is inlined, which takes most of the time of a first start; and a call that is left in a loop
over lanes costs a factor of five. Here calls are written out in the source: arguments become assignments, local names get a number.
"""

from __future__ import annotations

import ast
import copy


class _Rename(ast.NodeTransformer):
    def __init__(self, names: dict[str, ast.expr]) -> None:
        self.names = names

    def visit_Name(self, node: ast.Name) -> ast.AST:
        if node.id not in self.names:
            return node
        new = copy.deepcopy(self.names[node.id])
        if isinstance(new, ast.Name):
            new.ctx = node.ctx
        return new


def _simple(function: ast.FunctionDef) -> bool:
    """Whether a function has one return, at its end, or none."""
    returns = [node for node in ast.walk(function) if isinstance(node, ast.Return)]
    return not returns or (len(returns) == 1 and function.body[-1] is returns[0])


def _assigned(function: ast.FunctionDef) -> set[str]:
    return {node.id for node in ast.walk(function) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}


class _Inliner:
    def __init__(self, functions: dict[str, ast.FunctionDef]) -> None:
        self.functions = {name: function for name, function in functions.items() if _simple(function)}
        self.count = 0

    def body(self, statements: list[ast.stmt]) -> list[ast.stmt]:
        """The statements with calls written out."""
        out: list[ast.stmt] = []
        for statement in statements:
            for name in ("body", "orelse"):
                inner = getattr(statement, name, None)
                if isinstance(inner, list):
                    setattr(statement, name, self.body(inner))
            if isinstance(statement, (ast.Assign, ast.Expr, ast.AugAssign)):
                out += self._calls(statement)
            else:
                out.append(statement)
        return out

    def _known(self, node: ast.AST) -> bool:
        return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in self.functions

    def _calls(self, statement: ast.Assign | ast.Expr | ast.AugAssign) -> list[ast.stmt]:
        before: list[ast.stmt] = []
        value = statement.value
        if self._known(value) and not isinstance(statement, ast.AugAssign):
            targets = statement.targets if isinstance(statement, ast.Assign) else []
            return before + self._write(value, targets)  # type: ignore[arg-type]
        inliner = self

        class Hoist(ast.NodeTransformer):
            """Calls inside an expression become assignments before it; those in an arm of a conditional stay calls."""

            def visit_IfExp(self, node: ast.IfExp) -> ast.AST:
                node.test = self.visit(node.test)
                return node

            def visit_Call(self, node: ast.Call) -> ast.AST:
                self.generic_visit(node)
                if not inliner._known(node):
                    return node
                inliner.count += 1
                name = f"h{inliner.count}"
                before.extend(inliner._write(node, [ast.Name(name, ast.Store())]))
                return ast.Name(name, ast.Load())

        statement.value = Hoist().visit(value)
        return [*before, statement]

    def _write(self, call: ast.Call, targets: list[ast.expr]) -> list[ast.stmt]:
        function = copy.deepcopy(self.functions[call.func.id])  # type: ignore[attr-defined]
        self.count += 1
        number = self.count
        written = _assigned(function)
        names: dict[str, ast.expr] = {name: ast.Name(f"{name}_{number}", ast.Load()) for name in written}
        out: list[ast.stmt] = []
        for parameter, argument in zip(function.args.args, call.args, strict=True):
            plain = isinstance(argument, (ast.Name, ast.Constant)) and parameter.arg not in written
            if plain:
                names[parameter.arg] = argument
            else:
                out += self._calls(ast.Assign([ast.Name(f"{parameter.arg}_{number}", ast.Store())], argument, lineno=0))
                names[parameter.arg] = ast.Name(f"{parameter.arg}_{number}", ast.Load())
        body = [_Rename(names).visit(statement) for statement in function.body]
        last = body.pop() if body and isinstance(body[-1], ast.Return) else None
        out += self.body(body)
        if isinstance(last, ast.Return) and targets:
            out += self._result(last.value, targets)
        return out

    def _result(self, value: ast.expr | None, targets: list[ast.expr]) -> list[ast.stmt]:
        target = targets[0]
        if isinstance(value, ast.Tuple) and isinstance(target, ast.Tuple):
            self.count += 1
            names = [f"r{self.count}_{k}" for k in range(len(value.elts))]
            first = [ast.Assign([ast.Name(n, ast.Store())], v, lineno=0) for n, v in zip(names, value.elts, strict=True)]
            second = [ast.Assign([t], ast.Name(n, ast.Load()), lineno=0) for n, t in zip(names, target.elts, strict=True)]
            return [part for one in first for part in self._calls(one)] + list(second)
        return self._calls(ast.Assign([target], value or ast.Constant(None), lineno=0))


PARTS = (
    "move",
    "tiles",
    "springs",
    "resist",
    "contact_geometry",
    "solve_contacts",
    "levers",
    "close",
    "factor",
    "residual",
    "spread",
    "settle",
    "observe",
    "resize",
    "functions",
    "step",
)


def written_out(text: str, entry: str, parts: tuple[str, ...] = PARTS) -> str:
    """The text with all functions written into ``entry`` and a few ``parts``; functions with several returns stay calls.

    In one piece, numba's analysis of names takes longer than what is saved.
    """
    tree = ast.parse(text)
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    whole = [name for name in (*parts, entry) if name in functions]
    inliner = _Inliner({name: function for name, function in functions.items() if name not in whole})
    for name in whole:
        functions[name].body = inliner.body(functions[name].body)
    used = {entry}
    while True:
        more = {node.id for name in used & set(functions) for node in ast.walk(functions[name]) if isinstance(node, ast.Name)}
        if more <= used:
            break
        used |= more
    kept = [node for node in tree.body if not isinstance(node, ast.FunctionDef) or node.name in used]
    return ast.unparse(ast.fix_missing_locations(ast.Module(kept, []))) + "\n"
