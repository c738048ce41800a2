# Cortex-M4F: ARMv7E-M with DSP instructions and a single-precision FPU.
set(nlo_core_flags "-mthumb -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard")
set(NLO_BOARD mps2-an386)
include(${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake)
