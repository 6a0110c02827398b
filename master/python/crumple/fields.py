"""Fields of one output step as NumPy arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy

from . import _native
from ._optional import module

if TYPE_CHECKING:
    import pyvista

TYPES = {"Float32": "f4", "UInt32": "u4", "Int64": "i8", "UInt8": "u1"}
"""Types of NumPy by those of VTK."""
MESH = ("Points", "connectivity", "offsets", "types")
"""Arrays that are no fields."""

Array = numpy.ndarray[Any, Any]


@dataclass(frozen=True)
class Fields:
    """Fields of one output step. Each node and each element appears once, by ascending id, so that
    the arrays do not depend on the number of workers, except `worker` and `class`."""

    time: float
    """Simulated time, in the unit of the job."""
    points: Array
    """Coordinates of the nodes, (nodes, 3)."""
    connectivity: Array
    """Rows of `points` of all corners of the elements, one element after the other."""
    offsets: Array
    """End of the corners of each element in `connectivity`."""
    types: Array
    """Shape of each element, by the numbers of VTK."""
    point_data: dict[str, Array]
    """Fields at nodes, such as `displacement` (nodes, 3) and `node_id` (nodes)."""
    cell_data: dict[str, Array]
    """Fields of elements, such as `von_mises` (elements) and `stress` (elements, 6)."""

    @classmethod
    def read(cls, time: float, file: str) -> Fields:
        """Reads an output step.

        Raises `ValueError` if a file is missing or damaged.
        """
        pieces = [
            {name: numpy.frombuffer(data, TYPES[kind]) for name, (kind, data) in piece.items()}
            for piece in _native.read_step(file)
        ]
        return cls._join(time, pieces)

    @classmethod
    def _join(cls, time: float, pieces: list[dict[str, Array]]) -> Fields:
        """Joins the pieces of the workers."""
        counts = [len(piece["node_id"]) for piece in pieces]
        firsts = numpy.cumsum([0, *counts[:-1]])
        nodes = numpy.concatenate([piece["node_id"] for piece in pieces])
        _, first, places = numpy.unique(nodes, return_index=True, return_inverse=True)
        corners = numpy.concatenate(
            [places[piece["connectivity"] + start] for piece, start in zip(pieces, firsts)]
        )
        lengths = numpy.concatenate([numpy.diff(piece["offsets"], prepend=0) for piece in pieces])
        starts = numpy.cumsum(lengths) - lengths
        order = numpy.argsort(
            numpy.concatenate([piece["element_id"] for piece in pieces]), kind="stable"
        )
        ends = numpy.cumsum(lengths[order])
        # Position in `corners` of each corner of the elements in their new order.
        shift = starts[order] - (ends - lengths[order])
        at = numpy.arange(len(corners)) + numpy.repeat(shift, lengths[order])
        data = {name: numpy.concatenate([one[name] for one in pieces]) for name in pieces[0]}
        points, cells = len(nodes), len(order)
        point_data, cell_data = {}, {}
        for name, values in data.items():
            if name in MESH:
                continue
            if name in _native.POINT_ARRAYS:
                point_data[name] = _rows(values, points)[first]
            else:
                cell_data[name] = _rows(values, cells)[order]
        return cls(
            time=time,
            points=data["Points"].reshape(-1, 3)[first],
            connectivity=corners[at],
            offsets=ends,
            types=data["types"][order],
            point_data=point_data,
            cell_data=cell_data,
        )

    def __getitem__(self, name: str) -> Array:
        """Returns a field by its name."""
        for data in (self.point_data, self.cell_data):
            if name in data:
                return data[name]
        there = ", ".join([*self.point_data, *self.cell_data])
        raise KeyError(f"there is no field {name}; there are {there}")

    def grid(self) -> pyvista.UnstructuredGrid:
        """Returns the fields for PyVista.

        Raises `ImportError` without PyVista.
        """
        vista = module("pyvista")
        lengths = numpy.diff(self.offsets, prepend=0)
        starts = self.offsets - lengths
        cells = numpy.insert(self.connectivity, starts, lengths)
        grid: pyvista.UnstructuredGrid = vista.UnstructuredGrid(cells, self.types, self.points)
        grid.point_data.update(self.point_data)
        grid.cell_data.update(self.cell_data)
        return grid

    def __repr__(self) -> str:
        return f"<Fields at {self.time:g}: {len(self.points)} nodes, {len(self.types)} elements>"


def _rows(values: Array, count: int) -> Array:
    """Returns values with one row for each of `count` nodes or elements."""
    return values if len(values) == count else values.reshape(count, -1)
