#include "replay/replay_clocks.h"

#include <iostream>

#include "clock/clock_search.h"
#include "clock/line_delay_search.h"

namespace host {

double stated_offset(const Calibration& calibration, const EffectChoice& choice) {
  const double of_model = choice.value("time_offset.t_d");
  return of_model != 0 ? of_model : calibration.cameras.front().timeshift_cam_imu;
}

double align_clocks(ReplayArguments* a, EffectChoice* choice, std::vector<Recording>* sessions) {
  const double stated = stated_offset(a->replay.core.calibration, *choice);
  double offset = stated;
  for (Recording& session : *sessions) {
    if (session.device) return 0;  // a device's bits are the device's
    offset = stated;
    if (!a->keep_clock) {
      const ClockSearch found = search_clock(session, a->replay.core.calibration.cameras.front(), stated);
      a->replay.clocks.push_back(found);
      if (found.differs_from(stated)) {
        offset = found.offset_s;
        std::cerr << "segcal: " << session.root.string() << ": " << found.words
                  << "; time_offset is estimated from there" << std::endl;
        choice->enable("time_offset");
      }
    }
    shift_frames(offset, &session);
  }
  if (choice->enabled("time_offset")) choice->set("time_offset.t_d", 0);
  return offset;
}

void start_line_delay(const ReplayArguments& a, const std::vector<Recording>& sessions, EffectChoice* choice) {
  if (a.replay.state) return;  // its start is that of all its sessions, whatever each of them shows
  const Recording& session = sessions.front();
  if (session.device || !choice->enabled("rolling_shutter") || choice->value("rolling_shutter.line_delay") != 0) return;
  const LineDelaySearch found = search_line_delay(sessions, a.replay.core.calibration.cameras.front());
  if (!found.shows_rolling_shutter()) return;
  std::cerr << "segcal: " << session.root.string() << ": " << found.words << "; rolling_shutter is estimated from there"
            << std::endl;
  choice->set("rolling_shutter.line_delay", found.line_delay);
}

void count_offset_from_recording(double offset, ReplayResult* result) {
  const auto add = [offset](std::vector<CoreParameter>* parameters) {
    double value = offset;
    for (CoreParameter& p : *parameters) {
      if (p.name != "time_offset.t_d") continue;
      p.initial += offset;
      value = p.value += offset;
    }
    return value;
  };
  const double total = add(&result->result.parameters);
  for (std::size_t i = 0; i < result->result.mean.size() && i < result->result.parameters.size(); ++i) {
    if (result->result.parameters[i].name == "time_offset.t_d") result->result.mean[i] += offset;
  }
  for (ReplayCalibration& c : result->calibrations) add(&c.parameters);
  if (result->result.status != "calibrated") return;  // the calibration is the one that it started with
  for (CameraCalibration& camera : result->calibration.cameras) camera.timeshift_cam_imu = total;
}

}  // namespace host
