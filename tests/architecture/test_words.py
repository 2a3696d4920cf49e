"""Names are nouns of the field or verbs that say what happens: a list of words that are neither."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from architecture.sources import files

# Participles, adverbs, pronouns and riddles. A name is split at its underlines; a part of it must not be
# here.
WORDS = frozenset({
    "above", "anew", "apart", "asked", "asking", "begun", "beside", "bring", "brought", "carried", "carry",
    "doubt", "ended", "filled", "found", "given", "gone", "kept", "known", "lean", "lost", "made", "meant",
    "fitting", "more", "nearby", "plainly", "prescribed", "reading", "restart", "restarted", "said",
    "sampling", "seen", "seldom", "sought", "strikes", "studied", "stuff", "taken", "timing",
    "things", "together", "told", "tug", "utils", "helper", "helpers", "manager", "wanted", "whole", "worn",
    "woven",
})  # fmt: skip
# Pronouns, adverbs and quantities of nothing in particular: parts of a name they may be, but not the name of
# a function, class or constant of a module, which readers meet far from its definition.
ALONE = frozenset({
    "about", "across", "after", "again", "all", "along", "also", "any", "anything", "aside", "away",
    "back", "before", "below", "between", "beyond", "both", "each", "either", "enough", "even", "every",
    "everything", "far", "few", "further", "had", "has", "held", "here", "how", "least", "less", "many",
    "most", "much", "near", "never", "none", "nothing", "now", "nowhere", "once", "one", "ones", "other",
    "others", "over", "own", "rest", "same", "several", "some", "somewhere", "still", "such", "there",
    "through", "twice", "under", "what", "when", "where", "which", "who", "whose", "why",
})  # fmt: skip
# Names that scripts write, or that fields of files and answers are called: they stay as they are.
ALLOWED = frozenset(
    {
        ("vfife/identification/lawfit.py", "given"),  # keyword of fit_law
        ("vfife/identification/records.py", "every"),  # keywords of fit()
        ("vfife/identification/records.py", "own"),
        ("vfife/kernels/topology.py", "held"),  # rows of joints by name, which the compiler reads
        ("vfife/laws/law.py", "between"),  # Pair.between(): surfaces between other bodies
        ("vfife/laws/law.py", "known"),  # ContactLaw.known(), FrictionLaw.known()
        ("vfife/measures/motion.py", "along"),  # PointMotion.along(direction), of the documentation
        ("vfife/measures/trust.py", "apart"),  # of the summary's trust
        ("vfife/measures/trust.py", "lost"),
        ("vfife/results/derivatives.py", "known"),  # Derivatives.known()
        ("vfife/results/fit.py", "known"),  # of a fit's JSON
        ("vfife/schema/described.py", "above"),  # keyword of quantity(), for laws of one's own
        ("vfife/schema/values.py", "above"),
        ("vfife/studies/spec/iso286.py", "least"),  # Fit.least, Fit.most: least and greatest clearance
        ("vfife/studies/spec/iso286.py", "most"),
        ("vfife/tribology/wear_state.py", "Worn"),  # what tribology.wear returns
        ("vfife_validation/paper/beyond.py", "beyond"),  # of `vfife paper beyond`
    }
)


def defined(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line and name of each function, class, argument and assigned name of a file."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield node.lineno, node.name
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id


def of_module(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Line and name of each function, class and constant of a module."""
    for statement in tree.body:
        if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield statement.lineno, statement.name
        elif isinstance(statement, ast.Assign | ast.AnnAssign):
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            names = (node for target in targets for node in ast.walk(target) if isinstance(node, ast.Name))
            yield from ((node.lineno, node.id) for node in names)


def offences(name: str, tree: ast.AST) -> list[str]:
    """The definitions of a file, and its own name, that contain a word of the list."""
    stem = name.removesuffix(".py").rpartition("/")[2]
    return [
        f"{name}:{line} {one}"
        for line, one in [(1, stem), *sorted(set(defined(tree)))]
        if WORDS & set(one.lower().split("_")) and (name, one) not in ALLOWED
    ]


def test_words_that_are_no_names() -> None:
    bad = [one for name, tree, _ in files() for one in offences(name, tree)]
    assert not bad, f"{len(bad)} definitions:\n" + "\n".join(bad)


