"""Laws from the user's own file: what they compute, what is told of those that cannot be used, and what a run
file keeps of them.
"""

import ast
import linecache
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from support import bits, four_bar, lanes
from vfife import Result, simulate
from vfife.assembly.assemble import assemble
from vfife.compiler.runtime.lawloops import Single, traced
from vfife.dynamics import load_map, poincare_section
from vfife.errors import LawError, VfifeError
from vfife.laws import ContactLaw, FrictionLaw, LankaraniNikravesh
from vfife.laws.check import USUAL, faults, faults_of_class, faults_of_numbers
from vfife.laws.user import executed, load_laws
from vfife.live.page.reports import report as write_report
from vfife.modelfile import loads
from vfife.report.dynamics import document
from vfife.simulation.start import ideal_of

COPY = '''"""Lankarani and Nikravesh again, under a name of its own."""
import math
from dataclasses import dataclass
from typing import ClassVar

from vfife.laws import ContactLaw, quantity

SHARE = 0.75


def hysteresis(elastic, factor, slowness):
    """Damping coefficient (N s/m)."""
    return elastic * factor * slowness


@dataclass(frozen=True)
class Mine(ContactLaw):
    """F = K d^1.5 (1 + 3/4 (1 - e^2) d'/d'0)."""

    name: ClassVar[str] = "mine"
    source: ClassVar[str] = "own, 2026"
    formula: ClassVar[str] = "F = K d^1.5 (1 + 3/4 (1 - e^2) d'/d'0)"
    slots: ClassVar[tuple[str, ...]] = ("stiffness", "damping_factor")

    restitution: float = quantity("1", "restitution coefficient", 0.9, above=0.0, high=1.0)
    stiffness: float = quantity("N/m^1.5", "stiffness", 6.6e10, above=0.0)

    def parameters(self, pair):
        return self.stiffness, SHARE * (1.0 - self.restitution**2)

    @staticmethod
    def force(penetration, slowness, p):
        stiffness, factor = p
        elastic = stiffness * penetration * math.sqrt(penetration)
        return elastic, hysteresis(elastic, factor, slowness)
'''
RUBBING = '''from dataclasses import dataclass
from typing import ClassVar
import vfife


@dataclass(frozen=True)
class Rubbing(vfife.laws.FrictionLaw):
    """F = -f N sign(v)."""

    name: ClassVar[str] = "rubbing"
    slots: ClassVar[tuple[str, ...]] = ("coefficient",)
    coefficient: float = vfife.laws.quantity("1", "coefficient", 0.1)

    def parameters(self, pair):
        return (self.coefficient,)

    @staticmethod
    def force(normal_force, free_velocity, mobility, memory, dt, p):
        limit = p[0] * normal_force
        return (-limit if free_velocity > 0.0 else limit), memory
'''


pytestmark = pytest.mark.usefixtures("only_built_in_laws")


def loaded(tmp_path: Path, text: str = COPY, name: str = "my_laws.py") -> list:
    path = tmp_path / name
    path.write_text(text)
    return load_laws(path)


# --------------------------------------------------------------------------------------------------------
# what they compute


@pytest.mark.parametrize(
    "loop", ["interpreted", "generated", pytest.param("data-driven", marks=pytest.mark.verify)]
)
def test_a_copy_of_a_built_in_law_takes_the_same_steps(tmp_path, loop):
    """To the bit, in each loop. (The data-driven one takes half a minute to compile for a law
    of one's own.)
    """
    (mine,) = loaded(tmp_path)
    rows = []
    for law in (mine(restitution=0.7), LankaraniNikravesh(restitution=0.7, stiffness=6.6e10)):
        model = assemble(four_bar("C", contact=law), 2e-6, duration=1e-3, force_step=True)
        rows.append(bits(lanes([model], loop).advance(100, 5)))
    assert (rows[0] == rows[1]).all()


