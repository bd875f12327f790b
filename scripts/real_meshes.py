# SPDX-License-Identifier: Zlib
# The work of scripts/real-meshes once programs and meshes are there: verifies checksums, builds every mesh, proves what was
# built, writes table.txt, table.json and levels.csv, and lets three of them fall on each other. Exit code 1 where an outcome is none of BUILT, REFUSED, LIMIT.
import argparse
import csv
import hashlib
import json
import pathlib
import subprocess
import sys
import time

PICTURES = ("elephant", "StanfordBunny", "fandisk", "mug", "couplingdown", "dino")
WRAP = "3%"  # of the radius
DROPPED = ("elephant", "knot1", "dino")  # fall on each other
DROP_RADIUS = 0.025  # metres, what the scene drop is made for
SHARES = (0.01, 0.03, 0.10)  # pieces are counted at the coarsest level within these errors


def find(roots, path):
    for root in roots:
        if (root / path).is_file():
            return root / path
    sys.exit(f"{path} is in none of the packages")


def read_list(file, roots, only):
    entries = []
    for line in file.read_text().splitlines():
        if line.startswith("#") or not line.strip():
            continue
        digest, kind, package, path = line.split()
        name = pathlib.PurePath(path).stem
        if only and name not in only:
            continue
        mesh = find(roots, path)
        found = hashlib.sha256(mesh.read_bytes()).hexdigest()
        if found != digest:
            sys.exit(f"{mesh}: its checksum is {found}, expected {digest}")
        entries.append({"name": name, "kind": kind, "package": package, "mesh": mesh})
    return entries


def run(words):
    start = time.monotonic()
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr.strip(), time.monotonic() - start


def attempt(programs, entry, out, options):
    """One build and, where it succeeds, its proof: (outcome, reason, report)."""
    clod, report = out / (entry["name"] + ".clod"), out / (entry["name"] + ".json")
    clod.unlink(missing_ok=True)
    code, _, error, seconds = run([programs / "clod-build", "build", entry["mesh"], "-o", clod, "--quiet", "--json",
                                   report, *options])
    if code == 0:
        proof, _, complaint, _ = run([programs / "clod-build", "check", clod, "--quiet"])
        if proof != 0:
            return "FAILED", "check: " + complaint, None
        result = json.loads(report.read_text())
        result["seconds"] = seconds
        return "BUILT", "", result
    reason = error.split(str(entry["mesh"]) + ": ", 1)[-1].split("\n")[0]
    if clod.exists():
        return "FAILED", "a file is left behind", None
    return {3: "REFUSED", 5: "LIMIT"}.get(code, "FAILED"), reason or f"exit code {code}", None


def pieces(report, share):
    """Patches of the coarsest contact level whose certified error is at most this share of the radius; None: no level's."""
    fitting = [l for l in report["levels"] if l["clod"] and l["max_s"] <= share * report["radius"]]
    return min((l["patches"] for l in fitting), default=None)


def build(programs, entry, out):
    row = {"name": entry["name"], "kind": entry["kind"], "package": entry["package"]}
    row["reason"] = ""  # of the first refusal
    for how, options in (("as it is", []), ("--repair", ["--repair"]), ("--wrap " + WRAP, ["--wrap", WRAP])):
        outcome, reason, report = attempt(programs, entry, out, options)
        row["reason"] = row["reason"] or reason
        row.setdefault("attempts", []).append({"how": how, "outcome": outcome, "reason": reason})
        if outcome in ("BUILT", "FAILED"):
            break
    row["outcome"] = outcome
    if report is None:
        return row
    coarsest = [l for l in report["levels"] if l["clod"]][-1]
    row.update(how=how, triangles=report["triangles"], seconds=report["seconds"], radius=report["radius"],
               components=report["components"], pieces=report["levels"][0]["patches"], levels=report["levels"],
               coarsest=coarsest["patches"], coarsest_error=coarsest["max_s"] / report["radius"],
               bytes_per_triangle=report["bytes"] / report["triangles"],
               within={f"{s:g}": pieces(report, s) for s in SHARES})
    if "repair" in report:
        row["changes"] = report["repair"]["changes"]
        row["moved"] = max(report["repair"][side]["upper"] for side in ("added", "lost")) / report["radius"]
    return row


