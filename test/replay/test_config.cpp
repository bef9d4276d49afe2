// config.yaml: what it states reaches the core, what was used is written back and repeats the run, and gravity does to
// a result what the maths says. Files that cannot be used are in test_bad_input.
#include "../support/cases.h"
#include "gravity.h"
#include "program.h"
#include "replay/config_file.h"
#include "simulated_replay.h"
#include "temporary_folder.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

namespace fs = std::filesystem;
using test::Id;

fs::path scratch;

host::SensorConfig config_of(const std::string& text) {
  const fs::path file = scratch / "config.yaml";
  test::write_text(file, text);
  return host::read_config_file(file);
}

/// The ellipsoid's gravity at the pole is a derived constant of WGS 84 (TR8350.2, table 3.4), not one of those that the
/// formula is made of. At 45 deg it is 9.806199203 on the ellipsoid of GRS 80 (Moritz, Geodetic Reference System 1980),
/// whose gravity at the equator is 1.44e-6 above WGS 84's, and falls with height h in m by (0.30877 - 0.00043 sin^2
/// phi) h - 0.000072e-3 h^2 mGal (the same source, to 1e-7 m/s^2 over a kilometre).
void test_gravity_of_a_place() {
  test::check_near(Id(), "pole", 9.8321849378, host::normal_gravity(90, 0), 1e-9);
  test::check_near(Id(), "45 deg", 9.806199203 - 1.44e-6, host::normal_gravity(-45, 0), 1e-8);
  test::check_near(Id(), "1 km", 0.0030848, host::normal_gravity(45, 0) - host::normal_gravity(45, 1000), 5e-7);
  test::check_near(Id(), "by latitude", host::normal_gravity(47.38, 408),
                   config_of("gravity: {latitude_deg: 47.38, height_m: 408}\n").gravity.value(), 0);
}

void test_what_is_stated_reaches_the_options() {
  host::CoreOptions options;
  options.calibration.cameras.resize(1);
  options.calibration.cameras[0].intrinsics << 400, 300, 320, 240;
  config_of(
      "format: 1\nprior_sigma: {r_CI_rad: 0.2, focal_length_share: 0.1, accel_scale: 0.004}\ngravity: {m_s2: 9.78}\n"
      "noise: {gyroscope_noise_density: 3e-4, pixel_sigma_px: 1.25}\n")
      .apply(&options);
  test::check_near(Id(), "gravity", 9.78, options.gravity, 0);
  test::check_near(Id(), "gyro", 3e-4, options.noise.gyro_noise_density, 0);
  test::check_near(Id(), "accel as it was", host::ImuNoise().accel_noise_density, options.noise.accel_noise_density, 0);
  test::check_near(Id(), "pixel", 1.25, options.pixel_sigma, 0);
  const std::vector<double> sigma = host::prior_sigmas(options.prior_sigma, options.calibration);
  TEST_ASSERT_EQUAL(14 + 15, sigma.size());  // radtan
  const double stated[] = {0.2, 0.2, 0.2, 0, 0, 0, 40, 30, 0, 0};
  for (std::size_t i = 0; i < 10; ++i) test::check_near(Id().add("entry", i), "camera", stated[i], sigma[i], 1e-12);
  for (std::size_t i = 20; i < 29; ++i) test::check_near(Id().add("entry", i), "IMU", i < 23 ? 0.004 : 0, sigma[i], 0);
}

/// The file that a replay leaves repeats it bit by bit, with and without a config of its own.
void test_a_run_can_be_repeated() {
  const std::string rec = "\"" + (scratch / "rec").string() + "\"";
  test::write_text(
      scratch / "stated.yaml",
      "prior_sigma: {p_CI_m: 0.01}\ngravity: {latitude_deg: 10}\nnoise: {accelerometer_noise_density: 0.004}\n");
  for (const std::string& first :
       {std::string(), " --config \"" + (scratch / "stated.yaml").string() + "\" --pixel-sigma 0.75"}) {
    const fs::path out = scratch / ("out" + std::to_string(first.size())),
                   again = scratch / ("again" + std::to_string(first.size()));
    const std::string replay = "replay " + rec + " --hash --out \"";
    const test::Outcome a = test::run_program(replay + out.string() + "\"" + first, scratch);
    const test::Outcome b =
        test::run_program(replay + again.string() + "\" --config \"" + (out / "config.yaml").string() + "\"", scratch);
    TEST_ASSERT_EQUAL_MESSAGE(a.code, b.code, b.err.c_str());
    const auto hash = [](const std::string& text) { return text.substr(text.find("result_hash")); };
    TEST_ASSERT_TRUE_MESSAGE(a.out.find("result_hash") != std::string::npos, a.err.c_str());
    TEST_ASSERT_EQUAL_STRING(hash(a.out).c_str(), hash(b.out).c_str());
    TEST_ASSERT_EQUAL_STRING(test::text_of(out / "config.yaml").c_str(), test::text_of(again / "config.yaml").c_str());
  }
  const std::string used = test::text_of(scratch / "again0" / "config.yaml");
  TEST_ASSERT_TRUE_MESSAGE(used.find("# gravity:") != std::string::npos, "what nobody stated is not written as stated");
}

/// Gravity stated 0.3 % too large is taken up by the accelerometer's scales and by all lengths: the fit is as good as
/// before. Wider than usual is the prior of p_CI only: 3 cm against a shift of 0.2 mm, so that 1e-4 of chi2 and 2 % of
/// the step are far above what it does.
void test_wrong_gravity_is_taken_up_by_the_scales() {
  const host::SimulationResult session = test::simulated("rich", 40, 7);
  const auto with = [&session](double gravity) {
    host::ReplayOptions options;
    options.core.calibration = session.nominal;
    options.core.noise = session.recording.imu.noise;
    options.core.gravity = gravity;
    return host::replay({session.recording}, options).result;
  };
  const double g = host::kStandardGravity, wrong = g + 0.03;
  const host::CoreResult right = with(0), stated = with(g), off = with(wrong);
  test::check_near(Id(), "chi2, stated as it is", right.chi2, stated.chi2, 0);
  test::check_near(Id(), "chi2 of wrong gravity", right.chi2 / right.dof, off.chi2 / off.dof, 1e-3);
  for (std::size_t i = 0; i < right.parameters.size(); ++i) {
    const std::string& name = right.parameters[i].name;
    if (name.compare(0, 7, "accel.s") != 0) continue;
    const double expected = right.parameters[i].value * g / wrong;
    test::check_near(Id(), name.c_str(), expected, off.parameters[i].value,
                     0.1 * std::abs(expected - right.parameters[i].value));
  }
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  const test::TemporaryFolder folder("segcal_test_config");
  scratch = folder.path();
  host::SimulationOptions options;
  options.seconds = 20;
  host::write_simulation(host::simulate(options), scratch / "rec");
  UNITY_BEGIN();
  RUN_TEST(test_gravity_of_a_place);
  RUN_TEST(test_what_is_stated_reaches_the_options);
  RUN_TEST(test_a_run_can_be_repeated);
  RUN_TEST(test_wrong_gravity_is_taken_up_by_the_scales);
  return UNITY_END();
}
