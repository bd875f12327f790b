#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared libraries show only what says CLOD_API (Export.h), and a static build does not tell where one is missing: what
other libraries take of the core must say it. `ShownSymbolsTest.py NM HEADERS CORE LIBRARY...`, the last two archives;
--self-test shows the check failing on planted faults."""
import pathlib
import re
import subprocess
import sys


def symbols(nm, archive):
    """Mangled names to (kind, name as in the source)."""
    plain, demangled = ([line.split(maxsplit=2) if line[:1] != " " else ["", *line.split(maxsplit=1)]
                         for line in subprocess.run([nm, *words, archive], check=True, capture_output=True, text=True).stdout.splitlines()
                         if re.match(r"[0-9a-f ]{16} \S ", line)] for words in ([], ["-C"]))
    return [(mangled, kind, name) for (_, kind, mangled), (_, _, name) in zip(plain, demangled)]


def is_shown(name, headers):
    """Does a header say that the function, or its class, is shown? By name: an overload that says it counts for all."""
    if name.startswith(("vtable for ", "typeinfo for ")):
        owner, function = name.split("::")[-1], None
    else:
        path = re.sub(r"\[abi:\w+\]|\(.*", "", name)
        while "<" in path:
            path, before = re.sub(r"<[^<>]*>", "", path), path
            if path == before:
                break
        owner, function = (["", *path.split("::")])[-2:]
    if owner and re.search(rf"\b(class|struct) CLOD_API {re.escape(owner)}\b", headers):
        return True
    return function is not None and re.search(rf"\bCLOD_API\b[^;{{}}]*[^\w:~]~?{re.escape(function)}\(", headers) is not None


def hidden(core, library, headers):
    """What the library needs of the core and would not find where that is a shared one."""
    defined = {mangled for mangled, kind, _ in core if kind in "TDBR"}  # what is inline, each has itself
    own = {mangled for mangled, kind, _ in library if kind != "U"}
    needed = {mangled: name for mangled, kind, name in library if kind == "U" and mangled in defined - own}
    return sorted(name for name in needed.values() if not is_shown(name, headers)), len(needed)


def self_test():
    headers = ("CLOD_API bool f(int a);\nbool g(int a);\nclass CLOD_API S\n{\nvoid m();\n};\nstruct H\n{\nvoid m2();\n"
               "CLOD_API static double n(int a);\n};\nCLOD_API Result<std::vector<int>> t(const A& a,\n\tint b);\n")
    needed = {"clod::f(int)": True, "clod::g(int)": False, "clod::S::m()": True, "clod::H::m2()": False, "clod::H::n(int)": True,
              "clod::t[abi:cxx11](clod::A const&, int)": True, "vtable for clod::S": True, "vtable for clod::H": False,
              "clod::S::S()": True, "clod::H::H()": False}
    core = [(name, "T", name) for name in needed] + [("weak", "W", "clod::weak()")]
    library = [(name, "U", name) for name in needed] + [("weak", "U", "clod::weak()"), ("other", "U", "other()")]
    expected = (sorted(name for name, shown in needed.items() if not shown), len(needed))
    found = hidden(core, library, headers)
    return [] if found == expected else [f"finds {found} instead of {expected}"]


def main():
    if sys.argv[1] == "--self-test":
        return self_test()
    nm, folder, core, *libraries = sys.argv[1:]
    headers = "".join(re.sub(r"//.*", "", path.read_text()) for path in sorted(pathlib.Path(folder).rglob("*.h")))
    of_core, faults, most = symbols(nm, core), [], 0
    for library in libraries:
        names, count = hidden(of_core, symbols(nm, library), headers)
        most = max(most, count)
        faults += [f"{pathlib.Path(library).name} needs {name}, which is not CLOD_API" for name in names]
    return faults if most > 0 else ["none of the libraries needs anything: their symbols were not read"]


if __name__ == "__main__":
    found = main()
    if found:
        sys.exit("\n".join(found))
