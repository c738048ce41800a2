# RISC-V of 64 bits with vectors of 128 bits or more (V), which the runtime's kernels use.
set(nlo_core_flags "-march=rv64gcv -mabi=lp64d")
include(${CMAKE_CURRENT_LIST_DIR}/riscv64-virt.cmake)
