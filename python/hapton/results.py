"""Runs `hapton loop` and `hapton bench`, and returns their JSON or CSV results as dicts of NumPy arrays."""
import csv as _csv
import glob as _glob
import json as _json
import os as _os
import subprocess as _subprocess
import tempfile as _tempfile

import numpy as _numpy

__all__ = ["read_table", "run_bench", "run_loop"]


def _to_array(values):
    """An array of numbers if all values are numbers or missing (NaN), otherwise of texts."""
    try:
        return _numpy.array([float("nan") if value in (None, "") else float(value) for value in values])
    except (TypeError, ValueError):
        return _numpy.array(["" if value is None else str(value) for value in values])


def _flatten(item, prefix=""):
    """Joins the names of inner objects: {"inputs": {"rate_hz": 1000}} becomes {"inputs_rate_hz": 1000}."""
    flat = {}
    for name, value in item.items():
        if isinstance(value, dict):
            flat.update(_flatten(value, prefix + name + "_"))
        else:
            flat[prefix + name] = _from_json(value) if isinstance(value, list) else value
    return flat


def _from_json(value):
    """Turns a list of objects into a dict of arrays, any other list into an array, and an object into a dict."""
    if isinstance(value, dict):
        return _flatten(value)
    if not value or not all(isinstance(item, dict) for item in value):
        return _to_array(value) if not any(isinstance(item, (dict, list)) for item in value) else value
    rows = [_flatten(item) for item in value]
    names = list(dict.fromkeys(name for row in rows for name in row))
    columns = {name: [row.get(name) for row in rows] for name in names}
    return {name: column if any(isinstance(one, (dict, list, _numpy.ndarray)) for one in column) else _to_array(column)
            for name, column in columns.items()}


def _to_flags(flags):
    """Turns device="touch", json=True, delay=[0, 5] into --device touch --json --delay 0,5."""
    words = []
    for name, value in flags.items():
        if value is None or value is False:
            continue
        words.append("--" + name.replace("_", "-"))
        if isinstance(value, (list, tuple, _numpy.ndarray)):
            words.append(",".join(str(one) for one in value))
        elif value is not True:
            words.append(str(value))
    return words


def _run(program, words):
    try:
        done = _subprocess.run([program, *words], stdout=_subprocess.PIPE, stderr=_subprocess.PIPE, universal_newlines=True)
    except OSError as problem:
        raise ValueError(f"{program} cannot be run: {problem.strerror}; give program=, or put the folder of the programs on PATH") from None
    if done.returncode != 0:
        said = (done.stderr or done.stdout).strip().splitlines()
        raise ValueError(said[-1] if said else f"{program} ended with {done.returncode}")
    return done.stdout


def read_table(path):
    """Reads a CSV file of `hapton bench --out`, `hapton loop --csv`, `hapton replay --out` or `hapton session export`. Returns a dict with an
    array for each column. Columns of numbers are float64, with NaN for empty cells; others are text. Lines that begin with # are left out."""
    with open(path, newline="") as file:
        rows = list(_csv.reader(line for line in file if not line.startswith("#")))
    if not rows:
        raise ValueError(f"{path}: has no header")
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(rows[0]):
            raise ValueError(f"{path}: row {number} has {len(row)} cells and the header {len(rows[0])}")
    return {name: _to_array([row[k] for row in rows[1:]]) for k, name in enumerate(rows[0])}


def run_loop(name, program="hapton", **flags):
    """Runs `hapton loop NAME` (zwidth, press, recommend, integrators, velocity) and returns its JSON results as a dict. A list of rows becomes a
    dict of arrays; the names of inner objects are joined by _. Keywords are its flags: run_loop("zwidth", device="touch", delay="0:100:101").
    For press, result["samples"] has an array for each column of its CSV. For zwidth all values are arrays, with one element for each cell."""
    with _tempfile.TemporaryDirectory() as folder:
        words = ["loop", name, "--json", *_to_flags(flags)]
        samples = _os.path.join(folder, "press.csv")
        if name == "press":
            words += ["--csv", samples]
        told = _json.loads(_run(program, words))
        if name == "zwidth" and isinstance(told, dict):
            told = [told]
        result = _from_json(told)
        if name == "press":
            result["samples"] = read_table(samples)
        return result


def run_bench(name, program="hapton", **flags):
    """Runs `hapton bench NAME` (numbers, effects, objects, sixdof, pareto, haptons) and returns its tables: for each CSV file that it writes,
    a dict with an array for each column: run_bench("effects", steps=2000)["effects"]["mean_ns"]. Keywords are its flags. It may take minutes."""
    with _tempfile.TemporaryDirectory() as folder:
        _run(program, ["bench", name, "--out", folder, *_to_flags(flags)])
        return {_os.path.splitext(_os.path.basename(path))[0]: read_table(path) for path in sorted(_glob.glob(_os.path.join(folder, "*.csv")))}