def test_a_changed_file_is_noticed(tmp_path):
    """However quickly it is changed, and though it keeps its length: the step is compiled from what was read
    last.
    """
    forces = []
    for share in ("0.75", "0.15"):
        (mine,) = loaded(tmp_path, COPY.replace("SHARE = 0.75", f"SHARE = {share}"))
        model = assemble(four_bar("C", contact=mine(restitution=0.3)), 2e-6, duration=1e-3, force_step=True)
        runner = lanes([model], "interpreted")
        runner.advance(500, 1)
        forces.append(runner.states[model.layout.row("contact_damping_work", 0), 0])
    assert forces[0] > 2.0 * forces[1] > 0.0


def test_a_text_that_is_no_longer_on_disk_is_compiled_as_it_was_read(tmp_path):
    (mine,) = loaded(tmp_path)
    (tmp_path / "my_laws.py").write_text("# another text\n" * 50)
    linecache.checkcache()
    assert faults(mine) == []
    lanes(
        [assemble(four_bar("C", contact=mine()), 2e-6, duration=1e-3, force_step=True)], "interpreted"
    ).advance(1, 1)


def defined_in_cell(text, name, cell):
    """Execute a text as ipykernel does: its lines in linecache, each statement compiled by itself."""
    linecache.cache[cell] = (len(text), None, text.splitlines(keepends=True), cell)
    names = {"__name__": "__main__"}
    for statement in ast.parse(text).body:
        exec(compile(ast.Module([statement], []), cell, "exec"), names)
    return names[name]


def test_a_law_of_a_notebook_is_the_text_of_its_cell(tmp_path):
    """Statements of a cell are compiled one by one, so that ``math.sqrt`` becomes other instructions than in
    a file that imports math.
    """
    text = COPY.replace("penetration * math.sqrt(penetration)", "penetration**1.5")
    for k, one in enumerate((COPY, text)):
        law = defined_in_cell(one.replace('"mine"', f'"mine-{k}"'), "Mine", f"/cell_{k}.py")
        assert faults_of_class(law) == []
        assert law.force(2.0, 0.0, (1.0, 0.5))[0] == 2.0 * math.sqrt(2.0)
    text = text.replace("elastic = stiffness", "elastic = 2.0 * stiffness")
    linecache.cache["/cell_1.py"] = (len(text), None, text.splitlines(keepends=True), "/cell_1.py")
    assert "is not what Python runs" in faults_of_class(law)[0]


def unexamined(tmp_path, new):
    """The law with another elastic force, of a file that was executed and not examined."""
    path = tmp_path / "unexamined.py"
    module = executed(path, COPY.replace("penetration * math.sqrt(penetration)", new))
    return module.Mine


def test_a_step_has_products_for_powers_of_a_law_that_was_not_examined(tmp_path):
    law = unexamined(tmp_path, "penetration**1.5")
    assert sum(one.operator == "sqrt" for one in traced(Single("contact", law)).operations) == 1
    assert faults(law) == []


def test_laws_are_examined_before_the_ideal_mechanism_is_assembled(tmp_path):
    """Its step contains them. The fault names line and replacement, which the compiler does not know."""
    law = unexamined(tmp_path, "math.exp(penetration)")
    with pytest.raises(LawError, match=r"law 'mine'.*line 34: math.exp .* write exp of vfife"):
        ideal_of(four_bar("C", contact=law()))


SCRIPT = """
import vfife
m = vfife.Mechanism()
m.point("O", 0.0, 0.0)
m.point_mass("j", mass=1.0, velocity=(1.0, 0.0, 0.0))
m.clearance_joint("J", "ground.O", "j.center", clearance=2e-4, bearing_radius=0.01, contact=Mine())
print(float(vfife.simulate(m, duration=1e-3, loop="interpreted").measures["J.impacts"]))
"""


