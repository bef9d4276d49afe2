// The packed store of raw IMU samples: what goes in comes out within half a step, clipped at the range, in order.
#include <limits>

#include "../support/cases.h"
#include "../support/random.h"
#include "segments/imu_store.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr double kGyroRange = 35, kAccelRange = 157;

template <class S>
ImuStore<S>& store() {
  static ImuStore<S> instance;
  instance.clear(S(kGyroRange), S(kAccelRange));
  return instance;
}

template <class S>
InertialReading<S> reading(double gyro, double accel) {
  return {Vec3<S>::Constant(S(gyro)), Vec3<S>::Constant(S(accel))};
}

template <class S>
void check_round_trip() {
  ImuStore<S>& samples = store<S>();
  test::Random random(32);
  // Half a step of range / 32767, and what the scaling rounds in S.
  const double half = 0.5 * (1 + 4 * 32767 * double(std::numeric_limits<S>::epsilon())) / 32767;
  std::int32_t t = -40321;
  for (int i = 0; i < 600; ++i) {
    const InertialReading<S> in = {random.vector(5).cast<S>(), random.vector(25).cast<S>()};
    TEST_ASSERT_TRUE(samples.push(t, in));
    const InertialReading<S> out = samples.reading(i);
    const Id id = Id().add("check", "round_trip").type<S>().add("i", i);
    test::check_near(id, "stamp", t, samples.time(i), 0);
    test::check_near(id, "gyro", 0, double((out.gyro - in.gyro).cwiseAbs().maxCoeff()), half * kGyroRange);
    test::check_near(id, "accel", 0, double((out.accel - in.accel).cwiseAbs().maxCoeff()), half * kAccelRange);
    t += random.index(9000) + 1;
  }
}

/// Stamps are kept as differences: each must come back whatever was pushed later.
template <class S>
void check_stamps() {
  ImuStore<S>& samples = store<S>();
  std::int32_t expected[100];
  std::int32_t t = -200000;
  for (int i = 0; i < 100; ++i) {
    expected[i] = t;
    TEST_ASSERT_TRUE(samples.push(t, reading<S>(0, 0)));
    t += i % 7 == 0 ? 65535 : i % 3 == 0 ? 1 : 5000;
  }
  for (int i = 99; i >= 0; --i) {
    test::check_near(Id().add("check", "stamps").type<S>().add("i", i), "stamp", expected[i], samples.time(i), 0);
  }
}

template <class S>
void check_clipping() {
  ImuStore<S>& samples = store<S>();
  const S nan = std::numeric_limits<S>::quiet_NaN(), infinity = std::numeric_limits<S>::infinity();
  samples.push(0, reading<S>(1e9, -1e9));
  samples.push(1, reading<S>(-kGyroRange * 1.001, kAccelRange * 1.001));
  samples.push(2, {Vec3<S>(nan, infinity, -infinity), Vec3<S>::Zero()});
  const Id id = Id().add("check", "clipping").type<S>();
  test::check_near(id, "gyro far above", kGyroRange, samples.reading(0).gyro.x(), 1e-4);
  test::check_near(id, "accel far below", -kAccelRange, samples.reading(0).accel.y(), 1e-3);
  test::check_near(id, "gyro just below", -kGyroRange, samples.reading(1).gyro.z(), 1e-4);
  test::check_near(id, "accel just above", kAccelRange, samples.reading(1).accel.x(), 1e-3);
  test::check_true(id, "not-a-number is stored as a number", samples.reading(2).gyro.allFinite());
}

template <class S>
void check_small_values() {
  // One step up and down on each axis alone: neighbouring fields must not touch each other, and zero stays zero.
  const double step = kGyroRange / 32767;
  for (int axis = 0; axis < 3; ++axis) {
    for (double sign : {-1.0, 1.0}) {
      ImuStore<S>& samples = store<S>();
      const Vec3<S> in = S(sign * step) * Vec3<S>::Unit(axis);
      samples.push(0, {in, Vec3<S>::Zero()});
      const Id id = Id().add("check", "one_step").type<S>().add("axis", axis).add("sign", sign);
      test::check_near(id, "gyro", 0, double((samples.reading(0).gyro - in).norm()), 1e-8);
      test::check_near(id, "accel", 0, double(samples.reading(0).accel.norm()), 0);
    }
  }
}

void test_round_trip() {
  check_round_trip<float>();
  check_round_trip<double>();
}
void test_stamps() {
  check_stamps<float>();
  check_stamps<double>();
}
void test_clipping() {
  check_clipping<float>();
  check_clipping<double>();
}
void test_small_values() {
  check_small_values<float>();
  check_small_values<double>();
}

void test_full_store_refuses() {
  ImuStore<float>& samples = store<float>();
  for (int i = 0; i < SEGCAL_MAX_IMU_SAMPLES; ++i) TEST_ASSERT_TRUE(samples.push(i, reading<float>(0, 0)));
  TEST_ASSERT_TRUE(samples.full());
  TEST_ASSERT_FALSE(samples.push(SEGCAL_MAX_IMU_SAMPLES, reading<float>(1, 1)));
  TEST_ASSERT_EQUAL_INT(SEGCAL_MAX_IMU_SAMPLES, samples.size());
  TEST_ASSERT_EQUAL_INT(SEGCAL_MAX_IMU_SAMPLES - 1, samples.time(samples.size() - 1));
}

void test_long_gap_is_refused() {
  ImuStore<float>& samples = store<float>();
  TEST_ASSERT_TRUE(samples.push(0, reading<float>(0, 0)));
  TEST_ASSERT_FALSE(samples.push(65536, reading<float>(0, 0)));
  TEST_ASSERT_EQUAL_INT(1, samples.size());
  TEST_ASSERT_TRUE(samples.push(65535, reading<float>(0, 0)));
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_round_trip);
  RUN_TEST(test_stamps);
  RUN_TEST(test_clipping);
  RUN_TEST(test_small_values);
  RUN_TEST(test_full_store_refuses);
  RUN_TEST(test_long_gap_is_refused);
  return UNITY_END();
}
