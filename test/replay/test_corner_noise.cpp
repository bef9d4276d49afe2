// What corners are weighed by: tracks that are better or worse than the default, or drift, are found out; a calibration
// that is refused with the noise of use stays refused.
#include <unity.h>

#include <cmath>

#include "simulate/effect_names.h"
#include "simulated_replay.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using host::CornerNoise;
using host::ReplayResult;

host::SimulationResult session(double pixel_noise, double walk = 0, const char* effect = nullptr) {
  host::SimulationOptions options;
  options.scenario = "rich";
  options.seconds = effect ? 60 : 30;
  options.seed = 17;
  options.tracks.pixel_noise_px = pixel_noise;
  options.tracks.walk_px_per_sqrt_s = walk;
  if (effect) options.effects.push_back(host::sim::parse_effect(effect));
  return host::simulate(options);
}

ReplayResult replayed(const host::SimulationResult& session, CornerNoise noise, const char* profile = "mobile",
                      bool review = false) {
  host::ReplayOptions options;
  options.review = review;
  options.profile = profile;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  options.corner_noise = noise;
  return host::replay({session.recording}, options);
}

double mean_square(const host::SimulationResult& session, const ReplayResult& r) {
  double sum = 0;
  for (const auto& [name, z] : test::normalised_errors(session, r.result)) sum += z * z;
  return sum / static_cast<double>(r.result.parameters.size());
}

/// Corners of 0.1 px: with 0.5 px stated sigmas are several times too large, by their own noise they are right.
void test_better_tracks_are_found_out() {
  const host::SimulationResult s = session(0.1);
  const ReplayResult stated = replayed(s, CornerNoise::stated), better = replayed(s, CornerNoise::shown);
  TEST_ASSERT_EQUAL_STRING("calibrated", better.result.status.c_str());
  TEST_ASSERT_TRUE(better.weighed_by_tracks && !stated.weighed_by_tracks);
  // Restricted maximum likelihood of some 2000 points: 2 %, and what a fit with the wrong weights does to residuals.
  TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.1, better.model.pixel_sigma);
  TEST_ASSERT_DOUBLE_WITHIN(0.05, 0, better.model.track_walk);
  TEST_ASSERT_DOUBLE_WITHIN(0.1, 1, better.result.chi2 / better.result.dof);
  TEST_ASSERT_TRUE(stated.result.chi2 / stated.result.dof < 0.1);
  // Of 26 entries a mean of 1 with a spread of sqrt(2 / 26) = 0.28, if they were independent.
  const double z2 = mean_square(s, better);
  std::printf("mean (error/sigma)^2: %.2f with 0.5 px stated, %.2f by the tracks\n", mean_square(s, stated), z2);
  TEST_ASSERT_DOUBLE_WITHIN(0.7, 1, z2);
}

/// Corners as stated: one replay, to the last bit.
void test_tracks_as_stated() {
  const host::SimulationResult s = session(0.5);
  const ReplayResult stated = replayed(s, CornerNoise::stated), kept = replayed(s, CornerNoise::shown);
  TEST_ASSERT_FALSE(kept.weighed_by_tracks);
  TEST_ASSERT_EQUAL_UINT64(stated.result_hash, kept.result_hash);
  TEST_ASSERT_EQUAL_FLOAT(0.5F, static_cast<float>(kept.model.pixel_sigma));
}

/// 0.8 px, white, is chi2/dof 2.6 by the stated 0.5 px, and calibrated.
void test_worse_tracks_are_found_out() {
  const host::SimulationResult s = session(0.8);
  const ReplayResult r = replayed(s, CornerNoise::shown);
  TEST_ASSERT_EQUAL_STRING("calibrated", r.result.status.c_str());
  TEST_ASSERT_TRUE(r.weighed_by_tracks);
  TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.8, r.model.pixel_sigma);  // as above, 2 % and what the fit does to residuals
  TEST_ASSERT_DOUBLE_WITHIN(0.1, 1, r.result.chi2 / r.result.dof);
}

/// A walk of 0.9 px/sqrt(s) beside 0.1 px, as tracks of real cameras have: taken as white, 0.5 px would fit by its
/// size.
void test_tracks_that_drift_are_found_out() {
  const host::SimulationResult s = session(0.1, 0.9);
  const ReplayResult stated = replayed(s, CornerNoise::stated), r = replayed(s, CornerNoise::shown);
  TEST_ASSERT_EQUAL_STRING("calibrated", r.result.status.c_str());
  TEST_ASSERT_TRUE(r.weighed_by_tracks);
  TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.1, r.model.pixel_sigma);
  TEST_ASSERT_DOUBLE_WITHIN(0.15, 0.9, r.model.track_walk);
  TEST_ASSERT_DOUBLE_WITHIN(0.1, 1, r.result.chi2 / r.result.dof);
  const double z2 = mean_square(s, r);
  std::printf("tracks that drift, mean (error/sigma)^2: %.2f with 0.5 px stated, %.2f by the tracks\n",
              mean_square(s, stated), z2);
  TEST_ASSERT_DOUBLE_WITHIN(0.7, 1, z2);
}

