// Steps, a trend, or temperature: courses of a drawn device over sessions, what is said of them, and whether the odds
// are those of the densities themselves.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "../support/cases.h"
#include "../support/drawn_theta.h"
#include "calibration/course_trial.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using S = float;

constexpr int kSessions = 6;
constexpr double kRow = 100;  // length of a session's rows, in units of 1 / (sigma of the prior)
constexpr double kDegC[kSessions] = {5, -12, 15, -3, 9, -15};  // above 25

/// A session's rows say what theta was then.
struct World : test::DrawnTheta {
  std::vector<SegmentInformation<S>> rows;
  std::vector<CourseItem<S>> items;
  std::unique_ptr<S[]> scratch = std::make_unique<S[]>(CourseTrial<S>::kScratch);

  explicit World(std::uint32_t seed) : DrawnTheta(seed) { rows.reserve(kSessions); }

  /// Column 7 is `moved` by so many of the prior's sigmas beside the truth.
  void add(int session, double moved, int changes, double noise = 1) {
    truth[7] += moved;
    rows.push_back(information(noise, [this](int i, int c) { return c == i ? kRow : random.normal(0.2 * kRow); }));
    truth[7] -= moved;
    items.push_back({&rows.back(), &theta, S(session), S(kDegC[session]), changes});
  }
  Course<S> judge(bool has_temperature = true, S noise_scale = S(1)) {
    CourseTrial<S> trial;
    Course<S> course;
    trial.begin(scratch.get());
    const auto item = [this](int i) { return items[static_cast<std::size_t>(i)]; };
    while (!trial.step(item, static_cast<int>(items.size()), prior, theta, noise_scale, has_temperature, &course)) {
    }
    return course;
  }
};

constexpr std::uint32_t bit(CourseForm form) { return 1u << form; }

/// ln p of what the sessions say, from its covariance: y ~ N(A m, 1 + A A'), columns in the prior's sigmas. theta, and
/// v of `count` columns from `first` on times x(k).
template <class Place>
double log_density(const World& w, int first, int count, Place x) {
  const int n = w.n();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(kSessions * n, n + count);
  Eigen::VectorXd y(kSessions * n);
  for (int k = 0; k < kSessions; ++k) {
    const SegmentInformation<S>& rows = *w.items[static_cast<std::size_t>(k)].rows;
    for (int i = 0; i < n; ++i) {
      y(k * n + i) = static_cast<double>(rows.d(i));
      for (int c = i; c < n; ++c) {
        A(k * n + i, c) = static_cast<double>(rows.R(i, c) * w.prior.sigma[c]);
        if (c >= first && c < first + count) A(k * n + i, n + c - first) = x(k) * A(k * n + i, c);
      }
    }
  }
  const Eigen::MatrixXd C = Eigen::MatrixXd::Identity(kSessions * n, kSessions * n) + A * A.transpose();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(C);
  return -0.5 * (y.dot(ldlt.solve(y)) + ldlt.vectorD().array().log().sum());
}

/// Sessions up to the third and from the fourth on, independent of each other.
double log_two_levels(const World& w) {
  double sum = 0;
  for (int level = 0; level < 2; ++level) {
    const int n = w.n(), first = level * kSessions / 2;
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(kSessions / 2 * n, n);
    Eigen::VectorXd y(kSessions / 2 * n);
    for (int k = 0; k < kSessions / 2; ++k) {
      const SegmentInformation<S>& rows = *w.items[static_cast<std::size_t>(first + k)].rows;
      for (int i = 0; i < n; ++i) {
        y(k * n + i) = static_cast<double>(rows.d(i));
        for (int c = i; c < n; ++c) A(k * n + i, c) = static_cast<double>(rows.R(i, c) * w.prior.sigma[c]);
      }
    }
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(Eigen::MatrixXd::Identity(y.size(), y.size()) + A * A.transpose());
    sum -= 0.5 * (y.dot(ldlt.solve(y)) + ldlt.vectorD().array().log().sum());
  }
  return sum;
}

/// Of the best block.
template <class Place>
double log_density(const World& w, Place x) {
  double best = -1e300;
  int blocks = 0;
  for (int c = 0; c < w.n(); c = end_of_block(w.theta, c), ++blocks)
    best = std::max(best, log_density(w, c, end_of_block(w.theta, c) - c, x));
  return best - std::log(blocks);
}

