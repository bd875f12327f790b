#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Plants faults in a copy of the sources, builds and runs the tests of the folder, and prints what survives.

Faults by hand are those of scripts/mutants.txt. Mechanical ones are drawn with a seed from all sources of the product:
a sign, a comparison, a minimum for a maximum, a statement dropped. The copies are worktrees of HEAD under build/mutants, one
a job: a fault is one file to compile and one program to link at a time. Of all programs the quick cases run first, then the
slow ones of all of them, each alone, up to the first that fails. Tests must pass before anything is planted; what then takes
four times the processor's time counts as caught. A fault of which the compiler makes the same test programs is none (trivial
compiler equivalence), and is not counted. A known survivor counts as one without being planted: all tests of its folder would
run, most of a night's time.
"""
import argparse
import collections
import concurrent.futures
import hashlib
import json
import os
import pathlib
import queue
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
COPIES = ROOT / "build/mutants"
# The tests of a folder, the quickest first; of what lies in no folder named here, the one above it.
TESTS = {
    "plugin/clod/collide": ["collide_test", "manifold_test", "query_query_test", "distance_test"],
    "plugin/clod/hierarchy": ["hierarchy_file_test", "bullet_shape_test", "distance_test"],
    "plugin/clod/distance": ["distance_test", "query_query_test"],
    "plugin/clod/query": ["query_metric_test", "query_query_test", "query_budget_test", "hierarchy_file_test", "distance_test",
                           "bullet_report_test"],
    "plugin/clod/manifold": ["manifold_test", "bullet_report_test", "bullet_contact_test", "oracle_test", "bullet_convex_test",
                             "bullet_world_test", "bullet_motion_test", "bullet_metric_test", "bullet_rest_test", "MechanismsTest"],
    "plugin/clod/schedule": ["query_budget_test", "bullet_threads_test", "bullet_metric_test"],
    "plugin/clod/bullet": ["bullet_shape_test", "bullet_registration_test", "bullet_contact_test", "bullet_report_test",
                           "bullet_metric_test", "bullet_rest_test", "bullet_motion_test", "bullet_facilities_test", "bullet_convex_test",
                           "bullet_world_test", "bullet_threads_test", "random_worlds_test", "MechanismsTest"],
    "builder/intake": ["test_intake"],
    "builder/repair": ["test_repair"],
    "builder/assemble": ["builder_assemble_test", "test_check"],
    "builder/patches": ["test_patches"],
    "builder/check": ["test_check"],
    "builder/library": ["builder_library_test"],
    "builder/pipeline": ["builder_library_test"],
    "builder/cli": ["test_clod_build"],
    "cli": ["test_clod_build", "RunnerCommandTest"],
    "demos/models": ["ModelsTest"],
    "demos/render": ["RenderTest"],
    "demos/peers": ["PeersTest", "PlacedBodiesTest", "RunnerMeasureTest"],
    "demos/scenes": ["SceneListTest", "SceneFileTest", "ReplayPosesTest", "RunnerCommandTest", "MechanismsTest"],
    "demos/paper": ["PaperQueryTest"],
    "demos/extremes": ["ExtremesTest"],
    "demos/trial": ["TrialTest"],
    "demos/runner": ["RunnerFramesTest", "RunnerRowsTest", "RunnerPenetrationTest", "RunnerCommandTest", "RunnerMeasureTest",
                     "RunnerScriptedTest"],
}
SECONDS = 600  # of one test program on the clean copy
SLOW = 1  # seconds of a test case that runs alone, behind the quick ones of all programs of the folder
SLOWER, LEAST_SECONDS = 4, 10  # a mutant's may take so many times the processor's time, and so much in any case
WAITING = 40  # times as long by the clock: tests that wait, processes that they start, a busy machine

Mutant = collections.namedtuple("Mutant", "file says old new start reason")  # start: of old in the file
Run = collections.namedtuple("Run", "test filter seconds")  # of a program's cases, and the processor's seconds without a fault


def by_hand():
    """Those of scripts/mutants.txt, why mechanical ones may survive, by file, line and mutant, and a sentence for each that
    no longer fits the sources."""
    mutants, known, stale = [], {}, []
    text = (ROOT / "scripts/mutants.txt").read_text()
    for block in re.split(r"\n\n+", re.sub(r"(?m)^#.*\n", "", text).strip()):
        head, old, new = block.split("\n")
        file, says = head.split(": ", 1)
        says, _, reason = says.partition(" | ")
        source = (ROOT / file).read_text()
        old, new = old[2:], new[2:]
        if says == "mechanical":
            known[file, old.strip(), new.strip()] = reason
            if old not in source:
                stale.append(f"stale: {file}: no line {old.strip()}; keep scripts/mutants.txt up")
            continue
        if source.count(old) != 1:
            stale.append(f"stale: {file}: {says}: the text is there {source.count(old)} times, not once; keep scripts/mutants.txt up")
            continue
        mutants.append(Mutant(file, says, old, new, source.index(old), reason))
    return mutants, known, stale


SWAPS = [(r"(?<=\w) \+ (?=\w)", " - "), (r"(?<=\w) - (?=\w)", " + "), (r" < (?=[\w(*])", " >= "), (r" > (?=[\w(*])", " <= "),
         (r" <= ", " > "), (r" >= ", " < "), (r" == ", " != "), (r"std::min\(", "std::max("), (r"std::max\(", "std::min("),
         (r" && ", " || ")]
DROPPED = re.compile(r"(?m)^\t+(?:\+\+|--)?[\w.>\[\]-]+(?: [-+*/|&]?= [^;\n]+|\([^;\n]*\)|)?;$")

# Dropped: the same answers.
NO_FAULT = re.compile(r"\breserve\(|\bshrink_to_fit\(|\breport\(progress|\bprogress\(|\bprogress\.update\(")


def line_of(mutant, source):
    """The line it is in, before and after."""
    start = mutant.start + len(mutant.old) - len(mutant.old.lstrip())
    begin, end = source.rfind("\n", 0, start) + 1, source.find("\n", start)
    return source[begin:end], source[begin:mutant.start] + mutant.new + source[mutant.start + len(mutant.old):end]


def mechanical(seed, count, known):
    """Candidates of every file, of which `count` are drawn, as many a folder as there are lines in it; the same ones as long
    as their lines stay as they are."""
    candidates, sources = [], {}
    for folder in TESTS:
        for path in sorted((ROOT / folder).glob("*.cpp")) + sorted((ROOT / folder).glob("*.h")):
            source = path.read_text()
            name = str(path.relative_to(ROOT))
            sources[name] = source
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
    seen = collections.Counter()

    def lot(mutant):
        source = sources[mutant.file]
        begin, end = source.rfind("\n", 0, mutant.start) + 1, source.find("\n", mutant.start + 1)
        words = f"{seed} {mutant.file} {source[begin:end].strip()} {mutant.start - begin} {mutant.new}"
        seen[words] += 1
        return hashlib.sha256(f"{words} {seen[words]}".encode()).digest()

    def with_reason(mutant):
        before, after = line_of(mutant, sources[mutant.file])
        return mutant._replace(reason=known.get((mutant.file, before.strip(), after.strip()), ""))

    return [with_reason(mutant) for mutant in sorted(candidates, key=lot)[:count]]


def folder_of(file):
    folder = pathlib.PurePath(file).parent
    while str(folder) not in TESTS and folder != folder.parent:
        folder = folder.parent
    return str(folder)


def head():
    return subprocess.check_output(["git", "rev-parse", "HEAD"], cwd=ROOT, text=True).strip()


def used():
    """Seconds of the processor, of what was run and has ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


