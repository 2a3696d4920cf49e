"""What a script gets from ``import vfife``: every noun, every law, the ways to run them, seen by completion
and by a type checker.
"""

import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import vfife
from vfife import errors, laws
from vfife.model import bodies, drivers, joints, loads, springs

ROOT = Path(__file__).resolve().parents[2]
NAMESPACES = (
    "bodies", "drivers", "dynamics", "identification", "joints", "laws", "loads", "springs", "studies",
    "tribology",
)  # fmt: skip
NOUNS = [
    *(bodies.Frame, bodies.Link, bodies.Member, bodies.PointMass, bodies.RigidBody, bodies.Section),
    *(
        kind
        for room in (drivers.Driver, joints.Joint, springs.ForceElement)
        for kind in room.registry.values()
    ),
    joints.Gear,
    loads.PointForce,
]


def test_every_noun_and_every_law_is_public() -> None:
    own = [
        law
        for kind in (laws.ContactLaw, laws.FrictionLaw)
        for law in kind.registry.values()
        if law.__module__.startswith("vfife.")
    ]
    assert len(own) > 30
    spaces = (vfife.bodies, vfife.joints, vfife.springs, vfife.drivers, vfife.loads, vfife.laws)
    public = {name: getattr(space, name) for space in spaces for name in space.__all__}
    assert [
        one.__name__
        for one in (*NOUNS, *own, laws.Material, laws.Pair)
        if public.get(one.__name__) is not one
    ] == []
    assert len(vfife.__all__) < 40


def test_every_public_name_is_there_and_completed() -> None:
    assert len(set(vfife.__all__)) == len(vfife.__all__)
    for name in vfife.__all__:
        assert getattr(vfife, name) is not None
        assert name in dir(vfife)
    for space in NAMESPACES:
        module = getattr(vfife, space)
        assert all(getattr(module, name) is not None for name in module.__all__), space
    assert not {"annotations", "TYPE_CHECKING", "Any"} & set(dir(vfife))
    with pytest.raises(AttributeError, match="no attribute 'simulated'"):
        _ = vfife.simulated


@pytest.mark.parametrize(
    "name",
    [
        "Ambrosio",
        "ClearanceRevolute",
        "Section",
        "Spring",
        "Torque",
        "PointForce",
        "Study",
        "modes",
        "load_fit",
        "Worn",
    ],
)
def test_a_former_name_works_and_warns(name: str) -> None:
    with pytest.warns(DeprecationWarning, match="now; the old name will be removed") as said:
        found = getattr(vfife, name)
    place = str(said[0].message).split()[2]
    assert found is getattr(getattr(vfife, place.split(".")[1]), name)


def test_methods_are_there_by_whichever_name_a_class_comes() -> None:
    code = (
        "from vfife.gallery import four_bar; m = four_bar(); print(len(m.to_toml()) > 100, hasattr(m, "
        "'_repr_html_'))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "True True\n"


def test_every_error_is_one_of_vfife() -> None:
    raised = [
        one
        for one in vars(errors).values()
        if isinstance(one, type) and issubclass(one, Exception) and not issubclass(one, Warning)
    ]
    assert len(raised) > 5
    assert all(issubclass(one, vfife.VfifeError) and issubclass(one, ValueError) for one in raised)
    assert vfife.errors is errors


def test_a_status_is_its_text() -> None:
    assert vfife.Status.COMPLETE == "complete"
    assert f"{vfife.Status.NOT_CONVERGED}" == "not converged"


def test_model_files_are_written_and_read(tmp_path: Path) -> None:
    mechanism = vfife.gallery.four_bar()
    vfife.save_model(mechanism, tmp_path / "four_bar.toml")
    again = vfife.load_model(tmp_path / "four_bar.toml")
    assert (again.bodies, again.joints) == (mechanism.bodies, mechanism.joints)
    with pytest.raises(vfife.VfifeError, match="cannot be written"):
        vfife.save_model(mechanism, tmp_path / "no" / "folder.toml")
    mechanism.bodies["x"] = bodies.Body(name="x")
    with pytest.raises(vfife.VfifeError, match="it cannot be written as a model file"):
        vfife.save_model(mechanism, tmp_path / "four_bar.toml")
    assert [path.name for path in tmp_path.iterdir()] == ["four_bar.toml"]


def test_importing_says_nothing_and_loads_nothing_heavy() -> None:
    code = (
        "import sys, vfife; dir(vfife); print(sorted({'numba', 'llvmlite', 'matplotlib', 'scipy', 'xarray',"
        " 'pandas'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True
    )
    assert (done.stdout, done.stderr) == ("[]\n", "")


SCRIPT = '''
"""Every public name, used as a script would, each with the type that a checker must see."""

import vfife

{names}

mechanism: vfife.Mechanism = vfife.load_model("model.toml")
mechanism.link("crank", length=0.1, mass=1.0)
result: vfife.Result = vfife.simulate(
    mechanism, turns=2, step="1 us", reference=True, start={{"crank": (0.0, 0.0, 0.0)}}, loop="generated"
)
again: vfife.Result = vfife.simulate(mechanism, reference=result, start=result)
status: vfife.Status = result.record.status
later: vfife.Result = vfife.load_result("runs/model")
table: vfife.studies.Comparison = vfife.compare(
    mechanism, ["pereira", vfife.laws.Flores], turns=2, loop="auto"
)
last: float = vfife.studies.ensemble([mechanism], step="1 us", turns=3)[0].last.assembly.choice.step
laws: list[type[vfife.laws.Law]] = vfife.laws.load_laws("laws.py")
vfife.save_model(vfife.gallery.four_bar(), "out.toml")
'''
WRONG = """
import vfife

mechanism = vfife.Mechanism("m")
vfife.simulate(mechanism, loop="numba")
vfife.simulate(mechanism, start=3.0)
vfife.simulate(mechanism, turns="two")
vfife.compare(mechanism, torns=2)
vfife.load_result(3)
"""


@pytest.mark.system("starts a type checker")
def test_a_type_checker_sees_every_name(tmp_path: Path) -> None:
    api = pytest.importorskip("mypy.api")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        public = [
            *vfife.__all__,
            *(f"{space}.{name}" for space in NAMESPACES for name in getattr(vfife, space).__all__),
        ]
        names = "\n".join(f"reveal_type(vfife.{name})" for name in public)
    (tmp_path / "right.py").write_text(SCRIPT.format(names=names))
    (tmp_path / "wrong.py").write_text(WRONG)
    files = [str(tmp_path / "right.py"), str(tmp_path / "wrong.py")]
    said, failed, _ = api.run(
        [
            "--strict",
            "--config-file",
            str(ROOT / "pyproject.toml"),
            "--cache-dir",
            str(ROOT / ".mypy_cache"),
            *files,
        ]
    )
    assert not failed
    lines = said.splitlines()
    assert [line for line in lines if "right.py" in line and ": error:" in line] == []
    revealed = [line for line in lines if "Revealed type" in line]
    assert len(revealed) == len(public)
    assert [line for line in revealed if '"Any"' in line] == []
    wrong = sorted({int(line.split(":")[1]) for line in lines if "wrong.py" in line and ": error:" in line})
    assert wrong == [5, 6, 7, 8, 9]
