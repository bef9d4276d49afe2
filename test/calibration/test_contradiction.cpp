// Segments that contradict what is known, found among those that do not: rows drawn around a known theta.
#include <memory>

#include "../support/cases.h"
#include "../support/drawn_theta.h"
#include "calibration/contradiction.h"

using namespace SEGCAL_NS;
using test::Id;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using S = float;

constexpr int kKept = 6;
constexpr double kRow = 30;  // length of a segment's rows, in units of 1 / (sigma of the prior)

/// A device whose theta is the prior's mean plus `offset` sigmas of it, until it moves.
struct World : test::DrawnTheta {
  Database<S> database;
  Epochs<S> epochs;
  Contradiction<S> contradiction;
  std::unique_ptr<S[]> scratch = std::make_unique<S[]>(Contradiction<S>::kScratch);
  double noise = 1, scatter = 0;

  explicit World(std::uint32_t seed, double scatter_sigmas = 0) : DrawnTheta(seed), scatter(scatter_sigmas) {
    for (double& t : truth) t = random.normal(0.05);  // as near as a release is
    database.reset(kKept, Metric::A, Strategy::multi_session, S(0), 1);
    for (int i = 0; i < kKept; ++i) {
      database.building().information = segment();
      database.building().metrics.A = S(1);
      database.building().metrics.gain = S(1);
      database.offer();
    }
    epochs.begin(theta, 0);
  }

  /// R (theta [-] theta_0) = d with noise; every fifth column is not shown at all.
  /// `scatter`: of each segment's own theta, in its sigmas, in three columns of each sensor.
  SegmentInformation<S> segment() {
    double before[kMaxTheta];
    for (int c = 0; c < n(); ++c) before[c] = truth[c];
    for (const int c : {0, 6, 8, 15, 16, 17, 21, 22, 23}) truth[c] += random.normal(scatter / kRow);
    const SegmentInformation<S> s = information(noise, [this](int i, int c) {
      return (i % 5 == 4 || c % 5 == 4) ? 0 : c == i ? kRow : random.normal(0.2 * kRow);
    });
    for (int c = 0; c < n(); ++c) truth[c] = before[c];
    return s;
  }
  bool contradicts(SegmentInformation<S>* s) {
    contradiction.begin(S(1));
    while (!contradiction.step(*s, epochs, database, prior, theta, scratch.get())) {
    }
    return contradiction.found();
  }
  void take(SegmentInformation<S>* s) { epochs.newest().add(s->triangle(), 1000, contradiction.pull(), 0, 1); }
  /// How many of `n_segments` contradict; all are taken.
  int alarms(int n_segments) {
    int count = 0;
    for (int k = 0; k < n_segments; ++k) {
      SegmentInformation<S> s = segment();
      count += contradicts(&s) ? 1 : 0;
      take(&s);
    }
    return count;
  }
};

/// Of 100 devices that go on for 30 segments each.
int false_alarms(double scatter_sigmas) {
  int count = 0;
  for (std::uint32_t seed = 0; seed < 100; ++seed) count += std::make_unique<World>(seed, scatter_sigmas)->alarms(30);
  return count;
}

struct Found {
  int at_once = 0, as_of_now = 0;
};

/// Of 50 devices whose theta's entry moves after six segments, by so many sigmas of a segment.
Found steps_found(int entry, double step_sigmas, double scatter_sigmas) {
  Found found;
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    const auto w = std::make_unique<World>(seed, scatter_sigmas);
    w->alarms(6);
    w->truth[entry] += step_sigmas / kRow;
    SegmentInformation<S> s = w->segment();
    found.at_once += w->contradicts(&s) ? 1 : 0;
    found.as_of_now += w->contradiction.since_epoch() ? 0 : 1;
  }
  return found;
}

/// 3000 pairs of comparisons at 1e-5 each make 0.06 false alarms; two would be one in 600.
void test_false_alarms_are_as_rare_as_stated() { test::check_between(Id(), "false alarms", 0, false_alarms(0), 1); }

/// The same of segments that scatter by three of their sigmas in few directions, as where tracks drift. Were all
/// directions alike, the excess would have the shorter tails of chi-square.
void test_scatter_in_few_directions_raises_no_more_alarms() {
  test::check_between(Id(), "false alarms", 0, false_alarms(3), 3);
}

/// A step that a segment shows with 11 of its sigmas adds about 90 to F of 26 and 130 degrees, times 26: limit 79.
/// Found at once, as this moment's where the epoch has segments from before.
void test_a_large_step_is_found_at_once() {
  const Found found = steps_found(0, 11, 0);
  // Normal: 2.5 sigmas above the limit's noise, nine in ten.
  test::check_between(Id(), "found of 50", 42, found.at_once, 50);
  test::check_between(Id(), "dated to the segment", 48, found.as_of_now, 50);
}

/// With scatter it takes more, but less than where all of it could sit in three directions (limits of some 590 and
/// 960).
void test_a_large_step_is_found_beside_scatter() {
  test::check_between(Id(), "found of 50", 40, steps_found(1, 36, 3).at_once, 50);
}

/// A step of half that size shows in no segment alone. Twelve after it against six before: 90 once more, less what the
/// other columns of a row take of it.
void test_a_small_step_is_found_by_the_epoch() {
  int alone = 0, together = 0, since = 0;
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    const auto w = std::make_unique<World>(seed);
    w->truth[0] += 5.5 / kRow;
    for (int k = 0; k < 12; ++k) {
      SegmentInformation<S> s = w->segment();
      const bool found = w->contradicts(&s);
      alone += found && k == 0 ? 1 : 0;
      if (found) {
        ++together;
        since += w->contradiction.since_epoch() ? 1 : 0;
        break;
      }
      w->take(&s);
    }
  }
  test::check_between(Id(), "found at once", 0, alone, 15);
  test::check_between(Id(), "found within twelve", 40, together, 50);
  test::check_between(Id(), "dated to the epoch's beginning", 0.9 * together, since, together);
}

/// What segments disagree by is measured as they come: the same units as in scatter.h.
void test_pulls_tell_the_noise() {
  for (const double noise : {1.0, 3.0}) {
    double found = 0, expected = 0;
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
      const auto w = std::make_unique<World>(seed);
      w->noise = noise;
      w->alarms(20);
      found += static_cast<double>(w->epochs.newest().pulls.found);
      expected += static_cast<double>(w->epochs.newest().pulls.expected);
    }
    // What the kept segments said keeps its noise of 1; and chi-square of 600 degrees or so scatters by 6 %.
    test::check_between(Id().add("noise", noise), "variance found", 0.8 * noise * noise, found / expected,
                        1.2 * noise * noise);
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_false_alarms_are_as_rare_as_stated);
  RUN_TEST(test_scatter_in_few_directions_raises_no_more_alarms);
  RUN_TEST(test_a_large_step_is_found_at_once);
  RUN_TEST(test_a_large_step_is_found_beside_scatter);
  RUN_TEST(test_a_small_step_is_found_by_the_epoch);
  RUN_TEST(test_pulls_tell_the_noise);
  return UNITY_END();
}
