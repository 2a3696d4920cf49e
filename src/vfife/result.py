"""The result of a run: one dataset with units, the numbers it is judged by, and files that keep it."""

from __future__ import annotations

import os
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .analysis import Ledger, last_turn, ledger, measures
from .analysis.motion import times
from .assembly import Record
from .channels import Channel, channels, entities
from .provenance import keep_reference, provenance, restored, versions
from .runfile import RunFile, RunFileError

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

LONGEST_ATTRIBUTE = 60000  # bytes; HDF5 takes no attribute beyond 64 KiB


class Result:
    """What a run gives. All of it is built when it is first asked for, and only ``data`` loads xarray.

    ``record`` holds the rows, ``reference`` is the result of the ideal mechanism or None.
    """

    def __init__(self, record: Record, reference: Result | None = None) -> None:
        self.record, self.reference = record, reference

    def __repr__(self) -> str:
        choice, done = self.record.assembly.choice, int(self.record.steps[-1])
        length = f"{done * choice.step:.4g} s"
        if self.record.static:
            length = f"{done} load factors up to {self.time[-1]:.4g}"
            return f"<Result of {self.name!r}: static, {self.record.status}, {length}; see .data, .measures, .summary, .plot()>"
        if choice.turn is not None:
            length = f"{done * choice.step / choice.turn:.4g} turns"
        return (
            f"<Result of {self.name!r}: {self.record.status}, {length}, {done} steps of {choice.step:.4g} s, "
            f"{len(self.record.steps)} outputs; see .data, .measures, .summary, .plot()>"
        )

    # -------------------------------------------------------------------------------------------------------- numbers

    @property
    def name(self) -> str:
        """Name of the mechanism."""
        return self.record.assembly.mechanism.name

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the outputs (s), or load factors of a static analysis, shape (outputs,)."""
        return times(self.record)

    @property
    def crank(self) -> str | None:
        """The body that is driven, the first one if there are several."""
        return next((body.name for body in self.record.assembly.bodies.values() if body.driven == 0), None)

    @property
    def crank_angle(self) -> NDArray[np.float64] | None:
        """Angle of the crank (degrees, not reduced to one turn), shape (outputs,), or None without a crank."""
        if self.crank is None:
            return None
        p = self.record.assembly.topology.driven[0]
        return np.degrees(self.record.block("particle_theta")[:, p])

    @property
    def last_turn(self) -> NDArray[np.bool_]:
        """Outputs of the last full crank turn, over which maxima are taken; all outputs without a crank."""
        return last_turn(self.record)

    @cached_property
    def ledger(self) -> Ledger:
        """The energy ledger."""
        return ledger(self.record)

    @cached_property
    def measures(self) -> dict[str, float]:
        """Flat map of the numbers a run is judged by; see :func:`vfife.analysis.measures.measures`."""
        return measures(self.record, None if self.reference is None else self.reference.measures)

    @cached_property
    def summary(self) -> dict[str, Any]:
        """All that a summary says, as dictionaries, lists, texts and numbers."""
        from .summary import report

        return report(self)

    # ----------------------------------------------------------------------------------------------------------- data

    @cached_property
    def channels(self) -> dict[str, Channel]:
        """Series by name, as plain arrays with unit and meaning."""
        return channels(self.record, self.ledger)

    @cached_property
    def data(self) -> xarray.Dataset:
        """All channels over time and the names of joints, bodies, elements and particles, with units and long names."""
        import xarray

        told = {"units": "1", "long_name": "load factor"} if self.record.static else {"units": "s", "long_name": "time"}
        coords: dict[str, Any] = {"time": ("time", self.time, told)}
        coords |= {entity: (entity, np.array(names)) for entity, names in entities(self.record).items()}
        if self.crank_angle is not None:
            said = {"units": "deg", "long_name": f"angle of {self.crank}, not reduced to one turn"}
            coords["crank_angle"] = ("time", self.crank_angle, said)
        variables = {name: (one.dims, one.values, {"units": one.unit, "long_name": one.meaning}) for name, one in self.channels.items()}
        data = xarray.Dataset(variables, coords, self.attributes)
        if "mode" in data:
            data["mode"].attrs |= {
                "flag_values": np.array([0, 1, 2], dtype=np.int8),
                "flag_meanings": "free_flight impact continuous_contact",
            }
        return data

    @property
    def attributes(self) -> dict[str, Any]:
        """Where the data come from: model, step, loop, version, laws with their sources."""
        mechanism = self.record.assembly.mechanism
        found: dict[str, Any] = {
            "model": mechanism.name,
            "note": mechanism.note.strip(),
            "step": self.record.assembly.choice.step,
            "loop": self.record.loop,
            "status": self.record.status,
            "vfife_version": versions()["vfife"],
        }
        try:
            origin = provenance(self.record.assembly, self.record.kept, self.record.loop)
        except (TypeError, ValueError):  # a mechanism that no model file can hold still has data
            return found
        found["laws"] = "\n".join(f"{name}: {source}" for name, source in origin["laws"].items())
        if len(origin["model"].encode()) < LONGEST_ATTRIBUTE:
            found["model_file"] = origin["model"]
        return found

    # ---------------------------------------------------------------------------------------------------------- files

    def to_netcdf(self, path: str | Path) -> None:
        """Writes the dataset as NetCDF-4."""
        encoding = {name: {"zlib": True, "complevel": 1, "shuffle": True} for name in self.data.data_vars}
        self.data.to_netcdf(path, engine="h5netcdf", encoding=encoding)

    def save(self, path: str | Path) -> None:
        """Writes a run file that :meth:`load` reads; one that is there already gives way when the new one is whole."""
        path = Path(path)
        part = path.with_name(path.name + ".part")
        meta = provenance(self.record.assembly, self.record.kept, self.record.loop)
        with RunFile.create(part, meta, replace=True) as file:
            self.finish(file)
        os.replace(part, path)

    def finish(self, file: RunFile) -> None:
        """Ends a run file: outputs it does not have yet, the reference, how the run ended, and its summary."""
        missing = slice(len(file.steps), None)  # an interrupt may have come between a chunk and its being written
        file.append(self.record.steps[missing], self.record.rows[missing])
        if self.reference is not None:
            keep_reference(file, self.reference.record)
        meta = provenance(self.record.assembly, self.record.kept, self.record.loop)
        file.finish(self.record.status, self.summary, wall=self.record.wall, **meta)

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """The result that a run file, or the run file in a folder, holds; also that of a run that was killed.

        Raises RunFileError where there is no such file, or it is damaged or of another kind.
        """
        with RunFile.open(path) as file:
            where = str(file.path)
            result = cls(restored(file.meta, file.steps, file.rows, where))
            last = file.last_checkpoint()
            if last is not None and last[0] == file.steps[-1] and len(last[1]) == result.record.assembly.layout.rows:
                result.record.final = last[1]
            kept = file.reference()
            if kept is not None:
                result.reference = cls(restored(*kept, where=where))
        return result

    # ------------------------------------------------------------------------------------------------------- pictures

    def plot(self) -> dict[str, Figure]:
        """Figures by name: journal paths, forces and accelerations over the ideal ones, the mechanism."""
        from .plots import figures

        return figures(self, self.reference)


__all__ = ["Result", "RunFileError"]
