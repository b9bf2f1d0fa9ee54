"""What other programs read from files that modalign writes.

Run from the project's folder, after `cargo build --release`:

    python3 tests/reference/exchange.py target/release/modalign > tests/reference/exchange.txt

It writes tests/reference/exchange.uff (a universal file as text, made from the formulas below: no measurement), lets
`modalign convert` write it in every format, opens each file with the programs named in the output and compares every
number with the formulas. A line of the output is the SHA-256 of a file, its name, who opened it and what was compared;
the suite writes the same files again and holds their fingerprints against these lines.
"""

import hashlib
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy
import pandas
import pyuff
import scipy
import scipy.io

HERE = Path(__file__).parent
SOURCE = HERE / "exchange.uff"

SAMPLES, LINES, UNEVEN = 16, 9, 5
NODES = {1: (0.0, 0.0, 0.0), 2: (0.25, 0.0, 0.5), 7: (-1.5, 0.125, 0.0)}
TRACE = [1, 2, 0, 2, 7]
MODES = [
    (-1.5 + 62.5j, {1: (1.0, 0.5j, 0.25 - 0.5j), 2: (-0.5, 2.0, 0.0), 7: (0.125j, -1.0, 0.75)}),
    (-2.0 + 125.0j, {1: (-1.0, 0.25, 0.5), 2: (0.5 + 0.5j, 1.0, 0.25), 7: (1.0, -0.75j, 2.0)}),
]


def force(i):
    return ((i * 37) % 101 - 50) / 32


def response(i):
    return ((i * 53) % 97 - 48) / 16


def frf(point, k):
    return complex(((k * 29 + point) % 89 - 44) / 64, ((k * 31 + 5 * point) % 83 - 41) / 128)


def coherence(k):
    return 1 - ((k * 7) % 16) / 32


def uneven(i):
    return i * i / 8, response(i + 3)


def e13(value):
    return f"{value:13.5E}"


def e20(value):
    return f"{value:20.12E}"


def rows(fields, count):
    return ["".join(fields[i : i + count]) for i in range(0, len(fields), count)]


def dataset(number, lines):
    return ["    -1", f"{number:6d}", *lines, "    -1"]


def axis_record(code, label, unit):
    return f"{code:10d}    0    0    0 {label:<20} {unit:<20}"


def function(kind, data_type, points, even, start, step, at, by, abscissa, above, below, fields):
    names = f" {'NONE':<10}{at[0]:10d}{at[1]:4d} {'NONE':<10}{by[0]:10d}{by[1]:4d}"
    head = [
        "exchange",
        "NONE",
        "NONE",
        "NONE",
        "NONE",
        f"{kind:5d}{0:10d}{1:5d}{1:10d}{names}",
        f"{data_type:10d}{points:10d}{even:10d}{e13(start)}{e13(step)}{e13(0.0)}",
        axis_record(*abscissa),
        axis_record(*above),
        axis_record(*below),
        axis_record(0, "NONE", "NONE"),
    ]
    return dataset(58, head + fields)


def mode(number, pole, shape):
    head = [
        "exchange",
        "NONE",
        "NONE",
        f"MODE NO. {number}",
        "NONE",
        f"{1:10d}{3:10d}{2:10d}{8:10d}{5:10d}{3:10d}",
        f"{2:10d}{6:10d}{1:10d}{number:10d}",
        "".join(map(e13, [pole.real, pole.imag, 1.0, 0.0, 0.0, 0.0])),
    ]
    for node, values in shape.items():
        parts = [part for value in values for part in (complex(value).real, complex(value).imag)]
        head += [f"{node:10d}", "".join(map(e13, parts))]
    return dataset(55, head)


