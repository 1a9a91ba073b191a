#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What would another value of a constant change? For docs/thresholds.md.

bench/half_and_twice.py [--tree DIR] [--factors 0.5,2] [--diagnose] [--jobs N]
                        FILE:NAME... [--on RECORDING...]

FILE:NAME is a constant: calibration/trust/trust.cpp:kFieldResidualNo. A copy of the sources (DIR, by
default build-half) gets all constants of the list as variables, which the environment multiplies:
MAGIMU_TIMES_kFieldResidualNo=0.5. So the program is built once for all constants and all factors,
and only files with a constant are compiled anew. The normal build knows nothing of it.

Then `calibrate` (with --diagnose `diagnose`) runs on every recording, without --on on 40 simulated
ones, with each constant at each factor. A row of the table that is printed says in how many
recordings the outcome is another one, and in which way: the verdict, its reasons without their
numbers, the status of checks; with --diagnose the answer and the names that are found. Numbers do
not count.

A constant that must be known to the compiler (the size of an array, an integer of a template) does
not compile as a variable: the build's message names it, and it has to leave the list.
"""

import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
HEADER = "settable.h"
SETTABLE = """// Written by bench/half_and_twice.py into a copy of the sources.
#pragma once
#include <cstdlib>
#include <string>
template <class Number>
Number settable(const char* name, Number value) {
  const char* const times = std::getenv((std::string("MAGIMU_TIMES_") + name).c_str());
  return times == nullptr ? value : Number(double(value) * std::atof(times));
}
"""
EFFECTS = ("none", "gyro_bias_drift", "mag_lag", "acc_scale_misalignment", "hard_iron_change",
           "field_gradient", "gyro_scale_misalignment", "outliers")


def copy_sources(tree):
    """Files that differ, so that the rest is not compiled again."""
    names = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, check=True,
                           capture_output=True, text=True).stdout.split("\n")
    for name in names:
        source, target = ROOT / name, tree / name
        if not source.is_file():
            continue
        content = source.read_bytes()
        if target.is_file() and target.read_bytes() == content:
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
        target.chmod(source.stat().st_mode)


def make_settable(text, names):
    """The source with these constants as variables."""
    for statement in re.findall(r"(?:inline |static )*constexpr (?:double|float|int|long) k[^;]*;", text):
        own = [name for name in names if re.search(rf"\b{name}\s*=", statement)]
        if not own:
            continue
        changed = statement.replace("constexpr ", "const ", 1)
        kind = re.search(r"constexpr (\w+)", statement)[1]
        parts = re.split(r",(?![^({]*[)}])", changed)
        for i, part in enumerate(parts):
            found = re.search(r"\b(k\w+)(\s*=\s*)(.*?)(;?)\s*$", part, re.S)
            if found and found[1] in own:
                parts[i] = part[:found.start()] + \
                    f"{found[1]} = settable<{kind}>(\"{found[1]}\", {found[3]}){found[4]}"
                names.remove(found[1])
        text = text.replace(statement, ",".join(parts), 1)
    return f'#include "{HEADER}"\n' + text


def build(tree, constants, jobs):
    copy_sources(tree)
    (tree / HEADER).write_text(SETTABLE)
    by_file = collections.defaultdict(list)
    for file, name in constants:
        by_file[file].append(name)
    for file, names in by_file.items():
        target = tree / file
        text = target.read_text()
        # A header's #pragma once stays the first directive.
        left = list(names)
        target.write_text(make_settable(text, left))
        for name in left:
            sys.exit(f"{file} has no number {name} that can be set")
    subprocess.run(["cmake", "-S", tree, "-B", tree / "build", "-G", "Ninja",
                    "-DMAGIMU_BUILD_BENCH=OFF"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["ninja", "-C", tree / "build", "-j", str(jobs), "magimu"], check=True,
                   stdout=sys.stderr)
    # As they were, so that the next list begins with the sources.
    for file in by_file:
        (tree / file).write_bytes((ROOT / file).read_bytes())
    return tree / "build/magimu"


def simulated(program, folder):
    out = []
    for k in range(40):
        path = folder / f"{k}.csv"
        effect = EFFECTS[k // 2 % len(EFFECTS)]
        subprocess.run([program, "simulate", "-q", "-o", path, "--seed", str(7100 + k), "--rate", "50",
                        "--duration", str(30 + 15 * (k % 3)), "--rest", str(3 * (k % 2)),
                        "--motion", "hand_held" if k % 2 or effect == "field_gradient" else "hand",
                        *(() if effect == "none" else ("--effect", effect))], check=True)
        out.append(path)
    return out


def without_numbers(sentence):
    return re.sub(r"[-+]?\d[\d.e+-]*", "#", sentence)


def outcome(program, recording, constant, factor, diagnose):
    """What a user is told, in a form that compares."""
    environment = dict(os.environ)
    if constant:
        environment["MAGIMU_TIMES_" + constant] = str(factor)
    command = [program, "diagnose" if diagnose else "calibrate", recording, "--json", "-q", "--threads", "1"]
    run = subprocess.run(command, env=environment, capture_output=True, text=True)
    try:
        file = json.loads(run.stdout)
    except json.JSONDecodeError:
        return {"refused": without_numbers(run.stderr.strip().split("\n")[-1])}
    c = file.get("calibration_after", file)
    out = {"verdict": c["trust"]["verdict"],
           "reasons": sorted(without_numbers(r) for r in c["trust"]["reasons"]),
           "checks": sorted(f"{x['name']} {x['status']}" for x in c["checks"]), "motion": c["motion"]}
    if diagnose:
        out["answer"] = file["answer"]
        out["found"] = sorted(f["effect"] for f in file["findings"])
    return out


def difference(before, after):
    """The field that says most about it, in words."""
    for field in ("refused", "answer", "verdict", "found", "motion", "checks", "reasons"):
        a, b = before.get(field), after.get(field)
        if a == b:
            continue
        if field in ("verdict", "answer", "motion"):
            return f"{a} -> {b}"
        if field == "refused":
            return "refused" if b else "no longer refused"
        if field == "reasons":
            return "other reasons"
        gone, new = set(a or []) - set(b or []), set(b or []) - set(a or [])
        return " ".join([f"-{x}" for x in sorted(gone)] + [f"+{x}" for x in sorted(new)])
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("constants", nargs="+", metavar="FILE:NAME")
    parser.add_argument("--on", nargs="+", metavar="RECORDING")
    parser.add_argument("--tree", default=ROOT / "build-half", type=pathlib.Path)
    parser.add_argument("--factors", default="0.5,2")
    parser.add_argument("--diagnose", action="store_true")
    parser.add_argument("--jobs", default=os.cpu_count(), type=int)
    arguments = parser.parse_args()
    constants = [tuple(c.split(":")) for c in arguments.constants]
    factors = [float(f) for f in arguments.factors.split(",")]
    program = build(arguments.tree.resolve(), constants, arguments.jobs)
    with tempfile.TemporaryDirectory() as folder, \
            concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        recordings = [pathlib.Path(r).resolve() for r in arguments.on or []] or \
            simulated(program, pathlib.Path(folder))

        def all_of(constant, factor):
            return list(pool.map(lambda r: outcome(program, r, constant, factor, arguments.diagnose),
                                 recordings))

        usual = all_of("", 1.0)
        print("usual outcomes: " + ", ".join(
            f"{n} {key}" for key, n in collections.Counter(
                o.get("answer", o.get("verdict", "refused")) for o in usual).most_common()))
        print("| constant | " + " | ".join(f"times {f:g}" for f in factors) + " |")
        print("|---|" + "---|" * len(factors))
        for file, name in constants:
            cells = []
            for factor in factors:
                found = [difference(a, b) for a, b in zip(usual, all_of(name, factor))]
                ways = collections.Counter(d for d in found if d)
                cells.append("; ".join(f"{n} {way}" for way, n in ways.most_common(4)) or "none")
            print(f"| `{name}` in `{file}` | " + " | ".join(cells) + " |", flush=True)
        print(f"({len(recordings)} recordings)")


if __name__ == "__main__":
    main()
