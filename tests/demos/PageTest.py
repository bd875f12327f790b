#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of `clod-bench try` as a browser shows it: `PageTest.py CLOD_BENCH` tries two small meshes and opens the page
in headless Chromium at three widths; `--page FILE` looks at a page that is there; --self-test shows each fault found."""
import argparse
import html
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

WIDTHS = (360, 800, 1600)
MODELS, LONG = ("cup", "torus"), "_with_a_name_such_as_exporters_write_001"
# Written into a copy of the page: what only a browser knows.
PROBE = """<script>window.addEventListener('load', async () => {
const video = document.querySelector('video'), wait = ms => new Promise(done => setTimeout(done, ms));
for (let i = 0; video && video.readyState < 1 && !video.error && i < 40; ++i) await wait(100);
const found = {
  overflow: document.documentElement.scrollWidth - window.innerWidth,
  brokenImages: [...document.images].filter(i => !i.complete || i.naturalWidth === 0).length,
  withoutText: [...document.images].filter(i => !i.alt).length + [...document.querySelectorAll('svg')].filter(
    s => !s.querySelector('title') && !s.getAttribute('aria-label')).length,
  marksWithoutValue: [...document.querySelectorAll('svg circle')].filter(c => !c.querySelector('title')).length,
  marks: document.querySelectorAll('svg circle').length,
  videos: document.querySelectorAll('video').length,
  filmSeconds: video ? video.duration || 0 : 0,
  fromElsewhere: [...document.querySelectorAll('[src], [href]')].filter(
    e => !/^(data:|#)/.test(e.getAttribute('src') || e.getAttribute('href'))).length,
  width: window.innerWidth,
  smallestText: Math.min(...[...document.querySelectorAll('p, td, th, figcaption')].map(
    e => parseFloat(getComputedStyle(e).fontSize))),
};
const pre = parent.document.createElement('pre'); pre.id = 'probe'; pre.textContent = JSON.stringify(found);
parent.document.body.appendChild(pre); });</script>"""


def browser():
    return next((b for b in ("chromium", "chromium-browser", "google-chrome") if shutil.which(b)), None)


def look(page, width):
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder) / "page.html"
        # In a frame: no window of Chromium is narrower than 500 pixels.
        copy.write_text(f"<iframe style='border:0; width:{width}px; height:900px' srcdoc='{html.escape(page + PROBE)}'></iframe>")
        dom = subprocess.run([browser(), "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1700,1000",
                              f"--user-data-dir={folder}/profile", "--virtual-time-budget=8000", "--dump-dom", f"file://{copy}"],
                             capture_output=True, text=True, timeout=300).stdout
    probe = re.search(r'<pre id="probe">(.*?)</pre>', dom, re.S)
    if not probe:
        sys.exit("the browser did not run the page")
    return json.loads(html.unescape(probe.group(1)))


def faults(page, withFilm):
    for width in WIDTHS:
        found = look(page, width)
        print(width, found)
        if found["width"] != width:
            yield f"the window is {found['width']} wide instead of {width}"
        if found["overflow"] > 0:
            yield f"at {width} pixels the page is {found['overflow']} too wide"
        for what in ("brokenImages", "withoutText", "marksWithoutValue", "fromElsewhere"):
            if found[what]:
                yield f"{what}: {found[what]}"
        if found["marks"] < 5:
            yield "no plot"
        if found["smallestText"] < 12:
            yield f"text of {found['smallestText']} pixels"
        if withFilm and not found["filmSeconds"] > 4.9:
            yield f"a film of {found['filmSeconds']} s"


def self_test():
    plot = "<svg aria-label='p'>" + "<circle><title>1</title></circle>" * 5 + "</svg>"
    good = "<!doctype html><body><p>text</p>" + plot + "</body>"
    expected = [(good, False), (good + "<div style='width:2000px'>x</div>", True), (good + "<img alt='x' src='data:image/png;base64,AA'>", True),
                (good + "<svg></svg>", True), (good + "<svg aria-label='q'><circle></circle></svg>", True), ("<p>text</p>", True),
                (good + "<p style='font-size:8px'>x</p>", True), (good + "<a href='https://x.y'>x</a>", True)]
    return [f"{page[:200]}: {'not ' if wrong else ''}found" for page, wrong in expected if bool(list(faults(page, False))) != wrong]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bench", nargs="?")
    parser.add_argument("--page", type=pathlib.Path)
    parser.add_argument("--self-test", action="store_true")
    options = parser.parse_args()
    if not browser():
        print("no Chromium: skipped")
        sys.exit(77)
    if options.self_test:
        found = self_test()
    elif options.page:
        found = list(faults(options.page.read_text(), True))
    else:
        with tempfile.TemporaryDirectory() as folder:
            for model in MODELS:
                subprocess.run([options.bench, "model", model, "--triangles", "1200", "--quiet", "-o",
                                f"{folder}/{model}{LONG}.obj"], check=True)
            subprocess.run([options.bench, "try", *(f"{folder}/{model}{LONG}.obj" for model in MODELS), "--quick", "--quiet", "--peers-dir",
                            "/none", "-o", folder], check=True, stdout=subprocess.DEVNULL)
            found = list(faults((pathlib.Path(folder) / "report.html").read_text(), shutil.which("ffmpeg") is not None))
    if found:
        sys.exit("\n".join(found))


if __name__ == "__main__":
    main()
