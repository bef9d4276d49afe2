// A device log: what goes in comes out, with all bits and in order; the writer keeps to its buffer.
#include "../support/cases.h"
#include "log/config_fields.h"
#include "log_fixture.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace test;

void test_crc_is_the_known_one() {
  const char* text = "123456789";  // the check value of CRC-32 (IEEE 802.3)
  TEST_ASSERT_EQUAL_HEX32(0xCBF43926u, SEGCAL_NS::crc32(reinterpret_cast<const std::uint8_t*>(text), 9));
}

void test_calls_come_back() {
  for (std::size_t block_bytes : {SEGCAL_LOG_BLOCK_BYTES, std::size_t(100000)}) {
    LoggedCalls log(block_bytes);
    log_session(&log, 1, 5);
    log.mark(SEGCAL_LOG_FLUSH);
    log.mark(SEGCAL_LOG_CALIBRATE);
    log.hash(0xFEDCBA9876543210ull);
    log.mark(SEGCAL_LOG_NEW_SESSION);
    log_session(&log, 2, 3);
    log.end();
    const host::DeviceLog read = parsed(log.bytes);
    check_true(Id().add("block", block_bytes), "the same calls", calls_of(read) == log.calls);
    TEST_ASSERT_EQUAL_INT(2, read.sessions.size());
    TEST_ASSERT_TRUE(read.notes.empty());
    TEST_ASSERT_FALSE(read.sessions[0].device->last);
    TEST_ASSERT_EQUAL_STRING("mobile", read.sessions[0].device->profile.c_str());
  }
}

void test_configuration_comes_back() {
  LoggedCalls log;
  log.end();
  const host::DeviceLog read = parsed(log.bytes);
  const std::vector<std::uint8_t>& bytes = read.sessions[0].device->config;
  segcal_config_t config;
  TEST_ASSERT_TRUE(SEGCAL_NS::read_config(bytes.data(), bytes.size(), &config));
  const segcal_config_t expected = log_config();
  TEST_ASSERT_EQUAL_MEMORY(&expected, &config, sizeof config);
  TEST_ASSERT_EQUAL_INT(2, read.calibration.cameras.size());
  TEST_ASSERT_TRUE(read.calibration.cameras[1].p_CI.x() == 0.1);
  TEST_ASSERT_TRUE(read.noise.gyro_noise_density == 3e-4);
  TEST_ASSERT_TRUE(read.noise.rate_hz == 200);  // zero in the configuration: the default
}

constexpr std::size_t kHeaderPayload = SEGCAL_NS::kLogMagicBytes + SEGCAL_NS::kBlockHead, kHeaderNumbers = 21;

/// Of a log in whose header number `i` begins with this byte.
std::string profile_with(std::vector<std::uint8_t> bytes, std::size_t i, std::uint8_t byte) {
  bytes[kHeaderPayload + 4 * i] = byte;
  SEGCAL_NS::ByteWriter crc(bytes.data() + kHeaderPayload + 4 * kHeaderNumbers, SEGCAL_NS::kBlockTail);
  crc.integer(SEGCAL_NS::crc32(bytes.data() + kHeaderPayload, 4 * kHeaderNumbers));
  return parsed(bytes).sessions[0].device->profile;
}

/// Whatever changes the bits of a result is in the header: a build
/// that differs in one of its numbers is none of the profiles.
void test_every_capacity_counts() {
  LoggedCalls log;
  log.end();
  for (std::size_t i = 2; i < kHeaderNumbers; ++i) {
    const std::uint8_t other = log.bytes[kHeaderPayload + 4 * i] ^ 1;
    check_true(Id().add("number", i), "no known profile", profile_with(log.bytes, i, other).empty());
  }
}

/// Builds of mobile that had 36 columns for effects wrote logs too.
void test_earlier_columns_for_effects_are_mobile() {
  LoggedCalls log;
  log.end();
  constexpr std::size_t columns = 15;
  TEST_ASSERT_EQUAL_INT(SEGCAL_MAX_EFFECT_COLUMNS, log.bytes[kHeaderPayload + 4 * columns]);
  TEST_ASSERT_EQUAL_STRING("mobile", profile_with(log.bytes, columns, 36).c_str());
  TEST_ASSERT_EQUAL_STRING("", profile_with(log.bytes, columns, 37).c_str());
}

std::vector<std::uint8_t> encoded(const segcal_config_t& config) {
  std::vector<std::uint8_t> out(2 * sizeof config);
  SEGCAL_NS::ByteWriter writer(out.data(), out.size());
  SEGCAL_NS::ConfigWriter fields(&writer);
  SEGCAL_NS::config_fields(&config, &fields);
  TEST_ASSERT_TRUE(writer.fits());
  out.resize(writer.size());
  return out;
}

