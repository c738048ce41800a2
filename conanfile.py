# SPDX-License-Identifier: MIT
"""The header-only runtime as a package of Conan 2: conan create . The program `nlo` is not in it."""
import os

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.files import copy


class Nlo(ConanFile):
    name = "nlo"
    version = "0.2.0"
    description = "Runtime of neural Luenberger observers that nlo has exported"
    topics = ("state-estimation", "observer", "control", "embedded", "header-only")
    license = "MIT"
    package_type = "header-library"
    settings = "compiler"  # for validate(); the package is the same for all
    exports_sources = "runtime/include/*", "LICENSE"
    no_copy_source = True

    def validate(self):
        if self.settings.compiler.get_safe("cppstd"):
            check_min_cppstd(self, 20)

    def package_id(self):
        self.info.clear()

    def package(self):
        headers = os.path.join(self.source_folder, "runtime", "include")
        copy(self, "*", headers, os.path.join(self.package_folder, "include"))
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))

    def package_info(self):
        self.cpp_info.set_property("cmake_target_name", "nlo::runtime")
        self.cpp_info.bindirs = []
        self.cpp_info.libdirs = []
