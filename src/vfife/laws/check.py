"""Examine a law of the user's own in plain Python before the compiler sees it, and report its faults.

There are three checks, each only if the one before found no fault: how the functions are written, what they
return at a few states, and whether every loop computes the bits that Python computes. Built-in laws are
checked by the tests.
"""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
from collections.abc import Iterator, Sequence
from types import FunctionType
from typing import TYPE_CHECKING, Any, NamedTuple
from weakref import WeakKeyDictionary

from ..compiler.trace.source import data_driven
from ..compiler.trace.traceable import WRITING
from ..errors import LawError, SourceError
from ..kernels.blocks import CONTACT_SLOTS, FRICTION_MEMORY, FRICTION_SLOTS
from ..schema import required
from .grammar import NUMBER, Kind, TupleKind
from .language import Language
from .law import Law, Pair, built_in, law_kind
from .time_limit import SECONDS, Endless, limited

if TYPE_CHECKING:
    from .agreement import Agreement


class Part(NamedTuple):
    """A function of a law: its name, the kinds of its arguments, how many numbers it returns (a tuple of them
    where it is not 1), and the words for its answer.
    """

    name: str
    kinds: tuple[Kind, ...]
    numbers: tuple[int, ...]
    answer: str


def parts_of(law: Any, kind: str) -> list[Part]:
    """Return the functions of a law, with the kinds of their arguments."""
    slots = TupleKind((NUMBER,) * len(law.slots), slots=True)
    if kind == "friction":
        rows = len(law.memory)
        memory: Kind = TupleKind((NUMBER,) * rows) if rows > 1 else NUMBER
        answer = (
            "two numbers, the friction force (N) and the memory"
            if rows < 2
            else f"the friction force (N) and a tuple of {rows} numbers to remember"
        )
        problems = [Part("force", (NUMBER, NUMBER, NUMBER, memory, NUMBER, slots), (1, max(rows, 1)), answer)]
        return (
            [*problems, Part("regime", (NUMBER, slots), (1,), "one number")]
            if law.regime is not None
            else problems
        )
    answer = "two numbers, the elastic force (N) and the damping coefficient (N s/m)"
    problems = [Part("force", (NUMBER, NUMBER, slots), (1, 1), answer)]
    return (
        [*problems, Part("film_force", (NUMBER,) * 3 + (slots,), (1,) * 5, "five finite numbers")]
        if law.film
        else problems
    )


def place(law: type[Law]) -> str:
    """Return name, class, file and line of a law, for messages."""
    function = getattr(law, "force", None)
    code = getattr(function, "__code__", None)
    origin = (
        f"{code.co_filename}, line {code.co_firstlineno}, "
        if code is not None and law.__module__ != "vfife.laws.law"
        else ""
    )
    return f"{origin}law {law.name!r} ({law.__name__})"


INTERVALS = 400  # of the integral of an elastic force: exact to 1e-5 for a power of 1.5
ENERGY_TOLERANCE = 0.01  # share by which an elastic energy may differ from that integral
ARGUMENTS = {
    "contact": ("penetration", "slowness", "p"),
    "friction": ("normal_force", "free_velocity", "mobility", "memory", "dt", "p"),
}
ANSWER = {
    "contact": "the elastic force (N) and the damping coefficient (N s/m)",
    "friction": "the friction force (N) and the memory",
}
NAMES = {"film_force": "film", "regime": "regime"}  # of parts other than ``force``
UNITS = ("m", "s/m"), ("N", "m/s", "m/s/N", "m", "s")


ENDLESS = f"has run for {SECONDS:g} s and does not end; give its loops a largest number of rounds"
USUAL = Pair(0.01, 2e-4, 0.02)  # surfaces for a law that is tried by itself


def try_out(
    laws: Sequence[tuple[Law, Pair]], contacts: tuple[type, ...] = (), frictions: tuple[type, ...] = ()
) -> None:
    """Evaluate every user-defined law at the surfaces where it is used. Raises LawError with all
    faults.

    contacts, frictions: the laws of the same compiled loop
    """
    user_laws = [(law, pair) for law, pair in laws if not built_in(type(law))]
    if not user_laws:
        return
    problems: list[str] = []
    with WRITING:
        for kind in dict.fromkeys(type(law) for law, _ in user_laws):
            problems += faults_of_class(kind)
        for faults_of_law in (faults_of_numbers, faults_of_loops):
            if not problems:
                problems = [fault for law, pair in user_laws for fault in faults_of_law(law, pair)]
        if contacts and not problems:
            try:
                data_driven(contacts, frictions)
            except SourceError as error:
                problems.append(f"{place(type(user_laws[0][0]))}: {error}")
    if problems:
        raise LawError("\n".join(dict.fromkeys(problems)))


