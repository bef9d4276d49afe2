# What the bare-metal Arm toolchain files share; SEGCAL_CPU_OPTIONS and SEGCAL_PORT come from them.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

set(CMAKE_C_FLAGS_INIT "${SEGCAL_CPU_OPTIONS} -ffunction-sections -fdata-sections -fno-unwind-tables -fno-asynchronous-unwind-tables")
set(CMAKE_CXX_FLAGS_INIT "${CMAKE_C_FLAGS_INIT}")
set(CMAKE_ASM_FLAGS_INIT "${SEGCAL_CPU_OPTIONS}")

# Programs are the host's; Eigen's headers are too.
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
