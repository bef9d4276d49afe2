// A real recording from starts that are far off: the published calibration comes back, and the odometry with it is
// good. Without the recording the test says so and is skipped (exit code 77). SEGCAL_LONG tries all ten random starts.
#include <unity.h>

#include <cstdio>
#include <memory>

#include "../support/cases.h"
#include "euroc.h"
#include "segcal/segcal.h"
#include "temporary_folder.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

constexpr int kSkipped = 77;
constexpr double kDegree = M_PI / 180;

host::Recording recording;
host::Calibration published, fixture_start;

host::ReplayResult replayed(const host::Calibration& start, bool calibrate, std::uint32_t effects = 0,
                            const char* profile = "mobile") {
  host::ReplayOptions options;
  options.profile = profile;
  options.core.effects = effects;
  options.core.calibration = start;
  options.core.noise = recording.imu.noise;
  if (calibrate) options.corner_noise = host::CornerNoise::shown;  // as the command does
  options.calibrate = calibrate;
  return host::replay({recording}, options);
}

/// Start 0 is the one in fixtures/.
host::Calibration start_of(unsigned start) {
  return start == 0 ? fixture_start : test::euroc::disturbed(published, start);
}

const host::ReplayResult& first_replay() {
  static const host::ReplayResult result = replayed(fixture_start, true);
  return result;
}

/// Of errors against the published calibration.
struct Limits {
  double f, c_px, R_CI_deg, p_CI_m;
};

void check_calibration(const Id& id, const host::ReplayResult& found, const Limits& limits) {
  const test::euroc::CameraError error = test::euroc::camera_error(found.calibration.cameras[0], published.cameras[0]);
  const double R_CI = error.R_CI / kDegree;
  std::printf("%s: %s, chi2/dof %.3f, f %.2f %%, c %.2f px, R_CI %.2f deg, p_CI %.1f mm, reprojection median %.2f px\n",
              id.text().c_str(), found.result.status.c_str(), found.result.chi2 / found.result.dof, 100 * error.f,
              error.c, R_CI, 1e3 * error.p_CI, found.result.reprojection_median_px);
  test::check_true(id, "not calibrated", found.result.status == "calibrated");
  test::check_between(id, "f, share", 0, error.f, limits.f);
  test::check_between(id, "c, px", 0, error.c, limits.c_px);
  test::check_between(id, "R_CI, deg", 0, R_CI, limits.R_CI_deg);
  test::check_between(id, "p_CI, m", 0, error.p_CI, limits.p_CI_m);
  test::check_between(id, "reprojection median, px", 0, found.result.reprojection_median_px, 0.6);
}

/// The lens is not quite radtan: without radial_residual, which the review names, c stands for a part of it, with a
/// sigma of 3 px; with it, c has 1.4 px.
void test_the_published_calibration_is_found() {
  const unsigned random_starts = test::selection().empty() && !std::getenv("SEGCAL_LONG") ? 2 : 10;
  for (unsigned start = 0; start <= random_starts; ++start) {
    const Id plain = Id().add("start", start), lens = Id().add("lens_from", start);
    if (test::selected(plain.text())) {
      check_calibration(plain, start == 0 ? first_replay() : replayed(start_of(start), true),
                        {test::open_limit(0.01, 0.015), test::open_limit(1.5, 6.5), test::open_limit(0.4, 0.8), 0.020});
    }
    if (test::selected(lens.text())) {
      check_calibration(lens, replayed(start_of(start), true, SEGCAL_EFFECT_RADIAL_RESIDUAL),
                        {0.01, test::open_limit(1.5, 4), 0.4, 0.020});
    }
  }
}

/// Segments of 256 landmarks tell enough to contradict each other by five per degree of freedom, as the lens is not
/// quite radtan. Three of five were dropped as those of another device.
void test_larger_segments_are_not_outdated() {
  const Id id = Id().add("profile", "host");
  if (!test::selected(id.text())) return;
  for (const std::uint32_t effects : {0u, std::uint32_t(SEGCAL_EFFECT_RADIAL_RESIDUAL)}) {
    const host::ReplayResult out = replayed(fixture_start, true, effects, "host");
    int kept = 0;
    for (const host::CoreSegment& segment : out.segments) {
      test::check_true(id.add("effects", static_cast<int>(effects)), "outdated", !segment.outdated);
      kept += segment.kept ? 1 : 0;
    }
    test::check_between(id.add("effects", static_cast<int>(effects)), "kept", 4, kept, 8);
    if (effects != 0) check_calibration(id, out, {0.01, test::open_limit(1.5, 2.5), 0.4, 0.020});
  }
}

void test_odometry_with_the_result() {
  const host::ReplayResult second = replayed(first_replay().calibration, false);
  const double rmse = test::euroc::moving_rmse(second.trajectory, recording.truth);
  const double drift = test::euroc::standing_drift(second.trajectory);
  std::printf("trajectory: %.1f mm RMSE while it moves, %.1f mm drift while it stands\n", 1e3 * rmse, 1e3 * drift);
  test::check_between(Id().add("check", "rmse"), "RMSE, m", 0, rmse, 0.06);
  test::check_between(Id().add("check", "drift"), "drift, m", 0, drift, 0.01);
}

/// On the floor nothing is kept. Until it is shaken once more, at 31.3 s, each of the 29 entries of theta is blind
/// (radtan: 14 + 15); that says a little, and what it does not say must still be named.
void test_standing_still_tells_nothing() {
  int standing = 0;
  for (const host::CoreSegment& segment : first_replay().segments) {
    if (test::euroc::sequence_time(segment.start_ns) < test::euroc::kStandsFrom) continue;
    const bool shaken = test::euroc::sequence_time(segment.end_ns) > test::euroc::kShakenFrom;
    const Id id = Id().add("check", "standing").add("segment", segment.serial);
    const auto named = static_cast<double>(segment.not_excited.size());
    test::check_true(id, "kept", !segment.kept);
    test::check_between(id, "directions named", shaken ? 29 - segment.rank : 29, named,
                        29 - (shaken ? segment.rank : 0));
    standing += shaken ? 0 : 1;
  }
  test::check_between(Id().add("check", "standing"), "segments", 1, standing, 100);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  const auto data = host::find_real_data();
  if (!data || !std::filesystem::is_directory(*data / "euroc_mh01" / "mav0")) {
    std::printf("skipped: no euroc_mh01 in $SEGCAL_DATA or ../shared/data\n");
    return kSkipped;
  }
  const std::filesystem::path start = std::filesystem::path(SEGCAL_FIXTURES) / "euroc_mh01_start.yaml";
  const test::TemporaryFolder folder("segcal_test_euroc");
  recording = test::euroc::tracked(*data, start, folder.path() / "tracked");
  published = host::find_calibration(*data / "euroc_mh01", "", 1);
  fixture_start = host::read_calibration(start);
  UNITY_BEGIN();
  RUN_TEST(test_the_published_calibration_is_found);
  RUN_TEST(test_larger_segments_are_not_outdated);
  RUN_TEST(test_odometry_with_the_result);
  RUN_TEST(test_standing_still_tells_nothing);
  return UNITY_END();
}
