// Does an answer rest on one segment? What is left in that one, none of the others can show.
#pragma once

#include <optional>

#include "diagnose/selection.h"
#include "replay/replay.h"

namespace host::review {

/// Of an answer from a single one.
inline constexpr char kOneSegment[] =
    "one segment alone cannot show whether what is left in it is noise: two that agree are needed";

/// How much better values are known with a segment than without. With the information H of all and H_s of segment s,
/// variances are those of (H - H_s)^-1 over those of H^-1. Where three quarters of what is known of a value come from
/// one segment, the segments' scatter (segment_scatter.h) is that segment's own residuals: it draws the fit to itself,
/// an error that lasts as long as it does leaves no trace, and all values that are estimated with this one move along.
struct OneSegment {
  Eigen::VectorXd variance_factor;  ///< on each printed value: the largest without one of such segments; 1 without any
  std::vector<int> values;          ///< that rest on one, as rows of `printed`
  double largest = 1;               ///< by which a sigma is larger without its segment
};

/// `printed`: rows of printed values over theta's columns. The problem must hold all that is known (epochs it does
/// not). Of a single segment nothing is said.
OneSegment rests_on_one_segment(const diagnosis::Problem& problem, const Eigen::MatrixXd& printed);

/// The note `one_segment`, if any value does.
std::optional<Note> note_on_one_segment(const OneSegment& one, const std::vector<CoreParameter>& parameters);

}  // namespace host::review
