// segcal replay --state FILE: two runs with it are one run over both sessions, to the bit; a file that does not fit is
// refused in a line and stays as it is.
#include <unity.h>

#include <nlohmann/json.hpp>
#include <set>

#include "program.h"
#include "temporary_folder.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

namespace fs = std::filesystem;
using test::Outcome;

/// Three sessions of one device; they have the same starting calibration.
const fs::path& folder() {
  static const test::TemporaryFolder scratch("segcal_state");
  static const bool made = [] {
    for (const char* seed : {"1", "2", "3"}) {
      const Outcome o = test::run_program(std::string("simulate --scenario rich --seconds 24 --device-seed 1 --seed ") +
                                              seed + " --out \"" + (scratch.path() / seed).string() + "\"",
                                          scratch.path());
      TEST_ASSERT_EQUAL_INT_MESSAGE(0, o.code, o.err.c_str());
    }
    return true;
  }();
  (void)made;
  return scratch.path();
}

/// `recordings`: a digit each.
Outcome replay(const std::string& recordings, const std::string& out, const std::string& more) {
  std::string quoted;
  for (const char r : recordings) quoted += " \"" + (folder() / std::string(1, r)).string() + "\"";
  return test::run_program("replay" + quoted + " --hash --out \"" + (folder() / out).string() + "\" " + more, folder());
}
std::string with_state(const fs::path& file) { return " --state \"" + (folder() / file).string() + "\" "; }
nlohmann::json result_in(const std::string& out) {
  return nlohmann::json::parse(test::text_of(folder() / out / "result.json"));
}

/// "result_hash ..." of what was printed.
std::string hash(const Outcome& o) {
  TEST_ASSERT_TRUE_MESSAGE(o.code == 0 || o.code == 1, o.err.c_str());
  const std::size_t at = o.out.find("result_hash ");
  TEST_ASSERT_TRUE(at != std::string::npos);
  return o.out.substr(at, o.out.find('\n', at) - at);
}

void check_two_runs_are_one(const std::string& choice, const std::string& name) {
  const std::string state = with_state(name + "/device.state");
  const std::string both = hash(replay("12", "both", choice)), alone = hash(replay("2", "alone", choice));
  hash(replay("1", "one", choice + state));
  TEST_ASSERT_EQUAL_STRING_MESSAGE(both.c_str(), hash(replay("2", "two", choice + state)).c_str(), name.c_str());
  TEST_ASSERT_TRUE(alone != both);  // the first session counts
  // All that the run knows, and what happened in it.
  const nlohmann::json one = result_in("both"), two = result_in("two"), first = result_in("one");
  TEST_ASSERT_TRUE(one["parameters"] == two["parameters"]);
  TEST_ASSERT_TRUE(one["epochs"] == two["epochs"]);
  TEST_ASSERT_TRUE(test::text_of(folder() / "both/kept_segments.json") ==
                   test::text_of(folder() / "two/kept_segments.json"));
  TEST_ASSERT_TRUE(two["earlier_logs"] == first["logs"]);
  TEST_ASSERT_EQUAL_UINT(one["faults"]["frames"],
                         unsigned(first["faults"]["frames"]) + unsigned(two["faults"]["frames"]));
  for (const auto& segment : two["segments"]) TEST_ASSERT_EQUAL_UINT(1, segment["session"]);
}

void test_two_runs_are_one() {
  check_two_runs_are_one("--profile mcu --strategy multi", "multi");
  check_two_runs_are_one("--profile mcu --strategy single", "single");
  check_two_runs_are_one("--profile mobile --condense", "condense");
}

/// Through three runs, and with the strategy that --state brings.
void test_three_runs_are_one() {
  const std::string state = with_state("three.state");
  hash(replay("1", "a", "--profile mcu" + state));
  hash(replay("2", "b", "--profile mcu" + state));
  TEST_ASSERT_EQUAL_STRING(hash(replay("123", "all", "--profile mcu --strategy multi")).c_str(),
                           hash(replay("3", "c", "--profile mcu" + state)).c_str());
  TEST_ASSERT_EQUAL_UINT(2, result_in("c")["earlier_logs"].size());
}

