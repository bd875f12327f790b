#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Runs scenes x settings x seeds with clod-bench, and merges what they report.

A sweep is a file, a list a key; `settings` are words for `clod-bench run`, by the name that the report has for them:

  {"scenes": ["spoon-cup", "pile-heap"], "seeds": [0, 1, 2], "words": ["--resolution", "0.25"],
   "settings": {"default": [], "3.5 %": ["--size", "3.5"], "hull": ["--shapes", "hull"]}}

  scripts/sweep sweep.json -o out              every run, one after the other
  scripts/sweep sweep.json -o out --shard 2/8  the second eighth of them, on any machine that sees out/
  scripts/sweep sweep.json -o out --merge      out/sweep.csv and out/sweep.md, and what is missing or failed

Every run writes out/runs/NAME.json, whole or not at all. What is there is not run again: an interrupted sweep goes on
where it was. A run that fails leaves NAME.log, and is tried again. The same list elsewhere:

  scripts/sweep sweep.json -o out --list | parallel -j 8                           # GNU parallel, a run a job
  sbatch --array=1-64 --wrap 'scripts/sweep sweep.json -o out --shard $SLURM_ARRAY_TASK_ID/64'   # Slurm
"""
import argparse
import csv
import itertools
import json
import os
import pathlib
import re
import shlex
import shutil
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
KEYS = {"scenes", "settings", "seeds", "words"}
# Column: where it is in a run's report.
FIGURES = {"at_rest": ["summary", "end", "at_rest"], "in_place": ["summary", "stays_in_place"],
           "step_us": ["summary", "step_us", "median"], "step_us_p95": ["summary", "step_us", "p95"],
           "deepest_share": ["interpenetration", "share_of_smaller_radius"], "energy_final": ["energy", "final"],
           "trajectory_hash": ["trajectory_hash"]}


def jobs_of(path):
    try:
        sweep = json.loads(path.read_text())
    except (OSError, ValueError) as problem:
        sys.exit(f"{path}: {problem}")
    if not isinstance(sweep, dict) or set(sweep) - KEYS or not sweep.get("scenes") or not isinstance(sweep.get("settings"), dict):
        sys.exit(f"{path}: has to be an object of scenes and settings, and seeds and words if you like (sweep.py --help)")
    for scene, (setting, words), seed in itertools.product(sweep["scenes"], sweep["settings"].items(), sweep.get("seeds", [0])):
        name = re.sub(r"[^\w.-]+", "_", f"{pathlib.PurePath(scene).stem}-{setting}-{seed}")
        yield {"name": name, "scene": scene, "setting": setting, "seed": seed,
               "words": ["run", scene, *sweep.get("words", []), *words, "--seed", str(seed), "--verify-penetration", "--quiet"]}


def shard_of(jobs, shard):
    index, count = (int(n) for n in shard.split("/"))
    return jobs[index - 1 :: count]


def shard(text):
    if not re.fullmatch(r"[1-9]\d*/[1-9]\d*", text) or int(text.split("/")[0]) > int(text.split("/")[1]):
        raise argparse.ArgumentTypeError(f"'{text}' is no shard: 1/8 to 8/8")
    return text


def run(job, bench, runs):
    """Whether its report is there now. Exit code 4 tells of a deep overlap, which the report has, too."""
    report = runs / (job["name"] + ".json")
    if report.exists():
        return True
    part = runs / f".{job['name']}.{os.getpid()}.json"
    done = subprocess.run([bench, *job["words"], "--json", part], capture_output=True, text=True)
    if done.returncode in (0, 4) and part.exists():
        part.replace(report)
        (runs / (job["name"] + ".log")).unlink(missing_ok=True)
        return True
    part.unlink(missing_ok=True)
    (runs / (job["name"] + ".log")).write_text(f"exit {done.returncode}\n{done.stderr}")
    return False


def figure(report, way):
    for key in way:
        report = report.get(key) if isinstance(report, dict) else None
    return report


def merge(jobs, out):
    rows, missing = [], []
    for job in jobs:
        path = out / "runs" / (job["name"] + ".json")
        if not path.exists():
            missing.append(job["name"])
            continue
        report = json.loads(path.read_text())
        rows.append({**{k: job[k] for k in ("scene", "setting", "seed")}, **{k: figure(report, w) for k, w in FIGURES.items()}})
    with open(out / "sweep.csv", "w", newline="") as file:
        table = csv.DictWriter(file, ["scene", "setting", "seed", *FIGURES])
        table.writeheader()
        table.writerows(rows)
    lines = ["| scene | setting | runs | at rest | in place | step, us: median (least to most) | deepest, of R |",
             "|---|---|---|---|---|---|---|"]
    for key in dict.fromkeys((r["scene"], r["setting"]) for r in rows):
        of = [r for r in rows if (r["scene"], r["setting"]) == key]
        steps = [r["step_us"] for r in of if r["step_us"] is not None]
        depths = [r["deepest_share"] for r in of if r["deepest_share"] is not None]
        lines.append(f"| {key[0]} | {key[1]} | {len(of)} | {sum(bool(r['at_rest']) for r in of)} | "
                     f"{sum(bool(r['in_place']) for r in of)} | "
                     + (f"{statistics.median(steps):.0f} ({min(steps):.0f} to {max(steps):.0f}) | " if steps else "| ")
                     + (f"{100 * max(depths):.2g} % |" if depths else "|"))
    if missing:
        lines += ["", f"{len(missing)} of {len(jobs)} runs are not there: " + ", ".join(missing)]
    (out / "sweep.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))
    return not missing


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sweep", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--shard", type=shard, default="1/1", metavar="i/n")
    parser.add_argument("--only", help="one run, by its name")
    parser.add_argument("--list", action="store_true", help="print a command for every run of the shard, run none")
    parser.add_argument("--merge", action="store_true")
    parser.add_argument("--bench", default=str(ROOT / "build/release/bin/clod-bench"))
    options = parser.parse_args()
    jobs = list(jobs_of(options.sweep))
    if len({job["name"] for job in jobs}) < len(jobs):
        sys.exit("two runs have the same name: settings and scenes need names that differ in letters or digits")
    (options.output / "runs").mkdir(parents=True, exist_ok=True)
    if options.merge:
        sys.exit(0 if merge(jobs, options.output) else 1)
    mine = [job for job in shard_of(jobs, options.shard) if options.only in (None, job["name"])]
    if options.only and not mine:
        sys.exit(f"no run is called {options.only}; --list shows them")
    if options.list:
        bench = [] if options.bench == parser.get_default("bench") else ["--bench", options.bench]
        for job in mine:
            print(shlex.join([str(ROOT / "scripts/sweep"), str(options.sweep.resolve()), "-o", str(options.output.resolve()), *bench,
                              "--only", job["name"]]))
        return
    if not shutil.which(options.bench):
        sys.exit(f"{options.bench} is not there: build it (README.md), or name another with --bench")
    failed = []
    for i, job in enumerate(mine):
        print(f"{i + 1} of {len(mine)}: {job['name']}", file=sys.stderr, flush=True)
        if not run(job, options.bench, options.output / "runs"):
            failed.append(job["name"])
    if failed:
        sys.exit(f"{len(failed)} failed, each with its reason in {options.output}/runs/NAME.log: " + ", ".join(failed))


if __name__ == "__main__":
    main()