void test_odds_are_those_of_the_densities() {
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    World w(seed);
    for (int k = 0; k < kSessions; ++k) w.add(k, 0.03 * k, k >= 3 ? 1 : 0);
    const Course<S> course = w.judge();
    // One theta before the change and one after it, each from the prior: x picks one, and n columns more.
    double steps = log_two_levels(w);
    for (int at = 1; at < kSessions; ++at)
      steps = std::max(steps, log_density(w, [at](int k) { return k < at ? -1.0 : 0.0; }) - std::log(kSessions - 1));
    const double trend = log_density(w, [](int k) { return (k - kSessions + 1.0) / (kSessions - 1); });
    const double warm = log_density(w, [](int k) { return (kDegC[k] - kDegC[kSessions - 1]) / 30; });
    const double best = std::max(steps, std::max(trend, warm));
    const Id id = Id().add("seed", static_cast<int>(seed));
    // Float's rounding of sums of some thousands, in units of 1e-7 of these, many times over.
    check_near(id, "ln odds of steps", steps - best, static_cast<double>(course.ln_odds[steps_form]), 0.05);
    check_near(id, "ln odds of a trend", trend - best, static_cast<double>(course.ln_odds[trend_form]), 0.05);
    check_near(id, "ln odds of temperature", warm - best, static_cast<double>(course.ln_odds[temperature_form]), 0.05);
  }
}

/// What moves by 0.5 of the prior's sigmas over all sessions is fifty sigmas of one session.
void test_each_course_is_told() {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    const Id id = Id().add("seed", static_cast<int>(seed));
    World same(seed), step(seed), trend(seed), warm(seed);
    for (int k = 0; k < kSessions; ++k) {
      same.add(k, 0, 0);
      step.add(k, k >= 3 ? 0.5 : 0, k >= 3 ? 1 : 0);
      trend.add(k, 0.1 * k, k >= 3 ? 1 : 0);
      warm.add(k, kDegC[k] / 60, k >= 4 ? 1 : 0);
    }
    check_true(id, "nothing is steps", same.judge().forms == bit(steps_form));
    check_true(id, "a step is steps", step.judge().forms == bit(steps_form));
    const Course<S> aged = trend.judge(), warmed = warm.judge();
    check_true(id, "a trend", aged.forms == bit(trend_form) && aged.rate_form == trend_form);
    check_true(id, "temperature", warmed.forms == bit(temperature_form) && warmed.rate_form == temperature_form);
    const double sigma = static_cast<double>(trend.prior.sigma[7]);
    // 4 sigmas: 60 numbers are asked, chance does that once in 260 runs of other seeds.
    check_near(id, "rate per session in its sigmas", 0,
               (static_cast<double>(aged.rate[7]) - 0.1 * sigma) / static_cast<double>(aged.sigma[7]), 4);
    check_near(id, "rate per degC in its sigmas", 0,
               (static_cast<double>(warmed.rate[7]) - sigma / 60) / static_cast<double>(warmed.sigma[7]), 4);
  }
}

/// Where no change was decided, another course must be beyond doubt; what was released is a mean then, and the lag says
/// how far from the last session. A step that was not noticed is named with its place.
void test_what_is_slow_is_noticed() {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    World w(seed);
    for (int k = 0; k < kSessions; ++k) w.add(k, 0.04 * k, 0);  // four sigmas of a session each
    const Course<S> course = w.judge();
    const Id id = Id().add("seed", static_cast<int>(seed));
    check_true(id, "a trend", course.forms == bit(trend_form));
    // Rows are moved to theta, the prior's mean: from there to the last session it is 0.2.
    check_near(id, "lag in the prior's sigmas", 0.2, static_cast<double>(course.lag[7] / w.prior.sigma[7]), 0.05);
    World step(seed);
    for (int k = 0; k < kSessions; ++k) step.add(k, k >= 4 ? 0.15 : 0, 0);
    const Course<S> stepped = step.judge();
    check_true(id, "a step", stepped.forms == bit(steps_form) && stepped.rate_form == steps_form);
    check_true(id, "its place", stepped.step_session == 4);
    check_near(id, "its size in the prior's sigmas", 0.15, static_cast<double>(stepped.rate[7] / step.prior.sigma[7]),
               0.05);
    World warm(seed);
    for (int k = 0; k < kSessions; ++k) warm.add(k, kDegC[k] / 150, 0);
    const Course<S> warmed = warm.judge();
    check_true(id, "temperature", warmed.forms == bit(temperature_form));
    check_near(id, "lag at the farther end", 0.1, std::abs(static_cast<double>(warmed.lag[7] / warm.prior.sigma[7])),
               0.05);
  }
}

/// 200 devices.
void test_noise_is_no_course() {
  int named = 0;
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    World w(seed);
    for (int k = 0; k < kSessions; ++k) w.add(k, 0, 0);
    const Course<S> course = w.judge();
    named += course.forms != bit(steps_form) || course.lag[7] != S(0) ? 1 : 0;
  }
  TEST_ASSERT_EQUAL_INT(0, named);
}

/// Sessions that scatter twice as much as their noise say so in the scale; then a scatter of that size is no course.
void test_the_scale_counts() {
  World w(7);
  for (int k = 0; k < kSessions; ++k) w.add(k, 0.02 * k, 0, 2);
  const Course<S> sure = w.judge(true, S(1)), scaled = w.judge(true, S(2));
  TEST_ASSERT_TRUE(scaled.sigma[7] > S(1.8) * sure.sigma[7] && scaled.sigma[7] < S(2.2) * sure.sigma[7]);
}

