"""A study as its readers see it: parameters, cases, outcomes, and all of it as one labelled dataset."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import VfifeError, former_names, shown, suggestion
from ..files import DataTable, path_of, share_done, with_completeness
from ..measures.catalogue import IMPACT_SPEED, NO_IMPACT, is_no_impact
from ..options import with_faults
from ..solvers.status import Status
from ..store.connections import warn_of_damage
from ..store.studyfile import SPECIFICATION, StudyCase, StudyFile, has_former_measures
from ..units import unit_written
from .case_errors import NOT_ESTIMATED, ErrorEstimate, SampleErrors, repeated_cases, uncertain_ranges
from .export import STUDY_FORMATS, TableColumn, data_frame, export, table_rows
from .output_spacing import depends_on_outputs
from .parameters import Varied, in_list, in_order

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

OUTCOME = ("status", "turns", "settled", "period", "step", "reason")
TURN_COUNTS = dict.fromkeys(("turns", "settled", "period"), "1")  # numbers of turns, with their units
WRITTEN_VALUES = ("values", "from", "to", "nominal", "mean")  # keys of a parameter whose unit is shown
SAMPLE, CASE = "sample", "case"  # dimensions of what lies on no grid


@former_names(asked="request", lost="damaged_cases", damaged_members="damaged_cases", members="cases")
class Study(DataTable):
    """Cases and outcomes of a study so far. Everything is computed when first used, and only ``data`` loads
    xarray.

    ``meta`` is the specification, ``cases`` are all planned cases, ``outcomes`` those that have ended, by
    number; ``repeats`` are those of a sample of cases with another step, ``step_trials`` those with more.
    """

    def __init__(
        self,
        path: Path | None,
        meta: Mapping[str, Any],
        cases: Sequence[StudyCase],
        outcomes: Mapping[int, Mapping[str, Any]],
        repeats: Mapping[int, Mapping[str, Any]] | None = None,
        step_trials: Mapping[int, Mapping[int, Mapping[str, Any]]] | None = None,
    ) -> None:
        self.path, self.meta, self.cases = path, dict(meta), tuple(cases)
        with_outcome = (case for case in cases if case.number in outcomes)
        self.outcomes = {
            case.number: outcomes[case.number]
            for case in with_outcome
            if outcomes[case.number].get("hash", case.hash) == case.hash
        }
        recorded = {} if repeats is None else repeats
        self.repeats = {
            case.number: recorded[case.number]
            for case in cases
            if recorded.get(case.number, {}).get("hash") == case.hash
        }
        self.step_trials = dict(step_trials or {})
        self.damaged_cases = 0
        self.damage: tuple[str, ...] = ()

    @classmethod
    def open(cls, path: str | Path) -> Study:
        """Return the study of a file, which may still be growing.

        path: the study file

        Raises RunFileError for any other file.
        """
        with StudyFile.open(path) as file:
            study = cls.of(file)
        warn_of_damage(
            file.path, "study", study.damage, "Running the same study again computes the missing cases."
        )
        return study

    @classmethod
    def of(cls, file: StudyFile) -> Study:
        """Return the study of an open file."""
        study = cls(file.path, file.meta, file.cases(), file.outcomes(), file.repeats(), file.step_trials())
        study.damaged_cases, study.damage = file.damaged_cases, file.damage
        return study

    def __repr__(self) -> str:
        failed = f" ({len(self.failed)} failed, see .failed)" if self.failed else ""
        return (
            f"<Study of {self.model!r}: {len(self.outcomes)} of {len(self.cases)} cases{failed}; see .data,"
            " .parameters, .measures, .plot()>"
        )

    @property
    def has_former_measures(self) -> bool:
        """Whether measures are of an older definition, that of the turns of cases with a duration."""
        return has_former_measures(self.request, self.outcomes)

    @property
    def request(self) -> dict[str, Any]:
        """Specification of the study, as the file has it."""
        spec: dict[str, Any] = self.meta[SPECIFICATION]
        return spec

    @property
    def name(self) -> str:
        """Name of the study."""
        return str(self.request.get("name", ""))

    @property
    def model(self) -> str:
        """Name of the mechanism."""
        return str(self.request.get("model", ""))

    @property
    def measures(self) -> dict[str, str]:
        """Requested measures with their units."""
        return dict(self.request["measures"])

    @cached_property
    def parameters(self) -> tuple[Varied, ...]:
        """Varied parameters."""
        return tuple(
            Varied(**{**parameter, "paths": tuple(parameter["paths"]), "written": self._written(parameter)})
            for parameter in self.request["parameters"]
        )

    def _written(self, parameter: Mapping[str, Any]) -> str:
        """Return the unit in which the study file gives the values of a parameter."""
        raw = self.request.get("raw", {}).get("vary", {})
        entry = raw.get(parameter["name"], ()) if isinstance(raw, Mapping) else ()
        if isinstance(entry, Mapping):
            entry = [value for key in WRITTEN_VALUES for value in in_list(entry.get(key, ()))]
        return unit_written(in_list(entry), parameter["unit"])

    @cached_property
    def done(self) -> tuple[StudyCase, ...]:
        """Cases that have ended, in planned order."""
        return tuple(case for case in self.cases if case.number in self.outcomes)

    @property
    def left(self) -> tuple[StudyCase, ...]:
        """Cases still to be computed."""
        return tuple(case for case in self.cases if case.number not in self.outcomes)

    @property
    def progress(self) -> str:
        """How much is computed, as in "148 of 400 cases"; empty for a complete study."""
        return share_done(len(self.done), len(self.cases), "cases")

    @property
    def counts(self) -> dict[str, int]:
        """Number of cases by status, and of those left."""
        counts = dict(Counter(str(outcome["status"]) for outcome in self.outcomes.values()))
        return {Status.COMPLETE.value: 0, **counts, "left": len(self.left)}

    @property
    def status(self) -> str:
        """Status of the study: complete if every case has ended, else that of its file."""
        return Status.COMPLETE.value if not self.left else str(self.meta.get("status", "unfinished"))

    @property
    def failed(self) -> list[tuple[StudyCase, str]]:
        """Cases without measures, or with some missing, each with the reason."""
        return [
            (case, str(self.outcomes[case.number]["reason"]))
            for case in self.done
            if self.outcomes[case.number]["reason"]
        ]

    # ------------------------------------------------------------------------------------------------ numbers

    def at(self, case: StudyCase) -> tuple[float | str, ...]:
        """Return the values of the parameters of a case, in SI units."""
        return tuple(case.numbers[parameter.paths[0]] for parameter in self.parameters)

    def points(self) -> NDArray[np.float64]:
        """Return the parameters of the cases that have ended, shape (cases, parameters), in SI units; words
        as index in their list.
        """
        columns = []
        for k in range(len(self.parameters)):
            column = [self.at(case)[k] for case in self.done]
            words = {
                word: float(n)
                for n, word in enumerate(dict.fromkeys(value for value in column if isinstance(value, str)))
            }
            columns.append([words[value] if isinstance(value, str) else value for value in column])
        return np.array(columns, dtype=float).reshape(len(self.parameters), len(self.done)).T

    def values(self, measure: str) -> NDArray[np.float64]:
        """Return a measure of the cases that have ended, shape (cases,), NaN where missing. Raises VfifeError
        for a measure that was not requested.
        """
        if measure not in self.measures:
            remedy = suggestion(measure, self.measures, "name one of the measures")
            raise VfifeError(f"{self.path or 'this study'}: it has no measure {shown(measure)}: {remedy}")
        return np.array(
            [self.outcomes[case.number]["measures"].get(measure, math.nan) for case in self.done], dtype=float
        )

    @property
    def errors(self) -> dict[str, ErrorEstimate]:
        """Numerical error of a case by measure, from a sample repeated with other steps."""
        return self._sample_errors.estimates

    @property
    def sensitive(self) -> tuple[int, int]:
        """Number of cases of the repeated sample whose motion depends on the step, and of the sample."""
        return self._sample_errors.sensitive

    @property
    def sensitive_measures(self) -> dict[int, tuple[str, ...]]:
        """Measures that depend on the step, by number of the sensitive case of the repeated sample."""
        sample = self._sample_errors.sample
        return {case.number: case.changed_measures for case in sample if case.sensitive}

    def error_bars(self, measure: str) -> NDArray[np.float64]:
        """Return the error that a figure shows at each value, along the axes of the study.

        measure: a requested one
        """
        return self._along_axes(self._sample_errors.bars(measure, [case.number for case in self.done]))

    @cached_property
    def _sample_errors(self) -> SampleErrors:
        sample = repeated_cases(self.cases, self.outcomes, self.repeats, self.step_trials)
        names = [name for name in self.measures if name not in self.sampled]
        ranges = uncertain_ranges(self.request["wanted"], self.outcomes)
        return SampleErrors(sample, names, self.meta, ranges)

    @property
    def sampled(self) -> list[str]:
        """Measures taken at the outputs, whose error depends on their spacing and is not estimated."""
        return depends_on_outputs(self.measures, self.meta)

    def parameter(self, name: str) -> Varied:
        """Return a parameter by name or path. Raises VfifeError for an unknown one."""
        for parameter in self.parameters:
            if name == parameter.name or name in parameter.paths:
                return parameter
        remedy = suggestion(
            name, [parameter.name for parameter in self.parameters], "name one that is varied"
        )
        raise VfifeError(f"{self.path or 'this study'}: there is no parameter {shown(name)}: {remedy}")

    # --------------------------------------------------------------------------------------------------- data

    @cached_property
    def axes(self) -> dict[str, list[Any]]:
        """Dimensions of the dataset with their coordinates: the parameters if the cases form a grid, with
        ``sample`` for sampled ones; else ``case`` alone.
        """
        points = [self.at(case) for case in self.cases]
        lines = [k for k, parameter in enumerate(self.parameters) if parameter.gridded]
        axes: dict[str, list[Any]] = {
            self.parameters[k].name: in_order(values[k] for values in points) for k in lines
        }
        samples = list(dict.fromkeys(self._sample(values) for values in points))
        if len(lines) < len(self.parameters):
            axes[SAMPLE] = samples
        full = math.prod(len(values) for values in axes.values()) == len(points)
        return axes if full and lines else {CASE: points}

    def _sample(self, values: tuple[Any, ...]) -> tuple[Any, ...]:
        return tuple(
            value for value, parameter in zip(values, self.parameters, strict=True) if not parameter.gridded
        )

    def place(self, case: StudyCase) -> tuple[int, ...]:
        """Return the indices of a case along the axes."""
        values = self.at(case)
        if CASE in self.axes:
            return (self._places[CASE][values],)
        coordinates = {
            parameter.name: value for parameter, value in zip(self.parameters, values, strict=True)
        } | {SAMPLE: self._sample(values)}
        return tuple(self._places[name][coordinates[name]] for name in self.axes)

    @cached_property
    def _axis_indices(self) -> tuple[NDArray[np.intp], ...]:
        """Indices along each axis of the cases that have ended."""
        at = np.array([self.place(case) for case in self.done], dtype=np.intp).reshape(
            len(self.done), len(self.axes)
        )
        return tuple(at.T)

    @cached_property
    def _places(self) -> dict[str, dict[Any, int]]:
        return {name: {value: k for k, value in enumerate(values)} for name, values in self.axes.items()}

    def laid_out(self, name: str) -> NDArray[np.float64]:
        """Return a measure along the axes of the study; NaN where it is missing.

        name: a measure, or "turns", "settled", "period" or "step"
        """
        outcomes = [self.outcomes[case.number] for case in self.done]
        values = [
            outcome["measures"].get(name) if name in self.measures else outcome.get(name)
            for outcome in outcomes
        ]
        return self._along_axes([math.nan if value is None else value for value in values])

    def _along_axes(self, values: Sequence[float]) -> NDArray[np.float64]:
        """Return a value of each case that has ended along the axes of the study; NaN for the others."""
        grid = np.full(tuple(len(positions) for positions in self.axes.values()), np.nan)
        grid[self._axis_indices] = values
        return grid

    @cached_property
    def data(self) -> xarray.Dataset:
        """Dataset of the measures over the parameters, with units, and status, turns and step of each case;
        NaN where missing.
        """
        import xarray

        dims = tuple(self.axes)
        arrays = {name: self.laid_out(name) for name in (*self.measures, *TURN_COUNTS, "step")}
        status = np.full(tuple(len(values) for values in self.axes.values()), "left", dtype=object)
        status[self._axis_indices] = [str(self.outcomes[case.number]["status"]) for case in self.done]
        units = {**self.measures, **TURN_COUNTS, "step": "s"}
        variables: dict[str, Any] = {
            name: (dims, values, {"units": units[name], **self.error_attributes(name)})
            for name, values in arrays.items()
        }
        variables["status"] = (dims, status.astype(str), {"long_name": "how the case ended"})
        return xarray.Dataset(variables, self._coordinates(), self.attributes)

    def error_attributes(self, measure: str) -> dict[str, float | str]:
        """Return the numerical error of a case as attributes of a measure; empty for other variables."""
        if measure not in self.measures:
            return {}
        if (error := self.errors.get(measure)) is None:
            return {"numerical_error": NOT_ESTIMATED}
        return {
            "numerical_error": error.words,
            "numerical_error_typical": error.typical,
            "numerical_error_largest": error.most,
            **({"sensitive_cases": error.sensitive} if error.sensitive else {}),
        }

    def _coordinates(self) -> dict[str, Any]:
        coordinates: dict[str, Any] = {}
        for k, parameter in enumerate(self.parameters):
            attributes = {"units": parameter.unit, "long_name": ", ".join(parameter.paths)}
            if parameter.name in self.axes:
                coordinates[parameter.name] = (
                    parameter.name,
                    np.array(self.axes[parameter.name]),
                    attributes,
                )
            elif CASE in self.axes:
                coordinates[parameter.name] = (
                    CASE,
                    np.array([values[k] for values in self.axes[CASE]]),
                    attributes,
                )
            else:
                among = [sampled.name for sampled in self.parameters if not sampled.gridded].index(
                    parameter.name
                )
                coordinates[parameter.name] = (
                    SAMPLE,
                    np.array([values[among] for values in self.axes[SAMPLE]]),
                    attributes,
                )
        return coordinates

    @property
    def attributes(self) -> dict[str, Any]:
        """Provenance of the data."""
        requested = self.request["wanted"]
        return {
            "model": self.model, "study": self.name, "note": self.request.get("note", ""),
            "turns": requested["turns"], "last": requested["last"],
            **{key: requested[key] for key in ("settle", "counts") if requested.get(key) not in (None, CASE)},
            "vfife_version": self.request["versions"]["vfife"],
        }  # fmt: skip

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the entries of a row."""
        return ("case", *(parameter.name for parameter in self.parameters), *self.measures, *OUTCOME)

    def rows(self) -> list[dict[str, Any]]:
        """Return one map for each case, for tables: parameters, measures, :data:`OUTCOME`."""
        rows = []
        for case in self.cases:
            outcome = self.outcomes.get(case.number)
            row: dict[str, Any] = {
                "case": case.number,
                **dict(zip((parameter.name for parameter in self.parameters), self.at(case), strict=True)),
            }
            measures = {} if outcome is None else outcome["measures"]
            row |= {name: measures.get(name) for name in self.measures}
            row |= {name: None if outcome is None else outcome.get(name) for name in OUTCOME}
            row["status"] = row["status"] or "left"
            rows.append(row)
        return rows

    if TYPE_CHECKING:  # attached by vfife.methods

        def plot(self, *names: str, measures: Sequence[str] = ()) -> dict[str, Figure]:
            """See :func:`vfife.methods.plot_study`."""

        def _repr_html_(self) -> str: ...

    def export(self, path: str | Path, decimal: str = "point") -> None:
        """Write one row per case, or the dataset as NetCDF, in the format of the file's extension.

        path: the file, ``.csv`` and ``.xlsx`` with the parameters in the units of the study file,
            ``.parquet`` and ``.nc`` in SI units
        decimal: "point" or "comma" in a CSV file

        Raises VfifeError for another extension, OSError.
        """
        export(self, path_of(path, "export"), STUDY_FORMATS, "no study is", decimal)

    def table(self) -> Iterator[Sequence[Any]]:
        """Yield heads with units, then a row for each case."""
        return table_rows(self.table_columns())

    def spreadsheet(self) -> Iterator[Sequence[Any]]:
        """Yield the same table with the parameters in the units in which the study file gives them."""
        written = {parameter.name: parameter for parameter in self.parameters if parameter.written}
        columns = self.table_columns()
        for k, column in enumerate(columns):
            if parameter := written.get(column.name):
                scaled = [value and parameter.in_written_unit(value) for value in column.values]
                columns[k] = replace(column, values=scaled, unit=parameter.written)
        return table_rows(columns)

    def table_columns(self) -> list[TableColumn]:
        """Return the columns of the table of cases: number, parameters, measures, each followed by its
        largest numerical error and, of impact speeds, whether there was no impact; and status.
        """
        rows, units = self.rows(), {parameter.name: parameter.unit for parameter in self.parameters}
        units |= {**self.measures, "step": "s"}
        kinds: dict[str, type] = dict.fromkeys(("case", *TURN_COUNTS), int) | dict.fromkeys(
            ("status", "reason"), str
        )
        kinds |= dict.fromkeys((*self.measures, "step"), float)
        columns = []
        for name in self.columns:
            values, unit = [row[name] for row in rows], units.get(name, "1")
            columns.append(TableColumn(name, values, unit, self._error_texts(name), kinds.get(name)))
            if name in self.measures:
                errors = self._case_errors(name, values)
                columns.append(TableColumn(f"{name}.error", errors, unit, {}, float))
            if name.endswith(IMPACT_SPEED):
                remarks = [NO_IMPACT if is_no_impact(name, value) else None for value in values]
                columns.append(TableColumn(f"{name}.remark", remarks, kind=str))
        return columns

    def _case_errors(self, measure: str, values: Sequence[float | None]) -> list[float | None]:
        """Return the largest numerical error of each case; None without a value or an estimate."""
        if measure not in self.errors:
            return [None] * len(values)
        bounds = self._sample_errors.bounds(measure, [case.number for case in self.cases])
        return [None if value is None else bound for value, bound in zip(values, bounds, strict=True)]

    def _error_texts(self, measure: str) -> dict[str, str]:
        return {key: str(value) for key, value in self.error_attributes(measure).items()}

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a table for pandas with one row per case."""
        index, *columns = self.table_columns()
        return with_completeness(data_frame(columns, index=index), self.progress)


@with_faults()
def load_study(path: str | Path) -> Study:
    """Return the study of a file, which may still be growing.

    path: the study file

    Raises RunFileError for any other file.
    """
    return Study.open(path)
