# Cortex-M55 with FPU and MVE.
set(SEGCAL_CPU_OPTIONS "-mcpu=cortex-m55 -mthumb -mfloat-abi=hard")
set(SEGCAL_PORT mps3_an547)
include(${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake)
