// What tests of the C API share: storage of any content, a stream, and data that must be refused.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "../support/cases.h"
#include "../support/synthetic_stream.h"

namespace test {

/// Aligned memory of the caller, filled with one byte.
class Storage {
 public:
  explicit Storage(int fill, std::size_t offset = 0) : bytes_(segcal_storage_bytes() + 2 * SEGCAL_STORAGE_ALIGNMENT) {
    std::memset(bytes_.data(), fill, bytes_.size());
    const std::uintptr_t address = reinterpret_cast<std::uintptr_t>(bytes_.data());
    data = bytes_.data() + (SEGCAL_STORAGE_ALIGNMENT - address % SEGCAL_STORAGE_ALIGNMENT) % SEGCAL_STORAGE_ALIGNMENT +
           offset;
  }
  unsigned char* data;

 private:
  std::vector<unsigned char> bytes_;
};

/// Work that is due is done whatever the test's background did; what becomes of it else is asked in test_deadlines.
inline segcal_t* create(Storage* storage, const segcal_config_t& config) {
  segcal_t* device = nullptr;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_create(&device, &config, storage->data, segcal_storage_bytes()));
  TEST_ASSERT_NOT_NULL(device);
  segcal_work_when_due(device, 1);
  return device;
}

inline const SyntheticStream& stream() {
  static const SyntheticStream instance(201, 9);
  return instance;
}

/// One for each length, made when it is needed.
template <int seconds>
const SyntheticStream& long_stream() {
  static const SyntheticStream instance(7, seconds);
  return instance;
}

enum class Way { tracks, keyframes };

/// Data that must be refused, at one moment of the stream.
inline void push_rubbish(segcal_t* device, const segcal_imu_t& now, const SyntheticStream::Frame& frame) {
  segcal_imu_t bad = now;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STAMP, segcal_push_imu(device, &now));
  bad.t_ns = now.t_ns - 123456;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STAMP, segcal_push_imu(device, &bad));
  bad = now;
  bad.t_ns += 1;
  for (float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    bad.gyro[1] = value;
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NOT_FINITE, segcal_push_imu(device, &bad));
    bad.gyro[1] = 0;
    bad.accel[2] = -value;
    TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NOT_FINITE, segcal_push_imu(device, &bad));
    bad.accel[2] = 0;
  }
  std::vector<segcal_point_t> points = frame.points;
  const int n = static_cast<int>(points.size());
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STAMP, segcal_push_tracks(device, frame.state.t_ns, points.data(), n));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_push_tracks(device, now.t_ns + 1, nullptr, n));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_push_tracks(device, now.t_ns + 1, points.data(), -1));
  points[0].camera = 7;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CAMERA, segcal_push_tracks(device, now.t_ns + 1, points.data(), n));
  segcal_state_t state = frame.state;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_CAMERA, segcal_push_keyframe(device, &state, points.data(), n));
  points[0].camera = 0;
  state.p_GI[0] = std::nan("");
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NOT_FINITE, segcal_push_keyframe(device, &state, points.data(), n));
}

inline void push_frame(segcal_t* device, const SyntheticStream::Frame& frame, Way way) {
  const int n = std::min(static_cast<int>(frame.points.size()), SEGCAL_MAX_TRACKS);
  const int code = way == Way::tracks ? segcal_push_tracks(device, frame.state.t_ns, frame.points.data(), n)
                                      : segcal_push_keyframe(device, &frame.state, frame.points.data(), n);
  TEST_ASSERT_GREATER_OR_EQUAL_INT(0, code);
}

}  // namespace test
