// The line delay of a rolling shutter, found from rotation before anything is estimated, and a phone that is shaken by
// hand, whose filter does not start without it.
#include <cmath>

#include "../replay/simulated_replay.h"
#include "../replay/temporary_folder.h"
#include "../support/cases.h"
#include "clock/line_delay_search.h"
#include "replay/replay_clocks.h"
#include "segcal/segcal.h"
#include "simulate/effect_names.h"
#include "state/state_file.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

host::SimulationResult session_with(const char* scenario, std::uint64_t seed, double line_delay, bool columns = false) {
  host::SimulationOptions options;
  options.scenario = scenario;
  options.seconds = 40;
  options.seed = seed;
  options.reads_columns = columns;
  options.tracks = host::sim::drifting_tracks();
  if (line_delay != 0) options.effects = {host::sim::parse_effect("rolling_shutter=" + std::to_string(line_delay))};
  return host::simulate(options);
}

/// Four of its sigmas, which eight parts of a recording tell to a quarter, and 4 us beside: parallax, and a data
/// sheet's camera, which is 1 px and some milliradians off.
void test_delays_are_found() {
  for (const char* scenario : {"rich", "arvr"}) {
    for (const double delay : {-4e-5, 5e-5, 7e-5}) {
      const Id id = Id().add("scenario", scenario).add("delay", delay);
      const bool columns = delay < 0;
      const host::SimulationResult session = session_with(scenario, 11, delay, columns);
      const host::LineDelaySearch found = host::search_line_delay(session.recording, session.nominal.cameras[0]);
      test::check_true(id, found.words.c_str(), found.shows_rolling_shutter());
      test::check_near(id, "s/line", delay, found.line_delay, 4 * found.sigma + 4e-6);
    }
  }
}

void test_a_global_shutter_shows_none() {
  for (const char* scenario : {"rich", "arvr", "nav", "still"}) {
    for (const std::uint64_t seed : {1, 2}) {
      const host::SimulationResult session = session_with(scenario, seed, 0);
      const host::LineDelaySearch found = host::search_line_delay(session.recording, session.nominal.cameras[0]);
      test::check_true(Id().add("scenario", scenario).add("seed", seed), found.words.c_str(),
                       !found.shows_rolling_shutter());
    }
  }
}

/// A gyroscope whose axes are swapped is no rolling shutter, and a camera without a size has no rows.
void test_no_answer_where_something_else_is_wrong() {
  const host::SimulationResult session = session_with("rich", 11, 7e-5);
  host::Recording swapped = session.recording;
  for (host::ImuSample& s : swapped.imu.samples) std::swap(s.gyro[0], s.gyro[1]);
  test::check_true(Id(), "axes", !host::search_line_delay(swapped, session.nominal.cameras[0]).judged);
  host::CameraCalibration camera = session.nominal.cameras[0];
  camera.height = 0;
  test::check_true(Id(), "no height", !host::search_line_delay(session.recording, camera).judged);
}

/// The device may rest, or go straight on, in the first of several sessions.
void test_every_session_is_asked() {
  const host::SimulationResult shaken = session_with("rich", 11, 7e-5), still = session_with("still", 11, 7e-5);
  const host::LineDelaySearch found =
      host::search_line_delay({still.recording, shaken.recording}, shaken.nominal.cameras[0]);
  test::check_true(Id(), found.words.c_str(), found.shows_rolling_shutter());
}

/// A state goes on with its own start: what this session shows would be another configuration.
void test_a_state_keeps_its_start() {
  const host::SimulationResult shaken = session_with("rich", 11, 7e-5);
  test::TemporaryFolder folder("line_delay");
  host::StateFile state((folder.path() / "state.bin").string());
  for (host::StateFile* of : {static_cast<host::StateFile*>(nullptr), &state}) {
    host::ReplayArguments a;
    a.replay.core.calibration = shaken.nominal;
    a.replay.state = of;
    host::EffectChoice choice;
    choice.enable("rolling_shutter");
    host::start_line_delay(a, {shaken.recording}, &choice);
    test::check_true(Id(), "started from rotation",
                     (choice.value("rolling_shutter.line_delay") != 0) == (of == nullptr));
  }
}

host::ReplayResult replayed_from(const host::SimulationResult& session, std::uint32_t effects, double line_delay) {
  host::ReplayOptions options;
  options.core.calibration = session.nominal;
  options.core.noise = session.recording.imu.noise;
  options.core.effects = effects;
  if (effects) options.core.term_values = {line_delay};
  options.review = true;
  return host::replay({session.recording}, options);
}

/// 33 ms of read-out, as slow phones have, shaken: the filter used no image, and nothing said why.
void test_a_shaken_phone() {
  const host::SimulationResult session = session_with("rich", 11, 7e-5);
  const host::ReplayResult plain = replayed_from(session, 0, 0);
  test::check_true(Id(), plain.result.status.c_str(), plain.result.status == "insufficient");
  test::check_true(Id(), plain.cause.c_str(), plain.cause.find("--enable rolling_shutter") != std::string::npos);
  const double start = host::search_line_delay(session.recording, session.nominal.cameras[0]).line_delay;
  const host::ReplayResult with = replayed_from(session, SEGCAL_EFFECT_ROLLING_SHUTTER, start);
  test::check_true(Id(), (with.result.status + " " + with.cause).c_str(), with.result.status == "calibrated");
  double squares = 0, n = 0;
  std::map<std::string, double> truth = {{"rolling_shutter.line_delay", 7e-5}};
  for (const auto& p : host::sim::named_parameters(session.truth, true)) truth[p.name] = p.value;
  for (const host::CoreParameter& p : with.result.parameters) {
    const double error = (p.value - truth.at(p.name)) / p.sigma;
    test::check_near(Id(), (p.name + ", sigmas").c_str(), 0, error, 5);
    squares += error * error;
    ++n;
  }
  test::check_between(Id(), "mean (error/sigma)^2", 0.2, squares / n, 2.2);  // 27 correlated entries of one device
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_delays_are_found);
  RUN_TEST(test_a_global_shutter_shows_none);
  RUN_TEST(test_no_answer_where_something_else_is_wrong);
  RUN_TEST(test_every_session_is_asked);
  RUN_TEST(test_a_state_keeps_its_start);
  RUN_TEST(test_a_shaken_phone);
  return UNITY_END();
}
