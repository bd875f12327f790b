#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Plants faults in a copy of the sources, builds and runs the tests of the folder, and prints what survives.

Faults by hand are those of scripts/mutants.txt. Mechanical ones are drawn with a seed from all sources of the product:
a sign, a comparison, a minimum for a maximum, a statement dropped. The copy is build/mutants, a worktree of HEAD.
"""
import argparse
import collections
import pathlib
import random
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
TREE = ROOT / "build/mutants"
BUILD = TREE / "build/release"
# The tests of a folder, the quickest first; of what lies in no folder named here, the one above it.
TESTS = {
    "plugin/clod/collide": ["collide_test", "query_query_test"],
    "plugin/clod/hierarchy": ["hierarchy_file_test", "distance_test"],
    "plugin/clod/distance": ["distance_test", "query_query_test"],
    "plugin/clod/query": ["query_metric_test", "query_query_test", "query_budget_test", "distance_test", "bullet_report_test"],
    "plugin/clod/manifold": ["manifold_test", "bullet_contact_test", "bullet_motion_test"],
    "plugin/clod/bullet": ["bullet_shape_test", "bullet_contact_test", "bullet_report_test", "bullet_metric_test",
                           "bullet_motion_test"],
    "builder/intake": ["test_intake"],
    "builder/repair": ["test_repair"],
    "builder/assemble": ["builder_assemble_test"],
    "builder/patches": ["test_patches"],
    "builder/check": ["test_check"],
    "demos/models": ["ModelsTest"],
    "demos/render": ["RenderTest"],
    "demos/peers": ["PeersTest", "PlacedBodiesTest"],
    "demos/scenes": ["SceneFileTest", "ReplayPosesTest"],
    "demos/trial": ["TrialTest"],
    "demos/runner": ["RunnerFramesTest", "RunnerRowsTest", "RunnerPenetrationTest", "RunnerCommandTest", "RunnerMeasureTest",
                     "RunnerScriptedTest"],
}
SECONDS = 600  # of one test program

Mutant = collections.namedtuple("Mutant", "file says old new start")  # start: of old in the file


def by_hand():
    """Those of scripts/mutants.txt; what no longer fits the sources is named and left out."""
    mutants = []
    text = (ROOT / "scripts/mutants.txt").read_text()
    for block in re.split(r"\n\n+", re.sub(r"(?m)^#.*\n", "", text).strip()):
        head, old, new = block.split("\n")
        file, says = head.split(": ", 1)
        source = (ROOT / file).read_text()
        old, new = old[2:], new[2:]
        if source.count(old) != 1:
            print(f"stale: {file}: {says}: the text is there {source.count(old)} times, not once; keep scripts/mutants.txt up")
            continue
        mutants.append(Mutant(file, says, old, new, source.index(old)))
    return mutants


SWAPS = [(r"(?<=\w) \+ (?=\w)", " - "), (r"(?<=\w) - (?=\w)", " + "), (r" < (?=[\w(*])", " >= "), (r" > (?=[\w(*])", " <= "),
         (r" <= ", " > "), (r" >= ", " < "), (r" == ", " != "), (r"std::min\(", "std::max("), (r"std::max\(", "std::min("),
         (r" && ", " || ")]
DROPPED = re.compile(r"(?m)^\t+(?:\+\+|--)?[\w.>\[\]-]+(?: [-+*/|&]?= [^;\n]+|\([^;\n]*\)|)?;$")


def mechanical(seed, count):
    """Candidates of every file, of which `count` are drawn, as many a folder as there are lines in it."""
    candidates = []
    for folder in TESTS:
        for path in sorted((ROOT / folder).glob("*.cpp")) + sorted((ROOT / folder).glob("*.h")):
            source = path.read_text()
            name = str(path.relative_to(ROOT))
            code = re.sub(r"//.*|\"(?:\\.|[^\"\\\n])*\"|^#.*|template.*|^\w.*\(.*\)( const)?$", lambda m: " " * len(m.group()), source,
                          flags=re.M)
            for pattern, new in SWAPS:
                for m in re.finditer(pattern, code):
                    line = source.count("\n", 0, m.start()) + 1
                    candidates.append(Mutant(name, f"line {line}:{m.group().strip()} becomes {new.strip()}", m.group(), new, m.start()))
            for m in DROPPED.finditer(code):
                if not re.match(r"\s*(return|break|continue|using|const|auto|double|int|Vec3)\b", m.group()) and "=" in m.group() or "(" in m.group():
                    line = source.count("\n", 0, m.start()) + 1
                    candidates.append(Mutant(name, f"line {line} dropped: {source[m.start():m.end()].strip()}",
                                             source[m.start():m.end()], "", m.start()))
    return random.Random(seed).sample(candidates, min(count, len(candidates)))


def folder_of(file):
    folder = pathlib.PurePath(file).parent
    while str(folder) not in TESTS and folder != folder.parent:
        folder = folder.parent
    return str(folder)


def prepare(launcher):
    if not TREE.exists():
        subprocess.run(["git", "worktree", "add", "--detach", TREE, "HEAD"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["git", "checkout", "--detach", "--force", subprocess.check_output(["git", "rev-parse", "HEAD"], cwd=ROOT, text=True).strip()],
                   cwd=TREE, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    subprocess.run(["cmake", "--preset", "release", *([f"-DCMAKE_CXX_COMPILER_LAUNCHER={launcher}"] if launcher else [])],
                   cwd=TREE, check=True, stdout=subprocess.DEVNULL)


def build(targets, jobs):
    return subprocess.run(["nice", "ninja", "-C", BUILD, f"-j{jobs}", *targets], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True)


def verdict(mutant, jobs):
    path = TREE / mutant.file
    source = path.read_text()
    path.write_text(source[:mutant.start] + mutant.new + source[mutant.start + len(mutant.old):])
    try:
        for test in TESTS[folder_of(mutant.file)]:
            if build([test], jobs).returncode != 0:
                return "does not compile"
            try:
                run = subprocess.run(["nice", BUILD / "bin" / test, "--gtest_brief=1", "--gtest_fail_fast"], stdout=subprocess.DEVNULL,
                                     stderr=subprocess.DEVNULL, timeout=SECONDS)
            except subprocess.TimeoutExpired:
                return f"caught by {test}: it does not end"
            if run.returncode != 0:
                return f"caught by {test}"
        return "SURVIVED"
    finally:
        path.write_text(source)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mechanical", type=int, default=200, help="how many are drawn [200]")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="files and sentences that contain this")
    parser.add_argument("--sample", type=int, help="so many of all, drawn with the seed")
    parser.add_argument("--hours", type=float, default=2, help="stop after so long, and say what was not reached [2]")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--launcher", default="", help="compiler launcher, e.g. ccache")
    parser.add_argument("--list", action="store_true", help="print them, plant none")
    options = parser.parse_args()
    kinds = [("by hand", by_hand()), ("mechanical", mechanical(options.seed, options.mechanical))]
    mutants = [(kind, m) for kind, list_ in kinds for m in list_ if options.only in m.file + ": " + m.says]
    if options.sample:
        mutants = random.Random(options.seed).sample(mutants, min(options.sample, len(mutants)))
    if options.list:
        for kind, mutant in mutants:
            print(f"{kind}: {mutant.file}: {mutant.says}")
        return
    prepare(options.launcher)
    targets = sorted({test for _, m in mutants for test in TESTS[folder_of(m.file)]})
    clean = build(targets, options.jobs)
    if clean.returncode != 0:
        sys.exit("the copy does not build:\n" + clean.stdout[-2000:])
    counts = collections.Counter()
    survivors = []
    start = time.monotonic()
    for i, (kind, mutant) in enumerate(mutants):
        if time.monotonic() - start > 3600 * options.hours:
            print(f"{len(mutants) - i} not reached in {options.hours} hours")
            break
        told = verdict(mutant, options.jobs)
        print(f"{kind}: {mutant.file}: {mutant.says}: {told}", flush=True)
        outcome = told.split(" ")[0]
        counts[kind, outcome] += 1
        if outcome == "SURVIVED":
            survivors.append((kind, mutant))
    for kind in ("by hand", "mechanical"):
        caught, survived = counts[kind, "caught"], counts[kind, "SURVIVED"]
        if caught + survived:
            print(f"{kind}: {caught} of {caught + survived} caught, {counts[kind, 'does']} did not compile")
    unsound = [m for _, m in survivors if m.says.startswith("unsound")]
    for mutant in unsound:
        print(f"UNSOUND and not noticed: {mutant.file}: {mutant.says}")
    sys.exit(1 if unsound else 0)


if __name__ == "__main__":
    main()
