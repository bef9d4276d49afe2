// Two cameras in one run: simulated pairs with and without common track ids, frames of one camera alone, and the real
// recording, whose second camera ends after 17 s (exit code 77 without it, after the simulated part has passed).
// SEGCAL_LONG tries more devices and more starts.
#include <unity.h>

#include <cstdio>
#include <vector>

#include "../support/cases.h"
#include "euroc.h"
#include "simulated_replay.h"
#include "temporary_folder.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using test::Id;

constexpr int kSkipped = 77;
constexpr double kDegree = M_PI / 180;

int devices() { return test::long_run() ? 20 : 4; }

struct Study {
  std::map<std::string, double> squares;  ///< sum of (error / sigma)^2
  double chi2_per_dof = 0;                ///< sum
  double baseline = 0;                    ///< m, sum of squares
  int n = 0;
};

void add_device(const Id& id, const host::SimulationResult& session, Study* study) {
  const host::ReplayResult found = test::replayed(session);
  test::check_true(id, "not calibrated", found.result.status == "calibrated");
  test::check_true(id, "two cameras with fov have 37 parameters", found.result.parameters.size() == 37);
  const double ratio = found.result.chi2 / found.result.dof;
  const double baseline = (test::euroc::baseline(found.calibration) - test::euroc::baseline(session.truth)).norm();
  for (const auto& [name, error] : test::normalised_errors(session, found.result)) {
    // 37 parameters on 40 devices: beyond 6 sigma is once in 300000 such studies.
    test::check_between(Id(id).add("parameter", name), "error / sigma", -6, error, 6);
    study->squares[name] += error * error;
  }
  std::printf("%s: chi2/dof %.3f, baseline off by %.2f mm\n", id.text().c_str(), ratio, 1e3 * baseline);
  // About 15000 residuals: the ratio of a single run scatters by 0.012.
  test::check_between(id, "chi2/dof", 0.95, ratio, 1.05);
  study->chi2_per_dof += ratio;
  study->baseline += baseline * baseline;
  ++study->n;
}

/// The quantiles of chi-square / n that one parameter of 37 leaves by chance once in 100 runs: 0.01 / 74 at each end.
void check_honest(const Id& id, const Study& study) {
  const double low = test::long_run() ? 0.2282 : 0.0083, high = test::long_run() ? 2.574 : 5.715;
  double all = 0;
  for (const auto& [name, sum] : study.squares) {
    const double mean = sum / study.n;
    all += mean / static_cast<double>(study.squares.size());
    if (test::long_run()) std::printf("%-14s mean (error/sigma)^2 %.2f\n", name.c_str(), mean);
    test::check_between(Id(id).add("parameter", name), "mean (error/sigma)^2", low, mean, high);
  }
  std::printf("%s: mean (error/sigma)^2 %.2f over %d devices, chi2/dof %.4f, baseline %.2f mm (root mean square)\n",
              id.text().c_str(), all, study.n, study.chi2_per_dof / study.n, 1e3 * std::sqrt(study.baseline / study.n));
}

void check_pairs(bool matches, double baseline_limit) {
  const Id id = Id().add("matches", matches ? "yes" : "no");
  Study study;
  for (int seed = 1; seed <= devices(); ++seed) {
    const Id one = Id(id).add("seed", seed);
    if (test::selected(one.text()))
      add_device(one, test::simulated_pair("rich", 40, static_cast<std::uint64_t>(seed), matches), &study);
  }
  if (study.n < devices()) return;
  check_honest(id, study);
  test::check_between(id, "baseline, m", 0, std::sqrt(study.baseline / study.n), baseline_limit);
}

/// Devices scatter by 10 mm in the baseline. With common points it is known as well as the image points allow; without,
/// only through the motion that both cameras share.
void test_pairs_with_common_points() { check_pairs(true, 0.001); }
void test_pairs_without_common_points() { check_pairs(false, 0.002); }

/// The second camera misses every fifth frame and ends early; the first one misses some, too.
void test_frames_of_one_camera() {
  const Id id = Id().add("check", "one_camera");
  if (!test::selected(id.text())) return;
  host::SimulationResult session = test::simulated_pair("rich", 40, 1, true);
  std::vector<host::Frame> left[2];
  for (std::size_t c = 0; c < 2; ++c) {
    const auto& frames = session.recording.cameras[c].frames;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      const bool missing = c == 1 ? k % 5 == 4 || 3 * k > 2 * frames.size() : k % 11 == 7;
      if (!missing) left[c].push_back(frames[k]);
    }
  }
  for (std::size_t c = 0; c < 2; ++c) session.recording.cameras[c].frames = left[c];
  Study study;
  add_device(id, session, &study);
}

