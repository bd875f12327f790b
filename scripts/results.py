#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Measured figures in documents: measured, kept and printed by machines.

results.py measure   runs build/release/bin/clod-bench, or $CLOD_BENCH, and writes demos/results/*.json (half an hour; needs
                     scripts/peers; steps and dispatches are timed by the processor, so that a busy machine does not count)
results.py measure PART...   of them: spoon-cup, numbers-bowl, pile-heap, tradeoff, try, scaling
results.py tables    prints demos/results into the documents, between <!-- results NAME --> and <!-- end -->
results.py check     exit 1 where a document's table is not that of demos/results, or these are of several commits (a test runs this)

Kept of each report: the figures, the commit, the machine, the trajectory hash. No figure of ours is typed by hand.
"""
import functools
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
RESULTS = ROOT / "demos/results"
DOCUMENTS = ["README.md", "demos/results/README.md"]
BENCH = os.environ.get("CLOD_BENCH", ROOT / "build/release/bin/clod-bench")

RESOLUTION = "0.25"  # of the paper's triangle counts
NAMES = {"exact": "exact", "default": "certified 0.5 %, the default", "size-3.5": "the paper's s0 = 3.5 %"}
# Whole scenes with what Bullet users have: resolution, further words, and who is left out. The floor of the pile is one
# convex box: a static tree has nothing to hold there.
SCENES = {"spoon-cup": (RESOLUTION, [], ()), "numbers-bowl": ("1", [], ()), "pile-heap": ("1", ["--steps", "240"], ("bvh-vhacd",))}
SHAPES = {"exact": ("CLOD, exact", ["--exact"]), "default": ("CLOD, the default", []), "size-3.5": ("CLOD, s0 = 3.5 %", ["--size", "3.5"]),
          # As btClodDynamicsWorld does by itself.
          "world": ("CLOD, the default, in btClodDynamicsWorld", ["--passes", "3", "--parts", "8"]),
          **{kind: (name, ["--shapes", kind]) for kind, name in
             {"gimpact": "GImpact", "vhacd": "V-HACD, at most 32 hulls", "coacd": "CoACD, concavity 0.05",
              "bvh-vhacd": "V-HACD; a static tree for what stands still", "hull": "one convex hull"}.items()}}
FAMILIES = {"clod-dispatch": "CLOD", "gimpact": "GImpact", "vhacd": "V-HACD", "coacd": "CoACD"}

NOT_NUMBERS = "a pose or velocity is not finite"  # as a run says that ends so; all else that fails is no result


def bench(*words, codes=(0,)):
    start = time.monotonic()
    done = subprocess.run([BENCH, *map(str, words), "--quiet"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    print(done.stderr, end="", file=sys.stderr)
    print(f"{time.monotonic() - start:.0f} s: clod-bench", *words, file=sys.stderr, flush=True)
    if done.returncode not in codes or (done.returncode == 1 and NOT_NUMBERS not in done.stderr):
        sys.exit(f"clod-bench ends with {done.returncode}")
    return done.returncode


def keep(name, report):
    RESULTS.mkdir(parents=True, exist_ok=True)
    (RESULTS / f"{name}.json").write_text(json.dumps(report, indent=1) + "\n")


def load(name):
    return json.loads((RESULTS / f"{name}.json").read_text())


def run_scene(scene, resolution, words, folder, codes=(0,)):
    """What is kept of a run; None where it ended early: a body's place stopped being a number."""
    if bench("run", scene, "--resolution", resolution, "--verify-penetration", *words, "--json", folder / "run.json", codes=codes) == 1:
        return None
    report = json.loads((folder / "run.json").read_text())
    summary = report["summary"]
    return {"machine": report["machine"], "trajectory_hash": report["trajectory_hash"],
            "triangles": [model["triangles"] for model in report["models"]], "bodies": report["bodies"],
            "interpenetration": report["interpenetration"], "end": summary["end"], "stays_in_place": summary["stays_in_place"],
            "dispatch_us": summary["dispatch_us"], "step_us": summary["step_us"], "energy": report["energy"]}


def measure_scene(scene, folder):
    resolution, further, left_out = SCENES[scene]
    runs = {shape: run_scene(scene, resolution, [*further, *words], folder, (0, 1, 4))
            for shape, (_, words) in SHAPES.items() if shape not in left_out}
    keep("scenes", {**load("scenes"), scene: runs})


def measure_tradeoff(folder):
    bench("tradeoff", "spoon-cup", "--resolution", RESOLUTION, "--methods", ",".join(FAMILIES), "--decimations", 1,
          "--repeat", 2, "-o", folder / "tradeoff")
    report = json.loads((folder / "tradeoff/tradeoff.json").read_text())
    keep("tradeoff", {"machine": report["machine"], "poses": report["poses"], "rows": report["tradeoff"]["rows"],
                      "radius": report["tradeoff"]["radius"],
                      "points": [{key: point[key] for key in ("family", "setting", "us", "us_at_rest", "us_cold", "pair_bytes",
                                                                "gap_error", "contacts")}
                                 for point in report["tradeoff"]["points"]],
                      "left_out": report["tradeoff"]["left_out"]})


def measure_try(folder):
    for model in ("cup", "torus"):
        bench("model", model, "--triangles", 10000, "-o", folder / f"{model}.obj")
    bench("try", folder / "cup.obj", folder / "torus.obj", "--quick", "--no-film", "-o", folder / "try")
    report = json.loads((folder / "try/report.json").read_text())
    report.pop("models")
    keep("try", report)


def measure_scaling(folder):
    bench("scaling", "--only", "queries", "--resolutions", "0.0625,0.25,1", "-o", folder / "scaling")
    report = json.loads((folder / "scaling/scaling.json").read_text())
    keep("scaling", {"machine": report["machine"], "radius": report["radius"], "selections": report["selections"]})


PARTS = {**{scene: functools.partial(measure_scene, scene) for scene in SCENES}, "tradeoff": measure_tradeoff, "try": measure_try,
         "scaling": measure_scaling}


def table(head, rows):
    lines = ["| " + " | ".join(cells) + " |" for cells in [head, ["---"] * len(head)] + rows]
    return "\n".join(lines)


def machine(report):
    m = report["machine"]
    return f"{m['processor']}, {m['cores']} cores, {m['compiler']}, commit {m['commit']}"


def percent(share):
    return "0" if share == 0 else f"{100 * share:.2g}" if share < 0.1 else f"{100 * share:.0f}"


def plain(value, least):
    """Two digits and no powers of ten; what is below the least that matters is told as that."""
    if 0 < value < least:
        return f"< {least:g}"
    return f"{value:.0f}" if value >= 10 else f"{value:.2g}"


def times(more, less):
    """How many times the one is the other."""
    return f"{plain(more / less, 0)} times"


def fall():
    report = load("try")
    smallest = report["smallest_radius"]
    rows = [[run["method"], run["setting"], f"{run['step_us']['median'] / 1000:.2f}", percent(run["deepest"] / smallest),
             percent(run["points_off_share"]["p95"]) if "points_off_share" in run else "not measured",
             run["ending"] or ("fell through" if run["bodies_gone"] else "rests" if run["end_speed_radii_per_s"] < 0.1 else "still moves")]
            for run in report["runs"]]
    return table(["method", "setting", "step, ms", "deepest overlap, % of R", "contact points off the surface, % of R", "end"], rows)


def scene():
    rows = []
    for setting in NAMES:
        report = load("scenes")["spoon-cup"][setting]
        deep = report["interpenetration"]
        rows.append([NAMES[setting], f"{report['dispatch_us']['median']:.0f}", f"{report['step_us']['median']:.0f}",
                     f"{1000 * deep['deepest']:.3f} ({1000 * deep['limit']:.3f})",
                     f"{report['end']['largest_speed_radii_per_s']:.4f}", "yes" if report["stays_in_place"] else "no"])
    return table(["setting", "dispatch, us", "whole step, us", "deepest overlap (limit), mm", "speed at the end, radii/s",
                  "in the cup"], rows)


def scenes():
    """Rows where one is better than ours in time and depth are as visible as the others: nobody is left out."""
    report = load("scenes")
    rows = []
    for scene, runs in report.items():
        for shape, run in runs.items():
            if run is None:
                rows.append([scene, SHAPES[shape][0], "-", "-", "-", "-", "its places stopped being numbers"])
                continue
            step, energy = run["step_us"], run["energy"]
            made = (energy["largest"] - energy["initial"]) / max(abs(energy["initial"]), 1e-30)
            rows.append([scene, SHAPES[shape][0], f"{plain(step['median'] / 1000, 0.001)} ({plain(step['p95'] / 1000, 0.001)})",
                         percent(run["interpenetration"]["share_of_smaller_radius"]), plain(run["end"]["largest_speed_radii_per_s"], 0.001),
                         percent(max(0, made)), "yes" if run["stays_in_place"] else "NO"])
    return table(["scene", "shapes", "step, ms (95 %)", "deepest overlap, % of R", "speed at the end, radii/s", "energy made, %",
                  "all in place"], rows)


def curve():
    report = load("tradeoff")
    rows = []
    for family, name in FAMILIES.items():
        for point in report["points"]:
            if point["family"] != family:
                continue
            error = point["gap_error"]["p95"]
            rows.append([name, point["setting"], f"{point['us']['median']:.0f}", f"{point['us_at_rest']['median']:.0f}",
                         f"{point['us_cold']['median']:.0f}", f"{point['pair_bytes'] / 1000:.1f}",
                         "-" if error is None else percent(error / report["radius"])])
    return table(["method", "setting", "dispatch, moving, us", "at rest, us", "a new pair, cold, us", "a pair, kB",
                  "gap's error, 95 %, % of R"], rows)


def scaling():
    if not (RESULTS / "scaling.json").exists():
        return "Not measured: `scripts/results measure scaling`."
    rows = [[selection["selection"], f"{size['triangles_a'] + size['triangles_b']:,}", f"{size['query_us']['median']:.0f}",
             f"{size['growth']:.2f}", f"{size['front']:.0f}",
             *(f"{size[name] / 1e6:.2f}" for name in ("bytes", "loaded_bytes", "alike_bytes"))]
            for selection in load("scaling")["selections"] for size in selection["sizes"]]
    return table(["setting", "triangles of both", "query, us", "growth", "pairs in the front", "whole, MB", "levels asked, MB",
                  "same detail, MB"], rows)


def point_of(report, family, setting):
    return next(p for p in report["points"] if p["family"] == family and p["setting"] == setting)


def five():
    """The five numbers of the front page."""
    fall_report, curve_report = load("try"), load("tradeoff")
    runs = {run["method"]: run for run in fall_report["runs"]}
    radius = curve_report["radius"]
    ours, exact = point_of(curve_report, "clod-dispatch", "max-error 0.5 %"), point_of(curve_report, "clod-dispatch", "exact")
    theirs = point_of(curve_report, "gimpact", "full")
    checked = fall_report["for_accuracy"]
    lines = [
        f"**{times(theirs['us']['median'], ours['us']['median'])}** faster than `btGImpactMeshShape` on moving bodies "
        f"(spoon in cup, whole dispatches), {times(theirs['us']['median'], exact['us']['median'])} when exact",
        f"**{percent(ours['gap_error']['p95'] / radius)} %** of the radius: our error of the reported distance there (95 % of the poses), GImpact's is "
        f"{percent(theirs['gap_error']['p95'] / radius)} %",
        f"**{100 * runs['CLOD']['deepest'] / fall_report['smallest_radius']:.2g} %** of the radius: the deepest that meshes "
        f"sank into each other in a fall, GImpact's {percent(runs['GImpact']['deepest'] / fall_report['smallest_radius'])} %, "
        f"a convex hull's {percent(runs['convex hull']['deepest'] / fall_report['smallest_radius'])} %",
        f"**{times(runs['GImpact']['step_us']['median'], runs['CLOD']['step_us']['median'])}** less time for a whole step "
        "of that fall, solver included, than with GImpact",
        f"**{checked['fresh']['broken']} of {checked['fresh_poses']:,}** fresh poses broke a certified bound"]
    return "\n".join("- " + line for line in lines)


def about():
    report = load("tradeoff")
    scene_report = load("scenes")["spoon-cup"]["default"]
    return (f"{machine(report)}. Spoon in cup: {' and '.join(f'{n:,}' for n in scene_report['triangles'])} triangles, "
            f"{report['rows']} moving rows; trajectory {scene_report['trajectory_hash']}, "
            f"poses {report['poses']['trajectory_hash']}.")


def plot():
    """demos/results/curve.svg: error against time of the dispatches, both logarithmic."""
    import math
    report = load("tradeoff")
    width, height, left, right, top, bottom = 760, 360, 70, 20, 20, 50
    smallest = 0.001  # %, where smaller errors are drawn
    named = {"exact": "exact", "max-error 0.5 %": "0.5 %, the default"}
    points = [(name, color, p["us"]["median"], max(smallest, 100 * (p["gap_error"]["p95"] or 0) / report["radius"]), p["setting"])
              for (family, name), color in zip(FAMILIES.items(), ("#000000", "#D55E00", "#009E73", "#CC79A7"))
              for p in report["points"] if p["family"] == family and p["gap_error"]["p95"] is not None]
    lows = [min(p[i] for p in points) / 1.4 for i in (2, 3)]
    highs = [max(p[i] for p in points) * 1.4 for i in (2, 3)]

    def place(value, axis):
        share = math.log(value / lows[axis]) / math.log(highs[axis] / lows[axis])
        return left + share * (width - left - right) if axis == 0 else height - bottom - share * (height - top - bottom)

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="13">',
             "<title>Error against time, spoon in cup</title>", f'<rect width="{width}" height="{height}" fill="white"/>']
    for axis in (0, 1):
        # Two decades have room for more than whole ones.
        steps = (1, 2, 5) if highs[axis] / lows[axis] < 1000 else (1,)
        for tick in (step * 10.0 ** k for k in range(-4, 7) for step in steps):
            if not lows[axis] <= tick <= highs[axis]:
                continue
            at = place(tick, axis)
            parts.append(f'<line x1="{at:.1f}" x2="{at:.1f}" y1="{top}" y2="{height - bottom}" stroke="#ddd"/>'
                         f'<text x="{at:.1f}" y="{height - bottom + 18}" text-anchor="middle">{tick:g}</text>' if axis == 0 else
                         f'<line x1="{left}" x2="{width - right}" y1="{at:.1f}" y2="{at:.1f}" stroke="#ddd"/>'
                         f'<text x="{left - 6}" y="{at + 4:.1f}" text-anchor="end">{tick:g}</text>')
    parts.append(f'<text x="{width / 2}" y="{height - 8}" text-anchor="middle">a whole collision dispatch, microseconds</text>')
    parts.append(f'<text transform="translate(16 {height / 2}) rotate(-90)" text-anchor="middle">error of the gap (95 %), % of the radius</text>')
    for name, color, x, y, setting in points:
        parts.append(f'<circle cx="{place(x, 0):.1f}" cy="{place(y, 1):.1f}" r="5" fill="{color}">'
                     f"<title>{name}, {setting}: {x:.0f} us, {y:.2g} %</title></circle>")
        if setting in named:
            parts.append(f'<text x="{place(x, 0) - 9:.1f}" y="{place(y, 1) + 4:.1f}" text-anchor="end">{named[setting]}</text>')
    for i, (name, color) in enumerate(dict((p[0], p[1]) for p in points).items()):
        parts.append(f'<circle cx="{width - 120}" cy="{top + 14 + 20 * i}" r="5" fill="{color}"/>'
                     f'<text x="{width - 108}" y="{top + 18 + 20 * i}">{name}</text>')
    return "\n".join(parts + ["</svg>"]) + "\n"


def commits():
    """Of all that is kept: one, or some figure is older than the others."""
    runs = [run for scene_runs in load("scenes").values() for run in scene_runs.values() if run]
    kept = [load(name) for name in ("tradeoff", "try", "scaling") if (RESULTS / f"{name}.json").exists()]
    return sorted({report["machine"]["commit"] for report in [*kept, *runs]})


BLOCKS = {"five": five, "fall": fall, "scene": scene, "scenes": scenes, "curve": curve, "scaling": scaling,
          "about": about}
BLOCK = re.compile(r"<!-- results (\w+) -->\n.*?<!-- end -->", re.S)


def printed(text):
    return BLOCK.sub(lambda m: f"<!-- results {m.group(1)} -->\n{BLOCKS[m.group(1)]()}\n<!-- end -->", text)


def main():
    command, parts = (sys.argv[1] if len(sys.argv) > 1 else ""), sys.argv[2:]
    if command == "measure" and all(part in PARTS for part in parts):
        with tempfile.TemporaryDirectory() as folder:
            for part in parts or PARTS:
                PARTS[part](pathlib.Path(folder))
        command = "tables"
    elif parts:
        sys.exit(__doc__)
    if command not in ("tables", "check"):
        sys.exit(__doc__)
    stale = []
    for name in DOCUMENTS:
        path = ROOT / name
        text = path.read_text()
        if BLOCK.search(text) is None:
            stale.append(f"{name}: no table of results is in it")
        elif printed(text) != text:
            stale.append(f"{name}: its tables are not those of demos/results; run scripts/results tables")
            if command == "tables":
                path.write_text(printed(text))
    curve_path = RESULTS / "curve.svg"
    if not curve_path.exists() or curve_path.read_text() != plot():
        stale.append("demos/results/curve.svg is not of demos/results; run scripts/results tables")
        if command == "tables":
            curve_path.write_text(plot())
    if len(commits()) > 1:
        stale.append(f"demos/results are of several commits, {', '.join(commits())}: measure what is older again")
    if command == "check" and stale:
        sys.exit("\n".join(stale))


if __name__ == "__main__":
    main()
