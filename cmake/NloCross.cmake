# Cross builds of this tree (presets cortex-*, aarch64, riscv*): the programs that run on the target. The trainer and
# `nlo export` stay on the host.
set(NLO_PROGRAM ${PROJECT_SOURCE_DIR}/build/release/trainer/nlo CACHE FILEPATH "`nlo` of the host, which exports the models")
if(NOT EXISTS ${NLO_PROGRAM})
  message(FATAL_ERROR "There is no ${NLO_PROGRAM}. Build `nlo` for this machine first (cmake --preset release && cmake "
    "--build build/release --target nlo), or name another with -DNLO_PROGRAM=...")
endif()
include(codegen/cmake/NloAddModel.cmake)

if(NLO_BOARD)
  include(toolchains/NloFirmware.cmake)
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL arm) # the firmware uses the timer of a Cortex-M
    add_subdirectory(examples/firmware)
    target_link_libraries(firmware PRIVATE nlo_warnings)
  endif()
  add_subdirectory(tests/embedded/target)
  add_subdirectory(bench/embedded)
else()
  add_subdirectory(examples/minimal)
endif()