def test_functions_classes_and_constants_are_no_pronouns_or_adverbs() -> None:
    bad = [
        f"{name}:{line} {one}"
        for name, tree, _ in files()
        for line, one in of_module(tree)
        if one.lower() in ALONE and (name, one) not in ALLOWED
    ]
    assert not bad, f"{len(bad)} definitions:\n" + "\n".join(bad)


def of_classes(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line and name of each method."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            methods = (one for one in node.body if isinstance(one, ast.FunctionDef | ast.AsyncFunctionDef))
            yield from ((one.lineno, one.name) for one in methods)


def test_methods_are_no_pronouns_or_adverbs() -> None:
    bad = [
        f"{name}:{line} {one}"
        for name, tree, _ in files()
        for line, one in of_classes(tree)
        if one.strip("_") in ALONE - {"has"} and (name, one) not in ALLOWED
    ]
    assert not bad, f"{len(bad)} definitions:\n" + "\n".join(bad)


# Of arguments and locals a direction or a place in an order may be the whole name; these may not.
LOCAL = ALONE - {"across", "all", "along", "aside", "away", "back", "far", "near", "over", "rest"} | {
    "anew", "others", "them", "then", "these", "they", "this", "those",
}  # fmt: skip
# Keywords that scripts, files or the command line write, and the other side of a comparison.
KEYWORDS = frozenset({
    ("vfife/cli/arguments/analyses.py", "every"), ("vfife/errors.py", "what"), ("vfife/errors.py", "where"),
    ("vfife/cli/arguments/analyses.py", "own"),
    ("vfife/identification/fit_plan.py", "own"), ("vfife/identification/fit_task.py", "every"),
    ("vfife/identification/fit_task.py", "own"), ("vfife/identification/records.py", "every"),
    ("vfife/identification/records.py", "own"), ("vfife/live/page/sliders.py", "here"),
    ("vfife/measures/contacts.py", "before"), ("vfife/measures/contacts.py", "most"),
    ("vfife/results/case_errors.py", "most"), ("vfife/simulation/result.py", "other"),
    ("vfife_validation/measured/records.py", "every"), ("vfife_validation/measured/single.py", "others"),
    ("vfife_validation/paper/contents.py", "where"), ("vfife_validation/paper/mechanisms.py", "below"),
    ("vfife_validation/paper/search.py", "below"),
})  # fmt: skip


def local_offences(name: str, tree: ast.AST) -> list[str]:
    """Arguments and locals of a file that say nothing of what they hold."""
    methods = {
        id(argument)
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and len(node.args.args) == 2
        for argument in node.args.args
        if argument.arg == "other"
    }
    places = (
        (node.lineno, node.arg if isinstance(node, ast.arg) else node.id)
        for node in ast.walk(tree)
        if (isinstance(node, ast.arg) and id(node) not in methods)
        or (isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and not node.id.startswith("__"))
    )
    return [
        f"{name}:{line} {word}"
        for line, word in sorted(set(places))
        if word.strip("_") in LOCAL and (name, word) not in KEYWORDS
    ]


def test_arguments_and_locals_are_no_pronouns_or_adverbs() -> None:
    bad = [place for name, tree, _ in files() for place in local_offences(name, tree)]
    assert not bad, f"{len(bad)} definitions:\n" + "\n".join(bad)


def test_an_argument_and_a_local_are_seen() -> None:
    text = "def merge(self, other):\n    return [one for one in other]\ndef fill(what, row): own = row\n"
    assert local_offences("a.py", ast.parse(text)) == ["a.py:2 one", "a.py:3 own", "a.py:3 what"]


def test_names_of_a_module_are_seen() -> None:
    text = "MOST, SIDE = 6, 3.6\nNEAR: float = 1.0\ndef between(over):\n    few = over\nclass Each: pass\n"
    assert [one for _, one in of_module(ast.parse(text))] == ["MOST", "SIDE", "NEAR", "between", "Each"]


def test_names_of_methods_are_seen() -> None:
    text = "class Row:\n    each = 1\n    def over(self): pass\n    async def still(self): pass\n"
    assert [one for _, one in of_classes(ast.parse(text))] == ["over", "still"]


def test_a_word_of_the_list_is_seen() -> None:
    text = "def carry_out(told, count):\n    kept_rows = count\n    return kept_rows\n"
    assert offences("vfife/more.py", ast.parse(text)) == [
        "vfife/more.py:1 more",
        "vfife/more.py:1 carry_out",
        "vfife/more.py:1 told",
        "vfife/more.py:2 kept_rows",
    ]
