// A stored segment whose checksum is right is refused where a number that others use as an index is none.
#include "../support/cases.h"
#include "../support/synthetic_segments.h"
#include "store/stored_fields.h"

using namespace SEGCAL_NS;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

/// As a device would have stored it.
Segment<double> stored(const Calibration<double>& theta) {
  test::SyntheticOptions options;
  options.segments = 1;
  options.keyframes = 6;
  options.landmarks = 10;
  Segment<double> out = *test::SyntheticSession(options).segments[0];
  out.information.n_theta = theta.columns();
  return out;
}

void test_what_is_no_index_is_refused() {
  const Calibration<double> theta = test::nominal_calibration(Distortion::fov);
  const auto sound = [&theta](const Segment<double>& s) { return StoredFields<double>::sound(s, theta); };
  const Segment<double> good = stored(theta);
  TEST_ASSERT_TRUE(sound(good));
  Segment<double> s = good;
  s.observation[0].keyframe = 6;
  TEST_ASSERT_FALSE(sound(s));
  s = good;
  s.observation[1].keyframe = s.observation[0].keyframe;  // two points of a landmark in one image
  TEST_ASSERT_FALSE(sound(s));
  s = good;
  s.n_observations -= 1;
  TEST_ASSERT_FALSE(sound(s));
}

/// Nothing else is wrong with it: the last landmark of the list has no point.
void test_a_landmark_without_points_is_refused() {
  const Calibration<double> theta = test::nominal_calibration(Distortion::fov);
  Segment<double> s = stored(theta);
  s.first_observation[++s.n_landmarks] = static_cast<std::uint16_t>(s.n_observations);
  TEST_ASSERT_FALSE(StoredFields<double>::sound(s, theta));
}

/// Loops over samples would go round for ever.
void test_stamps_of_samples_grow() {
  const InertialReading<double> still{{0, 0, 0}, {0, 0, 0}};
  ImuStore<double> imu;
  imu.clear();
  for (int i = 0; i < 2 * kStampsPerAnchor; ++i) imu.push(5000 * i, still);
  TEST_ASSERT_TRUE(StoredFields<double>::stamps_grow(imu));
  ImuStore<double> back;
  back.clear();
  for (int i = 0; i < kStampsPerAnchor; ++i) back.push(5000 * i, still);
  back.push(1000, still);  // every sixteenth has a stamp of its own
  TEST_ASSERT_FALSE(StoredFields<double>::stamps_grow(back));
  ImuStore<double> far;
  far.clear();
  far.push(INT32_MAX, still);
  TEST_ASSERT_FALSE(StoredFields<double>::stamps_grow(far));
  const Calibration<double> theta = test::nominal_calibration(Distortion::fov);
  Segment<double> s = stored(theta);
  s.imu = back;
  TEST_ASSERT_FALSE(StoredFields<double>::sound(s, theta));
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc - 1, argv + 1);
  UNITY_BEGIN();
  RUN_TEST(test_what_is_no_index_is_refused);
  RUN_TEST(test_a_landmark_without_points_is_refused);
  RUN_TEST(test_stamps_of_samples_grow);
  return UNITY_END();
}
