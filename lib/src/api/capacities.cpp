// A mismatch of capacities in words.
#include "api/capacities.h"

namespace SEGCAL_NS {
namespace {

const char* const kNames[SEGCAL_N_CAPACITIES] = {
    "SEGCAL_MAX_CAMERAS",      "SEGCAL_MAX_SEGMENTS",    "SEGCAL_MAX_KEYFRAMES",        "SEGCAL_MAX_LANDMARKS",
    "SEGCAL_MAX_OBSERVATIONS", "SEGCAL_MAX_IMU_SAMPLES", "SEGCAL_MAX_CLONES",           "SEGCAL_MAX_TRACKS",
    "SEGCAL_FRAME_FEATURES",   "SEGCAL_START_DELAY_MS",  "SEGCAL_WAITING_FRAMES",       "SEGCAL_MAX_TIES",
    "SEGCAL_SHARED_LANDMARKS", "SEGCAL_IMU_HISTORY",     "SEGCAL_MAX_EFFECT_ESTIMATES", "SEGCAL_MAX_EFFECT_COLUMNS",
    "SEGCAL_PIXEL_BITS",       "SEGCAL_MAX_EPOCHS"};

/// Text into a caller's buffer; what does not fit is cut off.
class Line {
 public:
  Line(char* to, std::size_t bytes) : to_(to), end_(to + bytes - 1) { *to_ = 0; }
  void add(const char* text) {
    while (*text && to_ < end_) *to_++ = *text++;
    *to_ = 0;
  }
  void add(std::uint32_t number) {
    char digits[11];
    int at = 10;
    digits[at] = 0;
    do {
      digits[--at] = static_cast<char>('0' + number % 10);
      number /= 10;
    } while (number > 0);
    add(digits + at);
  }

 private:
  char *to_, *end_;
};

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" {

[[gnu::cold]] int segcal_explain_capacities(const uint32_t* capacities, char* line, size_t bytes) {
  if (!capacities || !line) return SEGCAL_ERROR_NULL;
  if (bytes == 0) return SEGCAL_ERROR_SIZE;
  Line out(line, bytes);
  const int i = first_difference(capacities);
  if (i == SEGCAL_N_CAPACITIES) return 0;
  out.add(kNames[i]);
  out.add(": the program has ");
  out.add(capacities[i]);
  out.add(", the library ");
  out.add(kCapacities[i]);
  return 1;
}

}  // extern "C"
