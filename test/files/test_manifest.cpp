// Files of a folder belong together: a run that is killed at any change of the file system leaves a folder that is
// whole, the old one or the new one, or one that readers refuse.
#include <unity.h>

#include <algorithm>
#include <map>

#include "../replay/program.h"
#include "../replay/temporary_folder.h"
#include "calibration_file.h"
#include "commands.h"
#include "diagnose/diagnose.h"
#include "experiments/experiment.h"
#include "files/output_run.h"
#include "killed_at.h"
#include "recording.h"
#include "replay/replay.h"
#include "replay/result_files.h"
#include "simulate/simulate.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

namespace fs = std::filesystem;
using namespace host;

fs::path scratch;

/// All files but the manifest, by name.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> out;
  if (!fs::exists(folder)) return out;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().filename() == manifest_name) continue;
    out[entry.path().lexically_relative(folder).string()] = test::text_of(entry.path());
  }
  return out;
}

bool is_part(const std::string& name) { return name.size() > 5 && name.substr(name.size() - 5) == ".part"; }

std::map<std::string, std::string> without_parts(std::map<std::string, std::string> files) {
  for (auto it = files.begin(); it != files.end();) it = is_part(it->first) ? files.erase(it) : std::next(it);
  return files;
}

std::string complaint_about(const fs::path& folder) {
  try {
    check_folder(folder);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// To its end, in a process whose output goes nowhere.
void complete(const std::function<void()>& run) { TEST_ASSERT_FALSE(test::killed_at(0, run)); }

/// Writes a folder by run `first`, then again by `second` killed at each change: what is accepted is one of the two,
/// whole. Returns the number of changes. Afterwards a run that ends puts all right and leaves no temporary file.
int check_every_kill(const char* what, const fs::path& folder, const std::function<void()>& prepare,
                     const std::function<void()>& first, const std::function<void()>& second) {
  const auto made_by = [&](const std::function<void()>& run) {
    fs::remove_all(folder);
    prepare();
    complete(run);
    return contents(folder);
  };
  const auto whole_second = made_by(second), whole_first = made_by(first);
  fs::remove_all(folder);
  prepare();
  const auto nothing = contents(folder);
  TEST_ASSERT_TRUE_MESSAGE(whole_first != whole_second, "the two runs must differ");
  int n = 1, refused = 0;
  for (const bool over_first : {false, true}) {
    for (n = 1;; ++n) {
      fs::remove_all(folder);
      prepare();
      if (over_first) complete(first);
      const bool killed = test::killed_at(n, second);
      const auto left = without_parts(contents(folder));
      const std::string complaint = complaint_about(folder);
      char message[300];
      std::snprintf(message, sizeof message, "%s killed at change %d (%s): %s", what, n,
                    over_first ? "over an earlier run" : "in a new folder", complaint.c_str());
      refused += complaint.empty() ? 0 : 1;
      if (complaint.empty())
        TEST_ASSERT_TRUE_MESSAGE(left == (over_first ? whole_first : nothing) || left == whole_second, message);
      if (!killed) {
        TEST_ASSERT_TRUE_MESSAGE(left == whole_second, message);
        break;
      }
      complete(second);
      TEST_ASSERT_EQUAL_STRING_MESSAGE("", complaint_about(folder).c_str(), message);
      TEST_ASSERT_TRUE_MESSAGE(contents(folder) == whole_second, message);  // no .part either
    }
  }
  std::printf("%s: killed at each of %d changes, %d folders refused\n", what, n - 1, refused);
  TEST_ASSERT_GREATER_THAN_MESSAGE(n / 2, refused, "most kills fall between the first file and the last");
  return n;
}

struct Session {
  Recording recording;
  ReplayResult result;
};

Session session_of(int seed) {
  SimulationOptions options;
  options.seconds = 6;
  options.seed = static_cast<std::uint64_t>(seed);
  SimulationResult simulated = simulate(options);
  ReplayOptions replaying;
  replaying.core.calibration = simulated.nominal;
  replaying.core.segment_s = 2;
  Session out;
  out.result = replay({simulated.recording}, replaying);
  out.recording = simulated.recording;
  return out;
}

const Session& session(int seed) {
  static const Session sessions[] = {session_of(1), session_of(2)};
  return sessions[seed - 1];
}

const auto nothing_before = [] {};

void test_replay_killed_anywhere() {
  const fs::path folder = scratch / "replay";
  const auto write = [&](int seed) {
    return [&folder, seed] { write_result_files(folder, session(seed).result, {}, session(seed).recording.truth); };
  };
  check_every_kill("replay", folder, nothing_before, write(1), write(2));
}

/// The second run writes fewer files than the first: those that are left over go.
void test_diagnose_killed_anywhere() {
  const fs::path folder = scratch / "diagnose";
  const auto write = [&](int seed) {
    return [&folder, seed] {
      Diagnosis d;
      d.verdict = "consistent";
      d.fit_before = session(seed).result;
      if (seed == 2) d.fit_before.calibration.cameras.clear();  // then camchain and imu.yaml are not written
      write_diagnosis(folder, d, {session(seed).recording});
    };
  };
  check_every_kill("diagnose", folder, nothing_before, write(1), write(2));
  TEST_ASSERT_FALSE(fs::exists(folder / "imu.yaml"));
}

void run_command(const std::vector<std::string>& arguments) {
  CLI::App app("test", "segcal");
  int code = 0;
  add_track_command(app, code);
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
  app.parse(reversed);
}

/// The tracks of the two cameras belong together: their identifiers are those of the rig.
void test_track_killed_anywhere() {
  const fs::path images = scratch / "images", folder = scratch / "track";
  const test::Outcome made =
      test::run_program("simulate --out \"" + images.string() +
                            "\" --images --scenario nav --seconds 1 --rate-camera 4 --seed 1 --cameras 2",
                        scratch);
  TEST_ASSERT_EQUAL_INT_MESSAGE(0, made.code, made.err.c_str());
  const auto prepare = [&] { fs::copy(images, folder, fs::copy_options::recursive); };
  const auto track = [&](const char* most) {
    return [&folder, most] { run_command({"track", folder.string(), "--max-tracks", most}); };
  };
  check_every_kill("track", folder, prepare, track("20"), track("30"));
  const Manifest manifest = read_manifest(folder);
  TEST_ASSERT_EQUAL_size_t(2, manifest.runs.size());  // simulate's files are still known, beside the tracks
  TEST_ASSERT_EQUAL_STRING("simulate", manifest.runs[0].command.c_str());
  TEST_ASSERT_EQUAL_STRING("track", manifest.runs[1].command.c_str());
}

void test_experiments_killed_anywhere() {
  const fs::path folder = scratch / "experiments";
  setenv("SEGCAL_PYTHON", "/bin/true", 1);  // no page
  const auto write = [&](double value) {
    return [&folder, value] {
      experiments::Experiment experiment{};
      experiment.name = "basin";
      experiment.description = "";
      experiments::Findings findings;
      findings.tables.push_back({"t", "", {{"x", "m"}}, {{value}}});
      findings.values["x"] = value;
      experiments::write_findings(experiment, findings, {}, folder);
    };
  };
  check_every_kill("experiments", folder, nothing_before, write(1), write(2));
  unsetenv("SEGCAL_PYTHON");
}

test::Outcome program(const std::string& arguments) { return test::run_program(arguments, scratch); }

void check_refused(const std::string& arguments, const std::string& words) {
  const test::Outcome outcome = program(arguments);
  TEST_ASSERT_EQUAL_INT_MESSAGE(2, outcome.code, arguments.c_str());
  TEST_ASSERT_TRUE_MESSAGE(outcome.err.find(words) != std::string::npos, (arguments + ": " + outcome.err).c_str());
  TEST_ASSERT_EQUAL_INT_MESSAGE(1, std::count(outcome.err.begin(), outcome.err.end(), '\n'), outcome.err.c_str());
}

/// As a user has it: a folder with a file of another run. All that reads result folders says so.
void test_programs_refuse_mixed_folders() {
  const fs::path a = scratch / "a", b = scratch / "b";
  write_result_files(a, session(1).result, {}, {});
  write_result_files(b, session(2).result, {}, {});
  const std::string mixed = a.string();
  TEST_ASSERT_EQUAL_INT(0, program("report " + mixed).code);
  fs::copy_file(b / "report_data.json", a / "report_data.json", fs::copy_options::overwrite_existing);
  const std::string words = "report_data.json: expected the file that `segcal replay` wrote";
  check_refused("report " + mixed, words);
  check_refused("export " + mixed + " --to kalibr --out " + (scratch / "k").string(), words);
  check_refused("compare " + mixed + " " + b.string(), words);
  check_refused("compare " + b.string() + " " + mixed, words);
  check_refused("reference --segments-from " + mixed + " --out " + (scratch / "r").string(), words);
  check_refused("diagnose " + mixed + " --out " + mixed, "found the files of `segcal replay`");
  fs::remove(a / manifest_name);  // the message says so: who changed a file himself takes the manifest away
  TEST_ASSERT_EQUAL_INT(0, program("report " + mixed).code);
}

/// A calibration is read by its file's name: of a stopped run, or of two runs, it is refused wherever it is named. A
/// copy without the manifest is the user's own.
void test_calibration_by_its_file() {
  const fs::path rec = scratch / "started", a = scratch / "half", b = scratch / "whole", copy = scratch / "copy";
  TEST_ASSERT_EQUAL_INT(
      0,
      program("simulate --out " + rec.string() + " --images --scenario nav --seconds 1 --rate-camera 4 --seed 1").code);
  TEST_ASSERT_EQUAL_INT(0, program("track " + rec.string()).code);
  const auto read_by = [&](const fs::path& folder) {
    const std::string out = " --out " + (scratch / "out3").string(),
                      calib = " --calib " + (folder / "camchain-imucam.yaml").string();
    return std::vector<std::string>{"replay " + rec.string() + calib + out,
                                    "diagnose " + rec.string() + calib + out,
                                    "track " + rec.string() + calib,
                                    "convert " + rec.string() + calib + out + ".segcal",
                                    "reference " + rec.string() + calib + out,
                                    "fleet " + rec.string() + out + " -- " + calib.substr(1),
                                    "import " + rec.string() + out + calib,
                                    "import " + rec.string() + out + " --imu-noise " + (folder / "imu.yaml").string(),
                                    "replay " + rec.string() + out + " --config " + (folder / "config.yaml").string(),
                                    "replay " + rec.string() + out + " --model " + (folder / "model.yaml").string()};
  };
  write_result_files(b, session(2).result, {}, {});
  const auto write_over = [&] { write_result_files(a, session(2).result, {}, {}); };
  const std::string of_second = test::text_of(b / "camchain-imucam.yaml");
  int n = 0;
  do {  // until the camera chain is the second run's and the IMU the first's
    fs::remove_all(a);
    write_result_files(a, session(1).result, {}, {});
    TEST_ASSERT_TRUE(test::killed_at(++n, write_over));
  } while (test::text_of(a / "camchain-imucam.yaml") != of_second);
  TEST_ASSERT_TRUE(test::text_of(a / "imu.yaml") != test::text_of(b / "imu.yaml"));
  for (const std::string& command : read_by(a)) check_refused(command, "was stopped while it wrote");
  fs::copy(a, copy);
  fs::remove(copy / manifest_name);
  TEST_ASSERT_EQUAL_size_t(1, read_calibration(copy / "camchain-imucam.yaml").cameras.size());
  complete(write_over);
  TEST_ASSERT_EQUAL_size_t(1, read_calibration(a / "camchain-imucam.yaml").cameras.size());
  for (const char* name : {"camchain-imucam.yaml", "imu.yaml", "config.yaml", "model.yaml"})
    test::write_text(a / name, test::text_of(a / name) + "# another\n");
  for (const std::string& command : read_by(a))
    check_refused(command, ".yaml: expected the file that `segcal replay` wrote");
}

void test_recordings() {
  const fs::path rec = scratch / "rec", other = scratch / "other";
  TEST_ASSERT_EQUAL_INT(0, program("simulate --out " + rec.string() + " --seconds 4 --seed 1").code);
  TEST_ASSERT_EQUAL_INT(0, program("simulate --out " + other.string() + " --seconds 4 --seed 2").code);
  const std::string replay = "replay " + rec.string() + " --out " + (scratch / "out").string();
  TEST_ASSERT_TRUE(program(replay).code <= 1);  // an answer, whichever
  const std::string tracks = test::text_of(rec / "mav0/cam0/tracks.csv");
  test::write_text(rec / "mav0/cam0/tracks.csv",
                   tracks.substr(0, tracks.rfind('\n', tracks.size() - 2) + 1));  // a corner less
  for (const char* command : {"replay ", "diagnose ", "reference ", "convert "})
    check_refused(command + rec.string() + " --out " + (scratch / "out2").string(),
                  "tracks.csv: expected the file that `segcal simulate` wrote");
  check_refused("replay " + other.string() + " --out " + other.string(), "found the files of `segcal simulate`");
  fs::remove(rec / manifest_name);
  TEST_ASSERT_TRUE(program(replay).code <= 1);  // without a manifest: as made by hand
  check_refused("replay " + other.string() + " --out " + rec.string(), "found a recording");
  test::write_text(rec / manifest_name, "{\"name\": \"of another program\"}");
  const test::Outcome outcome = program(replay);
  TEST_ASSERT_TRUE_MESSAGE(outcome.code <= 1, outcome.err.c_str());
}

/// Names in a manifest stay inside its folder, and damage is told.
void test_strange_manifests() {
  const fs::path folder = scratch / "strange";
  write_result_files(folder, session(1).result, {}, {});
  const std::string good = test::text_of(folder / manifest_name);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    test::write_text(folder / manifest_name, text.replace(text.find(from), from.size(), to));
    return complaint_about(folder);
  };
  TEST_ASSERT_NOT_NULL(std::strstr(with("\"imu.yaml\"", "\"../imu.yaml\"").c_str(), "inside the folder"));
  TEST_ASSERT_NOT_NULL(std::strstr(with("\"imu.yaml\"", "\"/dev/zero\"").c_str(), "inside the folder"));
  TEST_ASSERT_NOT_NULL(std::strstr(with("\"format\": 1", "\"format\": 2").c_str(), "expected format 1"));
  TEST_ASSERT_NOT_NULL(std::strstr(with("\"bytes\": ", "\"bytes\": 1").c_str(), "expected the file that"));
  TEST_ASSERT_NOT_NULL(std::strstr(with("\"runs\": [", "\"runs\": [{").c_str(), "manifest.json: expected"));
  test::write_text(folder / manifest_name, good);
  fs::remove(folder / "trajectory.tum");  // what is taken away mixes nothing
  TEST_ASSERT_EQUAL_STRING("", complaint_about(folder).c_str());
}

}  // namespace

int main() {
  const test::TemporaryFolder folder("segcal_test_manifest");
  scratch = folder.path();
  session(1);  // once, for all child processes: times are part of a result
  session(2);
  UNITY_BEGIN();
  RUN_TEST(test_replay_killed_anywhere);
  RUN_TEST(test_diagnose_killed_anywhere);
  RUN_TEST(test_track_killed_anywhere);
  RUN_TEST(test_experiments_killed_anywhere);
  RUN_TEST(test_programs_refuse_mixed_folders);
  RUN_TEST(test_calibration_by_its_file);
  RUN_TEST(test_recordings);
  RUN_TEST(test_strange_manifests);
  return UNITY_END();
}
