"""Makes small HDF5 files as other programs write them, packed with gzip.

    python3 hdf5_files.py FOLDER

Needs h5py (3.16 with HDF5 2.0.0 made the files that are kept) and numpy. The numbers are made up.

    h5py.h5.gz       the oldest structure, which h5py writes by default: groups, links, chunks, texts, complex numbers
    matlab73.mat.gz  what MATLAB 7.3 writes: columns first, characters, cells, structures, empty arrays
    links.h5.gz      groups of the oldest structure with soft links; two have external links, too, or many links
    newer.h5.gz      what needs a newer reader: data layout 5, chunks in a version 2 B-tree, the complex datatype
"""

import gzip
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np


def h5py_file(path):
    with h5py.File(path, "w", libver=("earliest", "v108")) as f:
        f["x"] = np.linspace(0, 1, 5)
        f["big"] = np.arange(6, dtype=">f4").reshape(2, 3)
        f["half"] = np.array([1.5, -0.25, 65504], dtype="<f2")
        f["long"] = np.array([0.5, -3], dtype=np.longdouble)
        f["i16"] = np.array([-2, 300], dtype=">i2")
        f["flag"] = np.array([True, False])
        f["one"] = 2.5
        f["text"] = "12:+Z"
        f["fixed"] = np.array([b"ab", b"cdef"])
        f.create_dataset("texts", data=["m/s\u00b2", "", "long"], dtype=h5py.string_dtype())
        f["complex"] = np.array([1 + 2j, 3 - 4j])
        f["none"] = h5py.Empty("f8")
        g = f.create_group("run")
        y = np.sin(np.arange(200)).astype("f4").reshape(20, 10)
        g.create_dataset("chunks", data=y, chunks=(7, 4), compression="gzip", shuffle=True, fletcher32=True)
        g.create_dataset("lzf", data=np.arange(100), chunks=(64,), compression="lzf")
        g.create_dataset("filled", shape=(10,), chunks=(4,), fillvalue=7.0, dtype="f8")
        g["soft"] = h5py.SoftLink("/x")
        g["away"] = h5py.ExternalLink("other.h5", "/x")
        g["loop"] = f["run"]
        g.create_dataset("table", data=np.zeros(2, dtype=[("t", "f8"), ("n", "i4")]))


def links_file(path):
    with h5py.File(path, "w", libver=("earliest", "v108")) as f:
        f["freq"] = np.linspace(5, 40, 5)
        f["H"] = np.array([1 + 2j, 3 - 4j])
        f["latest"] = h5py.SoftLink("/H")
        f["gone"] = h5py.SoftLink("/nothing")
        f["self"] = h5py.SoftLink("self")
        f["here"] = h5py.SoftLink("/run")
        run = f.create_group("run")
        run["y"] = np.arange(3.0)
        run["again"] = h5py.SoftLink("y")
        run["twice"] = h5py.SoftLink("/latest")
        run["up"] = h5py.SoftLink("/")
        run.create_group("inner")["through"] = h5py.SoftLink("/here/again")
        # An external link makes the group one of the next structure.
        away = f.create_group("away")
        away["z"] = np.arange(2.0)
        away["other"] = h5py.ExternalLink("other.h5", "/x/y")
        away["near"] = h5py.SoftLink("../away/z")
        away["soft"] = h5py.SoftLink("z")
        # Many links of a group that keeps their order are in a heap.
        many = f.create_group("many", track_order=True)
        many["first"] = np.arange(4.0)
        for number in range(120):
            many[f"soft{number:03}"] = h5py.SoftLink("first" if number % 40 else "gone")


def matlab_file(path):
    with h5py.File(path, "w", libver=("earliest", "v108"), userblock_size=512) as f:
        refs = f.create_group("#refs#")

        def put(group, name, data, kind, **attributes):
            dataset = group.create_dataset(name, data=data)
            dataset.attrs["MATLAB_class"] = np.bytes_(kind)
            for key, value in attributes.items():
                dataset.attrs[key] = value
            return dataset

        def codes(text):
            return np.array([[ord(c)] for c in text], dtype="u2")

        a = np.array([[1.0, 2, 3], [4, 5, 6]])
        put(f, "a", a.T, "double")
        z = np.zeros((2, 1), dtype=[("real", "f8"), ("imag", "f8")])
        z["real"], z["imag"] = [[1], [3]], [[2], [-4]]
        put(f, "z", z, "double")
        put(f, "text", codes("m/s\u00b2"), "char", MATLAB_int_decode=np.int32(2))
        put(f, "rows", np.array([[97, 99], [98, 100]], dtype="u2"), "char", MATLAB_int_decode=np.int32(2))
        put(f, "flag", np.array([[1]], dtype="u1"), "logical", MATLAB_int_decode=np.int32(1))
        put(f, "empty", np.array([0, 3], dtype="u8"), "double", MATLAB_empty=np.uint8(1))
        s = f.create_group("s")
        s.attrs["MATLAB_class"] = np.bytes_("struct")
        put(s, "fs", np.array([[51200.0]]), "double")
        put(s, "H", a.T.astype("f4"), "single")
        first = put(refs, "b", codes("1:+Z"), "char", MATLAB_int_decode=np.int32(2))
        second = put(refs, "c", np.array([[7.0]]), "double")
        cells = np.array([[first.ref], [second.ref]], dtype=h5py.ref_dtype)
        cell = f.create_dataset("c", data=cells, dtype=h5py.ref_dtype)
        cell.attrs["MATLAB_class"] = np.bytes_("cell")
    header = b"MATLAB 7.3 MAT-file, Platform: made by a script".ljust(124) + b"\x00\x02IM"
    with open(path, "r+b") as f:
        f.write(header)


def newer_file(path):
    y = np.arange(60.0).reshape(6, 10)
    with h5py.File(path, "w", libver=("v114", "v114")) as f:
        f["plain"] = np.arange(3.0)
        f.create_dataset("btree2", data=y, chunks=(4, 4), compression="gzip", maxshape=(None, None))
    with h5py.File(path, "r+", libver="latest") as f:
        f.create_dataset("layout5", data=y, chunks=(4, 4), compression="gzip")
        space = h5py.h5s.create_simple((2,))
        native = h5py.h5d.create(f.id, b"native", h5py.h5t.COMPLEX_IEEE_F64LE, space)
        native.write(h5py.h5s.ALL, h5py.h5s.ALL, np.array([1 + 2j, 3 - 4j]), mtype=h5py.h5t.COMPLEX_IEEE_F64LE)


if __name__ == "__main__":
    files = {"h5py.h5": h5py_file, "links.h5": links_file, "matlab73.mat": matlab_file, "newer.h5": newer_file}
    for name, make in files.items():
        with tempfile.TemporaryDirectory() as scratch:
            make(Path(scratch) / name)
            packed = gzip.compress((Path(scratch) / name).read_bytes(), mtime=0)
        (Path(sys.argv[1]) / (name + ".gz")).write_bytes(packed)
