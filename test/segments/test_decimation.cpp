// Several IMU samples become one: the sensor's value at their mean time
// where the motion curves, and nothing of a sample that was dropped.
#include <vector>

#include "../support/cases.h"
#include "sensors/decimation.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;
using namespace SEGCAL_NS;
using Reading = InertialReading<double>;

constexpr std::int64_t kPeriod = 5000000;
constexpr std::int64_t kBegin = 7000000000;

/// A parabola on each axis, of x in samples.
Reading parabola(double x) {
  Reading r;
  for (int c = 0; c < 3; ++c) {
    r.gyro(c) = 0.3 + 0.02 * (c + 1) * x - 0.01 * x * x;
    r.accel(c) = 9 - 0.4 * x + 0.03 * (c + 1) * x * x;
  }
  return r;
}
double difference(const Reading& a, const Reading& b) {
  return std::max((a.gyro - b.gyro).cwiseAbs().maxCoeff(), (a.accel - b.accel).cwiseAbs().maxCoeff());
}
double in_samples(std::int64_t t_ns) { return static_cast<double>(t_ns - kBegin) / kPeriod; }

/// Feeds sample i; true if something came out.
bool take(Decimation<double>* d, int i, std::int64_t* t_ns, Reading* r) {
  *t_ns = kBegin + i * kPeriod;
  *r = parabola(i);
  return d->take(t_ns, r);
}

void test_groups_of_one_pass() {
  Decimation<double> d;
  d.begin(1);
  std::int64_t t;
  Reading r;
  for (int i = 0; i < 5; ++i) {
    TEST_ASSERT_TRUE(take(&d, i, &t, &r));
    TEST_ASSERT_TRUE(t == kBegin + i * kPeriod && difference(r, parabola(i)) == 0);
  }
}

/// Second differences of a parabola's means are exact: all but the
/// first come out right to rounding, at the mean time, each once.
void test_a_parabola_comes_out_as_it_is() {
  for (const int group : {2, 3, 8, 20}) {
    const Id id = Id().add("group", group);
    if (!selected(id.text())) continue;
    Decimation<double> d;
    d.begin(group);
    int out = 0;
    for (int i = 0; i < 10 * group; ++i) {
      std::int64_t t;
      Reading r;
      if (!take(&d, i, &t, &r)) continue;
      check_near(id, "mean time, samples", out * group + 0.5 * (group - 1), in_samples(t), 1e-6);
      // Accelerations of 250 there; the mean alone is off by 0.18 (8^2 - 1) / 24 = 0.5 for groups of 8.
      if (out > 0) check_near(id, "value at that time", 0, difference(r, parabola(in_samples(t))), 1e-11 * 300);
      ++out;
    }
    check_near(id, "groups that came out: all but the newest", 9, out, 0);
  }
}

/// One or two, at each place of a group: nothing that comes out,
/// and was not to be taken back, has anything of the wrong ones.
void test_wrong_samples_leave_nothing() {
  for (const auto& [group, in_a_row] : {std::pair(2, 1), {2, 2}, {3, 1}, {3, 2}, {4, 1}, {4, 2}}) {
    for (int wrong = 6 * group; wrong < 7 * group; ++wrong) {
      const Id id = Id().add("group", group).add("wrong", wrong).add("in_a_row", in_a_row);
      if (!selected(id.text())) continue;
      Decimation<double> d;
      d.begin(group);
      std::vector<std::pair<double, Reading>> out;
      for (int i = 0; i < 12 * group; ++i) {
        if (i == wrong + in_a_row) {
          std::int64_t left;
          TEST_ASSERT_TRUE(d.stays(in_a_row, &left));
          check_true(id, "what stays is near", (i - in_samples(left)) <= 1.5 * group + 2);
          for (int n = d.drop_newest(in_a_row); n > 0; --n) out.pop_back();
        }
        std::int64_t t = kBegin + i * kPeriod;
        Reading r = parabola(i);
        if (i >= wrong && i < wrong + in_a_row) r.accel(1) += 1e6;
        if (d.take(&t, &r)) out.push_back({in_samples(t), r});
      }
      for (std::size_t k = 1; k < out.size(); ++k) {
        // Beside the hole a mean stays as it is.
        check_near(id, "value", 0, difference(out[k].second, parabola(out[k].first)),
                   0.18 * (group * group - 1) / 24 + 1e-9);
        check_true(id, "times grow", out[k].first > out[k - 1].first);
      }
      check_true(id, "one group is lost, or two", out.size() >= 8 && out.size() <= 10);
    }
  }
}

void test_a_new_stretch_knows_nothing_of_the_last() {
  Decimation<double> d;
  d.begin(2);
  std::int64_t t;
  Reading r;
  for (int i = 0; i < 7; ++i) take(&d, i, &t, &r);
  d.clear();
  for (int i = 0; i < 3; ++i) {
    t = kBegin + (1000 + i) * kPeriod;
    r = parabola(i);
    TEST_ASSERT_FALSE(d.take(&t, &r));
  }
  t = kBegin + 1003 * kPeriod;
  r = parabola(3);
  TEST_ASSERT_TRUE(d.take(&t, &r));
  TEST_ASSERT_TRUE(std::abs(in_samples(t) - 1000.5) < 1e-6);
  Reading mean;
  mean.gyro = 0.5 * (parabola(0).gyro + parabola(1).gyro);
  mean.accel = 0.5 * (parabola(0).accel + parabola(1).accel);
  TEST_ASSERT_TRUE(difference(r, mean) < 1e-12);
}

}  // namespace

int main(int argc, char** argv) {
  select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_groups_of_one_pass);
  RUN_TEST(test_a_parabola_comes_out_as_it_is);
  RUN_TEST(test_wrong_samples_leave_nothing);
  RUN_TEST(test_a_new_stretch_knows_nothing_of_the_last);
  return UNITY_END();
}
