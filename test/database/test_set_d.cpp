// Selection of the set that tells most together: sums without one segment against Eigen in double, each exchange
// against all subsets, and what the sum over single segments gets wrong.
#include <Eigen/LU>
#include <Eigen/QR>
#include <memory>
#include <set>
#include <vector>

#include "../support/cases.h"
#include "../support/random.h"
#include "database/database.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr int kTheta = 26;

/// A segment that tells `strength` sigmas of the prior about some directions, little or nothing about the rest.
Eigen::MatrixXd random_information(test::Random* random, double strength) {
  Eigen::MatrixXd J(kTheta + 4, kTheta);
  for (int i = 0; i < J.rows(); ++i) {
    for (int j = 0; j < kTheta; ++j) J(i, j) = random->normal();
  }
  for (int j = 0; j < kTheta; ++j) {
    const double kind = random->uniform(0, 1);
    J.col(j) *= kind < 0.2 ? 0 : kind < 0.5 ? 1e-3 * strength : strength * random->uniform(0.1, 1);
  }
  return J.householderQr().matrixQR().topRows(kTheta).triangularView<Eigen::Upper>();
}

/// Units of theta's entries: pixels and radians differ by four powers of ten.
Eigen::VectorXd prior_sigma() {
  Eigen::VectorXd s(kTheta);
  for (int j = 0; j < kTheta; ++j) s(j) = j % 3 == 0 ? 10 : j % 3 == 1 ? 0.05 : 0.002;
  return s;
}

template <class S>
void put(const Eigen::MatrixXd& W, SegmentInformation<S>* out) {
  const Eigen::VectorXd s = prior_sigma();
  out->n_theta = kTheta;
  PackedTriangle<S> T = out->triangle();
  T.clear();
  for (int i = 0; i < kTheta; ++i) {
    for (int j = i; j < kTheta; ++j) T.row(i)[j] = static_cast<S>(W(i, j) / s(j));
    T.row(i)[kTheta] = static_cast<S>(1);
  }
}

/// Half of log det(1 + sum of W'W), by a QR of the stack: log det of a sum of squares would lose the small ones.
double gain(const std::vector<Eigen::MatrixXd>& all, const std::vector<int>& subset) {
  Eigen::MatrixXd stack((subset.size() + 1) * kTheta, kTheta);
  stack.topRows(kTheta).setIdentity();
  for (std::size_t k = 0; k < subset.size(); ++k) stack.middleRows((k + 1) * kTheta, kTheta) = all[subset[k]];
  return stack.householderQr().matrixQR().diagonal().cwiseAbs().array().log().sum();
}

template <class S>
struct Joint {
  std::vector<S> sigma, scratch;
  JointInformation<S> information;
  Joint() : sigma(kTheta), scratch(kJointScratch), information(sigma.data(), kTheta, scratch.data()) {
    const Eigen::VectorXd s = prior_sigma();
    for (int j = 0; j < kTheta; ++j) sigma[j] = static_cast<S>(s(j));
  }
};

template <class S>
void check_sums(const char* scalar, double tolerance) {
  test::Random random(40);
  Joint<S> joint;
  for (int count : {1, 2, 3, 5, 8, 9, kMaxCompared}) {
    std::vector<Eigen::MatrixXd> all;
    std::vector<std::unique_ptr<SegmentInformation<S>>> segments;
    const SegmentInformation<S>* pointers[kMaxCompared];
    for (int i = 0; i < count; ++i) {
      all.push_back(random_information(&random, std::pow(10, random.uniform(-1, 3))));
      segments.push_back(std::make_unique<SegmentInformation<S>>());
      put(all.back(), segments.back().get());
      pointers[i] = segments.back().get();
    }
    S without[kMaxCompared];
    joint.information.gains_without_one(pointers, count, without);
    std::vector<int> everything;
    for (int left_out = 0; left_out < count; ++left_out) {
      std::vector<int> subset;
      for (int i = 0; i < count; ++i)
        if (i != left_out) subset.push_back(i);
      const Id id = Id().add("scalar", scalar).add("count", count).add("without", left_out);
      test::check_near(id, "nats", gain(all, subset), without[left_out], tolerance);
      everything.push_back(left_out);
    }
    const PackedTriangle<S> T = joint.information.sum(pointers, count);
    test::check_near(Id().add("scalar", scalar).add("sum_of", count), "nats", gain(all, everything),
                     JointInformation<S>::gain_of(T), tolerance);
  }
}

// Sums of 26 logarithms of numbers known to some 1e-6 and 1e-14 each, whose own formula is good to two digits more.
void test_sums_in_float() { check_sums<float>("float", 2e-4); }
void test_sums_in_double() { check_sums<double>("double", 1e-11); }

/// A stream of segments through a database; what is kept, by serial.
template <class S>
struct Stream {
  std::unique_ptr<Database<S>> database = std::make_unique<Database<S>>();
  Joint<S> joint;
  std::vector<Eigen::MatrixXd> all;

