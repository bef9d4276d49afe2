// From a device to the host and back: a log replays to the device's bits, and the folder made from it to the same ones.
#include "../replay/program.h"
#include "../replay/simulated_replay.h"
#include "../replay/temporary_folder.h"
#include "../support/cases.h"
#include "calibration_file.h"
#include "device_log/device_log.h"
#include "device_log/logged_config.h"
#include "device_log/write_log.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

namespace fs = std::filesystem;
using test::Id;

/// 24 s are five segments: enough for a calibration to have something to do.
const host::SimulationResult& session() {
  static const host::SimulationResult session = test::simulated("rich", 24, 1);
  return session;
}

host::CoreOptions options_of(const host::SimulationResult& session) {
  host::CoreOptions options;
  options.calibration = session.nominal;
  options.noise = session.recording.imu.noise;
  return options;
}

host::ReplayResult replayed_log(const std::vector<std::uint8_t>& bytes, const std::string& profile) {
  host::DeviceLog log = host::parse_device_log("x.segcal", bytes, host::Damaged::refuse);
  host::ReplayOptions options;
  options.core.calibration = log.calibration;
  options.core.device_config = log.sessions[0].device->config;
  options.profile = profile;
  return host::replay(log.sessions, options);
}

void test_log_replays_as_the_recording_does() {
  for (const char* profile : {"mcu", "mobile"}) {
    const host::ReplayResult direct = test::replayed(session(), profile);
    const std::vector<std::uint8_t> bytes = host::device_log_of({session().recording}, options_of(session()), profile);
    const host::ReplayResult log = replayed_log(bytes, profile);
    const Id id = Id().add("profile", profile);
    test::check_true(id, "a calibration ran", log.calibrated && log.result.iterations > 0);
    test::check_true(id, "the same hash", direct.result_hash == log.result_hash);
    test::check_near(id, "calibrations", static_cast<double>(direct.calibrations.size()),
                     static_cast<double>(log.calibrations.size()), 0);
  }
}

/// One sample by one step of the 16 bits that a segment stores (less may be rounded away), and the hash is another one.
void test_hash_sees_one_bit() {
  host::SimulationResult other = session();
  other.recording.imu.samples[1000].gyro[0] += 35.0 / 32767;
  TEST_ASSERT_TRUE(test::replayed(other, "mcu").result_hash != test::replayed(session(), "mcu").result_hash);
}

/// What each part of the hash stands for.
void test_hash_covers_what_was_found() {
  host::ReplayOptions options;
  options.core = options_of(session());
  options.profile = "mcu";
  options.calibrate = false;
  const std::uint64_t odometry = host::replay({session().recording}, options).result_hash;
  options.calibrate = true;
  const std::uint64_t calibrated = host::replay({session().recording}, options).result_hash;
  TEST_ASSERT_TRUE(odometry != calibrated);
  options.calibrate = false;
  options.core.segments = 3;  // the trajectory is the same, the kept segments are fewer
  TEST_ASSERT_TRUE(odometry != host::replay({session().recording}, options).result_hash);
}

void test_program_verifies_a_device() {
  test::TemporaryFolder folder("segcal_log");
  const fs::path log = folder.path() / "d.segcal";
  std::vector<std::uint8_t> bytes = host::device_log_of({session().recording}, options_of(session()), "mcu");
  // As a device would have written it: with the hash at its end.
  host::DeviceLog read = host::parse_device_log(log, bytes, host::Damaged::refuse);
  const std::uint64_t hash = replayed_log(bytes, "mcu").result_hash;
  for (const std::uint64_t written : {hash, hash ^ 1}) {
    read.sessions[0].device->calls.push_back({host::DeviceCall::hash, written});
    bytes = host::device_log_of(read.sessions, options_of(session()), "mcu");
    test::write_text(log, std::string(bytes.begin(), bytes.end()));
    const std::string common =
        "replay " + log.string() + " --out " + (folder.path() / "out").string() + " --hash --verify-hash ";
    const test::Outcome outcome = test::run_program(common + log.string(), folder.path());
    TEST_ASSERT_EQUAL_INT_MESSAGE(written == hash ? 0 : 1, outcome.code, outcome.err.c_str());
    TEST_ASSERT_TRUE(outcome.out.find("result_hash " + host::hash_text(hash)) != std::string::npos);
    const std::string line = "expected " + host::hash_text(written) + ", found " + host::hash_text(hash);
    TEST_ASSERT_EQUAL_INT(written == hash, outcome.err.find(line) == std::string::npos);
    read.sessions[0].device->calls.pop_back();
  }
  // The number alone, in a text as --hash prints it.
  const fs::path text = folder.path() / "hash.txt";
  for (const std::uint64_t written : {hash, hash ^ 1}) {
    test::write_text(text, "result_hash " + host::hash_text(written) + "\n");
    const test::Outcome outcome = test::run_program(
        "replay " + log.string() + " --out " + (folder.path() / "out").string() + " --verify-hash " + text.string(),
        folder.path());
    TEST_ASSERT_EQUAL_INT_MESSAGE(written == hash ? 0 : 1, outcome.code, outcome.err.c_str());
  }
}

