// A device whose logs rotate, across power-off: each begins with its state, and replays
// alone or behind the ones before it to the device's bits; what is no such log is refused.
#include "../replay/program.h"
#include "../replay/temporary_folder.h"
#include "device_log/device_log.h"
#include "log/format.h"
#include "replay/replay.h"
#include "rotating_device.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;
constexpr std::size_t kPage = 256;  ///< of the state in a log

const std::vector<Bytes>& quick_logs() {
  static std::vector<Bytes> logs;  // assigned: a check that fails inside an initialiser would lock it for ever
  if (logs.empty()) logs = logs_of_devices(1000000);
  return logs;
}

host::ReplayResult replayed(const std::vector<Bytes>& logs) {
  std::vector<host::Recording> sessions;
  host::ReplayOptions options;
  options.profile = "mobile";
  for (const Bytes& bytes : logs) {
    host::DeviceLog log = host::parse_device_log("x.segcal", bytes, host::Damaged::refuse);
    options.core.calibration = log.calibration;
    for (host::Recording& s : log.sessions) sessions.push_back(std::move(s));
  }
  options.core.device_config = sessions[0].device->config;
  return host::replay(sessions, options);
}

void expect_bits(const Id& id, const std::vector<Bytes>& logs) {
  const host::ReplayResult result = replayed(logs);
  check_near(id, "hashes", static_cast<double>(logs.size()), static_cast<double>(result.hash_checks.size()), 0);
  for (const host::HashCheck& check : result.hash_checks)
    check_true(id, "the device's bits", check.expected == check.found);
}

/// What a replay of these logs, or reading them, complains of; empty: nothing.
std::string refusal(const std::vector<Bytes>& logs) {
  try {
    replayed(logs);
  } catch (const host::InputError& error) {
    return error.what();
  }
  return "";
}

void expect_refusal(const std::vector<Bytes>& logs, const std::string& words) {
  const std::string said = refusal(logs);
  TEST_ASSERT_TRUE_MESSAGE(said.find("x.segcal") == 0 && said.find(words) != std::string::npos,
                           (words + " in: " + said).c_str());
}

/// Where the blocks of a type begin, with all that they take.
struct Stretch {
  std::size_t at, n;
};
std::vector<Stretch> blocks_of(const Bytes& log, SEGCAL_NS::LogBlock type) {
  std::vector<Stretch> out;
  for (std::size_t at = SEGCAL_NS::kLogMagicBytes; at < log.size();) {
    std::uint32_t n;
    std::memcpy(&n, log.data() + at + 8, 4);
    const std::size_t all = SEGCAL_NS::kBlockHead + n + SEGCAL_NS::kBlockTail;
    if (log[at + 4] == static_cast<std::uint8_t>(type)) out.push_back({at, all});
    at += all;
  }
  return out;
}

void test_each_log_replays_alone_and_behind_others() {
  for (const int slices : {1000000, 3, 1}) {
    const std::vector<Bytes> logs = slices > 1 ? quick_logs() : logs_of_devices(slices);
    for (int s = 0; s < kSessions; ++s)
      expect_bits(Id().add("slices", slices).add("log alone", s), {logs[static_cast<std::size_t>(s)]});
    expect_bits(Id().add("slices", slices).add("logs", "all"), logs);
    expect_bits(Id().add("slices", slices).add("logs", "last two"), {logs[2], logs[3]});
  }
}

/// What was late before a log began is not in it.
void test_no_call_is_late_for_an_earlier_one() {
  const std::vector<Bytes> logs = logs_of_devices(1);
  for (const Bytes& bytes : {logs[0], logs[1]}) {
    const host::DeviceLog log = host::parse_device_log("x.segcal", bytes, host::Damaged::refuse);
    TEST_ASSERT_TRUE(log.sessions[0].device->was_late);
    TEST_ASSERT_FALSE(log.sessions[0].device->calls[0].late);
  }
}

/// Without its state the second session has other bits: the test above can fail.
void test_without_its_state_a_log_has_other_bits() {
  host::DeviceLog log = host::parse_device_log("x.segcal", quick_logs()[1], host::Damaged::refuse);
  TEST_ASSERT_FALSE(log.sessions[0].device->state.empty());
  log.sessions[0].device->state.clear();
  host::ReplayOptions options;
  options.profile = "mobile";
  options.core.calibration = log.calibration;
  options.core.device_config = log.sessions[0].device->config;
  const host::HashCheck check = host::replay(log.sessions, options).hash_checks.at(0);
  TEST_ASSERT_TRUE(check.expected != check.found);
}

void test_a_missing_log_is_noticed() {
  expect_refusal({quick_logs()[0], quick_logs()[2]}, "begins with another state than the logs before it leave");
  expect_refusal({quick_logs()[1], quick_logs()[1]}, "begins with another state");
}

/// Power went while the state was written, at its last page (the commit) and before; or a page came out of order.
void test_a_state_that_is_not_whole_is_refused() {
  const Bytes& log = quick_logs()[1];
  const std::vector<Stretch> pages = blocks_of(log, SEGCAL_NS::LogBlock::state);
  for (const std::size_t left : {pages.size() - 1, std::size_t(3)}) {
    const auto end = log.begin() + static_cast<std::ptrdiff_t>(pages[left].at);
    expect_refusal({Bytes(log.begin(), end)}, "begins with a device's state: expected the state of a device");
    expect_refusal({Bytes(log.begin(), end + 100)}, "begins with a device's state: expected the state of a device");
  }
  // With right checksums: the second page names block 9; then it is the first one's again.
  const std::pair<std::size_t, std::uint8_t> forgeries[] = {{0, 9}, {5, 0}};
  for (const auto& [at, value] : forgeries) {
    Bytes forged = log;
    std::uint8_t* payload = forged.data() + pages[1].at + SEGCAL_NS::kBlockHead;
    payload[at] = value;
    const std::uint32_t crc = SEGCAL_NS::crc32(payload, kPage + SEGCAL_NS::kStateHead);
    std::memcpy(payload + kPage + SEGCAL_NS::kStateHead, &crc, 4);
    expect_refusal({forged}, "expected the device's state before all else and page by page, found block ");
  }
}

