# Cortex-M55 with vectors of floats (MVE) and FPU, ARMv8.1-M mainline; runs in the secure state.
set(nlo_core_flags "-mthumb -mcpu=cortex-m55 -mfloat-abi=hard")
set(NLO_BOARD mps3-an547)
include(${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake)
