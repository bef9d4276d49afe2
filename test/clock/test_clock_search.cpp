// The offset of two clocks, found from rotation before anything is estimated.
#include <cmath>

#include "../replay/simulated_replay.h"
#include "../support/cases.h"
#include "clock/clock_search.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

/// Rotation of images past near points is good to some milliseconds: near enough for the filter, which estimates on.
/// From the data sheet's camera, 1 px and some milliradians beside the true one.
void test_offsets_are_found() {
  for (const char* scenario : {"rich", "arvr", "nav"}) {
    for (const std::uint64_t seed : {1, 2}) {
      const host::SimulationResult session = test::simulated(scenario, 40, seed);
      for (const double offset : {-0.4, -0.2, -0.03, 0.0, 0.09, 0.2}) {
        const Id id = Id().add("scenario", scenario).add("seed", seed).add("offset", offset);
        host::Recording recording = session.recording;
        host::shift_frames(-offset, &recording);
        const host::ClockSearch found = host::search_clock(recording, session.nominal.cameras[0], 0);
        test::check_true(id, ("judged: " + found.words).c_str(), found.judged);
        test::check_near(id, "offset", offset, found.offset_s, 0.004);
        test::check_true(id, "is another one", found.differs_from(0) == (offset != 0));
        const host::ClockSearch near = host::search_clock(recording, session.nominal.cameras[0], offset + 0.1);
        test::check_near(id, "offset from another start", offset, near.offset_s, 0.004);
      }
    }
  }
}

/// No answer is better than a wrong one: a device at rest, a camera that looks elsewhere.
void test_no_answer_without_motion_or_with_wrong_axes() {
  const host::SimulationResult still = test::simulated("still", 20, 1);
  test::check_true(Id(), "at rest", !host::search_clock(still.recording, still.nominal.cameras[0], 0).judged);
  const host::SimulationResult rich = test::simulated("rich", 30, 1);
  host::CameraCalibration turned = rich.nominal.cameras[0];
  turned.R_CI = Eigen::Vector3d(1, -1, -1).asDiagonal() * turned.R_CI;
  test::check_true(Id(), "a camera half a turn about", !host::search_clock(rich.recording, turned, 0).judged);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_offsets_are_found);
  RUN_TEST(test_no_answer_without_motion_or_with_wrong_axes);
  return UNITY_END();
}
