# Cortex-M33 with DSP instructions and FPU, ARMv8-M mainline; runs in the secure state.
set(nlo_core_flags "-mthumb -mcpu=cortex-m33 -mfpu=fpv5-sp-d16 -mfloat-abi=hard")
set(NLO_BOARD mps2-an505)
include(${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake)
