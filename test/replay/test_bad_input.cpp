// Input that cannot be used: exit code 2, one line on stderr that names file and line, nothing written.
#include <unity.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "../support/cases.h"
#include "program.h"
#include "simulate/simulate.h"
#include "temporary_folder.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

namespace fs = std::filesystem;
using test::Id;
using test::text_of;
using test::write_text;

fs::path scratch;

/// One way to spoil a recording, and what the complaint must say.
struct Case {
  const char* name;
  std::function<void(const fs::path& rec)> spoil;
  std::string complaint;  ///< part of the line on stderr
  std::string command = "replay REC --out OUT";
};

const char* const kImu = "mav0/imu0/data.csv";
const char* const kTracks = "mav0/cam0/tracks.csv";
const char* const kExposures = "mav0/cam0/exposure.csv";
const char* const kCalibration = "camchain-imucam.yaml";

/// Replaces line `number` (from 1) of a file.
void put_line(const fs::path& file, int number, const std::string& line) {
  std::istringstream in(text_of(file));
  std::string out, next;
  for (int i = 1; std::getline(in, next); ++i) out += (i == number ? line : next) + "\n";
  write_text(file, out);
}

void put_words(const fs::path& file, const std::string& old_words, const std::string& new_words) {
  std::string text = text_of(file);
  const std::size_t at = text.find(old_words);
  if (at == std::string::npos) TEST_FAIL_MESSAGE((file.string() + " does not hold " + old_words).c_str());
  write_text(file, text.replace(at, old_words.size(), new_words));
}

void put_images(const fs::path& rec) {
  fs::remove(rec / kTracks);
  write_text(
      rec / "mav0/cam0/data.csv",
      "#timestamp [ns],filename\n" + text_of(rec / kImu).substr(text_of(rec / kImu).find('\n') + 1, 19) + ",a.png\n");
}

std::vector<Case> file_cases() {
  return {
      {"no_recording", [](const fs::path& rec) { fs::remove_all(rec); }, "rec: expected a recording"},
      {"no_imu", [](const fs::path& rec) { fs::remove(rec / kImu); }, kImu},
      {"empty_imu", [](const fs::path& rec) { write_text(rec / kImu, ""); }, kImu},
      {"header_only_imu", [](const fs::path& rec) { write_text(rec / kImu, "#timestamp [ns]\n"); }, kImu},
      {"imu_columns", [](const fs::path& rec) { put_line(rec / kImu, 7, "1,2,3"); }, "mav0/imu0/data.csv:7: expected"},
      {"imu_number", [](const fs::path& rec) { put_line(rec / kImu, 9, "1,0,0,zero,0,0,9.8"); },
       "mav0/imu0/data.csv:9: expected"},
      {"imu_stamp", [](const fs::path& rec) { put_line(rec / kImu, 9, "1.5,0,0,0,0,0,9.8"); },
       "mav0/imu0/data.csv:9: expected"},
      {"no_camera", [](const fs::path& rec) { fs::remove_all(rec / "mav0/cam0"); }, "mav0/cam0"},
      {"no_tracks", [](const fs::path& rec) { fs::remove(rec / kTracks); }, "mav0/cam0"},
      {"empty_tracks", [](const fs::path& rec) { write_text(rec / kTracks, ""); }, kTracks},
      {"track_columns", [](const fs::path& rec) { put_line(rec / kTracks, 5, "1,2,3"); },
       "mav0/cam0/tracks.csv:5: expected"},
      {"track_number", [](const fs::path& rec) { put_line(rec / kTracks, 5, "1,2,3,x"); },
       "mav0/cam0/tracks.csv:5: expected"},
      {"track_id", [](const fs::path& rec) { put_line(rec / kTracks, 5, "1,-2,3,4"); },
       "mav0/cam0/tracks.csv:5: expected"},
      {"exposure_number",
       [](const fs::path& rec) { write_text(rec / kExposures, "#timestamp [ns],exposure [ns]\n1,2\n3,x\n"); },
       "mav0/cam0/exposure.csv:3: expected"},
      {"exposure_columns", [](const fs::path& rec) { write_text(rec / kExposures, "1,2,3\n"); },
       "mav0/cam0/exposure.csv:1: expected"},
      {"exposure_size", [](const fs::path& rec) { write_text(rec / kExposures, "1,-2\n"); },
       "mav0/cam0/exposure.csv:1: expected an exposure of 0 (not known) to 1e9 ns, found -2"},
      {"no_overlap",
       [](const fs::path& rec) { write_text(rec / kTracks, "#timestamp [ns],track_id [],u [px],v [px]\n1,2,3,4\n"); },
       "expected stamps that overlap"},
      {"image_missing", put_images, "mav0/cam0/data.csv:2: expected an image"},
      {"image_missing_track", put_images, "mav0/cam0/data.csv:2: expected an image", "track REC --out OUT"},
      {"no_calibration", [](const fs::path& rec) { fs::remove(rec / kCalibration); }, kCalibration},
      {"distortion",
       [](const fs::path& rec) {
         put_words(rec / kCalibration, "distortion_model: fov", "distortion_model: fisheye8");
       },
       "camchain-imucam.yaml:"},
      {"focal_length", [](const fs::path& rec) { put_words(rec / kCalibration, "intrinsics: [", "intrinsics: [-"); },
       "camchain-imucam.yaml:"},
      {"coefficients",
       [](const fs::path& rec) {
         put_words(rec / kCalibration, "distortion_coeffs: [", "distortion_coeffs: [0.1, 0.1, ");
       },
       "camchain-imucam.yaml:"},
      {"readout",
       [](const fs::path& rec) {
         put_words(rec / kCalibration, "camera_model: pinhole", "camera_model: pinhole\n  readout: left");
       },
       "expected readout: rows or columns"},
      {"millimetres",
       [](const fs::path& rec) {
         put_words(rec / kCalibration, "  T_cam_imu:\n",
                   "  T_cam_imu: [[1, 0, 0, 57], [0, 1, 0, -15], [0, 0, 1, -34], [0, 0, 0, 1]]\n  before:\n");
       },
       "camchain-imucam.yaml: cam0: expected T_cam_imu with its translation in m, found a camera 68 m from the IMU"},
      {"yaml", [](const fs::path& rec) { write_text(rec / kCalibration, "cam0:\n  T_cam_imu: [1, 2\n"); },
       "camchain-imucam.yaml:"},
  };
}

