"""Answers of two builds on every shipped file, number by number.

    python3 tools/compare_answers.py OLD NEW [--renamed old=new ...]

OLD and NEW are `geardyn` programs. Numbers may differ by 1e-12 of their size, texts and shapes not at all. Run times and
versions are passed over. Keys of the old documents that were renamed are named by --renamed. Differences are counted by
key, the largest of each is printed; the exit code is 1 where an answer differs.
"""

import argparse
import json
import math
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TOLERANCE = 1e-12
PASSED_OVER = {"version", "time_s", "run_time_s"}

LOGS = [
    "identify data/spindle_impact.csv --input force --output ax,ay",
    "spectrum data/spindle_cutting.csv",
    "check data/spindle_impact.csv",
    "check data/y2250_te.csv",
    "te data/y2250_te.csv --input index_gear_1 --output work_spindle --teeth 30:37,54:36,1:90",
    "measure data/index_gear.toml",
    "gear reverse data/unknown_gear.toml",
    "gear cut models/gears/bevel_12_36.toml",
    "gear correct models/gears/bevel_12_36.toml --measured data/bevel_12_36_grid.csv",
    "gear models/gears/bevel_12_36.toml --torque 300",
    "gear models/gears/helical.toml --torques 50:400:8",
    "response models/y2250.toml --run-up 100:1500",
]


def commands():
    """One line of arguments for each answer, in a fixed order."""
    for path in sorted(ROOT.glob("models/*.toml")):
        model = path.relative_to(ROOT)
        yield from (f"check {model}", f"modes {model}", f"modes {model} --damped", f"te {model}", f"stability {model}")
    for path in sorted(ROOT.glob("models/gears/*.toml")):
        yield f"gear {path.relative_to(ROOT)}"
    for path in sorted(ROOT.glob("examples/*.toml")):
        yield f"simulate {path.relative_to(ROOT)} --no-sensitivity"
        yield f"te {path.relative_to(ROOT)}"
    yield from LOGS


def answer(program, arguments):
    """Exit code and document; None where the command has none in 60 s."""
    try:
        run = subprocess.run(
            [program, *arguments.split(), "--json"], cwd=ROOT, capture_output=True, text=True, timeout=60
        )
    except subprocess.TimeoutExpired:
        return None
    return run.returncode, json.loads(run.stdout) if run.stdout else None


def differences(old, new, key, renamed):
    """Pairs of a key and the size of its difference; infinite where a text or a shape differs."""
    if isinstance(old, dict) and isinstance(new, dict):
        old = {renamed.get(name, name): value for name, value in old.items()}
        for name in (old.keys() | new.keys()) - PASSED_OVER:
            if name in old and name in new:
                yield from differences(old[name], new[name], f"{key}.{name}", renamed)
            else:
                yield f"{key}.{name}", math.inf
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for one, other in zip(old, new):
            yield from differences(one, other, f"{key}[]", renamed)
    elif isinstance(old, float) and isinstance(new, (float, int)):
        size = abs(old - new) / max(abs(old), abs(new), 1e-300)
        if size > TOLERANCE:
            yield key, size
    elif old != new:
        yield key, math.inf


def main():
    reader = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    reader.add_argument("old")
    reader.add_argument("new")
    reader.add_argument("--renamed", nargs="*", default=[], metavar="OLD=NEW")
    given = reader.parse_args()
    renamed = dict(pair.split("=") for pair in given.renamed)
    programs = [str(pathlib.Path(program).resolve()) for program in (given.old, given.new)]
    count = different = 0
    for arguments in commands():
        count += 1
        old, new = (answer(program, arguments) for program in programs)
        if old is None or new is None:
            print(f"{arguments}: no answer in 60 s")
            different += 1
            continue
        worst = {}
        for key, size in differences(list(old), list(new), "", renamed):
            times, largest = worst.get(key, (0, 0.0))
            worst[key] = times + 1, max(size, largest)
        different += bool(worst)
        for key, (times, largest) in sorted(worst.items()):
            print(f"{arguments}: {key.removeprefix('[]')}: {times} times, at most {largest:.1e}")
    print(f"{different} of {count} answers differ")
    sys.exit(different > 0)


if __name__ == "__main__":
    main()
