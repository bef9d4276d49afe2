// The C API of the search for the offset of two clocks: checks, and nothing else.
#include "segcal/clock.h"

#include <new>

#include "api/camera_from_c.h"
#include "clock/device_clock.h"

namespace SEGCAL_NS {
namespace {

using ClockReal = SEGCAL_REAL;

struct Clock {
  static constexpr std::uint32_t kMagic = 0x5E6CC10Cu;
  std::uint32_t magic;
  DeviceClock<ClockReal> search;
};
static_assert(sizeof(Clock) <= sizeof(segcal_clock_t), "SEGCAL_CLOCK_BYTES is too small");
static_assert(sizeof(Clock) + 512 >= sizeof(segcal_clock_t), "SEGCAL_CLOCK_BYTES is larger than it needs to be");
static_assert(alignof(Clock) <= alignof(segcal_clock_t), "segcal_clock_t is not aligned enough");

Clock* created(segcal_clock_t* clock) {
  Clock* c = reinterpret_cast<Clock*>(clock);
  return c && c->magic == Clock::kMagic ? c : nullptr;
}
const Clock* created(const segcal_clock_t* clock) { return created(const_cast<segcal_clock_t*>(clock)); }

constexpr double kMostStart_s = 1000;
// rad/s: what turns faster is a reading gone wrong, and is farther in 0.25 s than angles are kept
constexpr float kMostRate = 100;

bool is_rate(float w) { return w >= -kMostRate && w <= kMostRate; }  // no for not-a-number

/// As segcal_push_tracks asks; and no camera has more than SEGCAL_MAX_TRACKS points.
int check_points(const segcal_point_t* points, std::int32_t n) {
  if (!points && n > 0) return SEGCAL_ERROR_NULL;
  if (n < 0 || n > SEGCAL_MAX_TRACKS * SEGCAL_MAX_CAMERAS) return SEGCAL_ERROR_SIZE;
  std::int32_t of_camera[SEGCAL_MAX_CAMERAS] = {};
  for (std::int32_t i = 0; i < n; ++i) {
    if (points[i].camera < 0 || points[i].camera >= SEGCAL_MAX_CAMERAS) return SEGCAL_ERROR_CAMERA;
    if (++of_camera[points[i].camera] > SEGCAL_MAX_TRACKS) return SEGCAL_ERROR_SIZE;
  }
  return SEGCAL_OK;
}

}  // namespace
}  // namespace SEGCAL_NS

using namespace SEGCAL_NS;

extern "C" {

int segcal_clock_create(segcal_clock_t* clock, size_t bytes, const segcal_camera_t* camera, int32_t index,
                        double start_s) {
  if (!clock || !camera) return SEGCAL_ERROR_NULL;
  if (bytes < sizeof(segcal_clock_t)) return SEGCAL_ERROR_SIZE;
  if (reinterpret_cast<std::uintptr_t>(clock) % alignof(Clock) != 0) return SEGCAL_ERROR_ALIGNMENT;
  clock->memory[0] = 0;
  CameraCalibration<ClockReal> checked;
  if (!camera_from_c(*camera, &checked) || !(start_s >= -kMostStart_s && start_s <= kMostStart_s))
    return SEGCAL_ERROR_CONFIG;
  if (index < 0 || index >= SEGCAL_MAX_CAMERAS) return SEGCAL_ERROR_CAMERA;
  Clock* c = new (clock) Clock{0, {checked, index, static_cast<std::int64_t>(1e9 * start_s)}};
  c->magic = Clock::kMagic;
  return SEGCAL_OK;
}

int segcal_clock_push_imu(segcal_clock_t* clock, const segcal_imu_t* sample) {
  if (!clock || !sample) return SEGCAL_ERROR_NULL;
  Clock* c = created(clock);
  if (!c) return SEGCAL_ERROR_STATE;
  const float* w = sample->gyro;
  if (!is_rate(w[0]) || !is_rate(w[1]) || !is_rate(w[2])) return SEGCAL_ERROR_NOT_FINITE;
  return c->search.push_imu(sample->t_ns, Vec3<ClockReal>(ClockReal(w[0]), ClockReal(w[1]), ClockReal(w[2])));
}

int segcal_clock_push_tracks(segcal_clock_t* clock, int64_t t_ns, const segcal_point_t* points, int32_t n) {
  if (!clock) return SEGCAL_ERROR_NULL;
  Clock* c = created(clock);
  if (!c) return SEGCAL_ERROR_STATE;
  const int error = check_points(points, n);
  return error != SEGCAL_OK ? error : c->search.push_tracks(t_ns, points, n);
}

int segcal_clock_background(segcal_clock_t* clock, int32_t slices) {
  if (!clock) return SEGCAL_ERROR_NULL;
  Clock* c = created(clock);
  if (!c) return SEGCAL_ERROR_STATE;
  if (slices < 0) return SEGCAL_ERROR_SIZE;
  for (; slices > 0 && c->search.has_work(); --slices) c->search.step();
  return c->search.has_work() ? 1 : 0;
}

int segcal_clock_get(const segcal_clock_t* clock, segcal_clock_result_t* out) {
  if (!clock || !out) return SEGCAL_ERROR_NULL;
  const Clock* c = created(clock);
  if (!c) return SEGCAL_ERROR_STATE;
  c->search.get(out);
  return SEGCAL_OK;
}

}  // extern "C"