class Copy:
    """A worktree of HEAD in which one fault at a time is planted. With ccache nothing is compiled that an earlier run or
    another copy has compiled: paths in its keys are relative to the copy."""

    def __init__(self, index):
        self.tree = COPIES / str(index)
        self.build_folder = self.tree / "build/release"
        self.environment = {**os.environ, "CCACHE_BASEDIR": str(self.tree), "CCACHE_NOHASHDIR": "1"}
        self.made = {}  # what its programs are made of
        self.spent = collections.Counter()  # seconds by the clock, of what is planted: building, testing
        if not self.tree.exists():
            self.git("worktree", "add", "--detach", self.tree, "HEAD", folder=ROOT)
        self.git("checkout", "--detach", "--force", head(), folder=self.tree)
        options = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
        options += ["-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=mold"] if shutil.which("mold") else []
        subprocess.run(["cmake", "--preset", "release", *options], cwd=self.tree, check=True, stdout=subprocess.DEVNULL)

    @staticmethod
    def git(*words, folder):
        subprocess.run(["git", *words], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def build(self, targets, jobs=1):
        began = time.monotonic()
        built = subprocess.run(["ninja", "-C", self.build_folder, f"-j{jobs}", *targets], stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True, env=self.environment)
        self.spent["building"] += time.monotonic() - began
        return built

    def programs(self, since=0):
        """What those are made of that were linked since then; some tests run others."""
        return {path.name: hashlib.sha256(path.read_bytes()).digest() for path in (self.build_folder / "bin").iterdir()
                if path.stat().st_mtime >= since}

    def run(self, test, seconds, *options):
        """Whether the test program passes, None where it does not end in its seconds of the processor."""
        limit = f"--cpu={round(seconds)}:{round(seconds) + 1}"
        began = time.monotonic()
        try:
            done = subprocess.run(["prlimit", limit, self.build_folder / "bin" / test, "--gtest_brief=1",
                                   "--gtest_fail_fast", *options], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                  timeout=WAITING * seconds, cwd=self.build_folder)
        except subprocess.TimeoutExpired:
            return None
        finally:
            self.spent["testing"] += time.monotonic() - began
        return None if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL) else done.returncode == 0

    def prepare(self, tests, jobs):
        built = self.build(tests, jobs)
        if built.returncode != 0:
            sys.exit("the copy does not build:\n" + built.stdout[-2000:])
        self.made = self.programs()