def table(rows):
    head = f"{'mesh':<19}{'kind':<5}{'as it is':<9}{'built':<11}{'moved %':>8}{'triangles':>10}{'s':>7}{'pieces':>8}"
    head += "".join(f"{'@%g%%' % (100 * s):>7}" for s in SHARES) + f"{'coarsest':>9}{'error %':>8}  refused for"
    lines = [head]
    for r in rows:
        line = f"{r['name']:<19}{r['kind']:<5}{r['attempts'][0]['outcome']:<9}"
        if "how" in r:
            moved = f"{100 * r['moved']:.2g}" if "moved" in r else "0"
            line += f"{r['how']:<11}{moved:>8}{r['triangles']:>10}{r['seconds']:>7.1f}{r['pieces']:>8}"
            line += "".join(f"{'-' if fit is None else fit:>7}" for fit in (r["within"]["%g" % s] for s in SHARES))
            line += f"{r['coarsest']:>9}{100 * r['coarsest_error']:>8.2g}"
        else:
            line += f"{'no':<11}" + " " * (8 + 10 + 7 + 8 + 7 * len(SHARES) + 9 + 8)
        lines.append(f"{line}  {r['reason'][:90]}")
    count = lambda word: sum(1 for r in rows if r.get("how", "").startswith(word))
    lines.append(f"{len(rows)} meshes: {count('as')} built as they are, {count('--repair')} repaired, {count('--wrap')} "
                 f"wrapped, {sum(1 for r in rows if 'how' not in r)} not built")
    return "\n".join(lines) + "\n"


def write_levels(rows, path):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["mesh", "level", "triangles", "patches", "max_s", "max_s_percent_of_radius"])
        for r in rows:
            for l in r.get("levels", []):
                if l["clod"]:
                    writer.writerow([r["name"], l["level"], l["triangles"], l["patches"], l["max_s"],
                                     100 * l["max_s"] / r["radius"]])


def drop_together(programs, rows, entries, out):
    """Three of the meshes fall on each other in Bullet, exactly and at 3.5 %: frames, and what came of it."""
    rows = {r["name"]: r for r in rows}
    if any("how" not in rows.get(name, {}) for name in DROPPED):
        return ""
    models = []
    for entry in entries:
        if entry["name"] not in DROPPED:
            continue
        row, scaled = rows[entry["name"]], out / (entry["name"] + "-scaled.clod")
        options = [] if row["how"] == "as it is" else row["how"].split()
        code, _, error, _ = run([programs / "clod-build", "build", entry["mesh"], "-o", scaled, "--quiet", "--scale",
                                 repr(DROP_RADIUS / row["radius"]), *options])
        if code != 0:
            sys.exit(f"{scaled}: {error}")
        models += ["--model", scaled]
    lines = []
    for name, selection in (("exact", ["--exact"]), ("size-3.5", ["--size", "3.5"])):
        report = out / f"drop-{name}.json"
        code, _, error, _ = run([programs / "clod-bench", "run", "drop", *models, *selection, "--quiet", "--json", report,
                                 "--verify-penetration", "--frames", out / f"drop-{name}", "--frame-every", "60"])
        if code not in (0, 4):
            sys.exit(f"drop: {error}")
        result = json.loads(report.read_text())
        end, depth = result["summary"]["end"], result["interpenetration"]
        lines.append(f"{', '.join(DROPPED)} dropped, {name}: {'in place' if result['summary']['stays_in_place'] else 'GONE'}, "
                     f"{'at rest' if end['at_rest'] else 'not at rest'}; deepest interpenetration "
                     f"{1000 * depth['deepest']:.3f} mm (limit {1000 * depth['limit']:.3f})")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser()
    for name in ("--list", "--programs", "--out"):
        parser.add_argument(name, type=pathlib.Path, required=True)
    parser.add_argument("--roots", type=pathlib.Path, nargs="+", required=True)
    parser.add_argument("--only", nargs="+", default=[], help="names of meshes")
    options = parser.parse_args()
    entries = read_list(options.list, options.roots, options.only)
    options.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for i, entry in enumerate(entries):
        print(f"  {i + 1} of {len(entries)}: {entry['name']}", file=sys.stderr, flush=True)
        rows.append(build(options.programs, entry, options.out))
        (options.out / "table.txt").write_text(table(rows))
        (options.out / "table.json").write_text(json.dumps(rows, indent=1))
        write_levels(rows, options.out / "levels.csv")
        if entry["name"] in PICTURES and "how" in rows[-1]:
            picture = options.out / (entry["name"] + ".png")
            code, _, error, _ = run([options.programs / "clod-bench", "levels", options.out / (entry["name"] + ".clod"),
                                     "-o", picture, "--quiet"])
            if code != 0:
                sys.exit(f"{picture}: {error}")
    fallen = drop_together(options.programs, rows, entries, options.out)
    (options.out / "table.txt").write_text(table(rows) + fallen)
    print(table(rows) + fallen, end="")
    return 1 if any(r["outcome"] == "FAILED" for r in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
