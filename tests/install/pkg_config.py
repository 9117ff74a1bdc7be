#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compiles, links and runs a program with nothing but what pkg-config says: pkg_config.py COMPILER PREFIX PACKAGE SOURCE FOLDER."""

import os
import pathlib
import shlex
import subprocess
import sys

compiler, prefix, package, source, folder = sys.argv[1:]
[file] = pathlib.Path(prefix).rglob(f"{package}.pc")
environment = {**os.environ, "PKG_CONFIG_PATH": str(file.parent), "LD_LIBRARY_PATH": str(file.parent.parent)}


def pkg_config(*words):
    return subprocess.run(["pkg-config", *words], env=environment, stdout=subprocess.PIPE, text=True, check=True).stdout


flags = shlex.split(pkg_config("--cflags", "--libs", package))
if os.path.realpath(file.parent.parent) not in [os.path.realpath(flag[2:]) for flag in flags if flag.startswith("-L")]:
    sys.exit(f"{package} is looked for elsewhere: {flags}")
program = pathlib.Path(folder) / package
program.parent.mkdir(parents=True, exist_ok=True)
subprocess.run([compiler, "-std=c++20", source, "-o", program, *flags], check=True)
subprocess.run([program], env=environment, cwd=folder, check=True)
print(package, pkg_config("--modversion", package).strip())
