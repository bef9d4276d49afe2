// Real recordings as they are have no faults and noise as stated. Skipped where they are missing.
#include <cstdio>
#include <filesystem>

#include "../replay/euroc.h"
#include "../replay/temporary_folder.h"
#include "../support/cases.h"
#include "diagnose/fault.h"
#include "diagnose/imu_noise.h"
#include "simulate/simulate.h"
#include "unity.h"

namespace {

std::filesystem::path data;

void check_none(const test::Id& id, const std::vector<host::Fault>& faults) {
  if (!faults.empty()) test::fail_case(id, faults[0].kind + ": " + faults[0].words);
}

void euroc_mh01_is_sound() {
  const test::TemporaryFolder folder("segcal_real_faults");
  const host::Calibration published = host::find_calibration(data / "euroc_mh01", "", 1);
  host::write_camchain(folder.path() / "start.yaml", published);
  const host::Recording recording = test::euroc::tracked(data, folder.path() / "start.yaml", folder.path() / "tracks");
  check_none(test::Id().add("recording", "euroc_mh01"), host::find_faults(recording, published));
  TEST_ASSERT_EQUAL_size_t(0, host::spikes_of(recording).size());
  const host::RawNoise noise = host::raw_imu_noise(recording);
  std::printf("%s\n%s\n", noise.gyro.words.c_str(), noise.accel.words.c_str());
  TEST_ASSERT_TRUE(noise.gyro.verdict == host::SensorNoise::Verdict::as_stated);
  TEST_ASSERT_TRUE(noise.accel.verdict == host::SensorNoise::Verdict::as_stated);
}

/// Drones that shake their sensors, and hands; landmarks are simulated along the published poses.
void real_samples_with_simulated_landmarks_are_sound() {
  for (const char* name : {"MH_03_medium", "V1_02_medium", "V2_01_easy", "tumvi_room1", "tumvi_room4"}) {
    const auto id = test::Id().add("recording", name);
    if (!test::selected(id.text())) continue;
    host::SimulationOptions options;
    options.trajectory_file = data / "imu_gt" / name / "groundtruth.csv";
    options.imu_file = data / "imu_gt" / name / "imu.csv";
    options.seconds = 60;
    const auto session = host::simulate(options);
    check_none(id, host::find_faults(session.recording, session.nominal));
    test::check_near(id, "samples taken for spikes", 0, static_cast<double>(host::spikes_of(session.recording).size()),
                     0);
    const auto noise = host::raw_imu_noise(session.recording);
    test::check_true(id, noise.gyro.words.c_str(), noise.gyro.verdict != host::SensorNoise::Verdict::above);
    test::check_true(id, noise.accel.words.c_str(), noise.accel.verdict != host::SensorNoise::Verdict::above);
  }
}

}  // namespace

void setUp() {}
void tearDown() {}

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  const auto found = host::find_real_data();
  if (!found) {
    std::printf("skipped: no real recordings in ../shared/data or SEGCAL_DATA\n");
    return 77;
  }
  data = *found;
  UNITY_BEGIN();
  RUN_TEST(euroc_mh01_is_sound);
  RUN_TEST(real_samples_with_simulated_landmarks_are_sound);
  return UNITY_END();
}
