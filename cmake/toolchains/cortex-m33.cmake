# Cortex-M33 with a single precision FPU.
set(SEGCAL_CPU_OPTIONS "-mcpu=cortex-m33 -mthumb -mfloat-abi=hard -mfpu=fpv5-sp-d16")
set(SEGCAL_PORT mps2_an505)
include(${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake)
