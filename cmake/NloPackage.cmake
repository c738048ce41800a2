# cmake --build DIR --target package: the Debian packages nlo (the program), libnlo-dev (headers, CMake, pkg-config),
# libnlo-model and python3-nlo (bindings).
# The program of the packages is built separately, in DIR/package, for any processor of the architecture. With
# -march=native, the default of a build for your own machine, it would stop with an illegal instruction on another
# machine. No tests are built there.
set(CMAKE_SKIP_PACKAGE_ALL_DEPENDENCY ON)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The nlo authors <nlo@example.invalid>" CACHE STRING "Maintainer of the packages that you publish")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_COMPONENTS_ALL runtime)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME libnlo-dev)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "nlo, libeigen3-dev") # the second for nlo/eigen.h
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION "learned state observers for control loops (headers)
A header-only C++20 runtime for observers that nlo has trained and exported:
no heap, no exceptions and no other library, for PCs and microcontrollers.
With a CMake package and a pkg-config file.")

if(NOT NLO_RUNTIME_ONLY)
  list(APPEND CPACK_COMPONENTS_ALL program)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME nlo)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "libnlo-dev (= ${PROJECT_VERSION}), gnuplot-nox | gnuplot") # nlo report
  set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "trains learned state observers for control loops
Trains a neural Luenberger observer from a model of the plant or from logs,
compares it with Kalman filters, and exports it as a C++20 header, C99, an
Arduino library or a Zephyr module.")
endif()

if(NLO_BINDINGS AND NOT NLO_RUNTIME_ONLY)
  list(APPEND CPACK_COMPONENTS_ALL model python)
  set(CPACK_DEBIAN_MODEL_PACKAGE_NAME libnlo-model)
  set(CPACK_DEBIAN_MODEL_PACKAGE_SECTION libs)
  set(CPACK_DEBIAN_MODEL_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_MODEL_DESCRIPTION "learned state observers for control loops (C library)
Loads the models that nlo has trained and steps them, through one C interface
for every structure. With its header and a pkg-config file.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-nlo)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.9), python3-numpy, libnlo-model (= ${PROJECT_VERSION}), nlo (= ${PROJECT_VERSION})")
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "learned state observers for control loops (Python)
Runs models over numpy arrays, trains them from plants and DataFrames,
evaluates and exports them.")
endif()

set(CPACK_INSTALL_CMAKE_PROJECTS "${PROJECT_BINARY_DIR}/package;nlo;ALL;/")
set(CPACK_INSTALL_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/package_build.cmake)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/package_documents.cmake)
set(CPACK_NLO_SOURCE ${PROJECT_SOURCE_DIR})
set(CPACK_NLO_BUILD ${PROJECT_BINARY_DIR}/package)
string(REPLACE ";" ":" CPACK_NLO_PREFIX_PATH "${CMAKE_PREFIX_PATH}")
set(CPACK_NLO_SETTINGS -G ${CMAKE_GENERATOR} -DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER} -DCMAKE_BUILD_TYPE=Release
  -DNLO_RUNTIME_ONLY=${NLO_RUNTIME_ONLY} -DNLO_NATIVE=OFF -DNLO_WARNINGS_AS_ERRORS=OFF
  -DNLO_TESTS=OFF -DNLO_BENCH=OFF -DNLO_EXAMPLES=OFF)
include(CPack)