def universal_file():
    time, hertz, none = (17, "Time", "s"), (18, "Frequency", "Hz"), (0, "NONE", "NONE")
    newton, acceleration = (13, "Excitation force", "N"), (12, "Acceleration", "m/s2")
    one = "  1.00000000000000000D+00"
    lines = dataset(151, ["exchange", "NONE", "NONE", "", "", "NONE", ""])
    lines += dataset(164, [f"{1:10d}{'SI: Meter (newton)':<20}{2:10d}", one * 3, "  2.73149999999999977D+02"])
    nodes = []
    for label, at in NODES.items():
        nodes += [f"{label:10d}{0:10d}{0:10d}{8:10d}", "".join(f"{x:25.16E}" for x in at)]
    lines += dataset(2411, nodes)
    lines += dataset(82, [f"{1:10d}{len(TRACE):10d}{0:10d}", "outline", "".join(f"{n:10d}" for n in TRACE)])
    even = (1, 0.0, 1 / 64)
    fields = rows([e13(force(i)) for i in range(SAMPLES)], 6)
    lines += function(1, 2, SAMPLES, *even, (1, 3), (0, 0), time, newton, none, fields)
    fields = rows([e13(response(i)) for i in range(SAMPLES)], 6)
    lines += function(1, 2, SAMPLES, *even, (2, -1), (1, 3), time, acceleration, none, fields)
    for point in (2, 7):
        parts = [part for k in range(LINES) for part in (frf(point, k).real, frf(point, k).imag)]
        fields = rows(list(map(e20, parts)), 4)
        lines += function(4, 6, LINES, 1, 0.0, 0.5, (point, 1), (1, 3), hertz, acceleration, newton, fields)
    fields = rows([e20(coherence(k)) for k in range(LINES)], 4)
    lines += function(6, 4, LINES, 1, 0.0, 0.5, (2, 1), (1, 3), hertz, none, none, fields)
    pairs = [text for i in range(UNEVEN) for text in (e13(uneven(i)[0]), e13(uneven(i)[1]))]
    lines += function(1, 2, UNEVEN, 0, 0.0, 0.0, (7, 3), (0, 0), time, acceleration, none, rows(pairs, 6))
    for number, (pole, shape) in enumerate(MODES, 1):
        lines += mode(number, pole, shape)
    return "\n".join(lines) + "\n"


TIME = [[force(i) for i in range(SAMPLES)], [response(i) for i in range(SAMPLES)]]
FRF = numpy.array([[frf(point, k) for k in range(LINES)] for point in (2, 7)])
COHERENCE = numpy.array([coherence(k) for k in range(LINES)])


def equal(got, expected, what):
    got, expected = numpy.asarray(got), numpy.asarray(expected)
    if got.shape != expected.shape or not (got == expected).all():
        raise SystemExit(f"{what}: got {got}, expected {expected}")


def near(got, expected, what):
    got, expected = numpy.asarray(got), numpy.asarray(expected)
    if got.shape != expected.shape or not numpy.allclose(got, expected, rtol=1e-5, atol=1e-30):
        raise SystemExit(f"{what}: got {got}, expected {expected}")


def with_pyuff(path):
    sets = [one for one in pyuff.UFF(str(path)).read_sets() if "type" in one]
    functions = [one for one in sets if one["type"] == 58]
    time = [one for one in functions if one["func_type"] == 1]
    for one, expected in zip(time, TIME):
        equal(one["data"], expected, "time record")
    equal(time[2]["x"], [uneven(i)[0] for i in range(UNEVEN)], "uneven abscissa")
    equal(time[2]["data"], [uneven(i)[1] for i in range(UNEVEN)], "uneven record")
    frfs = [one for one in functions if one["func_type"] == 4]
    for one, expected in zip(frfs, FRF, strict=True):
        equal(one["data"], expected, "FRF")
        equal(one["x"], [0.5 * k for k in range(LINES)], "frequency")
        equal([one["rsp_dir"], one["ref_node"], one["ref_dir"]], [1, 1, 3], "degrees of freedom")
    equal([one["data"] for one in functions if one["func_type"] == 6], [COHERENCE], "coherence")
    nodes = [one for one in sets if one["type"] in (15, 2411)]
    equal([one["node_nums"] for one in nodes], [list(NODES)], "nodes")
    equal(numpy.array([nodes[0]["x"], nodes[0]["y"], nodes[0]["z"]]).T, list(NODES.values()), "positions")
    lines = [one for one in sets if one["type"] == 82]
    equal([one["nodes"] for one in lines], [TRACE], "trace line")
    return check_pyuff_modes(sets) + ", 3 time records, 2 FRFs, coherence, nodes, trace line"


