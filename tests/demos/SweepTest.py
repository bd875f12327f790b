#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""scripts/sweep.py with a stand-in for clod-bench that counts its runs: shards are a partition, what is there is not run
again, a failure is told and tried again, --list is the same list, and the merge has every run. SweepTest.py SWEEP.py"""
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile

BENCH = """#!/usr/bin/env python3
import json, os, sys
words = sys.argv[1:]
open(os.environ["COUNT"], "a").write(" ".join(words) + "\\n")
if "--fail" in words and not os.path.exists(os.environ["MEND"]): sys.exit("no such cup")
seed = int(words[words.index("--seed") + 1])
json.dump({"trajectory_hash": f"{seed:x}", "summary": {"stays_in_place": True, "end": {"at_rest": seed != 1},
          "step_us": {"median": 10 * seed + 10, "p95": 50}}, "interpenetration": {"share_of_smaller_radius": 0.01}},
          open(words[words.index("--json") + 1], "w"))
sys.exit(4 if seed == 2 else 0)
"""


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        bench, sweep, out, count = folder / "bench", folder / "sweep.json", folder / "out", folder / "count"
        bench.write_text(BENCH)
        bench.chmod(0o755)
        sweep.write_text(json.dumps({"scenes": ["a", "b"], "seeds": [0, 1, 2], "settings": {"x": [], "3.5 %": ["--fail"]}}))
        os.environ.update(COUNT=str(count), MEND=str(folder / "mended"))

        def run(*words):
            return subprocess.run([sys.executable, sys.argv[1], sweep, "-o", out, "--bench", bench, *words], capture_output=True, text=True)

        def runs():
            return count.read_text().splitlines()

        assert run("--shard", "0/2").returncode == 2 and run("--shard", "3/2").returncode == 2
        first, second = run("--shard", "1/2"), run("--shard", "2/2")
        assert len(runs()) == 12 and len(set(runs())) == 12, runs()
        assert first.returncode and second.returncode, "half of them fail"
        assert "no such cup" in (out / "runs/a-3.5_-0.log").read_text()
        merged = run("--merge")
        assert merged.returncode == 1 and "6 of 12 runs are not there" in merged.stdout, merged.stdout
        (folder / "mended").touch()
        assert run().returncode == 0 and len(runs()) == 18, "only what failed is run again"
        assert not list((out / "runs").glob("*.log"))
        assert run().returncode == 0 and len(runs()) == 18
        merged = run("--merge")
        assert merged.returncode == 0 and "| a | x | 3 | 2 | 3 | 20 (10 to 30) | 1 % |" in merged.stdout, merged.stdout
        rows = list(csv.DictReader(open(out / "sweep.csv")))
        assert len(rows) == 12 and {r["seed"] for r in rows} == {"0", "1", "2"}
        listed = run("--list").stdout.splitlines()
        assert len(listed) == 12 and len(set(listed)) == 12
        (out / "runs/b-x-2.json").unlink()
        line = next(line for line in listed if line.endswith("b-x-2"))  # as GNU parallel runs it, from anywhere
        assert subprocess.run(line, shell=True, cwd="/", capture_output=True).returncode == 0
        assert len(runs()) == 19 and (out / "runs/b-x-2.json").exists(), "with the same clod-bench"
        wrapper = pathlib.Path(sys.argv[1]).resolve().with_suffix("")  # files are named from where the user stands
        command = [wrapper, "sweep.json", "-o", "there", "--bench", bench, "--only", "a-x-0"]
        assert subprocess.run(command, cwd=folder, capture_output=True).returncode == 0 and (folder / "there/runs/a-x-0.json").exists()
        lacking = run("--only", "a-x-1", "--bench", "/nowhere/clod-bench")
        assert lacking.returncode == 1 and "/nowhere/clod-bench is not there" in lacking.stderr, lacking.stderr
        assert run("--only", "a-x-1").returncode == 0 and run("--only", "a-x-9").returncode == 1
        sweep.write_text(json.dumps({"scenes": ["a"], "settings": {"x": [], "x ": []}, "sedes": [1]}))
        assert "has to be an object" in run().stderr
        sweep.write_text(json.dumps({"scenes": ["a"], "settings": {"x%": [], "x&": []}}))
        assert "same name" in run().stderr


if __name__ == "__main__":
    main()