/// The tracks show a walk, but a gyroscope that is not linear refuses the answer by name: it stays no, and is not asked
/// of another noise, unless the user wants it.
void test_what_is_refused_stays_refused() {
  const host::SimulationResult s = session(0.1, 0.9, "gyro_nonlinearity=2e-3,0,0");
  const ReplayResult kept = replayed(s, CornerNoise::shown, "mobile", true);
  TEST_ASSERT_EQUAL_STRING("failed", kept.result.status.c_str());
  TEST_ASSERT_EQUAL_STRING("gyro_nonlinearity", kept.health.suspects.at(0).name.c_str());
  TEST_ASSERT_TRUE(host::differs(kept.track_noise, kept.model));
  TEST_ASSERT_FALSE(kept.weighed_by_tracks);
  const ReplayResult r = replayed(s, CornerNoise::estimated, "mobile", true);
  TEST_ASSERT_TRUE(r.weighed_by_tracks);
  TEST_ASSERT_EQUAL_STRING("failed", r.result.status.c_str());  // what has a name is not noise
}

/// Profile mcu is built without walks along tracks: all of it counts as white.
void test_a_profile_without_walks() {
  const host::SimulationResult s = session(0.1, 0.2);
  const ReplayResult r = replayed(s, CornerNoise::shown, "mcu");
  TEST_ASSERT_EQUAL_STRING("calibrated", r.result.status.c_str());
  TEST_ASSERT_TRUE(r.weighed_by_tracks);
  TEST_ASSERT_EQUAL_DOUBLE(0, r.model.track_walk);
  // sqrt(0.1^2 + 0.2^2 1 s); walks are known to some 10 % only, and what is left of theta's errors walks too.
  TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.224, r.model.pixel_sigma);
}

/// Tracks without noise are not believed; others are weighed by what they show.
void test_no_corner_is_known_better_than_a_tenth() {
  const host::TrackNoise exact = host::to_weigh_by({0.05, 0.03, 1000});
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.05, exact.white_px);
  TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.0866, exact.walk_px_per_sqrt_s);  // sqrt(0.1^2 - 0.05^2)
  for (const auto& [white, walk] : {std::pair{0.2, 0.0}, {0.05, 0.5}, {0.1, 0.02}}) {
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, white, host::to_weigh_by({white, walk, 1000}).white_px);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, walk, host::to_weigh_by({white, walk, 1000}).walk_px_per_sqrt_s);
  }
  const ReplayResult r = replayed(session(0.03), CornerNoise::shown);
  TEST_ASSERT_TRUE(r.weighed_by_tracks);
  TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.1, std::hypot(r.model.pixel_sigma, r.model.track_walk));  // float in the core
}

/// The rule alone, by what a first replay with 0.5 px can end with.
void test_when_it_asks_again() {
  struct Case {
    CornerNoise noise;
    const char* status;
    double white, walk;
    bool weighs_walks, again;
  };
  for (const Case& c : {
           Case{CornerNoise::stated, "calibrated", 0.1, 0.9, true, false},
           Case{CornerNoise::shown, "calibrated", 0.45, 0.05, true, false},
           Case{CornerNoise::shown, "calibrated", 0.3, 0.4, true, true},
           Case{CornerNoise::shown, "calibrated", 0.3, 0.4, false, false},  // 0.5 px in all, and no walk to tell apart
           Case{CornerNoise::shown, "calibrated", 0.1, 0.9, false, true},
           Case{CornerNoise::shown, "insufficient", 0.1, 0.9, true, false},
           Case{CornerNoise::shown, "insufficient", 0.1, 0.1, true, true},
           Case{CornerNoise::shown, "failed", 0.1, 0.1, true, false},
           Case{CornerNoise::estimated, "failed", 0.1, 0.9, true, true},
       }) {
    ReplayResult first;
    first.result.status = c.status;
    first.model.pixel_sigma = 0.5;
    first.model.track_walk = 0;
    first.model.weighs_walks = c.weighs_walks;
    first.track_noise = {c.white, c.walk, 1000};
    char id[80];
    std::snprintf(id, sizeof id, "%s, %.2f px, %.2f px/sqrt(s), walks %d", c.status, c.white, c.walk, c.weighs_walks);
    TEST_ASSERT_EQUAL_INT_MESSAGE(c.again, host::asks_again(c.noise, first), id);
    first.track_noise.points = 0;
    TEST_ASSERT_FALSE_MESSAGE(host::asks_again(c.noise, first), id);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_better_tracks_are_found_out);
  RUN_TEST(test_tracks_as_stated);
  RUN_TEST(test_worse_tracks_are_found_out);
  RUN_TEST(test_tracks_that_drift_are_found_out);
  RUN_TEST(test_no_corner_is_known_better_than_a_tenth);
  RUN_TEST(test_when_it_asks_again);
  RUN_TEST(test_what_is_refused_stays_refused);
  RUN_TEST(test_a_profile_without_walks);
  return UNITY_END();
}
