#include "replay/sessions.h"

#include <iostream>

#include "device_log/device_log.h"
#include "imu_temperature.h"
#include "stamps/exposures.h"

namespace host {
namespace {

std::vector<Recording> sessions_of_log(const std::string& file, int n_cameras, LoggedStates states) {
  DeviceLog log = read_device_log(file);
  for (const std::string& note : log.notes) std::cerr << "segcal: " << note << std::endl;
  std::string& state = log.sessions.front().device->state;
  if (states == LoggedStates::left_out && !state.empty()) {
    state.clear();
    std::cerr << "segcal: " << file << ": the device's state that it begins with is left out: its data alone count"
              << std::endl;
  }
  const int has = static_cast<int>(log.calibration.cameras.size());
  if (has < n_cameras)
    throw InputError(file + ": expected " + std::to_string(n_cameras) + " cameras, found " + std::to_string(has));
  for (Recording& session : log.sessions) check_temperature(&session.imu, false);  // the device's bits are the device's
  return std::move(log.sessions);
}

}  // namespace

std::vector<Recording> read_sessions(const std::vector<std::string>& recordings, int n_cameras, bool smooth,
                                     std::optional<double> stamp_exposure, LoggedStates states) {
  std::vector<Recording> sessions;
  for (const std::string& root : recordings) {
    if (is_device_log(root)) {
      if (stamp_exposure)
        throw InputError(root +
                         ": expected a recording folder with mav0/cam0/exposure.csv for --stamp-exposure, found "
                         "a device log, which holds no exposures; leave the option away");
      for (Recording& session : sessions_of_log(root, n_cameras, states)) sessions.push_back(std::move(session));
      continue;
    }
    sessions.push_back(read_recording(root, n_cameras, smooth));
    for (std::size_t c = 0; c < sessions.back().cameras.size(); ++c) {
      if (!sessions.back().cameras[c].frames.empty()) continue;
      throw InputError(root + "/mav0/cam" + std::to_string(c) + "/tracks.csv: missing; run `segcal track " + root +
                       "` first to make it from the images");
    }
    if (stamp_exposure) sessions.back().notes.push_back(add_exposure_to_stamps(*stamp_exposure, &sessions.back()));
    for (const std::string& note : sessions.back().notes) std::cerr << "segcal: " << root << ": " << note << std::endl;
  }
  return sessions;
}

}  // namespace host