def test_the_laws_of_the_documentation_have_no_faults(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "researcher.md").read_text("utf-8")
    files = re.findall(r"```{file} (\w+\.py)\n(.*?)```", page, re.DOTALL)
    assert [name for name, _ in files] == ["my_laws.py", "my_friction.py"]
    for name, text in files:
        for law in loaded(tmp_path, text, name):
            assert faults_of_class(law) == [] and faults_of_numbers(law(), USUAL) == []


DRIVEN = """
import dataclasses
import vfife
machine = vfife.gallery.four_bar()
machine.joints["C"] = dataclasses.replace(machine.joints["C"], contact=Mine(), friction=Rubbing())
print(machine.check().step < 1e-3, vfife.simulate(machine, turns=0.01).measures["C.force.max"] > 0.0)
"""


@pytest.mark.system("starts a process that compiles its loops")
def test_powers_in_the_first_process(tmp_path):
    """Nothing is compiled yet, and a driven mechanism is first assembled without clearance."""
    rubbing = RUBBING.replace(
        "return (-limit if free_velocity > 0.0 else limit), memory",
        "return -limit * free_velocity / (free_velocity**2 + 1e-4) ** 0.5, memory",
    )
    text = COPY.replace("penetration * math.sqrt(penetration)", "penetration**1.5") + rubbing + DRIVEN
    path = tmp_path / "script.py"
    path.write_text(text)
    environment = {**os.environ, "VFIFE_CACHE": str(tmp_path / "cache")}
    done = subprocess.run([sys.executable, path], capture_output=True, text=True, env=environment)
    assert done.stdout.strip().endswith("True True"), done.stderr


@pytest.mark.system("starts a process that compiles its loops")
def test_a_law_in_a_script(tmp_path):
    """As __main__, and as a notebook hands its cells over: text in linecache, no file."""
    path = tmp_path / "script.py"
    path.write_text(COPY + SCRIPT)
    done = subprocess.run([sys.executable, path], capture_output=True, text=True)
    assert done.stdout.strip() == "2.0", done.stderr
    cell = "\n".join(
        (
            "import linecache",
            f"text = {COPY + SCRIPT!r}",
            "linecache.cache['<cell 1>'] = (len(text), None, text.splitlines(True), '<cell 1>')",
            "exec(compile(text, '<cell 1>', 'exec'))",
        )
    )
    done = subprocess.run(
        [sys.executable, "-"], input=f"{cell}\n{COPY}{SCRIPT}", capture_output=True, text=True
    )  # a shell: neither file nor cell
    assert done.stdout.strip() == "2.0", done.stderr
    assert "write the law in a file" in done.stderr


# ----------------------------------------------------------------------------------------------- what cannot
# be used, in words

