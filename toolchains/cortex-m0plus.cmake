# Cortex-M0 and M0+: ARMv6-M, no FPU. QEMU emulates the M0 (microbit), which has the same instructions.
set(nlo_core_flags "-mthumb -mcpu=cortex-m0plus -mfloat-abi=soft")
set(NLO_BOARD microbit)
include(${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake)