std::vector<Case> config_cases() {
  const std::pair<const char*, std::pair<const char*, const char*>> bad[] = {
      {"unknown",
       {"format: 1\nnoises: {}\n",
        "config.yaml:2: expected one of format, prior_sigma, gravity, noise, found 'noises'"}},
      {"unknown_prior", {"prior_sigma:\n  p_CI: 0.1\n", "config.yaml:2: expected one of r_CI_rad, p_CI_m"}},
      {"negative", {"prior_sigma:\n  p_CI_m: -0.1\n", "config.yaml:2: expected a number from"}},
      {"zero_noise", {"noise: {gyroscope_noise_density: 0}\n", "config.yaml:1: expected a number from"}},
      {"word", {"noise: {pixel_sigma_px: half}\n", "config.yaml:1: expected a finite number for 'pixel_sigma_px'"}},
      {"gravity_unit", {"gravity: {m_s2: 980.665}\n", "config.yaml:1: expected a number from 1 to 30 for 'm_s2'"}},
      {"latitude",
       {"gravity: {latitude_deg: 91}\n", "config.yaml:1: expected a number from -90 to 90 for 'latitude_deg'"}},
      {"two_gravities",
       {"gravity: {latitude_deg: 10, m_s2: 9.8}\n", "config.yaml:1: expected either 'm_s2' or 'latitude_deg'"}},
      {"height_alone", {"gravity: {height_m: 10}\n", "config.yaml:1: expected either"}},
      {"gravity_number", {"gravity: 9.8\n", "config.yaml:1: expected a map of names and numbers for 'gravity'"}},
      {"format", {"format: 7\n", "config.yaml:1: expected 'format: 1'"}},
      {"empty", {"", "config.yaml:1: file is empty"}},
  };
  std::vector<Case> out;
  for (const auto& [name, texts] : bad) {
    const std::string text = texts.first;
    out.push_back({name, [text](const fs::path& rec) { write_text(rec / "config.yaml", text); }, texts.second,
                   "replay REC --out OUT --config REC/config.yaml"});
  }
  out.push_back({"no_config", [](const fs::path&) {}, "config.yaml", "replay REC --out OUT --config REC/config.yaml"});
  return out;
}