def check_pyuff_modes(sets):
    modes = [one for one in sets if one["type"] == 55]
    for one, (pole, shape) in zip(modes, MODES, strict=True):
        near(one["eig"], pole, "pole")
        equal(one["node_nums"], list(shape), "nodes of a mode")
        for index, key in enumerate(("r1", "r2", "r3")):
            equal(one[key], [values[index] for values in shape.values()], "shape")
    return f"{len(modes)} modes"


def plain(value):
    if isinstance(value, numpy.ndarray):  # scipy reads an empty text as an empty array
        return "".join(value)
    return value.decode() if isinstance(value, bytes) else str(value)


def texts(values):
    return [plain(value) for value in numpy.ravel(values)]


def check_layout(array, name):
    """The arrays of the modalign layout, by name."""
    equal(array("time/values"), TIME, f"{name} time")
    equal(array("frf/re") + 1j * array("frf/im"), FRF, f"{name} FRF")
    equal(array("coherence/values"), [COHERENCE], f"{name} coherence")
    equal(numpy.ravel(array("frf/frequency_hz")), [0.5 * k for k in range(LINES)], f"{name} frequency")
    equal(texts(array("frf/response")), ["2:+X", "7:+X"], f"{name} response")
    equal(texts(array("time/reference")), ["", "1:+Z"], f"{name} reference")
    near(numpy.ravel(array("modes/frequency_hz")), [abs(pole) / 2 / numpy.pi for pole, _ in MODES], f"{name} modes")
    dofs = texts(array("modes/dof"))
    shapes = array("modes/shape_re") + 1j * array("modes/shape_im")
    for row, (_, shape) in zip(shapes, MODES, strict=True):
        wanted = [shape[int(dof[:-3])]["XYZ".index(dof[-1])] for dof in dofs]
        equal(row, wanted, f"{name} shape")
    equal(array("geometry/at_m"), list(NODES.values()), f"{name} nodes")
    return "time, frf, coherence, modes, geometry"


def with_h5py(path):
    with h5py.File(path) as file:
        return check_layout(lambda name: file[name][()], "h5py")


def with_scipy(path):
    file = scipy.io.loadmat(path, simplify_cells=True)

    def array(name):
        group, key = name.split("/")
        return file[group][key]

    def shaped(name):
        value = array(name)
        two = name in ("coherence/values",)
        return numpy.atleast_2d(value) if two else value

    return check_layout(shaped, "scipy.io")


def with_numpy(path):
    file = numpy.load(path)
    return check_layout(lambda name: file[name], "numpy")


def with_pandas(path):
    table = pandas.read_csv(path)
    for column, expected in zip(table.columns[1:], TIME):
        equal(table[column], expected, f"column {column}")
    return ", ".join(table.columns)


def main():
    program = sys.argv[1]
    SOURCE.write_text(universal_file())
    versions = f"pyuff {pyuff.__version__}, h5py {h5py.__version__}, scipy {scipy.__version__}, numpy {numpy.__version__}, pandas {pandas.__version__}"
    print(f"# {versions}")
    with tempfile.TemporaryDirectory() as folder:
        for name, flags, check, who in [
            ("exchange.binary.uff", [], with_pyuff, "pyuff"),
            ("exchange.text.uff", ["--text"], with_pyuff, "pyuff"),
            ("exchange.h5", [], with_h5py, "h5py"),
            ("exchange.mat", [], with_scipy, "scipy.io"),
            ("exchange.npz", [], with_numpy, "numpy"),
            ("exchange.csv", [], with_pandas, "pandas"),
        ]:
            path = Path(folder) / name
            command = [program, "--quiet", "convert", str(SOURCE), "-o", str(path), *flags]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            compared = check(path)
            fingerprint = hashlib.sha256(path.read_bytes()).hexdigest()
            print(f"{fingerprint} {name} {who}: equal: {compared}")


main()
