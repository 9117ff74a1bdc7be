#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs golden cases of the command line.

  run_cases.py list FILE                          names of the cases
  run_cases.py run FILE NAME FRANSAC              runs one

A *.cases file is lines of a keyword and its text; '#' comments. Each case runs in a fresh folder:

  case NAME            begins a case
  make KIND ARG …      an input, by the function of that name in inputs.py
  run ARG …            what follows "fransac" (shell quoting); several: one after the other, the last one is looked at
  stdout-to FILE       where stdout goes; "closed" is a pipe that nobody reads
  exit CODE            default 0
  stdout REGEX         found in stdout (multi-line); several: all
  stderr REGEX         the same for stderr
  json PATH [VALUE]    stdout is JSON that has this path (keys and indices joined by '.'), with this JSON value
  json-lines N         stdout is N lines, each a JSON document
  partial              some of several frames fail (exit 1): what the others gave is printed and written all the same
  absent FILE          does not exist afterwards
  exists FILE          exists afterwards and is not empty
  png FILE W H BITS    is a grey or colour PNG of this size and depth
  object-ids FILE PATH is a 16-bit grey PNG, or a PLY with a property obstacle, of the "id"s of the list at PATH in stdout's JSON, each on
                       its number of "pixels", and 0
  csv FILE ROWS COLS   is a table of this size

Always checked: a case that fails (exit other than 0) prints nothing to stdout, says why on stderr after "fransac: ", and
neither leaves a new file nor changes one; a case that succeeds prints nothing to stderr unless `stderr` expects it.
"""
import collections
import csv
import json
import math
import os
import re
import shlex
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import inputs


def read_cases(file):
    cases = {}
    case = None
    for number, line in enumerate(Path(file).read_text(encoding="utf-8").splitlines(), 1):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        keyword, _, text = line.partition(" ")
        if keyword == "case":
            if text in cases:
                sys.exit(f"{file}:{number}: a second case '{text}'")
            case = cases[text] = []
        else:
            case.append((keyword, text.strip()))
    return cases


def snapshot(folder):
    return {path.relative_to(folder): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


def execute(fransac, arguments, folder, stdout_to):
    command = [fransac, *shlex.split(arguments)]
    if stdout_to == "closed":
        reader, writer = os.pipe()
        os.close(reader)
        with os.fdopen(writer, "wb") as closed:
            return subprocess.run(command, cwd=folder, stdout=closed, stderr=subprocess.PIPE, timeout=100, check=False)
    if stdout_to:
        with open(stdout_to, "wb") as file:
            return subprocess.run(command, cwd=folder, stdout=file, stderr=subprocess.PIPE, timeout=100, check=False)
    return subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=100, check=False)


def look_up(document, path):
    for key in path.split("."):
        document = document[int(key)] if isinstance(document, list) else document[key]
    return document


def check_png(folder, text):
    name, width, height, bits = text.split()
    header = (folder / name).read_bytes()[:26]
    assert header[:8] == inputs.PNG_SIGNATURE, f"{name} is no PNG"
    found = struct.unpack(">IIB", header[16:25])
    assert found == (int(width), int(height), int(bits)), f"{name} is {found}"


def check_object_ids(folder, stdout, text):
    name, _, path = text.partition(" ")
    data = (folder / name).read_bytes()
    found = collections.Counter(inputs.ply_column(data, "obstacle") if name.endswith(".ply") else inputs.grey(data, 16))
    del found[0]
    listed = {entry["id"]: entry["pixels"] for entry in look_up(json.loads(stdout), path)}
    assert found == listed, f"{name} holds {dict(found)}, the list {listed}"


def check_csv(folder, text):
    name, rows, columns = text.split()
    with open(folder / name, newline="", encoding="utf-8") as file:
        table = list(csv.reader(file))
    assert len(table) == int(rows), f"{name} has {len(table)} rows"
    assert all(len(row) == int(columns) for row in table), f"{name} has rows of {sorted({len(row) for row in table})} columns"


def check_json(stdout, text):
    """A number with a decimal point is compared to six digits."""
    path, _, value = text.partition(" ")
    found = look_up(json.loads(stdout), path)
    if not value:
        return
    wanted = json.loads(value)
    same = math.isclose(found, wanted, rel_tol=1e-6, abs_tol=1e-6) if isinstance(wanted, float) else found == wanted
    assert same, f"{path} is {found!r}"


def check_json_lines(stdout, text):
    lines = stdout.splitlines()
    assert len(lines) == int(text), f"{len(lines)} lines"
    for line in lines:
        json.loads(line)


def check_exists(folder, name):
    path = folder / name
    assert path.exists(), f"{name} does not exist"
    assert path.is_dir() or path.stat().st_size > 0, f"{name} is empty"


def check_always(case, code, stdout, stderr, before, after):
    if code != 0:
        assert stderr.startswith("fransac: "), "a failure must say why"
        assert "internal error" not in stderr, "an internal error is never expected"
        if any(keyword == "partial" for keyword, _ in case):
            return
        assert stdout == "", "a failure must print nothing to stdout"
        assert after == before, f"files left behind or changed: {[str(p) for p in after if after[p] != before.get(p, b'?')]}"
    elif not any(keyword == "stderr" for keyword, _ in case):
        assert stderr == "", "nothing was expected on stderr"


def check_case(case, result, folder, before):
    stdout = (result.stdout or b"").decode("utf-8", "replace")
    stderr = result.stderr.decode("utf-8", "replace")
    expected = int(next((text for keyword, text in case if keyword == "exit"), "0"))
    try:
        assert result.returncode == expected, f"exit code {result.returncode}, not {expected}"
        for keyword, text in case:
            if keyword in ("stdout", "stderr"):
                assert re.search(text, stdout if keyword == "stdout" else stderr, re.MULTILINE), f"{keyword} lacks: {text}"
            elif keyword == "json":
                check_json(stdout, text)
            elif keyword == "json-lines":
                check_json_lines(stdout, text)
            elif keyword == "exists":
                check_exists(folder, text)
            elif keyword == "absent":
                assert not (folder / text).exists(), f"{text} exists"
            elif keyword == "png":
                check_png(folder, text)
            elif keyword == "object-ids":
                check_object_ids(folder, stdout, text)
            elif keyword == "csv":
                check_csv(folder, text)
            elif keyword not in ("make", "run", "stdout-to", "exit", "partial"):
                sys.exit(f"unknown keyword '{keyword}'")
        check_always(case, result.returncode, stdout, stderr, before, snapshot(folder))
    except (AssertionError, LookupError, ValueError, OSError) as error:
        sys.exit(f"FAILED: {error!r}\n--- stdout\n{stdout}\n--- stderr\n{stderr}")


def run_case(case, fransac):
    stdout_to = next((text for keyword, text in case if keyword == "stdout-to"), None)
    with tempfile.TemporaryDirectory(prefix="fransac_cli_") as name:
        folder = Path(name)
        result = before = None
        for keyword, text in case:
            if keyword == "make":
                kind, *arguments = shlex.split(text)
                getattr(inputs, kind)(folder, *arguments)
            elif keyword == "run":
                before = snapshot(folder)
                result = execute(fransac, text, folder, stdout_to)
        check_case(case, result, folder, before)


def main():
    action, file, *rest = sys.argv[1:]
    cases = read_cases(file)
    if action == "list":
        print("\n".join(cases))
    else:
        run_case(cases[rest[0]], rest[1])


main()