void test_program_converts_both_ways() {
  test::TemporaryFolder folder("segcal_convert");
  const fs::path first = folder.path() / "a.segcal", rec = folder.path() / "rec", second = folder.path() / "b.segcal";
  const std::vector<std::uint8_t> bytes = host::device_log_of({session().recording}, options_of(session()), "mcu");
  test::write_text(first, std::string(bytes.begin(), bytes.end()));
  test::Outcome outcome = test::run_program("convert " + first.string() + " --out " + rec.string(), folder.path());
  TEST_ASSERT_EQUAL_INT_MESSAGE(0, outcome.code, outcome.err.c_str());
  outcome = test::run_program("convert " + rec.string() + " --profile mcu --out " + second.string(), folder.path());
  TEST_ASSERT_EQUAL_INT_MESSAGE(0, outcome.code, outcome.err.c_str());
  // The quaternions of the configuration go through matrices and may differ in their last digits; the data may not.
  const host::DeviceLog a = host::read_device_log(first), b = host::read_device_log(second);
  TEST_ASSERT_EQUAL_UINT(a.sessions[0].imu.samples.size(), b.sessions[0].imu.samples.size());
  for (std::size_t i = 0; i < a.sessions[0].imu.samples.size(); ++i) {
    const host::ImuSample &x = a.sessions[0].imu.samples[i], &y = b.sessions[0].imu.samples[i];
    TEST_ASSERT_TRUE(x.t_ns == y.t_ns && x.gyro == y.gyro && x.accel == y.accel);
  }
  TEST_ASSERT_EQUAL_UINT(a.sessions[0].cameras[0].frames.size(), b.sessions[0].cameras[0].frames.size());
  for (std::size_t i = 0; i < a.sessions[0].cameras[0].frames.size(); ++i) {
    const host::Frame &x = a.sessions[0].cameras[0].frames[i], &y = b.sessions[0].cameras[0].frames[i];
    TEST_ASSERT_TRUE(x.t_ns == y.t_ns && x.points.size() == y.points.size());
    for (std::size_t k = 0; k < x.points.size(); ++k) {
      TEST_ASSERT_TRUE(x.points[k].track_id == y.points[k].track_id && x.points[k].u == y.points[k].u &&
                       x.points[k].v == y.points[k].v);
    }
  }
}

void test_program_complains() {
  test::TemporaryFolder folder("segcal_log_bad");
  const fs::path log = folder.path() / "d.segcal", out = folder.path() / "out", text = folder.path() / "h.txt";
  std::vector<std::uint8_t> bytes = host::device_log_of({session().recording}, options_of(session()), "mcu");
  test::write_text(log, std::string(bytes.begin(), bytes.end()));
  test::write_text(text, "no number here\n");
  const auto complains = [&](const std::string& arguments, const std::string& words) {
    const test::Outcome outcome = test::run_program(arguments, folder.path());
    const Id id = Id().add("arguments", arguments);
    test::check_near(id, "exit code", 2, outcome.code, 0);
    test::check_true(id, (words + " in " + outcome.err).c_str(), outcome.err.find(words) != std::string::npos);
    test::check_near(id, "lines", 1, static_cast<double>(std::count(outcome.err.begin(), outcome.err.end(), '\n')), 0);
  };
  const std::string replay = "replay " + log.string() + " --out " + out.string();
  complains(replay + " --metric D", "--metric: the log holds the device's configuration");
  complains(replay + " --verify-hash " + text.string(), "expected 'result_hash' and 16 hexadecimal digits");
  complains(replay + " --verify-hash " + log.string(), "expected a result hash in the log");
  bytes[bytes.size() / 2] ^= 1;
  test::write_text(log, std::string(bytes.begin(), bytes.end()));
  complains(replay, log.string() + ": byte ");
  TEST_ASSERT_FALSE(fs::exists(out / "result.json"));
}

/// A log knows the columns and not the rows: its camera chain is read all the same, and states them.
void test_a_shutter_along_columns_is_kept() {
  segcal_config_t config{};
  config.camera[0].intrinsics[0] = config.camera[0].intrinsics[1] = 300;
  config.camera[0].q_CI[0] = config.imu.q_AI[0] = 1;
  config.camera[0].height = -640;
  const host::Calibration logged = host::calibration_of(config);
  TEST_ASSERT_TRUE(logged.cameras.at(0).reads_columns);
  TEST_ASSERT_EQUAL_INT(640, logged.cameras[0].width);
  const test::TemporaryFolder folder("columns");
  host::write_camchain(folder.path() / "camchain.yaml", logged);
  TEST_ASSERT_TRUE(host::read_calibration(folder.path() / "camchain.yaml").cameras.at(0).reads_columns);
  config.camera[0].height = 480;
  TEST_ASSERT_FALSE(host::calibration_of(config).cameras.at(0).reads_columns);
  config.camera[0].height = INT32_MIN;  // of a damaged log: refused later, by the core
  TEST_ASSERT_TRUE(host::calibration_of(config).cameras.at(0).reads_columns);
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_a_shutter_along_columns_is_kept);
  RUN_TEST(test_log_replays_as_the_recording_does);
  RUN_TEST(test_hash_sees_one_bit);
  RUN_TEST(test_hash_covers_what_was_found);
  RUN_TEST(test_program_verifies_a_device);
  RUN_TEST(test_program_converts_both_ways);
  RUN_TEST(test_program_complains);
  return UNITY_END();
}
