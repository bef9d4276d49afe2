# The library's sources, relative to lib/: the one list that every build uses (CMake, Zephyr, ESP-IDF; library.json for
# PlatformIO repeats it, and a test compares).
set(SEGCAL_CORE_SOURCES
  src/api/capacities.cpp
  src/api/convert.cpp
  src/api/device.cpp
  src/api/effects.cpp
  src/api/epochs.cpp
  src/api/health.cpp
  src/api/kept.cpp
  src/api/memory.cpp
  src/api/options.cpp
  src/api/posterior.cpp
  src/api/residuals.cpp
  src/api/results.cpp
  src/api/segcal.cpp
  src/log/writer.cpp)

# A memory that outlives power (store.h): a library of its own, for who wants it.
set(SEGCAL_STORE_SOURCES
  src/log/state.cpp
  src/store/device_records.cpp
  src/store/ring_look.cpp
  src/store/ring_save.cpp
  src/store/store.cpp)

# The offset of the camera's clock, before a device is started (clock.h): a library of its own too.
set(SEGCAL_CLOCK_SOURCES
  src/clock/clock.cpp)

# What the core is compiled with everywhere. Outside a shared library only the C API is seen (segcal.h makes it visible). Bits: no contraction, no reassociation, no vector kernels of Eigen's. No heap,
# exceptions, RTTI or guards of statics.
set(SEGCAL_CORE_C_OPTIONS -ffp-contract=off -fno-math-errno -fvisibility=hidden)
set(SEGCAL_CORE_CXX_OPTIONS -fno-exceptions -fno-rtti -fno-threadsafe-statics)
# GCC may let inlining make a unit 40 % larger, and here it does. With 25 % the code is 5 % smaller on a Cortex-M7, and a frame takes
# 2 % more instructions, a score 3 %. Other compilers do not know the parameter.
if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  list(APPEND SEGCAL_CORE_CXX_OPTIONS --param=inline-unit-growth=25)
endif()
# Eigen's checks call assert(), which a library without libc's must not; with SEGCAL_ASSERT=1 they call the port's instead.
set(SEGCAL_CORE_DEFINITIONS EIGEN_DONT_VECTORIZE EIGEN_NO_MALLOC EIGEN_NO_IO EIGEN_DONT_PARALLELIZE EIGEN_NO_DEBUG)
