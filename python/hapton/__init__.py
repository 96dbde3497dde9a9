"""Touch meshes, read recordings and join a running session of Hapton. All numbers are SI; docs/python.md has examples."""
import json as _json

# Imported now. Otherwise the first array would import it, at the first force of a node, which must not take a second.
import numpy as _numpy

from ._hapton import Client, DeformStep, FieldNode, HandSample, Material, Mesh, ToolStep, TouchStep, fields, load_mesh, methods, read_session, run_haptics_node
from ._hapton import _report_mesh
from .results import read_table, run_bench, run_loop

__all__ = [
    "Client",
    "DeformStep",
    "FieldNode",
    "HandSample",
    "Material",
    "Mesh",
    "ToolStep",
    "TouchStep",
    "fields",
    "load_mesh",
    "mesh_info",
    "methods",
    "read_session",
    "read_table",
    "run_bench",
    "run_haptics_node",
    "run_loop",
]


def mesh_info(path, unit=None):
    """Returns the report of `hapton info --json` on a mesh file as a dict: size, parts, flaws, and which cracks are sealed when it is loaded."""
    return _json.loads(_report_mesh(path, unit))