def faults_of_class(law: type[Law]) -> list[str]:
    """Return the faults of the class and of the text of its functions."""
    origin, kind = place(law), law_kind(law)
    problems = []
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", law.name):
        problems.append(
            f"{origin}: a law's name is made of small letters, digits and hyphens, as in lankarani-nikravesh"
        )
    fields = [name for name, text in inspect.get_annotations(law).items() if "ClassVar" not in str(text)]
    if fields and "__dataclass_params__" not in law.__dict__:
        problems.append(
            f"{origin}: the class has fields ({', '.join(fields)}) and is no dataclass; write"
            " @dataclass(frozen=True, kw_only=True)"
        )
    room = CONTACT_SLOTS if kind == "contact" else FRICTION_SLOTS
    slots: Any = law.slots
    if not isinstance(slots, tuple) or not all(isinstance(slot, str) for slot in slots):
        problems.append(f'{origin}: slots is a tuple of names, as in slots = ("stiffness",)')
    elif len(law.slots) > room:
        problems.append(
            f"{origin}: {len(law.slots)} slots; a {kind} law may have {room}: work out in parameters() what"
            " does not change in a run"
        )
    memory: Any = law.memory if kind == "friction" else ()  # type: ignore[attr-defined]
    if not isinstance(memory, tuple) or len(memory) > FRICTION_MEMORY:
        problems.append(
            f'{origin}: memory is a tuple of at most {FRICTION_MEMORY} names, as in memory = ("bend (m)",)'
        )
    function, expected = law.force, ARGUMENTS[kind]  # type: ignore[attr-defined]
    if not isinstance(inspect.getattr_static(law, "force"), staticmethod):
        return [
            *problems,
            (
                f"{origin}: force is a static function; write @staticmethod above it and no self among its"
                " arguments"
            ),
        ]
    required = [
        name
        for name, argument in inspect.signature(function).parameters.items()
        if argument.default is argument.empty
    ]
    if len(inspect.signature(function).parameters) != len(expected) or len(required) != len(expected):
        count = f"{len(required)} argument{'s' * (len(required) != 1)} ({', '.join(required)})"
        problems.append(
            f"{origin}: force takes {count}; a {kind} law takes {len(expected)}: {', '.join(expected)}"
        )
    film: Any = getattr(law, "film_force", None) if kind == "contact" and law.film else None  # type: ignore[attr-defined]
    if kind == "contact" and law.film and (film is None or len(inspect.signature(film).parameters) != 4):  # type: ignore[attr-defined]
        problems.append(
            f"{origin}: a law with film = True has a static function film_force(penetration, turning,"
            " sense, p)"
        )
        return problems
    return problems or [f"{origin}: {fault}" for fault in faults_of_functions(law, kind)]


def faults_of_functions(law: Any, kind: str) -> list[str]:
    """List the uses of Python that the language of laws does not have, in all functions of a law."""
    problems: list[str] = []
    for part in parts_of(law, kind):
        function = getattr(law, part.name)
        if not isinstance(function, FunctionType):
            problems.append(f"{part.name} is no plain function; write it as a `def` in the class")
            continue
        try:
            problems += Language().examine(function, part.kinds, part.numbers, part.answer)
        except (OSError, TypeError):
            problems.append(
                "the text of its function cannot be read; write the law in a file, as the compiler needs its"
                " text"
            )
    return problems


def faults_of_numbers(law: Law, pair: Pair) -> list[str]:
    """List the faults of the numbers that parameters() and force return for these surfaces."""
    origin, kind = place(type(law)), law_kind(type(law))
    try:
        with limited(SECONDS):
            p: tuple[Any, ...] = tuple(law.parameters(pair))
    except Endless:
        return [f"{origin}: parameters() {ENDLESS}"]
    except Exception as error:
        return [
            f"{origin}: parameters() raises {type(error).__name__}: {error} (clearance {pair.clearance:g} m)"
        ]
    if len(p) != len(law.slots):
        return [
            f"{origin}: parameters() gives {len(p)} numbers, and slots names {len(law.slots)}:"
            f" {', '.join(law.slots)}"
        ]
    for slot, value in zip(law.slots, p, strict=True):
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            return [
                f"{origin}: parameters() gives {slot} = {value!r}, which is no finite number (clearance"
                f" {pair.clearance:g} m)"
            ]
    p = tuple(float(value) for value in p)
    states = contact_states(pair) if kind == "contact" else friction_states(len(law.memory))  # type: ignore[attr-defined]
    problems: dict[str, str] = {}  # by the remedy: each once
    for state in states:
        text = zip(ARGUMENTS[kind], state, UNITS[kind == "friction"], strict=False)
        at = ", ".join(f"{name} {value:g} {unit}" for name, value, unit in text if isinstance(value, float))
        for fault in faults_at(law, kind, state, p):
            problems.setdefault(fault.partition("; ")[2], f"{origin}, function force: {fault} (at {at})")
    if problems:
        return list(problems.values())
    return [*faults_of_film(law, pair, p), *faults_of_energy(law, pair, p)] if kind == "contact" else []


