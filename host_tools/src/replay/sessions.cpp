#include "replay/sessions.h"

namespace host {

std::vector<Recording> read_sessions(const std::vector<std::string>& recordings, int n_cameras) {
  std::vector<Recording> sessions;
  for (const std::string& root : recordings) {
    sessions.push_back(read_recording(root, n_cameras));
    for (std::size_t c = 0; c < sessions.back().cameras.size(); ++c) {
      if (!sessions.back().cameras[c].frames.empty()) continue;
      throw InputError(root + "/mav0/cam" + std::to_string(c) + "/tracks.csv: missing; run `segcal track " + root +
                       "` first to make it from the images");
    }
  }
  return sessions;
}

}  // namespace host
