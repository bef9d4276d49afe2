// Does an answer rest on one segment? What is left in that one, none of the others can show.
#pragma once

#include <optional>

#include "diagnose/selection.h"
#include "replay/replay.h"

namespace host::review {

/// Of an answer from a single one.
inline constexpr char kOneSegment[] =
    "one segment alone cannot show whether what is left in it is noise: two that agree are needed";

/// How much better each printed value is known with the segment that tells most about it than without. With the
/// information H of all and H_s of segment s, variances are those of (H - H_s)^-1 over those of H^-1. Where three
/// quarters of what is known of a value come from one segment, the segments' scatter (segment_scatter.h) is that
/// segment's own residuals: it draws the fit to itself, an error that lasts as long as it does leaves no trace, and all
/// values that are estimated with this one move along.
struct OneSegment {
  Eigen::VectorXd variance_factor;  ///< on each printed value, what the others know of it; 1 where none rests on one
  std::vector<int> values;          ///< that rest on it, as rows of `printed`
  double largest = 1;               ///< by which a sigma is larger without that segment
};

/// `printed`: rows of printed values over theta's columns; `covariance`: theirs from segments, epochs and the prior, by
/// stated noise. Of two segments, or one, nothing is said.
OneSegment rests_on_one_segment(const std::vector<diagnosis::Piece>& pieces, const Eigen::MatrixXd& printed,
                                const Eigen::MatrixXd& covariance);

/// The note `one_segment`, if any value does.
std::optional<Note> note_on_one_segment(const OneSegment& one, const std::vector<CoreParameter>& parameters);

}  // namespace host::review
