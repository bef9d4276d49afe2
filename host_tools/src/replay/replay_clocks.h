// The camera's clock against the IMU's, before a replay and after it.
#pragma once

#include "replay/model_file.h"
#include "replay/replay_arguments.h"

namespace host {

/// The offset that the clocks are known to have: of the model, if it
/// has one, else of the camera chain (a result holds the same in both).
double stated_offset(const Calibration& calibration, const EffectChoice& choice);
/// Moves all camera stamps to the IMU's clock: by the offset that is stated and, where
/// the images and the gyroscope say another one, by that, which is then estimated on.
/// Returns the offset of the last session, from which the effect counts.
double align_clocks(ReplayArguments* a, EffectChoice* choice, std::vector<Recording>* sessions);
/// Where rolling_shutter is to be estimated and no value of it is known, it starts from what rotation says: shaken by
/// hand, no filter starts without it. After align_clocks().
void start_line_delay(const ReplayArguments& a, const std::vector<Recording>& sessions, EffectChoice* choice);
/// The effect's value as people and files count it: from the stamps as they are in the recording.
void count_offset_from_recording(double offset, ReplayResult* result);

}  // namespace host
