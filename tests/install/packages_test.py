#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Debian packages in a system of their own: packages_test.py FOLDER COMPILER CONSUMER [CMAKE-OPTION…], FOLDER with the *.deb files.

dpkg installs them into an empty folder whose list of packages is this machine's, so that it judges their dependencies; a program of
somebody else's (the CMake project CONSUMER) is built against that folder alone, and the tool is run from there. Needs no network, and
no other rights than this folder's. Exit code 77 where dpkg is missing. lintian is asked where it is installed.
"""

import contextlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

if not shutil.which("dpkg-deb") or len(sys.argv) < 4:
    print("skipped: dpkg is missing" if len(sys.argv) >= 4 else __doc__)
    sys.exit(77 if len(sys.argv) >= 4 else 2)
FOLDER, CONSUMER = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[3])
COMPILER = sys.argv[2]
CMAKE_OPTIONS = sys.argv[4:]
del sys.argv[1:]
PYTHON = "/usr/bin/python3"  # the one that Debian's packages are for
PACKAGES = sorted(pathlib.Path(FOLDER).glob("*.deb"))


def run(*words, **more):
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **more)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, words))}: exit {done.returncode}\n{done.stdout}")
    return done.stdout


def field(package, name):
    return run("dpkg-deb", "--field", package, name).strip()


def by_name():
    return {field(package, "Package"): package for package in PACKAGES}


class Contents(unittest.TestCase):
    """What stands in the packages."""

    def test_there_are_these(self):
        names = [re.sub(r"[\d.]+$", "", name) for name in by_name()]
        self.assertEqual(sorted(names), ["fransac", "libfransac", "libfransac-dev", "libfransac-pcl-dev", "python3-fransac"])

    def test_dependencies(self):
        packages = by_name()
        [library] = [name for name in packages if re.fullmatch(r"libfransac[\d.]+", name)]
        same = f"(= {field(packages[library], 'Version')})"
        wanted = {
            library: ["libc6 (", "libtbb12 (", "libhwy1 (", "libdeflate0 (", "libspng0 (", "libtiff6 (", "libturbojpeg0 (", "libyaml-cpp0.7 ("],
            "libfransac-dev": [f"{library} {same}", "libeigen3-dev"],
            "libfransac-pcl-dev": [f"libfransac-dev {same}", "libpcl-dev"],
            "fransac": [f"{library} {same}", "libfmt9 ("],
            "python3-fransac": [f"{library} {same}", "python3 (>= 3.", "python3-numpy (>= ", "libstdc++6 ("],
        }
        for name, needs in wanted.items():
            depends = field(packages[name], "Depends")
            for need in needs:
                self.assertIn(need, depends, name)
        # Nobody gets PCL who does not ask for its place.
        self.assertNotIn("pcl", field(packages[library], "Depends"))
        self.assertNotIn("pcl", field(packages["libfransac-dev"], "Depends"))

    def test_the_python_module_is_for_the_version_of_python_that_it_asks_for(self):
        package = by_name()["python3-fransac"]
        [module] = re.findall(r" \./usr/lib/python3/dist-packages/fransac/_core\.(\S+)\.so\n", run("dpkg-deb", "--contents", package))
        minor = int(run(PYTHON, "-c", "import sys; print(sys.version_info.minor)"))
        depends = re.findall(r"python3 \(([^)]+)\)", field(package, "Depends"))
        if module == "abi3":
            self.assertEqual(depends, [f">= 3.{minor}"])
        else:
            self.assertTrue(module.startswith(f"cpython-3{minor}-"), module)
            self.assertEqual(depends, [f">= 3.{minor}", f"<< 3.{minor + 1}"])

    def test_the_tool_brings_its_manual_and_completions(self):
        listing = run("dpkg-deb", "--contents", by_name()["fransac"])
        for file in ("bin/fransac", "share/man/man1/fransac.1.gz", "share/bash-completion/completions/fransac",
                     "share/zsh/vendor-completions/_fransac", "share/fish/vendor_completions.d/fransac.fish",
                     "share/doc/fransac/copyright", "share/doc/fransac/changelog.Debian.gz"):
            self.assertIn(f" ./usr/{file}\n", listing)

    def test_no_file_is_in_two(self):
        files = []
        for package in PACKAGES:
            files += re.findall(r" (\./\S+[^/\s])(?: -> .*)?\n", run("dpkg-deb", "--contents", package))
        self.assertEqual(sorted(files), sorted(set(files)))

    @unittest.skipUnless(shutil.which("lintian"), "lintian is not installed")
    def test_lintian_finds_nothing(self):
        root = ["--allow-root"] if os.geteuid() == 0 else []
        # The address of the maintainer is for whoever publishes the packages to fill in.
        # It is no upload to Debian; and CPack lets the packages call ldconfig besides asking for it.
        tags = "bogus-mail-host,initial-upload-closes-no-bugs,maintscript-calls-ldconfig"
        run("lintian", *root, "--no-cfg", "--fail-on", "error,warning", "--suppress-tags", tags, *PACKAGES)


class Installation(unittest.TestCase):
    """The packages in a root of their own."""

    @classmethod
    def setUpClass(cls):
        cls.stack = contextlib.ExitStack()
        cls.root = pathlib.Path(cls.stack.enter_context(tempfile.TemporaryDirectory()))
        admin = cls.root / "var/lib/dpkg"
        (admin / "info").mkdir(parents=True)
        (admin / "updates").mkdir()
        shutil.copy("/var/lib/dpkg/status", admin)
        info = pathlib.Path("/var/lib/dpkg/info")
        for file in [*info.glob("*.list"), info / "format"]:  # without them dpkg warns of each package
            shutil.copy(file, admin / "info")
        # Scripts and triggers would want the rest of a system.
        run("dpkg", f"--root={cls.root}", f"--log={cls.root}/dpkg.log", "--force-not-root", "--force-script-chrootless", "--no-triggers",
            "--install", *PACKAGES, env={**os.environ, "PATH": f"{os.environ['PATH']}:/usr/sbin:/sbin"})
        [cls.libraries] = {library.parent for library in cls.root.rglob("libfransac*.so.*")}

    @classmethod
    def tearDownClass(cls):
        cls.stack.close()

    def environment(self):
        return {**os.environ, "LD_LIBRARY_PATH": str(self.libraries), "PKG_CONFIG_PATH": str(self.libraries / "pkgconfig")}

    def test_dpkg_has_them_all_as_they_were(self):
        for name in by_name():
            status = run("dpkg-query", f"--root={self.root}", "--show", "--showformat=${db:Status-Status}", name)
            self.assertEqual(status, "installed", name)
            self.assertEqual(run("dpkg", f"--root={self.root}", "--verify", name), "")

    def test_the_tool_runs(self):
        with tempfile.TemporaryDirectory() as folder:
            tool = self.root / "usr/bin/fransac"
            for line in run("ldd", tool, env=self.environment()).splitlines():
                if "libfransac" in line:
                    self.assertIn(f"=> {self.libraries}/", line)
            run(tool, "synth", "frames", "--width", "160", "--height", "120", cwd=folder, env=self.environment())
            run(tool, "segment", "frames", "--cloud", "clouds", cwd=folder, env=self.environment())
            self.assertTrue(list(pathlib.Path(folder, "clouds").glob("*.ply")))

    def test_the_python_package_segments(self):
        folder = self.root / "usr/lib/python3/dist-packages"
        program = """
