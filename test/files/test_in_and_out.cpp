// What cannot be written or read is told at once: one line on stderr and exit code 2, never a wait and never silence.
#include <sys/stat.h>
#include <unity.h>

#include <algorithm>
#include <chrono>

#include "../replay/program.h"
#include "../replay/temporary_folder.h"
#include "csv.h"
#include "recording.h"
#include "simulate/simulate.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

namespace fs = std::filesystem;

fs::path scratch;

struct Outcome {
  int code;
  std::string err;
};

/// A whole shell command; `segcal` in it is the program. `timeout` is far above what any of these takes.
Outcome shell(std::string command) {
  for (std::size_t at = 0; (at = command.find("segcal ", at)) != std::string::npos; at += std::strlen(SEGCAL_PROGRAM))
    command.replace(at, 6, SEGCAL_PROGRAM);
  const fs::path err = scratch / "err.txt";
  const std::string all = "cd '" + scratch.string() + "' && { " + command + " ; } 2> '" + err.string() + "'";
  const int status = std::system(("timeout 60 bash -o pipefail -c \"" + all + "\"").c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, test::text_of(err)};
}

/// The last line on stderr, behind progress.
std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of("\n");
  if (end == std::string::npos) return "";
  const std::size_t begin = text.find_last_of("\n\r", end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1,
                     end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

void check_refused(const std::string& command, const std::string& words) {
  const Outcome outcome = shell(command);
  TEST_ASSERT_EQUAL_INT_MESSAGE(2, outcome.code, (command + "\n" + outcome.err).c_str());
  TEST_ASSERT_TRUE_MESSAGE(last_line(outcome.err).find(words) != std::string::npos,
                           (command + "\n" + outcome.err).c_str());
  TEST_ASSERT_TRUE_MESSAGE(outcome.err.find("Traceback") == std::string::npos, outcome.err.c_str());
}

/// Ids modulo 97, and the truth says that it was done.
void test_a_fault_of_the_study_can_be_simulated() {
  TEST_ASSERT_EQUAL_INT(0, shell("segcal simulate --out spoilt --seconds 8 --fault ids_repeated").code);
  std::uint32_t most = 0;
  const host::Recording spoilt = host::read_recording(scratch / "spoilt", 1);
  for (const host::Frame& frame : spoilt.cameras[0].frames)
    for (const host::TrackPoint& p : frame.points) most = std::max(most, p.track_id);
  TEST_ASSERT_EQUAL_UINT32(96, most);
  TEST_ASSERT_TRUE(test::text_of(scratch / "spoilt/truth/truth.json").find("ids_repeated") != std::string::npos);
}

void test_a_full_disk_or_closed_pipe_is_an_error() {
  for (const char* command :
       {"segcal --help", "segcal --version", "segcal replay rec --out out --json", "segcal replay rec --out out",
        "segcal compare out out", "segcal compare out out --json", "segcal experiments --list",
        "segcal export out --to kalibr --out kalibr", "segcal import rec --list", "segcal fleet --help"}) {
    check_refused(std::string(command) + " > /dev/full", "cannot be written");
  }
  check_refused("segcal replay rec --out out --json | true", "standard output: cannot be written");
  check_refused("segcal import rec --list | true", "standard output: cannot be written: Broken pipe");
}

void test_an_empty_text_names_nothing() {
  const auto before = std::distance(fs::directory_iterator(scratch), fs::directory_iterator());
  for (const char* command :
       {"segcal replay rec --out ''", "segcal replay '' --out out", "segcal diagnose rec --out ''",
        "segcal simulate --out ''", "segcal track rec --out ''", "segcal experiments basin --out ''",
        "segcal convert rec --out ''", "segcal report ''", "segcal allan rec --out ''", "segcal fleet rec --out ''",
        "segcal export out --to kalibr --out ''", "segcal import rec --out ''"}) {
    check_refused(command, "empty");
  }
  TEST_ASSERT_EQUAL_INT(before, std::distance(fs::directory_iterator(scratch), fs::directory_iterator()));
}

/// Without temperatures their effects mean nothing; nor do those of a camera to the joint filter.
void test_effects_that_cannot_be_used_are_refused() {
  test::write_text(scratch / "warm.yaml",
                   "format: 1\neffects:\n- name: camera_temperature\n  parameters:\n  - {name: f, value: 1e-4}\n");
  check_refused("segcal diagnose rec --out d --model warm.yaml", "found an IMU log without them");
  check_refused("segcal replay rec --out out --joint-ekf --model warm.yaml",
                "expected effects without camera_temperature");
}

/// A pipe that nobody writes into, and a file that never ends.
void test_only_regular_files_are_read() {
  ::mkfifo((scratch / "pipe").c_str(), 0600);
  const char* const words = "expected a regular file, found a pipe or a device";
  for (const std::string file : {"pipe", "/dev/zero"}) {
    check_refused("segcal replay rec --out out --calib " + file, words);
    check_refused("segcal replay rec --out out --model " + file, words);
    check_refused("segcal replay rec --out out --verify-hash " + file, words);
    check_refused("segcal replay " + file + " --out out", "expected a recording");
    check_refused("segcal convert " + file + " --out rec2", "expected a recording");
    check_refused("segcal diagnose rec --out d --calib " + file, words);
    check_refused("segcal simulate --out s --trajectory " + file, words);
    check_refused("segcal simulate --out s --track-noise " + file, words);
    check_refused("segcal compare out out --truth " + file, words);
    check_refused("segcal import " + file + " --out rec2", "expected a regular file");
    check_refused("segcal fleet @" + file + " --out tables", "expected a regular file");
    for (const char* part : {"mav0/imu0/data.csv", "mav0/cam0/tracks.csv", "camchain-imucam.yaml"}) {
      fs::remove_all(scratch / "bad");
      fs::copy(scratch / "rec", scratch / "bad", fs::copy_options::recursive);
      fs::remove(scratch / "bad" / part);
      fs::create_symlink(fs::absolute(scratch / file), scratch / "bad" / part);
      check_refused("segcal replay bad --out out", words);
    }
  }
  check_refused("segcal replay rec --out out --calib rec", "expected a file, found a folder");
  check_refused("segcal replay rec --out rec/camchain-imucam.yaml", "expected a folder");
}

std::vector<host::ImuSample> read_imu_text(const std::string& text) {
  const fs::path rec = scratch / "cut";
  fs::remove_all(rec);
  fs::copy(scratch / "rec", rec, fs::copy_options::recursive);
  test::write_text(rec / "mav0/imu0/data.csv", text);
  return host::read_recording(rec, 1).imu.samples;
}

/// Wherever a file is cut, no number comes in that was not there: all rows are the whole file's.
void test_a_cut_file_brings_no_wrong_number() {
  const std::string whole = test::text_of(scratch / "rec/mav0/imu0/data.csv");
  const std::vector<host::ImuSample> all = read_imu_text(whole);
  for (std::size_t back = 1; back < 200; ++back) {
    const std::vector<host::ImuSample> left = read_imu_text(whole.substr(0, whole.size() - back));
    TEST_ASSERT_TRUE(left.size() < all.size() && left.size() + 4 > all.size());
    for (std::size_t i = 0; i < left.size(); ++i)
      TEST_ASSERT_TRUE(left[i].t_ns == all[i].t_ns && left[i].gyro == all[i].gyro && left[i].accel == all[i].accel);
  }
  test::write_text(scratch / "cut/mav0/imu0/data.csv", whole.substr(0, whole.size() - 3));
  const Outcome outcome = shell("segcal replay cut --out out_of_cut");
  TEST_ASSERT_TRUE_MESSAGE(outcome.code <= 1, outcome.err.c_str());
  TEST_ASSERT_TRUE_MESSAGE(outcome.err.find("the last line does not end") != std::string::npos, outcome.err.c_str());
  TEST_ASSERT_EQUAL_INT(std::string::npos, shell("segcal replay rec --out out_of_rec").err.find("does not end"));
}

}  // namespace

int main() {
  const test::TemporaryFolder folder("segcal_test_in_and_out");
  scratch = folder.path();
  host::SimulationOptions options;
  options.seconds = 4;
  host::write_simulation(host::simulate(options), scratch / "rec");
  shell("segcal replay rec --out out > /dev/null");
  UNITY_BEGIN();
  RUN_TEST(test_a_fault_of_the_study_can_be_simulated);
  RUN_TEST(test_a_full_disk_or_closed_pipe_is_an_error);
  RUN_TEST(test_an_empty_text_names_nothing);
  RUN_TEST(test_effects_that_cannot_be_used_are_refused);
  RUN_TEST(test_only_regular_files_are_read);
  RUN_TEST(test_a_cut_file_brings_no_wrong_number);
  return UNITY_END();
}
