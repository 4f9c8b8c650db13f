"""Instructions of thirteen commands, compared with those of the last renewal.

    python3 tools/work_counts.py            compares; exit code 1 where a command takes 3 % more
    python3 tools/work_counts.py --renew    writes benches/work_counts.csv

Counts are those of valgrind's callgrind on target/release/geardyn with one thread. They do not depend on the load of the
machine, but on the compiler and on the vector instructions of the processor: renew on the machine that compares.
"""

import csv
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TABLE = ROOT / "benches" / "work_counts.csv"
LIMIT = 1.03

COMMANDS = {
    "modes of 200 discs": "modes {chain_200}",
    "lowest 20 of 20 000 discs": "modes {chain_20000} --lowest 20",
    "damped modes": "modes models/y2250.toml --damped",
    "response of 1 000 lines": "response {chain_200} --input c.1 --output c.200 --band 0.001:0.5 --lines 1000",
    "simulate by exact": "simulate examples/linear_chain.toml --no-sensitivity",
    "simulate by switched": "simulate examples/geared_chain.toml --until 0.1 --no-sensitivity",
    "stability": "stability models/geared_damped.toml",
    "te of a machine": "te examples/y2250_te.toml",
    "te of encoder records": "te data/y2250_te.csv --input index_gear_1 --output work_spindle"
    " --teeth 30:37,54:36,1:90 --lines 10000,36000",
    "check of 200 000 rows": "check {log}",
    "identify": "identify data/spindle_impact.csv --input force --output ax,ay",
    "gear under load": "gear models/gears/helical.toml --torques 50:400:8",
    "bevel contact": "gear models/gears/bevel_12_36.toml",
}


def inputs(folder):
    """Files that are too large to ship, by name."""
    files = {"log": folder / "log.csv"}
    for count in (200, 20000):
        files[f"chain_{count}"] = folder / f"chain_{count}.toml"
        files[f"chain_{count}"].write_text(
            'title = "chain"\nsource = "counts of work"\nunits = "SI"\n'
            f'[[chain]]\nname = "c"\ncount = {count}\nJ = 1.0\nk = 1.0\nheld = "start"\ndamping_ratio = 0.01\n'
        )
    rows = (f"{1e-4 * i:.4f},{(i * 7919) % 2003 / 997:.6f},{(i * 104729) % 3001 / 89:.5f}" for i in range(200_000))
    files["log"].write_text("time [s],a [m/s²],f [N]\n" + "\n".join(rows) + "\n")
    return files


def count(arguments, folder):
    """Instructions of one command."""
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={folder}/out"]
    command += [str(ROOT / "target/release/geardyn"), *arguments, "--threads", "1"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    found = re.search(r"Collected : (\d+)", run.stderr)
    if run.returncode > 1 or not found:
        sys.exit(f"{' '.join(arguments)}: exit code {run.returncode}\n{run.stderr}")
    return int(found[1])


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        files = inputs(folder)
        now = {
            title: count([word.format(**files) for word in text.split()], folder)
            for title, text in COMMANDS.items()
        }
    if "--renew" in sys.argv:
        rows = [f"{title},{value / 1e6:.5g}\n" for title, value in now.items()]
        TABLE.write_text("command,million instructions\n" + "".join(rows))
        return
    before = {row[0]: float(row[1]) for row in list(csv.reader(TABLE.open()))[1:]}
    grown = False
    for title, value in now.items():
        ratio = value / 1e6 / before[title] if title in before else float("nan")
        grown |= ratio > LIMIT
        print(f"{title:28}{value / 1e6:12.1f}{ratio:8.3f}{'  more work' if ratio > LIMIT else ''}")
    sys.exit(grown)


if __name__ == "__main__":
    main()
