// Unity as a C++ test wants it: its macros `isnan` and `isinf`, for C libraries without them, would break std::isnan.
#include_next <unity.h>
#ifdef __cplusplus
#undef isnan
#undef isinf
#endif