BODY = "elastic = stiffness * penetration * math.sqrt(penetration)"
ANSWER = "return elastic, hysteresis(elastic, factor, slowness)"
REFUSED = {
    "no law": (COPY, "x = 1\n", "defines no law"),
    "no name": ('    name: ClassVar[str] = "mine"\n', "", "no name"),
    "a built-in's name": ('"mine"', '"pereira"', "'pereira' is taken by a law that vfife brings"),
    "a bad name": ('"mine"', '"My law"', "small letters, digits and hyphens"),
    "syntax": ("SHARE = 0.75", "SHARE = = 0.75", "line 8: this is not valid Python"),
    "import": ("import math", "import nonsense_xyz", "line 2: No module named 'nonsense_xyz'"),
    "an error": ("SHARE = 0.75", "SHARE = 1 / 0", "line 8: ZeroDivisionError"),
    "an end": ("SHARE = 0.75", "raise SystemExit", "line 8: SystemExit"),
    "no dataclass": ("@dataclass(frozen=True)\n", "", "no dataclass"),
    "not static": ("    @staticmethod\n", "", "@staticmethod"),
    "arguments": (
        "force(penetration, slowness, p)",
        "force(penetration, p)",
        "takes 2 arguments .penetration, p.; a contact law takes 3",
    ),
    "if": (
        BODY,
        f"{BODY}\n        if penetration > 1.0:\n            elastic = 0.0",
        "line 35: an `if` statement",
    ),
    "exp": (BODY, f"{BODY} * math.exp(penetration)", "math.exp differs between machines.*write exp of"),
    "numpy": ("import math", "import math\nimport numpy as np", "numpy.sqrt cannot be compiled"),
    "power": (BODY, "elastic = stiffness * penetration**1.45", r"literal exponent.*power"),
    "max": (BODY, f"{BODY} * max(1.0, penetration)", "max.. cannot be compiled.*`a if a > b else b`"),
    "in a function that is called": (
        "return elastic * factor * slowness",
        "return elastic * factor * math.cos(slowness)",
        "hysteresis, line 13: math.cos",
    ),
    "a list": ("SHARE = 0.75", "SHARE = 0.75\nTABLE = [1.0]", "TABLE .list. cannot be compiled"),
    "slots": ('("stiffness", "damping_factor")', '("stiffness",)', "gives 2 numbers, and slots names 1"),
    "no number": ("return self.stiffness, SHARE", "return float('nan'), SHARE", "stiffness = nan"),
    "one answer": (ANSWER, "return elastic", "two numbers, the elastic force"),
    "infinite": (ANSWER, "return elastic, elastic * math.inf", "have to be finite"),
    "apart": (
        ANSWER,
        "return elastic, factor",
        "damping coefficient is 0.1425 N s/m while the surfaces are apart",
    ),
    "division": (ANSWER, "return elastic, elastic / slowness", "divides by zero"),
    "pulls": (BODY, f"{BODY} * (1.0 - penetration * 1e5)", "elastic force is -.* 0 or more"),
    "gives energy": (
        ANSWER,
        "return elastic, -hysteresis(elastic, factor, slowness)",
        "damping coefficient is -",
    ),
    "at nothing": (BODY, f"{BODY} + 2.0", "is 2 N; it has to be 0 where nothing is pressed in"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_wrong_is_told(tmp_path, case):
    old, new, expected = REFUSED[case]
    text = COPY.replace(old, new)
    if case == "numpy":
        text = text.replace("math.sqrt(pen", "np.sqrt(pen")
    if case == "a list":
        text = text.replace("math.sqrt(pen", "TABLE[0] * math.sqrt(pen")
    assert text != COPY
    before = dict(ContactLaw.registry)
    with pytest.raises(LawError, match=r"my_laws\.py.*(?s:.*)" + expected):
        found = [fault for law in loaded(tmp_path, text) for fault in faults(law)]
        raise LawError("\n".join(found))
    if case not in (
        "slots",
        "no number",
        "one answer",
        "infinite",
        "apart",
        "division",
        "pulls",
        "gives energy",
        "at nothing",
    ):
        assert ContactLaw.registry == before, "a file that is refused leaves no law"


def test_all_faults_at_once_before_a_run(tmp_path):
    """assemble itself looks, so that a law in a script is told as well as one in a file;
    nothing is compiled.
    """
    (mine,) = loaded(tmp_path, COPY.replace(ANSWER, "return elastic, -factor"))
    (rubbing,) = loaded(
        tmp_path,
        RUBBING.replace("limit = p[0] * normal_force", "limit = p[0] * (normal_force + 1.0)"),
        "rubbing.py",
    )
    with pytest.raises(LawError) as told:
        assemble(four_bar("BC", contact=mine(), friction=rubbing()))
    assert "damping coefficient" in str(told.value) and "without a normal force" in str(told.value)
    assert len(str(told.value).splitlines()) == 2


def test_all_faults_of_a_force_are_told_in_a_short_traceback(tmp_path):
    """A preload and a constant damping act while surfaces are apart: two faults, each told once."""
    (mine,) = loaded(tmp_path, COPY.replace(ANSWER, "return elastic + 2.0, 3.0"))
    with pytest.raises(LawError) as told:
        simulate(four_bar("C", contact=mine()), turns=0.05)
    first, second = str(told.value).splitlines()
    assert "0 where nothing is pressed in" in first and "while the surfaces are apart" in second
    assert len(told.traceback) == 2 and told.value.__suppress_context__


def test_a_file_that_is_missing(tmp_path):
    with pytest.raises(LawError, match="cannot be read .No such file"):
        load_laws(tmp_path / "none.py")


def test_two_files_may_not_share_a_name(tmp_path):
    loaded(tmp_path)
    with pytest.raises(LawError, match=r"'mine' already, from .*my_laws.py"):
        loaded(tmp_path, name="others.py")
    assert ContactLaw.registry["mine"].__module__ == "own_laws_my_laws"


# ------------------------------------------------------------------------------------------------------ what
# a run file keeps


def test_a_run_file_opens_without_the_law(tmp_path):
    """It keeps the text, runs none of it, and gives the same numbers, the energies to the accuracy of a
    table.
    """
    marker = tmp_path / "was run"
    (mine,) = loaded(tmp_path, COPY + f"\nopen({str(marker)!r}, 'a').write('x')\n")
    (rubbing,) = loaded(tmp_path, RUBBING, "rubbing.py")
    first = simulate(four_bar("C", contact=mine(stiffness=5e10), friction=rubbing()), turns=0.25)
    first.save(tmp_path / "run.sqlite")
    assert marker.read_text() == "x"
    del ContactLaw.registry["mine"], FrictionLaw.registry["rubbing"]
    again = Result.load(tmp_path / "run.sqlite")
    assert marker.read_text() == "x"
    assert (again.record.rows == first.record.rows).all()
    assert again.measures == first.measures
    stored, table = (result.ledger.terms["contact"] for result in (first, again))
    assert stored.max() > 1.0 and np.abs(table - stored).max() < 1e-4 * stored.max()
    assert again.ledger.error == pytest.approx(first.ledger.error, rel=0.05)
    law = again.record.assembly.mechanism.clearances["C"].contact
    assert (law.name, law.stiffness) == ("mine", 5e10)
    assert "mine" not in ContactLaw.registry and "rubbing" not in FrictionLaw.registry
    again.save(tmp_path / "second.sqlite")
    third = Result.load(tmp_path / "second.sqlite")
    assert (third.ledger.terms["contact"] == table).all()
    with pytest.raises(LawError, match="known from a run file only.*my_laws.py"):
        simulate(
            again.record.assembly.mechanism,
            turns=0.25,
            reference=False,
            step=again.record.assembly.choice.step,
        )


BALL = """
gravity = [0, -9.81]
[ground]
floor = [0, 0]
[body.ball]
mass = 1
inertia = 0.01
position = [0, "51 mm"]
[joint.touch]
kind = "contact"
bearing = "ground.floor"
journal = "ball.center"
bearing_radius = "20 mm"
journal_radius = "30 mm"
axial_length = "20 mm"
[joint.touch.contact]
law = "mine"
stiffness = 1e9
"""


def test_surfaces_without_a_clearance_have_a_table_too(tmp_path):
    """A ball falls on a round: the force at the depth of its own weight from the table."""
    loaded(tmp_path)
    first = simulate(loads(BALL), duration="40 ms", companions=0, reference=False)
    first.save(tmp_path / "run.sqlite")
    assert first.measures["touch.impacts"] > 0
    del ContactLaw.registry["mine"]
    again = Result.load(tmp_path / "run.sqlite")
    law = again.record.assembly.mechanism.contacts["touch"].contact
    depth, parameters = 1e-4, tuple(law.entry["joints"][0]["p"])
    assert law.force(depth, 0.0, parameters)[0] == pytest.approx(1e9 * depth**1.5, rel=1e-3)
    stored, table = (result.ledger.terms["contact"] for result in (first, again))
    assert stored.max() > 1e-3 and np.abs(table - stored).max() < 1e-3 * stored.max()
    (note,) = write_report(again, tmp_path / "a.html")
    assert "known from a run file only" in note and (tmp_path / "a.html").stat().st_size > 1e5


def test_a_map_file_opens_without_the_law(tmp_path):
    (mine,) = loaded(tmp_path)
    model = four_bar("C", contact=mine(stiffness=5e10))
    made = poincare_section(model, turns=3, dropped=1, step=1.5e-5, file=tmp_path / "a.map")
    said = str(document(made))
    (changed,) = loaded(tmp_path, COPY.replace("0.75", "0.25"))
    model = four_bar("C", contact=changed(stiffness=5e10))
    with pytest.raises(VfifeError, match="computed with another text of the law mine"):
        poincare_section(model, turns=3, dropped=1, step=1.5e-5, file=tmp_path / "a.map")
    del ContactLaw.registry["mine"]
    again = load_map(tmp_path / "a.map")
    assert "contact mine" in again.laws and again.kind == again.verdict.kind == "not settled"
    assert str(document(again)) == said


def test_a_law_that_changed_since_does_not_stand_for_the_recorded_one(tmp_path):
    (mine,) = loaded(tmp_path)
    simulate(four_bar("C", contact=mine()), turns=0.05, reference=False).save(tmp_path / "run.sqlite")
    assert (
        type(Result.load(tmp_path / "run.sqlite").record.assembly.mechanism.clearances["C"].contact) is mine
    )
    (other,) = loaded(tmp_path, COPY.replace("0.75", "0.25"))
    law = type(Result.load(tmp_path / "run.sqlite").record.assembly.mechanism.clearances["C"].contact)
    assert law not in (mine, other) and law.name == "mine"
    assert ContactLaw.registry["mine"] is other


@pytest.mark.system("compiles a film in every loop")
def test_a_film_of_ones_own_is_tried_out_too(tmp_path):
    film = (
        "    film: ClassVar[bool] = True\n\n    @staticmethod\n    def film_force(penetration, turning,"
        " sense, p):\n        return {answer}\n"
    )
    text = COPY + "\n" + film
    (mine,) = loaded(tmp_path, text.format(answer="0.0, 0.0, 1.0, 1.0, 0.5 * sense"))
    assert faults(mine) == []
    assemble(four_bar("C", contact=mine()), 2e-6, duration=1e-3, force_step=True)
    for answer, expected in (
        ("0.0, 0.0", "five finite numbers"),
        ("0.0, 0.0, 1.0, 1.0, 2.0", "gives energy"),
        ("max(1.0, turning)", "max"),
    ):
        with pytest.raises(LawError, match=expected):
            raise LawError(
                "\n".join(
                    fault for law in loaded(tmp_path, text.format(answer=answer)) for fault in faults(law)
                )
            )
    with pytest.raises(LawError, match="static function film_force"):
        loaded(tmp_path, COPY + "\n    film: ClassVar[bool] = True\n")


@pytest.mark.usefixtures("only_built_in_laws")
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("import os\nos._exit(3)\n", "line 2: SystemExit: it ends the process (os._exit(3))"),
        ("import sys\n\nsys.exit('enough')\n", "line 3: SystemExit: enough"),
        ("raise SystemExit\n", "line 1: SystemExit: nothing said"),
        ("while True:\n    pass\n", "does not end; a file of laws defines them"),
    ],
)
def test_what_a_file_does_instead_of_defining_laws_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, said: str
) -> None:
    import os
    import signal

    from vfife.laws import user

    monkeypatch.setattr(user, "SECONDS", 0.2)
    ends, hears = os._exit, signal.getsignal(signal.SIGALRM)
    (tmp_path / "laws.py").write_text(text)
    with pytest.raises(LawError) as told:
        load_laws(tmp_path / "laws.py")
    assert said in str(told.value)
    assert os._exit is ends and signal.getsignal(signal.SIGALRM) is hears