/// Exit code 2, one line that says what is wrong, the file as it was, no result.
void check_refused(const std::string& recordings, const fs::path& file, const std::string& more, const char* words) {
  const std::string before = test::text_of(file);
  const Outcome o = replay(recordings, "refused", more + " --state \"" + file.string() + "\"");
  TEST_ASSERT_EQUAL_INT_MESSAGE(2, o.code, words);
  TEST_ASSERT_TRUE_MESSAGE(o.err.find(words) != std::string::npos, o.err.c_str());
  TEST_ASSERT_EQUAL_INT_MESSAGE(1, std::count(o.err.begin(), o.err.end(), '\n'), o.err.c_str());
  TEST_ASSERT_TRUE(before == test::text_of(file));
  TEST_ASSERT_FALSE(fs::exists(folder() / "refused/result.json"));
}

void test_what_does_not_fit_is_refused() {
  const fs::path state = folder() / "fits.state";
  hash(replay("1", "fits", "--profile mcu --state \"" + state.string() + "\""));
  check_refused("2", state, "--profile mcu --strategy single", "another configuration (strategy differs)");
  check_refused("2", state, "--profile mcu --metric D", "(metric differs)");
  check_refused("2", state, "--profile mcu --pixel-sigma 0.7", "(pixel_sigma differs)");
  check_refused("2", state, "--profile mobile", "saved with --profile mcu");
  check_refused("2", state, "--profile mcu --calib \"" + (folder() / "1/truth/camchain-imucam.yaml").string() + "\"",
                "starting calibration differs");
  check_refused("1", state, "--profile mcu", "has the samples of 1, which");
  check_refused("22", state, "--profile mcu", "has the samples of ");
  // The same samples under another name, tracked otherwise.
  fs::copy(folder() / "1", folder() / "4", fs::copy_options::recursive);
  const std::string tracks = test::text_of(folder() / "4/mav0/cam0/tracks.csv");
  test::write_text(folder() / "4/mav0/cam0/tracks.csv", tracks.substr(0, tracks.rfind('\n', tracks.size() / 2) + 1));
  fs::remove(folder() / "4/manifest.json");
  check_refused("4", state, "--profile mcu", "has the samples of 1, which");
  const Outcome o = replay("2", "refused", "--joint-ekf" + with_state("fits.state"));
  TEST_ASSERT_EQUAL_INT(2, o.code);
}

void test_no_state_file_is_refused() {
  const fs::path state = folder() / "some.state", other = folder() / "other.state";
  hash(replay("1", "some", "--profile mcu --state \"" + state.string() + "\""));
  const std::string good = test::text_of(state);
  const auto check = [&other](const std::string& text, const char* words) {
    test::write_text(other, text);
    check_refused("2", other, "--profile mcu", words);
  };
  check("not a state file", "expected a state file");
  check(std::string(8192, 'x'), "expected a state file");
  check(good.substr(0, good.size() - 1), "damaged");
  check(good.substr(0, 40), "damaged");
  check(good + "\n", "damaged");
  for (const std::size_t at : {std::size_t(20), std::size_t(100), good.size() / 3, good.size() - 1}) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 1);
    check(bad, "damaged");
  }
  std::string newer = good;
  newer[13] = '2';
  check(newer, "of a newer segcal");
  const Outcome o = replay("2", "refused", "--profile mcu --state \"" + folder().string() + "\"");
  TEST_ASSERT_EQUAL_INT(2, o.code);
  TEST_ASSERT_TRUE_MESSAGE(o.err.find("no regular file") != std::string::npos, o.err.c_str());
}

/// A run that ends badly leaves no file behind, or the one that was there.
void test_a_failed_run_leaves_the_file() {
  const fs::path state = folder() / "new.state";
  check_refused("11", state, "--profile mcu", "has the samples of ");
  TEST_ASSERT_FALSE(fs::exists(state));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_two_runs_are_one);
  RUN_TEST(test_three_runs_are_one);
  RUN_TEST(test_what_does_not_fit_is_refused);
  RUN_TEST(test_no_state_file_is_refused);
  RUN_TEST(test_a_failed_run_leaves_the_file);
  return UNITY_END();
}
