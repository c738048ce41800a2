# Bare-metal Arm, Debian's gcc-arm-none-eabi with newlib. Included by the file of each core, which sets
#   nlo_core_flags  flags of the compiler and the linker for the core
#   NLO_BOARD       the emulated board with this core: name of a linker script in NLO_BOARD_DIR and of a machine of
#                   qemu-system-arm
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_ASM_COMPILER arm-none-eabi-gcc)
set(CMAKE_SIZE arm-none-eabi-size)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY) # a program would need start-up code and a linker script

# With a section per function, the linker drops functions that nobody calls. Start-up code for guarded statics, exception
# tables and type information are switched off, because a control loop does not need them.
foreach(language IN ITEMS C CXX)
  set(CMAKE_${language}_FLAGS_INIT "${nlo_core_flags} -ffunction-sections -fdata-sections")
  set(CMAKE_${language}_FLAGS_RELEASE "-O2 -DNDEBUG" CACHE STRING "Speed at a sensible size")
endforeach()
string(APPEND CMAKE_CXX_FLAGS_INIT " -fno-exceptions -fno-rtti -fno-threadsafe-statics -fno-unwind-tables")
string(APPEND CMAKE_CXX_FLAGS_INIT " -fno-asynchronous-unwind-tables")
set(CMAKE_ASM_FLAGS_INIT "${nlo_core_flags}")
set(CMAKE_EXE_LINKER_FLAGS_INIT "${nlo_core_flags}")
set(NLO_BOARD_DIR ${CMAKE_CURRENT_LIST_DIR}/cortex_m)
# nano.specs: the small newlib, for the memcpy and memset that a compiler may call.
set(NLO_BOARD_LINK_OPTIONS -nostartfiles --specs=nano.specs --specs=nosys.specs)

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER) # programs run on the host; headers such as Eigen's are used for both