host::ReplayOptions options_from(const host::Recording& recording, const host::Calibration& start) {
  host::ReplayOptions options;
  options.core.calibration = start;
  options.core.noise = recording.imu.noise;
  return options;
}

/// As a user runs it: these lenses are not quite radtan, c would be 4 to 6 px off, and that has a name.
void check_named(const host::Recording& recording, const host::Calibration& start) {
  const Id id = Id().add("check", "named");
  if (!test::selected(id.text())) return;
  host::ReplayOptions options = options_from(recording, start);
  options.review = true;
  options.corner_noise = host::CornerNoise::shown;
  const host::ReplayResult found = host::replay({recording}, options);
  std::printf("without it: %s, %s\n", found.result.status.c_str(), found.cause.c_str());
  test::check_true(id, "refused", found.result.status != "calibrated");
  test::check_true(id, "by name", found.cause.find("--enable radial_residual") != std::string::npos);
}

/// With it.
void check_euroc(const Id& id, const host::Recording& recording, const host::Calibration& published,
                 const host::Calibration& start) {
  host::ReplayOptions options = options_from(recording, start);
  options.core.effects = SEGCAL_EFFECT_RADIAL_RESIDUAL;
  const host::ReplayResult found = host::replay({recording}, options);
  std::printf("%s: %s, chi2/dof %.3f\n", id.text().c_str(), found.result.status.c_str(),
              found.result.chi2 / found.result.dof);
  test::check_true(id, "not calibrated", found.result.status == "calibrated");
  for (std::size_t c = 0; c < 2; ++c) {
    const Id one = Id(id).add("camera", c);
    const auto error = test::euroc::camera_error(found.calibration.cameras[c], published.cameras[c]);
    std::printf("  cam%zu: f %.2f %%, c %.2f px, R_CI %.2f deg, p_CI %.1f mm\n", c, 100 * error.f, error.c,
                error.R_CI / kDegree, 1e3 * error.p_CI);
    test::check_between(one, "f, share", 0, error.f, 0.015);
    test::check_between(one, "c, px", 0, error.c, 3);                     // 0.4 to 1.8
    test::check_between(one, "R_CI, deg", 0, error.R_CI / kDegree, 0.5);  // 0.21 to 0.30
    test::check_between(one, "p_CI, m", 0, error.p_CI, 0.020);
  }
  const double baseline = (test::euroc::baseline(found.calibration) - test::euroc::baseline(published)).norm();
  std::printf("  baseline off by %.1f mm\n", 1e3 * baseline);
  test::check_between(id, "baseline, m", 0, baseline, 0.010);
}

std::filesystem::path data;  ///< the folder of real recordings

void test_euroc_with_two_cameras() {
  const std::filesystem::path start = std::filesystem::path(SEGCAL_FIXTURES) / "euroc_mh01_start_stereo.yaml";
  const test::TemporaryFolder folder("segcal_test_two_cameras");
  const host::Recording recording = test::euroc::tracked(data, start, folder.path() / "tracked", 2);
  const host::Calibration published = host::find_calibration(data / "euroc_mh01", "", 2);
  check_named(recording, host::read_calibration(start));
  const unsigned random_starts = test::selection().empty() && !test::long_run() ? 2 : 10;
  for (unsigned i = 0; i <= random_starts; ++i) {
    const Id id = Id().add("start", i);
    if (!test::selected(id.text())) continue;
    check_euroc(id, recording, published,
                i == 0 ? host::read_calibration(start) : test::euroc::disturbed(published, i));
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  const auto found = host::find_real_data();
  const bool real = found && std::filesystem::is_directory(*found / "euroc_mh01" / "mav0" / "cam1");
  if (real) data = *found;
  UNITY_BEGIN();
  RUN_TEST(test_pairs_with_common_points);
  RUN_TEST(test_pairs_without_common_points);
  RUN_TEST(test_frames_of_one_camera);
  if (real) RUN_TEST(test_euroc_with_two_cameras);
  const int failures = UNITY_END();
  if (failures != 0 || real) return failures;
  std::printf("the real part is skipped: no euroc_mh01 with cam1 in $SEGCAL_DATA or ../shared/data\n");
  return kSkipped;
}