/// What can be saved of a damaged log is its data: a state with a hole is none.
void test_salvage_leaves_a_damaged_state_out() {
  Bytes log = quick_logs()[1];
  log[blocks_of(log, SEGCAL_NS::LogBlock::state)[2].at + 40] ^= 1;
  const host::DeviceLog saved = host::parse_device_log("x.segcal", log, host::Damaged::leave_out);
  TEST_ASSERT_TRUE(saved.sessions[0].device->state.empty());
  TEST_ASSERT_EQUAL_UINT(session(1).imu.size(), saved.sessions[0].imu.samples.size());
}

/// As a user replays it; by its data alone the bits are others.
void test_program_replays_a_log_with_a_state() {
  const TemporaryFolder folder("segcal_rotation");
  const std::string log = (folder.path() / "x.segcal").string();
  write_text(log, std::string(quick_logs()[1].begin(), quick_logs()[1].end()));
  const std::string replay =
      "replay " + log + " --json --out " + (folder.path() / "out").string() + " --verify-hash " + log;
  const Outcome as_it_was = run_program(replay, folder.path()),
                alone = run_program(replay + " --without-state", folder.path());
  TEST_ASSERT_EQUAL_INT_MESSAGE(0, as_it_was.code, as_it_was.err.c_str());
  TEST_ASSERT_TRUE(as_it_was.out.find("\"begins_with_state\": true") != std::string::npos);
  TEST_ASSERT_EQUAL_INT(1, alone.code);
  TEST_ASSERT_TRUE(alone.out.find("begins_with_state") == std::string::npos);
  // Without their calibrations, logs before it cannot leave that state.
  const std::string earlier = (folder.path() / "w.segcal").string();
  write_text(earlier, std::string(quick_logs()[0].begin(), quick_logs()[0].end()));
  const Outcome odometry = run_program(
      "replay " + earlier + " " + log + " --no-calibration --out " + (folder.path() / "o").string(), folder.path());
  TEST_ASSERT_EQUAL_INT(2, odometry.code);
  TEST_ASSERT_TRUE(odometry.err.find("expected --without-state beside --no-calibration") != std::string::npos);
  // Other commands take its data alone, in which nothing is missing.
  const Outcome diagnosed = run_program("diagnose " + log + " --out " + (folder.path() / "d").string(), folder.path());
  TEST_ASSERT_EQUAL_INT_MESSAGE(0, diagnosed.code, diagnosed.err.c_str());
  TEST_ASSERT_TRUE(diagnosed.err.find("state that it begins with is left out") != std::string::npos);
}

/// A session that left no log is missed although it changed no result; logs out of order would count twice.
void test_logs_are_in_order() {
  const AgedDevice aged(1000000);
  const Bytes& first = aged.first.bytes;
  segcal_new_session(aged.device);
  Writer second(rotating_config());
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, second.state(aged.device));
  second.feed(aged.device, 1, 1000000);
  second.end(aged.device, true);
  expect_refusal({first, second.bytes}, "begins with another state than the logs before it leave");
  expect_bits(Id(), {second.bytes});
  expect_refusal({second.bytes, first}, "begins without a state, behind a log that begins with one");
}

/// What a restored device does with work that is due is decided by who calls it, not by the restore: scores that were
/// in time, before the first late one, are so in the replay.
void test_work_is_late_behind_a_state_as_it_was() {
  const AgedDevice aged(3);
  segcal_t* const device = aged.device;
  Writer second(rotating_config());
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, second.state(device));
  for (int s = 1; s < kSessions; ++s) {
    second.feed(device, s, 3);
    segcal_log_hash(&second.log, segcal_result_hash(device));
    segcal_log_mark(&second.log, SEGCAL_LOG_NEW_SESSION);
    segcal_new_session(device);
    segcal_log_hash(&second.log, segcal_result_hash(device));
  }
  segcal_log_end(&second.log);
  const host::ReplayResult result = replayed({second.bytes});
  TEST_ASSERT_EQUAL_size_t(2 * (kSessions - 1), result.hash_checks.size());
  for (const host::HashCheck& check : result.hash_checks) TEST_ASSERT_TRUE(check.expected == check.found);
}

}  // namespace

int main(int argc, char** argv) {
  select_cases(argc - 1, argv + 1);
  UNITY_BEGIN();
  RUN_TEST(test_each_log_replays_alone_and_behind_others);
  RUN_TEST(test_no_call_is_late_for_an_earlier_one);
  RUN_TEST(test_without_its_state_a_log_has_other_bits);
  RUN_TEST(test_a_missing_log_is_noticed);
  RUN_TEST(test_a_state_that_is_not_whole_is_refused);
  RUN_TEST(test_salvage_leaves_a_damaged_state_out);
  RUN_TEST(test_program_replays_a_log_with_a_state);
  RUN_TEST(test_logs_are_in_order);
  RUN_TEST(test_work_is_late_behind_a_state_as_it_was);
  return UNITY_END();
}
