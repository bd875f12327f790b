#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Plants faults in a copy of the sources, builds and runs the tests of the folder, and prints what survives.

Faults by hand are those of scripts/mutants.txt. Mechanical ones are drawn with a seed from all sources of the product:
a sign, a comparison, a minimum for a maximum, a statement dropped. The copy is build/mutants, a worktree of HEAD, whose
tests must pass before anything is planted; one that then takes four times the processor's time counts as caught. One of
which the compiler makes the same test programs is no fault (trivial compiler equivalence), and is not counted.
"""
import argparse
import collections
import hashlib
import pathlib
import random
import re
import resource
import shutil
import signal
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
    "plugin/clod/manifold": ["manifold_test", "bullet_report_test", "bullet_contact_test", "bullet_motion_test"],
    "plugin/clod/schedule": ["bullet_threads_test", "bullet_metric_test"],
    "plugin/clod/bullet": ["bullet_shape_test", "bullet_registration_test", "bullet_contact_test", "bullet_report_test",
                           "bullet_metric_test", "bullet_motion_test", "bullet_facilities_test", "bullet_convex_test",
                           "bullet_world_test"],
    "builder/intake": ["test_intake"],
    "builder/repair": ["test_repair"],
    "builder/assemble": ["builder_assemble_test", "test_check"],
    "builder/patches": ["test_patches"],
    "builder/check": ["test_check"],
    "builder/library": ["builder_library_test"],
    "builder/pipeline": ["builder_library_test"],
    "builder/cli": ["test_clod_build"],
    "cli": ["test_clod_build"],
    "demos/models": ["ModelsTest"],
    "demos/render": ["RenderTest"],
    "demos/peers": ["PeersTest", "PlacedBodiesTest", "RunnerMeasureTest"],
    "demos/scenes": ["SceneFileTest", "ReplayPosesTest", "RunnerCommandTest"],
    "demos/paper": ["PaperQueryTest"],
    "demos/extremes": ["ExtremesTest"],
    "demos/trial": ["TrialTest"],
    "demos/runner": ["RunnerFramesTest", "RunnerRowsTest", "RunnerPenetrationTest", "RunnerCommandTest", "RunnerMeasureTest",
                     "RunnerScriptedTest"],
}
SECONDS = 600  # of one test program on the clean copy
SLOWER, LEAST_SECONDS = 4, 10  # a mutant's may take so many times the processor's time, and so much in any case
WAITING = 10  # times as long by the clock: tests that wait, processes that they start, a busy machine

Mutant = collections.namedtuple("Mutant", "file says old new start reason")  # start: of old in the file


def by_hand():
    """Those of scripts/mutants.txt, and a sentence for each that no longer fits the sources."""
    mutants, stale = [], []
    text = (ROOT / "scripts/mutants.txt").read_text()
    for block in re.split(r"\n\n+", re.sub(r"(?m)^#.*\n", "", text).strip()):
        head, old, new = block.split("\n")
        file, says = head.split(": ", 1)
        says, _, reason = says.partition(" | ")
        source = (ROOT / file).read_text()
        old, new = old[2:], new[2:]
        if source.count(old) != 1:
            stale.append(f"stale: {file}: {says}: the text is there {source.count(old)} times, not once; keep scripts/mutants.txt up")
            continue
        mutants.append(Mutant(file, says, old, new, source.index(old), reason))
    return mutants, stale


SWAPS = [(r"(?<=\w) \+ (?=\w)", " - "), (r"(?<=\w) - (?=\w)", " + "), (r" < (?=[\w(*])", " >= "), (r" > (?=[\w(*])", " <= "),
         (r" <= ", " > "), (r" >= ", " < "), (r" == ", " != "), (r"std::min\(", "std::max("), (r"std::max\(", "std::min("),
         (r" && ", " || ")]
DROPPED = re.compile(r"(?m)^\t+(?:\+\+|--)?[\w.>\[\]-]+(?: [-+*/|&]?= [^;\n]+|\([^;\n]*\)|)?;$")

NO_FAULT = re.compile(r"\breserve\(|\bshrink_to_fit\(")  # dropped: the same answers


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
                    candidates.append(Mutant(name, f"line {line}:{m.group().strip()} becomes {new.strip()}", m.group(), new, m.start(), ""))
            for m in DROPPED.finditer(code):
                if NO_FAULT.search(m.group()):
                    continue
                if not re.match(r"\s*(return|break|continue|using|const|auto|double|int|Vec3)\b", m.group()) and "=" in m.group() or "(" in m.group():
                    line = source.count("\n", 0, m.start()) + 1
                    candidates.append(Mutant(name, f"line {line} dropped: {source[m.start():m.end()].strip()}",
                                             source[m.start():m.end()], "", m.start(), ""))
    return random.Random(seed).sample(candidates, min(count, len(candidates)))


def folder_of(file):
    folder = pathlib.PurePath(file).parent
    while str(folder) not in TESTS and folder != folder.parent:
        folder = folder.parent
    return str(folder)


def prepare():
    """The copy at HEAD, configured; with ccache what an earlier run has compiled is not compiled again."""
    if not TREE.exists():
        subprocess.run(["git", "worktree", "add", "--detach", TREE, "HEAD"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["git", "checkout", "--detach", "--force", subprocess.check_output(["git", "rev-parse", "HEAD"], cwd=ROOT, text=True).strip()],
                   cwd=TREE, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    options = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    options += ["-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=mold"] if shutil.which("mold") else []
    subprocess.run(["cmake", "--preset", "release", *options], cwd=TREE, check=True, stdout=subprocess.DEVNULL)


def build(targets, jobs):
    return subprocess.run(["nice", "ninja", "-C", BUILD, f"-j{jobs}", *targets], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True)


def programs(since=0):
    """What those are made of that were linked since then; some tests run others."""
    return {path.name: hashlib.sha256(path.read_bytes()).digest() for path in (BUILD / "bin").iterdir()
            if path.stat().st_mtime >= since}


def run(test, seconds):
    """Whether the test program passes, None where it does not end in its seconds; and those of the processor that it took."""
    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (round(seconds), round(seconds) + 1))

    def used():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    before = used()
    try:
        done = subprocess.run(["nice", BUILD / "bin" / test, "--gtest_brief=1", "--gtest_fail_fast"], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, timeout=WAITING * seconds, cwd=BUILD, preexec_fn=limit)
    except subprocess.TimeoutExpired:
        return None, seconds
    return None if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL) else done.returncode == 0, used() - before


def clean_copy(tests, jobs):
    """What each test takes on the clean copy, and its programs; one that fails there would catch everything."""
    built = build(tests, jobs)
    if built.returncode != 0:
        sys.exit("the copy does not build:\n" + built.stdout[-2000:])
    before, clean = programs(), {}
    for test in tests:
        passes, seconds = run(test, SECONDS)
        if not passes:  # on a busy machine once more
            passes, seconds = run(test, SECONDS)
        if not passes:
            sys.exit(f"{test} fails without a fault planted")
        clean[test] = seconds
        print(f"clean: {test}: {seconds:.1f} s", flush=True)
    return clean, before


def verdict(mutant, clean, before, jobs):
    began = time.time()
    path = TREE / mutant.file
    source = path.read_text()
    path.write_text(source[:mutant.start] + mutant.new + source[mutant.start + len(mutant.old):])
    same = True
    try:
        for test in TESTS[folder_of(mutant.file)]:
            if build([test], jobs).returncode != 0:
                return "does not compile"
            if all(before[name] == made for name, made in programs(began).items()):
                continue
            same = False
            passes, _ = run(test, max(LEAST_SECONDS, SLOWER * clean[test]))
            if passes is None:
                return f"caught by {test}: it does not end"
            if not passes:
                return f"caught by {test}"
        return "same programs" if same else "SURVIVED"
    finally:
        path.write_text(source)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mechanical", type=int, default=200, help="how many are drawn [200]")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=["by hand", "mechanical"], help="no others")
    parser.add_argument("--only", default="", help="files and sentences that contain this")
    parser.add_argument("--sample", type=int, help="so many of all, drawn with the seed")
    parser.add_argument("--hours", type=float, default=2, help="stop after so long, and say what was not reached [2]")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--list", action="store_true", help="print them, plant none; exit 1 where one no longer fits (a test)")
    options = parser.parse_args()
    listed, stale = by_hand()
    print("\n".join(stale), end="\n" if stale else "")
    kinds = [("by hand", listed), ("mechanical", mechanical(options.seed, options.mechanical))]
    mutants = [(kind, m) for kind, list_ in kinds for m in list_
               if options.kind in (None, kind) and options.only in m.file + ": " + m.says]
    if options.sample:
        mutants = random.Random(options.seed).sample(mutants, min(options.sample, len(mutants)))
    if options.list:
        for kind, mutant in mutants:
            print(f"{kind}: {mutant.file}: {mutant.says}")
        sys.exit(1 if stale else 0)
    prepare()
    clean, before = clean_copy(sorted({test for _, m in mutants for test in TESTS[folder_of(m.file)]}), options.jobs)
    counts = collections.Counter()
    survivors = []
    start = time.monotonic()
    for i, (kind, mutant) in enumerate(mutants):
        if time.monotonic() - start > 3600 * options.hours:
            print(f"{len(mutants) - i} not reached in {options.hours} hours")
            break
        began = time.monotonic()
        told = verdict(mutant, clean, before, options.jobs)
        outcome = told.split(" ")[0]
        why = f", known: {mutant.reason}" if outcome == "SURVIVED" and mutant.reason else ""
        print(f"{kind}: {mutant.file}: {mutant.says}: {told}{why} ({time.monotonic() - began:.0f} s)", flush=True)
        counts[kind, outcome] += 1
        if outcome == "SURVIVED":
            survivors.append((kind, mutant))
    planted = sum(counts.values())
    print(f"{planted} planted, {(time.monotonic() - start) / max(1, planted):.0f} s each")
    for kind in ("by hand", "mechanical"):
        caught, survived = counts[kind, "caught"], counts[kind, "SURVIVED"]
        if caught + survived:
            print(f"{kind}: {caught} of {caught + survived} caught, {counts[kind, 'does']} did not compile, "
                  f"{counts[kind, 'same']} made the same programs")
    unsound = [m for _, m in survivors if m.says.startswith("unsound")]
    for mutant in unsound:
        print(f"UNSOUND and not noticed: {mutant.file}: {mutant.says}")
    sys.exit(1 if unsound else 0)


if __name__ == "__main__":
    main()