import sys
import fransac
assert fransac.__file__.startswith(sys.argv[1]), fransac.__file__
frame = fransac.synth("desk")
found = fransac.segment(frame.depth, frame.camera)
assert found.labels.shape == frame.depth.shape and len(found.planes) >= 2, found
"""
        environment = {**self.environment(), "PYTHONPATH": str(folder)}
        run(PYTHON, "-B", "-c", program, folder, env=environment)
        lines = [line for line in run("ldd", *folder.glob("fransac/_core*.so"), env=environment).splitlines() if "libfransac" in line]
        self.assertTrue(lines)
        for line in lines:
            self.assertIn(f"=> {self.libraries}/", line)

    def test_nothing_tells_where_it_was_built(self):
        dynamic = run("readelf", "--dynamic", self.root / "usr/bin/fransac", *self.libraries.glob("libfransac*.so.*.*.*"),
                      *self.root.glob("usr/lib/python3/dist-packages/fransac/*.so"))
        self.assertNotIn("RUNPATH", dynamic)

    def test_a_program_is_built_against_them(self):
        with tempfile.TemporaryDirectory() as build:
            run("cmake", "-S", CONSUMER, "-B", build, "-G", "Ninja", "-DCONSUMER_READS_FILES=ON", "-DCONSUMER_USES_PCL=ON", f"-DCMAKE_CXX_COMPILER={COMPILER}",
                f"-DCMAKE_PREFIX_PATH={self.root}/usr", *CMAKE_OPTIONS)
            cache = pathlib.Path(build, "CMakeCache.txt").read_text(encoding="utf-8")
            self.assertIn(f"fransac_DIR:PATH={self.root}", cache)
            run("cmake", "--build", build)
            for program in ("segment_a_wall", "write_and_read", "pcl_plane"):
                run(pathlib.Path(build, program), cwd=build, env=self.environment())

    def test_pkg_config_finds_them(self):
        flags = run("pkg-config", "--cflags", "--libs", "fransac-io", env=self.environment())
        self.assertIn("-lfransac_io", flags)


if __name__ == "__main__":
    unittest.main(verbosity=2)
