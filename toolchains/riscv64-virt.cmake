# 64-bit RISC-V without an operating system, rv64gc, on the emulated board `virt`. Debian: g++-riscv64-linux-gnu (only its
# headers and libgcc are used); qemu-system-misc runs the result.
if(NOT nlo_core_flags)
  set(nlo_core_flags "-march=rv64gc -mabi=lp64d")
endif()
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR riscv64)
set(CMAKE_C_COMPILER riscv64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER riscv64-linux-gnu-g++)
set(CMAKE_ASM_COMPILER riscv64-linux-gnu-gcc)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY) # a program would need start-up code and a linker script

# The flags are those of arm-none-eabi.cmake. The memory of the board begins at 2^31, which needs the code model medany.
foreach(language IN ITEMS C CXX)
  set(CMAKE_${language}_FLAGS_INIT "${nlo_core_flags} -mcmodel=medany -fno-pie -ffunction-sections -fdata-sections")
  string(APPEND CMAKE_${language}_FLAGS_INIT " -fno-unwind-tables -fno-asynchronous-unwind-tables -fno-stack-protector")
  set(CMAKE_${language}_FLAGS_RELEASE "-O2 -DNDEBUG" CACHE STRING "Speed at a sensible size")
endforeach()
string(APPEND CMAKE_CXX_FLAGS_INIT " -fno-exceptions -fno-rtti -fno-threadsafe-statics")
set(CMAKE_ASM_FLAGS_INIT "${nlo_core_flags} -fno-pie")
set(CMAKE_EXE_LINKER_FLAGS_INIT "${nlo_core_flags}")
set(NLO_BOARD virt)
set(NLO_BOARD_DIR ${CMAKE_CURRENT_LIST_DIR}/riscv_virt)
set(NLO_BOARD_LINK_OPTIONS -nostdlib -static -no-pie -Wl,--build-id=none)

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
