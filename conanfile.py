# SPDX-License-Identifier: Apache-2.0
"""For Conan 2: conan create . --build=missing. What the libraries need comes from the system's packages, of the same versions
that everything else here is tested with; Conan checks that they are there, or installs them when
tools.system.package_manager:mode=install says so. Consumers find the library by its own CMake package or by pkg-config."""

import os
import re

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy, load
from conan.tools.system.package_manager import Apt


class FransacConan(ConanFile):
    name = "fransac"
    description = "Planes and obstacles in depth frames and point clouds"
    license = "Apache-2.0"
    topics = ("depth", "point-cloud", "plane-segmentation", "ransac", "robotics")
    package_type = "library"
    settings = "os", "compiler", "build_type", "arch"
    options = {"shared": [True, False], "fPIC": [True, False], "io": [True, False]}
    default_options = {"shared": False, "fPIC": True, "io": True}
    exports_sources = "CMakeLists.txt", "LICENSE", "cmake/*", "include/*", "src/*", "adapters/*"

    def set_version(self):
        text = load(self, os.path.join(self.recipe_folder, "CMakeLists.txt"))
        self.version = re.search(r"project\(fransac VERSION ([\d.]+)", text).group(1)

    def configure(self):
        if self.options.shared:
            self.options.rm_safe("fPIC")

    def layout(self):
        cmake_layout(self)

    def system_requirements(self):
        packages = ["libeigen3-dev", "libhwy-dev", "libtbb-dev"]
        if self.options.io:
            packages += ["pkgconf", "nlohmann-json3-dev", "libdeflate-dev", "libspng-dev", "libtiff-dev", "libturbojpeg0-dev", "libyaml-cpp-dev"]
        Apt(self).install(packages, check=True)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["FRANSAC_BUILD_IO"] = bool(self.options.io)
        toolchain.cache_variables["FRANSAC_BUILD_APP"] = False
        toolchain.cache_variables["FRANSAC_BUILD_TESTS"] = False
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))

    def package_info(self):
        # The library's own CMake package, which finds what it stands on, instead of one that Conan would write.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = [os.path.join("lib", "cmake", "fransac")]
        self.cpp_info.libs = ["fransac"]
        if self.options.io:
            self.cpp_info.libs.insert(0, "fransac_io")