def runs_of(copy, test):
    """A test program's quick cases as one run and its slow ones as a run each, by seconds. What fails without a fault would
    catch everything."""
    report = copy.build_folder / "cases.json"
    for _ in range(2):  # on a busy machine once more
        before = used()
        if copy.run(test, SECONDS, f"--gtest_output=json:{report}"):
            break
    else:
        sys.exit(f"{test} fails without a fault planted")
    seconds = used() - before
    told = [(f"{case['classname']}.{case['name']}", float(case["time"].rstrip("s")))
            for suite in json.loads(report.read_text())["testsuites"] for case in suite["testsuite"]]
    scale = seconds / max(1e-9, sum(time for _, time in told))  # they are told by the clock
    slow = sorted((Run(test, name, scale * time) for name, time in told if scale * time > SLOW), key=lambda run: run.seconds)
    quick = Run(test, "-" + ":".join(run.filter for run in slow), seconds - sum(run.seconds for run in slow))
    print(f"clean: {test}: {seconds:.1f} s, {len(slow)} slow cases", flush=True)
    return ([quick] if len(slow) < len(told) else []) + slow


def clean_runs(copy, tests):
    """Of each test its runs; what an earlier start at this commit measured is not measured again."""
    kept = COPIES / f"clean-{head()}.json"
    runs = {test: [Run(*run) for run in runs] for test, runs in json.loads(kept.read_text()).items()} if kept.exists() else {}
    for test in tests:
        if test not in runs:
            runs[test] = runs_of(copy, test)
            kept.write_text(json.dumps(runs))
    return runs


def in_order(runs):
    """Of all the tests of a folder: quick cases, then slow ones."""
    return [run for run in runs if run.filter.startswith("-")] + sorted(
        (run for run in runs if not run.filter.startswith("-")), key=lambda run: run.seconds)


def verdict(copy, mutant, clean):
    began = time.time()
    path = copy.tree / mutant.file
    source = path.read_text()
    path.write_text(source[:mutant.start] + mutant.new + source[mutant.start + len(mutant.old):])
    differs = {}  # of each program linked so far, whether the fault is in it
    try:
        for test, chosen, seconds in in_order([run for test in TESTS[folder_of(mutant.file)] for run in clean[test]]):
            if test not in differs:
                if copy.build([test]).returncode != 0:
                    return "does not compile"
                differs[test] = any(copy.made[name] != made for name, made in copy.programs(began).items())
            if not differs[test]:
                continue
            passes = copy.run(test, max(LEAST_SECONDS, SLOWER * seconds), f"--gtest_filter={chosen}")
            if passes is None:
                return f"caught by {test}: it does not end"
            if not passes:
                return f"caught by {test}"
        return "SURVIVED" if any(differs.values()) else "same programs"
    finally:
        path.write_text(source)


def in_words(spent):
    return ", ".join(f"{seconds:.0f} s {what}" for what, seconds in sorted(spent.items())) or "not planted"