def faults_of_energy(law: Any, pair: Pair, p: tuple[float, ...]) -> list[str]:
    """Return a fault if the elastic energy is not computed in time, or is not the integral of the elastic
    force: the ledger of a run would have an error that no step removes.
    """
    origin, depth = place(type(law)), 0.1 * pair.clearance
    try:
        with limited(SECONDS):
            energy = float(law.elastic_energy(depth, p)) - float(law.elastic_energy(0.0, p))
            depths = [depth * k / INTERVALS for k in range(INTERVALS + 1)]
            forces = [float(law.force(penetration, 0.0, p)[0]) for penetration in depths]
    except Endless:
        return [f"{origin}: elastic_energy() {ENDLESS}"]
    except Exception:  # an elastic energy is optional
        return []
    integral = depth / INTERVALS * (sum(forces) - 0.5 * (forces[0] + forces[-1]))
    if abs(energy - integral) <= ENERGY_TOLERANCE * abs(integral):
        return []
    return [
        f"{origin}: elastic_energy() gives {energy:.4g} J at penetration {depth:g} m, and the integral of"
        f" the elastic force is {integral:.4g} J; correct it, or leave it out: it is integrated then"
    ]


def faults_of_film(law: Any, pair: Pair, p: tuple[float, ...]) -> list[str]:
    """List the faults of a law's film: it returns five finite numbers, and its damping dissipates energy."""
    for depth in (-1.0, -0.5, -1e-3, 0.0, 0.1) if law.film else ():
        at = f"{place(type(law))}, function film_force (at penetration {depth * pair.clearance:g} m)"
        try:
            answer = tuple(float(value) for value in law.film_force(depth * pair.clearance, 1e-3, 1.0, p))
        except Exception as error:
            return [f"{at}: it raises {type(error).__name__}: {error}"]
        if len(answer) != 5 or not all(math.isfinite(value) for value in answer):
            return [
                f"{at}: it returns {answer}; it has to return five finite numbers: radial and across (N),"
                " D_n, D_t and X (N s/m)"
            ]
        if min(answer[2:4]) < 0.0 or answer[4] * answer[4] > answer[2] * answer[3]:
            return [
                f"{at}: D_n, D_t and X are {answer[2:]}; D_n and D_t have to be 0 or more and X^2 at most D_n"
                " D_t, or the film gives energy"
            ]
    return []


def contact_states(pair: Pair) -> Iterator[tuple[float, ...]]:
    """Yield states apart, and in contact at depths up to the clearance after impacts of 1 mm/s to 10 m/s."""
    yield 0.0, 0.0
    for share in (0.0, 1e-6, 1e-3, 0.1, 1.0):
        for slowness in (0.1, 1.0, 1e3):
            yield share * pair.clearance, slowness


def friction_states(memories: int) -> Iterator[tuple[Any, ...]]:
    """Yield states without memory: apart and under forces up to 10 kN, at rest and sliding up to 1 m/s either
    way, with a small and a large mobility.
    """
    for normal in (0.0, 1.0, 1e4):
        for velocity in (0.0, 1e-6, -1e-3, 1.0, -1.0):
            for mobility in (1e-12, 1e-6):
                yield normal, velocity, mobility, (0.0,) * memories if memories > 1 else 0.0, 1e-6