/// A byte of the structure that leaves the log as it is belongs to no field in it: only the
/// padding behind lone 32-bit numbers may do that (n_cameras, each camera's model and height,
/// the three choices, joint_filter, term[]: 4 bytes each at most; calibration_window at its
/// end), and the one place of term[] and term_value[] that is there so that neither is empty.
void test_no_field_is_forgotten() {
  segcal_config_t config = log_config();
  const std::vector<std::uint8_t> before = encoded(config);
  std::size_t silent = 0;
  for (std::size_t i = 0; i < sizeof config; ++i) {
    reinterpret_cast<unsigned char*>(&config)[i] ^= 0x11;
    silent += encoded(config) == before ? 1 : 0;
    reinterpret_cast<unsigned char*>(&config)[i] ^= 0x11;
  }
  TEST_ASSERT_LESS_OR_EQUAL_UINT(4 * (5 + 2 * SEGCAL_MAX_CAMERAS) + sizeof(segcal_term_t) + sizeof(double), silent);
}

void test_older_configuration_has_defaults_behind_its_end() {
  const std::vector<std::uint8_t> bytes = encoded(log_config());
  segcal_config_t config;
  const std::size_t newest = 4 + 8 + 4 + 4;  // has_temperature, track_walk, calibration_window, condense
  TEST_ASSERT_TRUE(SEGCAL_NS::read_config(bytes.data(), bytes.size() - newest, &config));
  TEST_ASSERT_EQUAL_INT(0, config.has_temperature);
  TEST_ASSERT_EQUAL_DOUBLE(0, config.track_walk);
  TEST_ASSERT_EQUAL_INT(0, config.condense);
  TEST_ASSERT_TRUE(config.seed == log_config().seed);
  std::vector<std::uint8_t> newer = bytes;
  newer.push_back(1);
  TEST_ASSERT_FALSE(SEGCAL_NS::read_config(newer.data(), newer.size(), &config));
}

/// A disk that takes `left` bytes and then no more.
struct FullDisk {
  std::size_t left = 0, taken = 0;
  static int write(void* context, const void*, std::size_t n) {
    FullDisk* disk = static_cast<FullDisk*>(context);
    if (n > disk->left) return 1;
    disk->left -= n;
    disk->taken += n;
    return 0;
  }
};

void test_a_full_disk_is_reported_and_stays_so() {
  std::vector<std::uint8_t> block(SEGCAL_LOG_BLOCK_BYTES);
  const segcal_config_t config = log_config();
  FullDisk disk{5000, 0};
  segcal_log_t log;
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_begin(&log, &config, block.data(), block.size(), FullDisk::write, &disk));
  segcal_imu_t s{};
  int error = SEGCAL_OK;
  for (int i = 0; i < 1000 && error == SEGCAL_OK; ++i, s.t_ns += 5000000) error = segcal_log_imu(&log, &s);
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, error);
  const std::size_t taken = disk.taken;
  disk.left = 1000000;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_log_tracks(&log, 0, nullptr, 0));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_STATE, segcal_log_end(&log));
  TEST_ASSERT_EQUAL_UINT(taken, disk.taken);
}

void test_arguments_are_checked() {
  std::vector<std::uint8_t> block(SEGCAL_LOG_BLOCK_BYTES + 1, 0xA5);
  const segcal_config_t config = log_config();
  std::vector<std::uint8_t> out;
  segcal_log_t log{};
  const segcal_imu_t sample{};
  std::vector<segcal_point_t> points(SEGCAL_MAX_TRACKS * SEGCAL_MAX_CAMERAS + 1);
  const int most = SEGCAL_MAX_TRACKS * SEGCAL_MAX_CAMERAS;
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_log_imu(&log, &sample));  // not begun
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_log_end(&log));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE,
                        segcal_log_begin(&log, &config, block.data(), SEGCAL_LOG_BLOCK_BYTES - 1, append, &out));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_log_begin(&log, nullptr, block.data(), block.size(), append, &out));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_log_begin(&log, &config, nullptr, block.size(), append, &out));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_log_begin(&log, &config, block.data(), block.size(), nullptr, &out));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_begin(&log, &config, block.data(), SEGCAL_LOG_BLOCK_BYTES, append, &out));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_log_imu(&log, nullptr));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_NULL, segcal_log_tracks(&log, 0, nullptr, 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_log_tracks(&log, 0, points.data(), most + 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_log_mark(&log, 0));
  TEST_ASSERT_EQUAL_INT(SEGCAL_ERROR_SIZE, segcal_log_mark(&log, SEGCAL_LOG_LATE + 1));
  TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_tracks(&log, 0, points.data(), most));  // the largest frame fits
  for (int i = 0; i < 500; ++i) TEST_ASSERT_EQUAL_INT(SEGCAL_OK, segcal_log_imu(&log, &sample));
  TEST_ASSERT_EQUAL_HEX8(0xA5, block.back());
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  UNITY_BEGIN();
  RUN_TEST(test_crc_is_the_known_one);
  RUN_TEST(test_calls_come_back);
  RUN_TEST(test_configuration_comes_back);
  RUN_TEST(test_every_capacity_counts);
  RUN_TEST(test_earlier_columns_for_effects_are_mobile);
  RUN_TEST(test_no_field_is_forgotten);
  RUN_TEST(test_older_configuration_has_defaults_behind_its_end);
  RUN_TEST(test_a_full_disk_is_reported_and_stays_so);
  RUN_TEST(test_arguments_are_checked);
  return UNITY_END();
}