def verdicts(copies, mutants, clean, deadline, also_known):
    """Of each mutant in turn what became of it and the seconds spent on it; a job a copy. None: it was not reached."""
    free = queue.SimpleQueue()
    for copy in copies:
        free.put(copy)

    def judge(mutant):
        if mutant.reason and not also_known:
            return "SURVIVED before", {}
        if time.monotonic() > deadline:
            return None
        copy = free.get()
        copy.spent = collections.Counter()
        try:
            return verdict(copy, mutant, clean), copy.spent
        finally:
            free.put(copy)

    with concurrent.futures.ThreadPoolExecutor(len(copies)) as pool:
        yield from pool.map(judge, mutants)


def options_given():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mechanical", type=int, default=200, help="how many are drawn [200]")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", choices=["by hand", "mechanical"], help="no others")
    parser.add_argument("--only", nargs="+", default=[""], help="files and sentences that contain one of these")
    parser.add_argument("--sample", type=int, help="so many of all, drawn with the seed")
    parser.add_argument("--shard", default="1/1", help="i/n: each nth of them from the ith on, in copies of its own [1/1]")
    parser.add_argument("--hours", type=float, default=2, help="stop after so long, and say what was not reached [2]")
    parser.add_argument("--known", action="store_true", help="plant known survivors, too: is one caught by now?")
    parser.add_argument("--jobs", type=int, default=2, help="copies that faults are planted in at once [2]")
    parser.add_argument("--list", action="store_true", help="print them, plant none; exit 1 where one no longer fits (a test)")
    return parser.parse_args()


def mutants_of(options, listed, known):
    """The faults that the options choose, each with its kind."""
    kinds = [("by hand", listed), ("mechanical", mechanical(options.seed, options.mechanical, known))]
    mutants = [(kind, m) for kind, list_ in kinds for m in list_
               if options.kind in (None, kind) and any(only in m.file + ": " + m.says for only in options.only)]
    if options.sample:
        mutants = random.Random(options.seed).sample(mutants, min(options.sample, len(mutants)))
    shard, shards = (int(number) for number in options.shard.split("/"))
    return mutants[shard - 1::shards]


def ready_copies(options, tests):
    """A copy a job, and the runs of each test where no fault is planted."""
    shard = int(options.shard.split("/")[0])
    copies = [Copy(index + options.jobs * (shard - 1)) for index in range(options.jobs)]
    copies[0].prepare(tests, options.jobs)
    clean = clean_runs(copies[0], tests)
    for copy in copies[1:]:
        copy.prepare(tests, options.jobs)
    return copies, clean


def main():
    options = options_given()
    start = time.monotonic()
    listed, known, stale = by_hand()
    print("\n".join(stale), end="\n" if stale else "")
    mutants = mutants_of(options, listed, known)
    if options.list:
        for kind, mutant in mutants:
            print(f"{kind}: {mutant.file}: {mutant.says}")
        sys.exit(1 if stale else 0)
    copies, clean = ready_copies(options, sorted({test for _, m in mutants for test in TESTS[folder_of(m.file)]}))
    counts = collections.Counter()
    survivors = []
    reached, not_planted, spent = 0, 0, collections.Counter()
    planting, before = time.monotonic(), used()
    told = verdicts(copies, [m for _, m in mutants], clean, start + 3600 * options.hours, options.known)
    for (kind, mutant), answer in zip(mutants, told):
        if answer is None:
            break
        reached += 1
        not_planted += answer[0] == "SURVIVED before"
        outcome = answer[0].split(" ")[0]
        why = f", known: {mutant.reason}" if outcome == "SURVIVED" and mutant.reason else ""
        spent += answer[1]
        print(f"{kind}: {mutant.file}: {mutant.says}: {answer[0]}{why} ({in_words(answer[1])})", flush=True)
        counts[kind, outcome] += 1
        if outcome == "SURVIVED":
            survivors.append((kind, mutant))
    if reached < len(mutants):
        print(f"{len(mutants) - reached} not reached in {options.hours} hours")
    planted = sum(counts.values()) - not_planted
    print(f"{planted} planted in {time.monotonic() - planting:.0f} s, of the processor {used() - before:.0f} s "
          f"({in_words(spent)}), behind {planting - start:.0f} s, of the processor {before:.0f} s, that made the copies ready")
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