def faults_at(law: Law, kind: str, state: tuple[Any, ...], p: tuple[float, ...]) -> list[str]:
    """Return the faults of the force at a state."""
    try:
        answer: Any = law.force(*state, p)  # type: ignore[attr-defined]
    except ZeroDivisionError:
        return [
            "it divides by zero; a step calls it also while the surfaces are apart, so add a bound or choose"
            " by `a if condition else b`"
        ]
    except Exception as error:
        return [f"it raises {type(error).__name__}: {error}"]
    if not isinstance(answer, tuple) or len(answer) != 2:
        return [f"it returns {answer!r}; it has to return two numbers, {ANSWER[kind]}"]
    for value in (answer[0], *answer[1]) if isinstance(answer[1], tuple) else answer:
        if isinstance(value, bool) or not isinstance(value, int | float):
            return [
                f"it returns {value!r} of type {type(value).__name__}; it has to return two numbers,"
                f" {ANSWER[kind]}"
            ]
        if not math.isfinite(value):
            return [f"it returns {answer[0]!r} and {answer[1]!r}; both have to be finite"]
    first, second = answer
    if kind == "friction":
        friction = f"a friction of {first:g} N without a normal force; it has to vanish with it"
        return [friction] if state[0] == 0.0 and first != 0.0 else []
    force, damping = f"the elastic force is {first:g} N", f"the damping coefficient is {second:g} N s/m"
    problems = {
        f"{force}; surfaces that press on one another push, so it has to be 0 or more": first < 0.0,
        f"{damping}; it has to be 0 or more, or the contact would give energy": second < 0.0,
        f"{force}; it has to be 0 where nothing is pressed in: `F if penetration > 0.0 else 0.0`": (
            state[0] == 0.0 and first > 0.0
        ),
        f"{damping} while the surfaces are apart; it has to be 0 there, where slowness is 0": (
            state == (0.0, 0.0) and second > 0.0
        ),
    }
    return [problem for problem, fails in problems.items() if fails]


def agreements(law: Law, pair: Pair, javascript: bool = False) -> list[Agreement]:
    """Compare the functions of a law in every loop with Python. Raises LawError where one has no loop."""
    from .agreement import (
        agreement_of,  # all that writes loops, which a run without laws of one's own has no need to load
    )

    slots = tuple(float(value) for value in law.parameters(pair))
    kind = law_kind(type(law))
    return [
        agreement_of(NAMES.get(part.name, kind), type(law), slots, javascript)
        for part in parts_of(type(law), kind)
    ]


def comparison(laws: Sequence[tuple[Law, Pair]]) -> dict[str, str]:
    """Compare the loops of user-defined laws with Python, also in JavaScript if node is installed, and
    describe the comparison by law.

    Raises LawError where a loop differs from Python.
    """
    user_laws = {law.name: (law, pair) for law, pair in laws if not built_in(type(law))}
    if problems := [
        fault for law, pair in user_laws.values() for fault in faults_of_loops(law, pair, javascript=True)
    ]:
        raise LawError("\n".join(problems))
    return {
        name: agreements(law, pair, javascript=True)[0].words() for name, (law, pair) in user_laws.items()
    }


# Text of each law when it was last tried: at a prompt a number of its file or a function that it calls may
# change afterwards.
_TEXTS: WeakKeyDictionary[type[Law], str] = WeakKeyDictionary()


def renew(law: type[Law]) -> None:
    """Discard the compiled loops and comparisons of a law whose text has changed."""
    from ..compiler.runtime.lawloops import Single, text_of
    from ..compiler.runtime.loops import forget_steps
    from .agreement import forget

    text = "\n".join(
        text_of(Single(NAMES.get(part.name, law_kind(law)), law)) for part in parts_of(law, law_kind(law))
    )
    if _TEXTS.get(law, text) != text:
        forget_steps()
        forget(law)
    _TEXTS[law] = text


def faults_of_loops(law: Law, pair: Pair, javascript: bool = False) -> list[str]:
    """Return a fault for each loop that does not compute the same bits as Python. A law whose text has passed
    the check rarely fails here.
    """
    try:
        with WRITING:
            renew(type(law))
            if javascript:  # by itself; where it is assembled, the text with all laws of the model follows
                data_driven(*(((type(law),), ()) if law_kind(type(law)) == "contact" else ((), (type(law),))))
        return [
            f"{place(type(law))}, {fault}"
            for agreement in agreements(law, pair, javascript)
            for fault in agreement.faults
        ]
    except (LawError, SourceError) as error:
        return [f"{place(type(law))}: {error}"]


def needed(law: type[Law]) -> list[str]:
    """Return the fields without a default."""
    return [field.name for field in dataclasses.fields(law) if required(field)]


def faults(law: type[Law], pair: Pair | None = None) -> list[str]:
    """Return the faults of a law that no model uses yet, with its default parameters if it has them."""
    problems: list[Any] = faults_of_class(law)
    if problems or needed(law):
        return problems
    pair = pair or USUAL
    return faults_of_numbers(law(), pair) or faults_of_loops(law(), pair, javascript=True)
