// What was stated wrongly is said: noise three times too small or too large, and gravity where it can be told.
#include <algorithm>

#include "../replay/simulated_replay.h"
#include "../support/cases.h"
#include "gravity.h"
#include "review/stated.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

struct Stated {
  double gyro = 1, accel = 1, pixel = 1;  // factors on what is true
  double gravity = 0;
};

std::vector<host::Note> notes_of(const host::SimulationResult& session, const Stated& stated,
                                 double accel_scale_sigma = 0) {
  host::ReplayOptions options;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  options.core.noise.gyro_noise_density *= stated.gyro;
  options.core.noise.accel_noise_density *= stated.accel;
  options.core.pixel_sigma *= stated.pixel;
  options.core.gravity = stated.gravity;
  options.core.prior_sigma.accel_scale = accel_scale_sigma;
  options.review = true;
  host::Recording recording = session.recording;
  recording.imu.noise = options.core.noise;
  std::vector<host::Note> notes = host::replay({recording}, options).health.notes;
  // Said of every lens, whatever is stated (test_review.cpp).
  notes.erase(
      std::remove_if(notes.begin(), notes.end(), [](const host::Note& n) { return n.name == "unseen_effects"; }),
      notes.end());
  return notes;
}

/// Which of the three sensors is named, and its factor on what was stated.
std::map<std::string, double> named(const std::vector<host::Note>& notes) {
  std::map<std::string, double> out;
  for (const host::Note& n : notes) out[n.name] = n.factor;
  return out;
}

/// The spectrum tells an IMU's noise to some per cent, a hundred
/// image points theirs to ten: 20 %, and nothing else is named.
void test_noise_that_is_three_times_off_is_named() {
  const double g = host::kStandardGravity;
  for (const char* scenario : {"rich", "nav"}) {
    const host::SimulationResult session = test::simulated(scenario, 40, 3);
    TEST_ASSERT_EQUAL_MESSAGE(0, notes_of(session, {1, 1, 1, g}).size(), scenario);
    for (const double factor : {3.0, 1 / 3.0}) {
      const std::pair<const char*, Stated> cases[] = {
          {"gyro_noise", {factor, 1, 1, g}}, {"accel_noise", {1, factor, 1, g}}, {"pixel_noise", {1, 1, factor, g}}};
      for (const auto& [name, stated] : cases) {
        const Id id = Id().add("scenario", scenario).add("sensor", name).add("factor", factor);
        if (!test::selected(id.text())) continue;
        const std::map<std::string, double> found = named(notes_of(session, stated));
        test::check_true(id, "named, and nothing else", found.size() == 1 && found.count(name) == 1);
        if (found.count(name)) test::check_near(id, "factor", 1 / factor, found.at(name), 0.2 / factor);
      }
    }
  }
}

/// What the raw samples say needs no fit: 20 recordings of each
/// motion, 19 of 20 wanted, and nothing said of noise that is right.
void test_imu_noise_over_many_recordings() {
  for (const char* scenario : {"rich", "arvr", "nav"}) {
    int said[3][2] = {}, right = 0;
    const double factors[] = {3, 1 / 3.0};
    for (std::uint64_t seed = 201; seed <= 220; ++seed) {
      host::Recording recording = test::simulated(scenario, 60, seed).recording;
      const host::ImuNoise truth = recording.imu.noise;
      right += host::review::notes_on_noise(recording, {}).empty() ? 1 : 0;
      for (int f = 0; f < 2; ++f) {
        recording.imu.noise = truth;
        recording.imu.noise.gyro_noise_density *= factors[f];
        said[0][f] += named(host::review::notes_on_noise(recording, {})).count("gyro_noise");
        recording.imu.noise = truth;
        recording.imu.noise.accel_noise_density *= factors[f];
        said[1][f] += named(host::review::notes_on_noise(recording, {})).count("accel_noise");
      }
    }
    const Id id = Id().add("scenario", scenario);
    test::check_between(id, "nothing said of what is right", 20, right, 20);
    for (int f = 0; f < 2; ++f) {
      test::check_between(id.add("factor", factors[f]), "gyroscope", 19, said[0][f], 20);
      test::check_between(id.add("factor", factors[f]), "accelerometer", 19, said[1][f], 20);
    }
    std::printf(
        "%s: gyroscope %d and %d, accelerometer %d and %d of 20 stated 3 times too large and too small; %d of 20 "
        "right\n",
        scenario, said[0][0], said[0][1], said[1][0], said[1][1], right);
  }
}

/// No residual tells wrong gravity from a scale that all three accelerometers share. It is said where the prior of the
/// scales is narrow, and where nobody stated gravity although the scales are known better than it; else nothing is.
void test_gravity() {
  host::SimulationOptions options;
  options.seconds = 40;
  options.seed = 5;
  const double g = host::kStandardGravity;
  const host::SimulationResult any = host::simulate(options);
  test::check_true(Id(), "not stated", named(notes_of(any, {})).count("gravity") == 1);
  test::check_true(Id(), "stated, scales of the prior's 5 %",
                   named(notes_of(any, {1, 1, 1, g + 0.03})).count("gravity") == 0);
  options.device_scale = 0;  // an accelerometer that was calibrated
  const host::SimulationResult calibrated = host::simulate(options);
  test::check_true(Id(), "right", named(notes_of(calibrated, {1, 1, 1, g}, 1e-3)).count("gravity") == 0);
  for (const double off : {0.03, -0.03}) {
    const std::map<std::string, double> found = named(notes_of(calibrated, {1, 1, 1, g + off}, 1e-3));
    const Id id = Id().add("off", off);
    test::check_true(id, "named", found.count("gravity") == 1);
    // The prior of 0.1 % holds the scales back a little.
    if (found.count("gravity"))
      test::check_near(id, "share", -off / g, found.at("gravity") - 1, 0.3 * std::abs(off) / g);
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_noise_that_is_three_times_off_is_named);
  RUN_TEST(test_imu_noise_over_many_recordings);
  RUN_TEST(test_gravity);
  return UNITY_END();
}
