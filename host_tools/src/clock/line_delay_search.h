// The line delay of a rolling shutter by rotation alone, before the filter starts: shaken by hand, a phone that reads
// its image out in 25 ms shows corners 60 px from where a global shutter would, and no filter that does not know it
// starts.
#pragma once

#include <string>
#include <vector>

#include "calibration_file.h"
#include "recording.h"

namespace host {

struct LineDelaySearch {
  bool judged = false;               ///< the motion tells one; else `words` is empty
  double line_delay = 0, sigma = 0;  ///< s/row (s/column with `readout: columns`); sigma by parts of the recording
  double readout_s = 0;              ///< over the whole image
  double drop = 0;                   ///< of the logarithm of the pairs' mean misfits, against a global shutter
  std::string words;                 ///< a sentence

  /// Enough to keep a filter from running, and sure.
  bool shows_rolling_shutter() const;
};

/// Camera stamps are of the IMU's clock, to some ms. `camera` need not be precise: a few per cent, a few degrees.
LineDelaySearch search_line_delay(const Recording& recording, const CameraCalibration& camera);

/// Of the first session that shows a rolling shutter, else of the first one.
LineDelaySearch search_line_delay(const std::vector<Recording>& sessions, const CameraCalibration& camera);

}  // namespace host