void test_what_cannot_be_told() {
  World two(1);
  for (int k = 0; k < 2; ++k) two.add(k, 0.5 * k, k);
  const Course<S> none = two.judge();
  TEST_ASSERT_EQUAL_UINT32(0, none.forms);
  TEST_ASSERT_EQUAL_INT(2, none.sessions);
  World cold(1);
  for (int k = 0; k < kSessions; ++k) cold.add(k, 0.1 * k, k >= 3 ? 1 : 0);
  const Course<S> without = cold.judge(false);
  TEST_ASSERT_TRUE(without.ln_odds[temperature_form] > S(0));  // not asked
  TEST_ASSERT_EQUAL_UINT32(bit(trend_form), without.forms);
  // Temperature that rises with time is both.
  World rising(1);
  for (int k = 0; k < kSessions; ++k) {
    rising.add(k, 0.1 * k, k >= 3 ? 1 : 0);
    rising.items.back().warmth = S(4 * k);
  }
  TEST_ASSERT_EQUAL_UINT32(bit(trend_form) | bit(temperature_form), rising.judge().forms);
}

/// Kept segments are of older sessions than what was condensed, and come after it.
void test_any_order_is_the_same() {
  World w(3);
  for (int k = 0; k < kSessions; ++k) w.add(k, k >= 1 ? 0.2 : 0, 0);
  const Course<S> in_order = w.judge();
  std::rotate(w.items.begin(), w.items.begin() + 1, w.items.end());
  const Course<S> first_last = w.judge();
  TEST_ASSERT_EQUAL_INT(steps_form, first_last.rate_form);
  TEST_ASSERT_EQUAL_UINT32(1, in_order.step_session);
  TEST_ASSERT_EQUAL_UINT32(1, first_last.step_session);
  TEST_ASSERT_EQUAL_UINT32(in_order.forms, first_last.forms);
}

/// A change that was decided is no small step beside it, and leaves no lag.
void test_a_decided_change_is_enough() {
  for (std::uint32_t seed = 1; seed <= 30; ++seed) {
    World w(seed);
    for (int k = 0; k < kSessions; ++k) w.add(k, k >= 3 ? 0.5 : 0, k >= 3 ? 1 : 0);
    const Course<S> course = w.judge();
    test::check_true(Id().add("seed", static_cast<int>(seed)), "a rate or a lag",
                     course.rate_form == -1 && course.lag[7] == S(0));
  }
}

/// Entries stay in order of time, the oldest gives way, and a change divides sessions before it from those after.
void test_history_keeps_order() {
  if (kHistory == 0) return;
  World w(1);
  auto history = std::make_unique<History<S>>();
  history->clear();
  const SegmentInformation<S> rows = w.information(1, [](int i, int c) { return c == i ? kRow : 0; });
  for (std::uint32_t session : {1u, 1u, 3u, 0u, 3u}) history->add(rows, w.theta, session, S(session));
  TEST_ASSERT_EQUAL_INT(3, history->count());
  TEST_ASSERT_EQUAL_UINT32(0, history->find(0)->session);
  TEST_ASSERT_EQUAL_INT(2, history->find(1)->segments);
  TEST_ASSERT_EQUAL_INT(2, history->find(2)->segments);
  TEST_ASSERT_TRUE(history->find(2)->mean_warmth() == S(3));
  history->take_change(1);
  TEST_ASSERT_EQUAL_INT(0, history->find(1)->changes);
  TEST_ASSERT_EQUAL_INT(1, history->find(2)->changes);
  history->add(rows, w.theta, 1, S(0));  // the rest of a session within which it changed
  TEST_ASSERT_EQUAL_INT(4, history->count());
  TEST_ASSERT_EQUAL_INT(1, history->find(2)->changes);
  for (std::uint32_t session = 10; session < 10 + kHistory; ++session) history->add(rows, w.theta, session, S(0));
  TEST_ASSERT_EQUAL_INT(kHistory, history->count());
  TEST_ASSERT_EQUAL_UINT32(10, history->find(0)->session);
  TEST_ASSERT_NULL(history->find(kHistory));
  history->add(rows, w.theta, 2, S(0));  // older than all
  TEST_ASSERT_EQUAL_INT(kHistory, history->count());
  TEST_ASSERT_EQUAL_UINT32(10, history->find(0)->session);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_odds_are_those_of_the_densities);
  RUN_TEST(test_each_course_is_told);
  RUN_TEST(test_what_is_slow_is_noticed);
  RUN_TEST(test_noise_is_no_course);
  RUN_TEST(test_the_scale_counts);
  RUN_TEST(test_what_cannot_be_told);
  RUN_TEST(test_any_order_is_the_same);
  RUN_TEST(test_a_decided_change_is_enough);
  RUN_TEST(test_history_keeps_order);
  return UNITY_END();
}
