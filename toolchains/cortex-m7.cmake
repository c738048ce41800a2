# Cortex-M7 with a single-precision FPU (programs for it also run on the variant with double precision).
set(nlo_core_flags "-mthumb -mcpu=cortex-m7 -mfpu=fpv5-sp-d16 -mfloat-abi=hard")
set(NLO_BOARD mps2-an500)
include(${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake)