std::vector<Case> usage_cases() {
  const auto nothing = [](const fs::path&) {};
  return {
      {"no_command", nothing, "segcal", ""},
      {"command", nothing, "reply", "reply REC --out OUT"},
      {"option", nothing, "--metrics", "replay REC --out OUT --metrics A"},
      {"no_out", nothing, "--out", "replay REC"},
      {"profile", nothing, "--profile", "replay REC --out OUT --profile tiny"},
      {"metric", nothing, "--metric", "replay REC --out OUT --metric B"},
      {"segments", nothing, "--segments", "replay REC --out OUT --profile mcu --segments 9"},
      {"zero_segments", nothing, "--segments", "replay REC --out OUT --segments 0"},
      {"cameras", nothing, "cam1", "replay REC --out OUT --cameras 2"},
      {"calibration_file", nothing, "none.yaml", "replay REC --out OUT --calib none.yaml"},
      {"no_exposures", nothing, "exposure.csv: expected the exposure of most images",
       "replay REC --out OUT --stamp-exposure 0.5"},
      {"no_exposures to diagnose", nothing, "exposure.csv: expected the exposure of most images",
       "diagnose REC --out OUT --stamp-exposure 0.5"},
      {"stamp_exposure", nothing, "--stamp-exposure", "replay REC --out OUT --stamp-exposure 1.5"},
      {"exposure_offset", nothing, "expected -1 to 1", "simulate --out OUT --effect exposure_offset=2"},
      {"scenario", nothing, "--scenario", "simulate --out OUT --scenario rest"},
      {"seconds", nothing, "--seconds", "simulate --out OUT --seconds x"},
      {"fault", nothing, "unknown fault 'rain'", "simulate --out OUT --fault rain"},
      {"fault of images", nothing, "--fault tracks_lost", "simulate --out OUT --images --fault tracks_lost"},
      {"report_of_nothing", nothing, "OUT", "report OUT"},
  };
}

std::string replaced(std::string text, const std::string& word, const std::string& by) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + by.size())) {
    text.replace(at, word.size(), by);
  }
  return text;
}

/// Files and folders below `root`, with their sizes.
std::string listing(const fs::path& root) {
  std::vector<std::string> entries;
  if (!fs::exists(root)) return "";
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    entries.push_back(entry.path().string() + (entry.is_regular_file() ? " " + std::to_string(entry.file_size()) : ""));
  }
  std::sort(entries.begin(), entries.end());
  std::string text;
  for (const std::string& e : entries) text += e + "\n";
  return text;
}

void check(const Case& c) {
  const Id id = Id().add("case", c.name);
  if (!test::selected(id.text())) return;
  const fs::path rec = scratch / "rec", out = scratch / "out";
  fs::remove_all(rec);
  fs::remove_all(out);
  fs::copy(scratch / "good", rec, fs::copy_options::recursive);
  c.spoil(rec);
  const std::string before = listing(rec);
  const test::Outcome outcome =
      test::run_program(replaced(replaced(c.command, "REC", rec.string()), "OUT", out.string()), scratch);
  const std::string complaint = replaced(c.complaint, "OUT", out.string());
  test::check_between(id, "exit code", 2, outcome.code, 2);
  test::check_true(id, ("stderr is not one line:\n" + outcome.err).c_str(),
                   std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1 && outcome.err.back() == '\n');
  test::check_true(id, ("expected '" + complaint + "' in: " + outcome.err).c_str(),
                   outcome.err.find(complaint) != std::string::npos);
  test::check_true(id, ("stdout: " + outcome.out).c_str(), outcome.out.empty());
  test::check_true(id, ("written:\n" + listing(out)).c_str(), !fs::exists(out));
  test::check_true(id, "the recording was changed", listing(rec) == before);
}

void test_files_that_cannot_be_used() {
  for (const Case& c : file_cases()) check(c);
}

void test_configurations_that_cannot_be_used() {
  for (const Case& c : config_cases()) check(c);
}

void test_bad_usage() {
  for (const Case& c : usage_cases()) check(c);
}

/// Without this the cases above could all fail for another reason.
void test_the_recording_itself_is_good() {
  const test::Outcome outcome = test::run_program(
      "replay \"" + (scratch / "good").string() + "\" --out \"" + (scratch / "good_out").string() + "\"", scratch);
  TEST_ASSERT_TRUE_MESSAGE(outcome.code == 0 || outcome.code == 1, outcome.err.c_str());
  TEST_ASSERT_TRUE(fs::exists(scratch / "good_out" / "result.json"));
}

}  // namespace

int main(int argc, char** argv) {
  test::select_cases(argc, argv);
  const test::TemporaryFolder folder("segcal_test_bad_input");
  scratch = folder.path();
  host::SimulationOptions options;
  options.seconds = 5;
  host::write_simulation(host::simulate(options), scratch / "good");
  UNITY_BEGIN();
  RUN_TEST(test_the_recording_itself_is_good);
  RUN_TEST(test_files_that_cannot_be_used);
  RUN_TEST(test_configurations_that_cannot_be_used);
  RUN_TEST(test_bad_usage);
  return UNITY_END();
}
