// A camera that turns late on the way: what comes after is too little for the device to drop what came before.
#include <cmath>

#include "../replay/simulated_replay.h"
#include "../support/cases.h"
#include "simulate/effect_names.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

host::SimulationResult session(const char* scenario, int seed, const char* effect = nullptr, double walk = 0) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = 40;
  options.seed = static_cast<std::uint64_t>(seed);
  if (walk > 0) {
    options.tracks.pixel_noise_px = 0.1;
    options.tracks.walk_px_per_sqrt_s = walk;
  }
  if (effect) options.effects.push_back(host::sim::parse_effect(effect));
  return host::simulate(options);
}

/// Corners count as white noise of 0.5 px.
host::ReplayResult reviewed(const host::SimulationResult& session) {
  host::ReplayOptions options;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  options.review = true;
  return host::replay({session.recording}, options);
}

const host::Suspect* step_in(const host::ReplayResult& out) {
  for (const host::Suspect& s : out.health.suspects)
    if (s.name.rfind("calibration_shift.", 0) == 0) return &s;
  return nullptr;
}

/// Number in `words` after `before`; -1: not there.
double number_after(const std::string& words, const std::string& before) {
  const std::size_t at = words.find(before);
  return at == std::string::npos ? -1 : std::atof(words.c_str() + at + before.size());
}

/// All of these are beyond 2 sigma of the camera as it is now, and the second was called calibrated at 9.2. 0.84 deg
/// are told to a fifth: what is known of the new camera is one segment of four seconds.
void test_a_camera_that_turns_late_is_refused() {
  struct Case {
    const char* scenario;
    int seed;
  };
  for (const Case& c : {Case{"rich", 1103}, {"arvr", 1106}, {"nav", 1101}}) {
    const Id id = Id().add("scenario", c.scenario).add("seed", c.seed);
    if (!test::selected(id.text())) continue;
    const host::ReplayResult out =
        reviewed(session(c.scenario, c.seed, "calibration_shift=cam0.r_CI,30,0.012,-0.006,0.006"));
    test::check_true(id, ("status " + out.result.status + " " + out.cause).c_str(),
                     out.result.status == "insufficient");
    const host::Suspect* step = step_in(out);
    test::check_true(id, "named", step && step->name == "calibration_shift.cam0.r_CI");
    if (!step) continue;
    test::check_between(id, "by, deg", 0.8 * 0.842, number_after(step->words, "rotates by "), 1.2 * 0.842);
    const double from_s = number_after(step->words, "between ");
    test::check_between(id, "when it begins, s", 22, from_s, 30);
    test::check_between(id, "when it ends, s", 30,
                        number_after(step->words.substr(step->words.find("between")), " and "), 36);
    test::check_between(id, "chance, log10", -1e4, step->log10_p, -4);
  }
}

/// By chi-square alone three of these would have a step, of statistics 48, 53 and 144: a mount that gives way and comes
/// back, a lens that hunts for focus, forces that follow the attitude make segments disagree, but no two sides of them.
void test_what_scatters_is_no_step() {
  struct Case {
    const char* scenario;
    int seed;
    const char* effect;
    double walk;
  };
  for (const Case& c : {Case{"rich", 51, "outside:loose_mount=0.004", 0},
                        {"rich", 54, "outside:focus_hunting=0.004", 0},
                        {"rich", 55, "outside:attitude_error=0.1", 0},
                        {"arvr", 31, nullptr, 0.9},
                        {"nav", 31, nullptr, 0.9}}) {
    const Id id = Id().add("scenario", c.scenario).add("seed", c.seed).add("effect", c.effect ? c.effect : "none");
    if (!test::selected(id.text())) continue;
    const host::ReplayResult out = reviewed(session(c.scenario, c.seed, c.effect, c.walk));
    const host::Suspect* step = step_in(out);
    test::check_true(id, step ? step->words.c_str() : "", step == nullptr);
    test::check_between(id, "scatter, or the case is not there", 1.5, out.health.segment_scatter, 50);
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_a_camera_that_turns_late_is_refused);
  RUN_TEST(test_what_scatters_is_no_step);
  return UNITY_END();
}
