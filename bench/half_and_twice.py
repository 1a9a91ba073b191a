#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What would another value of a constant change? For docs/thresholds.md.

bench/half_and_twice.py [--tree DIR] [--factors 0.5,2] [--diagnose] [--jobs N]
                        [--recordings 40] [--seed 7100] FILE:NAME... [--on RECORDING...]

FILE:NAME is a constant: calibration/trust/trust.cpp:kFieldResidualNo. A copy of the sources (DIR, by
default build-half) gets all constants of the list as variables, which the environment multiplies:
MAGIMU_TIMES_calibration_trust_trust_cpp_kFieldResidualNo=0.5. So the program is built once for all
constants and all factors, and only files with a constant are compiled anew. The normal build knows
nothing of it. That program also tells which of the constants it has read (MAGIMU_READ=FILE).

Then `calibrate` (with --diagnose `diagnose`) runs on every recording, without --on on simulated
ones (--recordings of them, with seeds from --seed on), as it is; and with each constant at each
factor on those recordings where it was read. A row of the table that is printed says in how many
recordings it was read, and in how many the outcome is another one, and in which way: the verdict,
its reasons without their numbers, the status of checks; with --diagnose the answer and the names
that are found. Numbers do not count.

A constant that must be known to the compiler (the size of an array, an integer of a template) does
not compile as a variable: the build's message names it, and it has to leave the list. One within a
function cannot be set.
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
#include <cstdio>
#include <cstdlib>
#include <string>
template <class Number>
Number settable(const char* name, Number value) {
  const char* const times = std::getenv((std::string("MAGIMU_TIMES_") + name).c_str());
  return times == nullptr ? value : Number(double(value) * std::atof(times));
}
inline bool settable_tell(const char* name) {
  const char* const path = std::getenv("MAGIMU_READ");
  std::FILE* const file = path == nullptr ? nullptr : std::fopen(path, "a");
  if (file == nullptr) return true;
  std::fprintf(file, "%s\\n", name);
  std::fclose(file);
  return true;
}
// A constant is a macro that tells, once, that it was read.
#define SETTABLE_READ(name, variable) \\
  (*([] { static const bool told = settable_tell(name); return told ? &variable : nullptr; }()))
"""
EFFECTS = ("none", "gyro_bias_drift", "mag_lag", "acc_scale_misalignment", "hard_iron_change",
           "field_gradient", "gyro_scale_misalignment", "outliers")
# Of a diagnosis: noise, too, and small effects, beside whose evidence there is little.
CAUSES = ("none", "gyro_bias_drift", "mag_lag", "hard_iron_change", "hard_iron_change=0.2", "field_gradient",
          "outliers", "correlated_noise", "mains_interference", "mag_quantization", "stationary_source",
          "gyro_scale_misalignment", "mag_change", "field_drift=0.3", "mag_eddy_current", "mag_own_clock",
          "gyro_g_sensitivity", "clock_scale", "mag_saturation", "acc_time_offset", "hard_iron_drift",
          "mag_nonlinearity", "lever_arm", "gyro_change")


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


def key_of(file, name):
    return re.sub(r"\W", "_", file) + "_" + name


def make_settable(file, text, names):
    """The source with these constants as variables; what is found leaves the list."""
    for statement in re.findall(r"^(?:inline |static )*constexpr (?:double|float|int|long|std::size_t) k[^;]*;",
                                text, re.M):
        own = [name for name in names if re.search(rf"\b{name}\s*=", statement)]
        if not own:
            continue
        changed = statement.replace("constexpr ", "const ", 1)
        kind = re.search(r"constexpr ([\w:]+)", statement)[1]
        parts = re.split(r",(?![^({]*[)}])", changed)
        macros = ""
        for i, part in enumerate(parts):
            found = re.search(r"\b(k\w+)(\s*=\s*)(.*?)(;?)\s*$", part, re.S)
            if found and found[1] in own:
                key = key_of(file, found[1])
                parts[i] = part[:found.start()] + \
                    f"{found[1]}_ = settable<{kind}>(\"{key}\", {found[3]}){found[4]}"
                macros += f"\n#define {found[1]} SETTABLE_READ(\"{key}\", {found[1]}_)\n"
                names.remove(found[1])
        text = text.replace(statement, ",".join(parts) + "/**/", 1)
        before, _, after = text.partition("/**/")
        rest_of_line, _, after = after.partition("\n")  # a comment
        text = before + rest_of_line + macros + "\n" + after
        if file.endswith(".cpp"):  # sources are compiled in batches
            text += "".join(f"#undef {name}\n" for name in re.findall(r"#define (k\w+)", macros))
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
        target.write_text(make_settable(file, text, left))
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


def simulated(program, folder, number, seed, effects):
    out = []
    for k in range(number):
        path = folder / f"{k}.csv"
        effect = effects[k // 2 % len(effects)] if number > len(effects) else effects[k]
        moved = k % 2 or effect in ("field_gradient", "stationary_source")
        subprocess.run([program, "simulate", "-q", "-o", path, "--seed", str(seed + k), "--rate", "50",
                        "--duration", str(30 + 15 * (k % 3)), "--rest", str(3 * (k % 2)),
                        "--motion", "hand_held" if moved else "hand",
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
    else:
        environment["MAGIMU_READ"] = f"{recording}.read"
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
            return "no longer refused" if b is None else "refused"
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
    parser.add_argument("--recordings", default=40, type=int)
    parser.add_argument("--seed", default=7100, type=int)
    parser.add_argument("--jobs", default=os.cpu_count(), type=int)
    arguments = parser.parse_args()
    constants = [tuple(c.split(":")) for c in arguments.constants]
    factors = [float(f) for f in arguments.factors.split(",")]
    program = build(arguments.tree.resolve(), constants, arguments.jobs)
    with tempfile.TemporaryDirectory() as folder, \
            concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        recordings = [pathlib.Path(r).resolve() for r in arguments.on or []] or \
            simulated(program, pathlib.Path(folder), arguments.recordings, arguments.seed,
                      CAUSES if arguments.diagnose else EFFECTS)

        def all_of(constant, factor, which):
            return list(pool.map(lambda r: outcome(program, r, constant, factor, arguments.diagnose), which))

        usual = dict(zip(recordings, all_of("", 1.0, recordings)))
        reads = {r: set(pathlib.Path(f"{r}.read").read_text().split()) if pathlib.Path(f"{r}.read").exists()
                 else set() for r in recordings}
        print("usual outcomes: " + ", ".join(
            f"{n} {key}" for key, n in collections.Counter(
                o.get("answer", o.get("verdict", "refused")) for o in usual.values()).most_common()))
        print("| constant | read in | " + " | ".join(f"times {f:g}" for f in factors) + " |")
        print("|---|---|" + "---|" * len(factors))
        for file, name in constants:
            key = key_of(file, name)
            which = [r for r in recordings if key in reads[r]]
            cells = []
            for factor in factors:
                found = [difference(usual[r], now) for r, now in zip(which, all_of(key, factor, which))]
                ways = collections.Counter(d for d in found if d)
                cells.append("; ".join(f"{n} {way}" for way, n in ways.most_common(4)) or "none")
            print(f"| `{name}` in `{file}` | {len(which)} | " + " | ".join(cells) + " |", flush=True)
        print(f"({len(recordings)} recordings)")


if __name__ == "__main__":
    main()