  Stream(int capacity, Metric metric, Strategy strategy = Strategy::single_session) {
    database->reset(capacity, metric, strategy, S(1), 1);
  }
  bool offer(const Eigen::MatrixXd& W) {
    Segment<S>& s = database->building();
    s.serial = static_cast<std::uint32_t>(all.size());
    put(W, &s.information);
    const Eigen::MatrixXd covariance = (Eigen::MatrixXd::Identity(kTheta, kTheta) + W.transpose() * W).inverse();
    s.metrics.A = static_cast<S>(covariance.trace());
    s.metrics.gain = static_cast<S>(20);
    all.push_back(W);
    return database->offer(&joint.information);
  }
  std::vector<int> kept() const {
    std::set<int> serials;
    for (int i = 0; i < Database<S>::kSlots; ++i) {
      if (database->kept(i)) serials.insert(static_cast<int>(database->slot(i).serial));
    }
    return {serials.begin(), serials.end()};
  }
};

/// The best subset of `count` out of `from`, all tried.
double best_gain(const std::vector<Eigen::MatrixXd>& all, const std::vector<int>& from, int count,
                 std::vector<int>* best) {
  double most = -1;
  for (unsigned mask = 0; mask < 1u << from.size(); ++mask) {
    if (__builtin_popcount(mask) != count) continue;
    std::vector<int> subset;
    for (std::size_t i = 0; i < from.size(); ++i)
      if (mask >> i & 1) subset.push_back(from[i]);
    const double value = gain(all, subset);
    if (value > most) *best = subset;
    most = std::max(most, value);
  }
  return most;
}

void test_each_exchange_is_the_best() {
  double shortfall = 0;
  for (int capacity : {1, 2, 4, 8}) {
    test::Random random(50 + capacity);
    Stream<double> stream(capacity, Metric::set_d);
    for (int i = 0; i < 12; ++i) {
      std::vector<int> before = stream.kept(), best;
      const Eigen::MatrixXd W = random_information(&random, std::pow(10, random.uniform(-0.5, 1.5)));
      stream.offer(W);
      before.push_back(i);
      if (i < capacity) continue;
      best_gain(stream.all, before, capacity, &best);
      const Id id = Id().add("capacity", capacity).add("offer", i);
      test::check_true(id, "not the best subset of those kept and the new one", stream.kept() == best);
    }
    // One pass with exchanges of one is no search of all subsets, but not far from it.
    std::vector<int> everything, best;
    for (int i = 0; i < 12; ++i) everything.push_back(i);
    const double most = best_gain(stream.all, everything, capacity, &best), reached = gain(stream.all, stream.kept());
    shortfall = std::max(shortfall, 1 - reached / most);
    test::check_between(Id().add("capacity", capacity).add("check", "stream"), "share of the best set's nats", 0.97,
                        reached / most, 1 + 1e-12);
  }
  std::printf("largest shortfall of the stream against the best of all subsets: %.3f\n", shortfall);
}

/// Tells `sigmas` about entries [first, last).
Eigen::MatrixXd about(int first, int last, double sigmas) {
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(kTheta, kTheta);
  for (int j = first; j < last; ++j) W(j, j) = sigmas;
  return W;
}

/// Many segments that turn well and few that accelerate a little: by A alone only the former stay.
template <class S>
std::vector<int> of_two_kinds(Metric metric) {
  Stream<S> stream(4, metric);
  for (int i = 0; i < 12; ++i) stream.offer(i % 4 == 3 ? about(13, 26, 5) : about(0, 14, 20 + i));
  return stream.kept();
}

int second_kind(const std::vector<int>& kept) {
  int n = 0;
  for (int serial : kept) n += serial % 4 == 3 ? 1 : 0;
  return n;
}

void test_what_is_missing_is_worth_more() {
  TEST_ASSERT_EQUAL_INT(0, second_kind(of_two_kinds<float>(Metric::A)));
  TEST_ASSERT_EQUAL_INT(2, second_kind(of_two_kinds<float>(Metric::set_d)));
}

void test_all_sessions_together() {
  for (Strategy strategy : {Strategy::single_session, Strategy::multi_session}) {
    Stream<float> stream(2, Metric::set_d, strategy);
    stream.offer(about(0, 13, 10));
    stream.offer(about(0, 13, 5));
    stream.database->begin_session();
    const bool multi = strategy == Strategy::multi_session;
    TEST_ASSERT_EQUAL_INT(multi ? 2 : 0, stream.kept().size());
    stream.offer(about(0, 13, 6));   // multi: no better than what there is beside serial 0
    stream.offer(about(13, 26, 3));  // the other half
    const std::vector<int> expected = multi ? std::vector<int>{0, 3} : std::vector<int>{2, 3};
    TEST_ASSERT_TRUE(stream.kept() == expected);
  }
}

void test_equals_do_not_displace() {
  Stream<float> stream(2, Metric::set_d);
  for (int i = 0; i < 5; ++i) stream.offer(about(0, 26, 7));
  TEST_ASSERT_TRUE(stream.kept() == (std::vector<int>{0, 1}));
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_sums_in_float);
  RUN_TEST(test_sums_in_double);
  RUN_TEST(test_each_exchange_is_the_best);
  RUN_TEST(test_what_is_missing_is_worth_more);
  RUN_TEST(test_all_sessions_together);
  RUN_TEST(test_equals_do_not_displace);
  return UNITY_END();
}
