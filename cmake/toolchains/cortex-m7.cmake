# Cortex-M7 with a double precision FPU; for one with single precision: -mfpu=fpv5-sp-d16. The bits are the same.
set(SEGCAL_CPU_OPTIONS "-mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16")
set(SEGCAL_PORT mps2_an500)
include(${CMAKE_CURRENT_LIST_DIR}/arm-none-eabi.cmake)
