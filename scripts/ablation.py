# SPDX-License-Identifier: Zlib
# The work of scripts/ablation once the programs are there. A cell of its table is triangles / patches: the largest certified
# s in % of the radius, in brackets the larger of surf and protrude alone, at the contact level whose patches come nearest (in
# ratio) to an eighth of level 0's, to the paper's coarsest level, and at the coarsest.
import argparse
import csv
import json
import math
import pathlib
import resource
import subprocess
import sys

PLACEMENTS = ("filter", "quadric", "probabilistic")
PAPERS_COARSEST = {"cup": 241, "spoon": 61, "spiral": 100, "torus": 92, "bowl": 63, "number1": 37}  # Table 1


def run(*words):
    """Processor seconds of one program; ends the script where it fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{words[0]} {words[1]}: {done.stderr.strip()}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def build(programs, out, model):
    mesh = out / f"{model}.obj"
    run(programs / "clod-bench", "model", model, "-o", mesh, "--quiet")
    reports = []
    for placement in PLACEMENTS:
        print(f"  {model}, {placement}", file=sys.stderr, flush=True)
        report = out / f"{model}-{placement}.json"
        seconds = run(programs / "clod-build", "build", mesh, "-o", report.with_suffix(".clod"), "--paper", "--placement",
                      placement, "--threads", 1, "--quiet", "--json", report)
        reports.append({**json.loads(report.read_text()), "model": model, "placement": placement, "seconds": seconds})
    return reports


def contact_levels(report):
    return [level for level in report["levels"] if level["clod"]]


def nearest(levels, patches):
    return min(levels, key=lambda level: abs(math.log(level["patches"] / patches)))


def percent(report, *names):
    return lambda level: 100 * max(level[name] for name in names) / report["radius"]


def row(report):
    s, own = percent(report, "max_s"), percent(report, "max_surf", "max_protrude")
    levels = contact_levels(report)
    cuts = [nearest(levels[1:], levels[0]["patches"] / 8), nearest(levels[1:], PAPERS_COARSEST[report["model"]]), levels[-1]]
    cells = " | ".join(f"{cut['triangles']}/{cut['patches']}: {s(cut):.3g} ({own(cut):.3g})" for cut in cuts)
    return f"| {report['model']} | {report['placement']} | {cells} | {report['seconds']:.1f} |"


def write(reports, out):
    lines = ["| model | placement | an eighth of level 0's patches | as the paper's coarsest | coarsest | processor s |",
             "|---|---|---|---|---|---|"] + [row(report) for report in reports]
    (out / "table.txt").write_text("\n".join(lines) + "\n")
    with open(out / "levels.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["model", "placement", "level", "triangles", "patches", "max_s_percent", "max_surf_protrude_percent"])
        for report in reports:
            s, own = percent(report, "max_s"), percent(report, "max_surf", "max_protrude")
            for level in contact_levels(report):
                writer.writerow([report["model"], report["placement"], level["level"], level["triangles"],
                                 level["patches"], f"{s(level):.4g}", f"{own(level):.4g}"])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--programs", type=pathlib.Path, required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--models", nargs="+", choices=PAPERS_COARSEST, default=list(PAPERS_COARSEST))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    reports = []
    for model in options.models:
        reports += build(options.programs, options.out, model)
        write(reports, options.out)
    print((options.out / "table.txt").read_text(), end="")


if __name__ == "__main__":
    main()
