"""Small logs written by scipy and pyuff, for tests/signal/log_formats.rs.

Run: python3 tools/log_formats.py > data/reference/log_formats.json
Files are hexadecimal; beside each stand the numbers it was written from, as text, since not every reader of JSON rounds
numbers to the last bit.
"""

import io
import json
import os
import struct
import tempfile

import numpy as np
import pyuff
import scipy
import scipy.io
from scipy.io.matlab import MatlabObject


def mat(variables, **options):
    file = io.BytesIO()
    scipy.io.savemat(file, variables, **options)
    data = bytearray(file.getvalue())
    if data.startswith(b"MATLAB"):
        data[:116] = b"MATLAB 5.0 MAT-file, scipy".ljust(116)  # without the date
    return data.hex()


def big_endian():
    """A file of the other byte order, which scipy does not write: `x` of 5 numbers, `dt`."""

    def element(kind, data):
        return struct.pack(">II", kind, len(data)) + data + bytes(-len(data) % 8)

    def array(name, values):
        flags = element(6, struct.pack(">II", 6, 0))
        size = element(5, struct.pack(">ii", len(values), 1))
        numbers = element(9, struct.pack(f">{len(values)}d", *values))
        return element(14, flags + size + element(1, name) + numbers)

    head = b"MATLAB 5.0 MAT-file, big-endian".ljust(116) + bytes(8) + b"\x01\x00" + b"MI"
    x = [float(k) ** 0.5 for k in range(9)]
    return (head + array(b"x", x) + array(b"dt", [0.004])).hex(), x


def uff(sets):
    folder = tempfile.mkdtemp()
    path = os.path.join(folder, "a.uff")
    pyuff.UFF(path).write_sets(sets, "add")
    with open(path, "rb") as file:
        return file.read().hex()


def exact(values):
    return " ".join(repr(float(v)) for v in np.asarray(values))


rng = np.random.default_rng(58)
t = np.arange(12) / 400.0
whole = rng.integers(0, 100, 12)
classes = {"t": t}
for name in ["int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64"]:
    classes["c_" + name] = whole.astype(name)
run = rng.normal(size=12)
f = 2.5 * np.arange(1, 11)
h = rng.normal(size=(10, 2)) + 1j * rng.normal(size=(10, 2))
coherence = rng.uniform(size=(10, 2))
big, big_x = big_endian()


def time_set(binary, x, data, double=True):
    return pyuff.prepare_58(
        binary=binary, func_type=1, rsp_node=3, rsp_dir=-2, ref_node=0, ref_dir=0, data=data, x=x,
        id1="id 1", id2="NONE", id3="01-Jan-24 12:00:00", id4="NONE", id5="NONE", rsp_ent_name="NONE",
        abscissa_spacing=1, abscissa_min=x[0], abscissa_inc=x[1] - x[0], ord_data_type=4 if double else 2,
        abscissa_spec_data_type=17, ordinate_spec_data_type=12, abscissa_axis_units_lab="s",
        ordinate_axis_units_lab="m/s^2", orddenom_spec_data_type=0, orddenom_axis_units_lab="NONE",
    )


def frf_set(binary, x, data, node):
    return pyuff.prepare_58(
        binary=binary, func_type=4, rsp_node=node, rsp_dir=3, ref_node=1, ref_dir=3, data=data, x=x,
        id1="NONE", id2="NONE", id3="NONE", id4="NONE", id5="NONE", rsp_ent_name="NONE", ref_ent_name="NONE",
        abscissa_spacing=1, abscissa_min=x[0], abscissa_inc=x[1] - x[0], ord_data_type=6,
        abscissa_spec_data_type=18, ordinate_spec_data_type=12, abscissa_axis_units_lab="Hz",
        ordinate_axis_units_lab="m/s^2", orddenom_spec_data_type=13, orddenom_axis_units_lab="N",
    )


def geometry_sets(kind):
    """Nodes 1, 7, 8 (data set 15 or 2411), a trace line 1-7-8 with a second part 8-1, and a response at 7+z and 8+z."""
    x, y, z = ([0.0, 0.1, 1.0 / 3.0], [0.0, -2.5e-3, 0.0], [0.0, 1e-7, -4.0])
    prepare = {15: pyuff.prepare_15, 2411: pyuff.prepare_2411}[kind]
    numbers = dict(node_nums=[1, 7, 8], def_cs=[0, 0, 0], disp_cs=[0, 0, 0], color=[8, 8, 8])
    values = dict(zip("xyz", (np.array(v) for v in (x, y, z))))
    trace = pyuff.prepare_82(trace_num=1, n_nodes=6, color=0, id="beam", nodes=np.array([1, 7, 8, 0, 8, 1]))
    return [prepare(**numbers, **values), trace, frf_set(0, f, h[:, 0], 7), frf_set(0, f, h[:, 1], 8)]


# Times and lines that the six digits of a UFF header hold.
signal = rng.normal(size=13)
time = np.arange(13) * 0.0025
document = {
    "made_by": f"tools/log_formats.py with scipy {scipy.__version__}, pyuff {pyuff.__version__}, numpy {np.__version__}",
    "mat_classes": mat(classes, do_compression=False),
    "mat_classes_compressed": mat(classes, do_compression=True),
    "classes": exact(whole),
    "mat_struct": mat({"run": {"time": t, "data": run, "note": "second gear"}, "cells": np.array([run, 2 * run], dtype=object)}),
    "run": exact(run),
    "mat_frf": mat({"freq": f, "H": h, "coh_H": coherence}, do_compression=True),
    "h_re": [exact(c) for c in h.real.T],
    "h_im": [exact(c) for c in h.imag.T],
    "coherence": [exact(c) for c in coherence.T],
    "mat_big_endian": big, "big_x": exact(big_x),
    "mat_level_4": mat({"x": run, "dt": 0.1}, format="4"),
    "mat_object": mat({"o": MatlabObject(np.array([(1.0,)], dtype=[("a", object)]), "gearbox")}),
    "uff_time_text": uff([time_set(0, time, signal)]),
    "uff_time_binary": uff([time_set(1, time, signal)]),
    "signal": exact(signal),
    "uff_frf_text": uff([frf_set(0, f, h[:, 0], 7), frf_set(0, f, h[:, 1], 8)]),
    "uff_frf_binary": uff([frf_set(1, f, h[:, 0], 7), frf_set(1, f, h[:, 1], 8)]),
    "uff_geometry_15": uff(geometry_sets(15)),
    "uff_geometry_2411": uff(geometry_sets(2411)),
}
print(json.dumps(document, indent=0))
