#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Documents: links lead somewhere, code is compiled, sizes are kept. `DocumentsTest.py ROOT`; --self-test shows each
check failing on a planted fault."""
import pathlib
import re
import sys
import tempfile

MOST_WORDS = 12000  # of all documents but what was tried, generated tables and the log of changes
MOST_README_LINES = 200
UNCOUNTED = ["plugin/docs/tried.md", "demos/results/README.md", "CHANGES.md"]  # the second is written by a script
COMPILED = ["demos/example/Example.cpp", "demos/example/HowTo.cpp"]


def documents(root):
    skipped = ("build", ".git", "out")
    return sorted(path for path in root.rglob("*.md") if path.relative_to(root).parts[0] not in skipped)


def broken_links(root):
    for path in documents(root):
        text = re.sub(r"```.*?```", "", path.read_text(), flags=re.S)
        for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
            if "://" not in target and not (path.parent / target).exists():
                yield f"{path.relative_to(root)}: {target} is not there"


def code_not_compiled(root):
    lines = {line.strip() for source in COMPILED for line in (root / source).read_text().splitlines()}
    for path in documents(root):
        for block in re.findall(r"```cpp\n(.*?)```", path.read_text(), flags=re.S):
            for line in block.splitlines():
                if line.strip() and line.strip() not in lines:
                    yield f"{path.relative_to(root)}: '{line.strip()}' is in none of {', '.join(COMPILED)}"


def sizes(root):
    words = {path: sum(any(c.isalnum() for c in word) for word in path.read_text().split()) for path in documents(root)}
    total = sum(count for path, count in words.items() if str(path.relative_to(root)) not in UNCOUNTED)
    if total > MOST_WORDS:
        yield f"{total} words in all documents but {', '.join(UNCOUNTED)}, at most {MOST_WORDS}"
    lines = len((root / "README.md").read_text().splitlines())
    if lines > MOST_README_LINES:
        yield f"README.md has {lines} lines, at most {MOST_README_LINES}"


CHECKS = [broken_links, code_not_compiled, sizes]


def self_test():
    def faults(check, readme):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for source in COMPILED:
                (root / source).parent.mkdir(parents=True, exist_ok=True)
                (root / source).write_text("int main()\n{\n\tknown();\n}\n")
            (root / "README.md").write_text(readme)
            return len(list(check(root)))

    expected = [(broken_links, "[a](README.md) [b](https://x.y/z)", 0), (broken_links, "[a](none.md)", 1),
                (code_not_compiled, "```cpp\nknown();\n```", 0), (code_not_compiled, "```cpp\nunknown();\n```", 1),
                (sizes, "word " * MOST_WORDS, 0), (sizes, "word " * (MOST_WORDS + 1), 1), (sizes, "\n" * 201, 1)]
    return [f"{check.__name__} finds {faults(check, text)} faults instead of {count}"
            for check, text, count in expected if faults(check, text) != count]


if __name__ == "__main__":
    found = self_test() if sys.argv[1] == "--self-test" else [f for check in CHECKS for f in check(pathlib.Path(sys.argv[1]))]
    if found:
        sys.exit("\n".join(found))
