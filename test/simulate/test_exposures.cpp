// Exposure times: what the simulator writes, what a recording keeps, and stamps that are moved by them.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "../replay/temporary_folder.h"
#include "exposure_file.h"
#include "simulate/effect_names.h"
#include "simulate/exposures.h"
#include "simulate/simulate.h"
#include "stamps/exposures.h"
#include "unity.h"

namespace {

host::SimulationOptions options_with(const std::string& effect) {
  host::SimulationOptions options;
  options.seconds = 20;
  options.seed = 3;
  options.exposures = true;
  if (!effect.empty()) options.effects.push_back(host::sim::parse_effect(effect));
  return options;
}

/// Both ends are reached within two periods, neighbours of 0.1 s differ by a seventh at most.
void exposures_go_smoothly_from_2_to_20_ms() {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const host::sim::AutoExposure exposure(seed);
    double least = 1, most = 0, steepest = 0;
    for (double t = 0; t < 60; t += 0.1) {
      const double e = exposure.at(t);
      least = std::min(least, e);
      most = std::max(most, e);
      steepest = std::max(steepest, std::abs(std::log(exposure.at(t + 0.1) / e)));
    }
    TEST_ASSERT_TRUE(least >= 2e-3 && least < 2.1e-3);
    TEST_ASSERT_TRUE(most <= 20e-3 && most > 19e-3);
    // log 10 / 2 times both phases' rates at most: 1.15 (2 pi / 8 + 1.5 2 pi / 17) = 1.54 per s
    TEST_ASSERT_TRUE(steepest < 0.154);
  }
}

/// Where the points are is said by the pose at stamp + kappa exposure: as a time offset of that much sees it.
void stamps_are_apart_from_the_middle_by_their_share() {
  const host::SimulationResult follows = host::simulate(options_with("exposure_offset=0.5"));
  const host::SimulationResult plain = host::simulate(options_with(""));
  TEST_ASSERT_EQUAL_STRING("exposure_offset", follows.effects[0].name.c_str());
  TEST_ASSERT_EQUAL_STRING("kappa", follows.effects[0].parameters[0].name.c_str());
  TEST_ASSERT_EQUAL_DOUBLE(0.5, follows.effects[0].parameters[0].value);
  const std::vector<host::Frame>&a = follows.recording.cameras[0].frames, &b = plain.recording.cameras[0].frames;
  TEST_ASSERT_EQUAL_UINT(b.size(), a.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    TEST_ASSERT_TRUE(a[k].t_ns == b[k].t_ns);
    TEST_ASSERT_EQUAL_DOUBLE(b[k].exposure_s, a[k].exposure_s);
  }
  const double first = a[0].exposure_s;
  char offset[64];
  std::snprintf(offset, sizeof offset, "time_offset=%.12g", 0.5 * first);
  const host::SimulationResult late = host::simulate(options_with(offset));
  const std::vector<host::TrackPoint>&p = a[0].points, &q = late.recording.cameras[0].frames[0].points;
  for (std::size_t i = 0; i < std::min<std::size_t>(20, p.size()); ++i) {
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, q[i].u, p[i].u);  // the noise is the same, and rays differ by rounding
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, q[i].v, p[i].v);
  }
}

void a_folder_keeps_them() {
  const test::TemporaryFolder folder("segcal_exposures");
  host::SimulationOptions options = options_with("");
  options.cameras = 2;
  const host::SimulationResult session = host::simulate(options);
  host::write_simulation(session, folder.path());
  const host::Recording back = host::read_recording(folder.path(), 2, true);  // smoothed: by the file's own stamps
  for (std::size_t c = 0; c < 2; ++c) {
    const std::vector<host::Frame>&read = back.cameras[c].frames, &written = session.recording.cameras[c].frames;
    TEST_ASSERT_EQUAL_UINT(written.size(), read.size());
    for (std::size_t k = 0; k < read.size(); ++k) {
      TEST_ASSERT_DOUBLE_WITHIN(1e-12, written[k].exposure_s, read[k].exposure_s);  // whole ns
    }
  }
}

/// What nobody says is their neighbour's, of both cameras alike, and a sentence tells it.
void stamps_move_by_the_exposure() {
  host::SimulationOptions options = options_with("");
  options.cameras = 2;
  host::Recording r = host::simulate(options).recording;
  const host::Recording before = r;
  r.cameras[0].frames[7].exposure_s = r.cameras[1].frames[7].exposure_s = 0;
  const std::string note = host::add_exposure_to_stamps(-0.5, &r);
  TEST_ASSERT_TRUE_MESSAGE(note.find("of 1 nobody says it") != std::string::npos, note.c_str());
  for (std::size_t k = 0; k < r.cameras[0].frames.size(); ++k) {
    const host::Frame& was = before.cameras[0].frames[k == 7 ? 6 : k];
    const std::int64_t moved = -std::llround(0.5e9 * was.exposure_s);
    TEST_ASSERT_TRUE(r.cameras[0].frames[k].t_ns == before.cameras[0].frames[k].t_ns + moved);
    TEST_ASSERT_TRUE(r.cameras[1].frames[k].t_ns == r.cameras[0].frames[k].t_ns);
  }
}

std::string refusal(double k, host::Recording recording) {
  try {
    host::add_exposure_to_stamps(k, &recording);
  } catch (const host::InputError& error) {
    return error.what();
  }
  return "";
}

void what_cannot_be_moved_is_refused() {
  host::Recording r = host::simulate(options_with("")).recording;
  r.cameras[0].frames[5].exposure_s = 0.5;  // in us and not in ns, say: later than the four images behind it
  const std::string out_of_order = refusal(0.5, r);
  TEST_ASSERT_TRUE_MESSAGE(out_of_order.find("stay in order") != std::string::npos, out_of_order.c_str());
  std::vector<host::Frame>& frames = r.cameras[0].frames;
  for (std::size_t k = 0; k < frames.size(); ++k)
    if (k % 5 > 0) frames[k].exposure_s = 0;  // four of five: of another recording
  TEST_ASSERT_FALSE(host::has_exposures(r));
  const std::string none = refusal(0.5, r);
  TEST_ASSERT_TRUE_MESSAGE(none.find("exposure.csv: expected the exposure of most images") != std::string::npos,
                           none.c_str());
}

}  // namespace

extern "C" void setUp() {}
extern "C" void tearDown() {}

int main() {
  UNITY_BEGIN();
  RUN_TEST(exposures_go_smoothly_from_2_to_20_ms);
  RUN_TEST(stamps_are_apart_from_the_middle_by_their_share);
  RUN_TEST(a_folder_keeps_them);
  RUN_TEST(stamps_move_by_the_exposure);
  RUN_TEST(what_cannot_be_moved_is_refused);
  return UNITY_END();
}
