// Stamps of images that follow the exposure: t_imu = t_stamp + t_d + kappa exposure.
//
// The core knows nothing of exposures. To first order the column of kappa is, in each segment's rows, that of
// time_offset times the segment's exposure, the mean over its keyframes. An exposure that changes within a segment is
// lost in that; so once kappa is in the model, the stamps themselves are moved by it, the fit is made again, and kappa
// is estimated about what was taken. The whole exposure is taken, and not what is above its mean: a device whose stamps
// are of the exposure's start then departs by one effect, and not by two. That time_offset is another effect is for
// the rows to tell: where kappa would not show beside it, exposures change too little (Candidate::beside).
//
// Joined segments are one triangle R, which has no rows of single segments any more. Their column k follows from what
// is additive: with the rows R_i of the segments alone and the mean exposure e of all, R'k = e R't + sum of
// (e_i - e) R_i't_i, and k'k likewise; what the links say beside them counts with the mean.
#pragma once

#include "diagnose/diagnose.h"
#include "diagnose/searched_model.h"
#include "replay/core.h"

namespace host::diagnosis {

/// Where its column stands among the terms, and at which kappa the stamps are.
struct ExposureColumn {
  int at = -1;  ///< -1: it is no candidate
  int of = 0;   ///< time_offset's place among the other terms
  double kappa = 0;
  std::vector<double> exposure_s;  ///< of each kept segment, in the order of time
  std::vector<Rows> segments;      ///< their rows without it
};
/// kappa, which the core knows nothing of.
TermInfo exposure_term();
ExposureColumn exposure_column(const std::vector<TermInfo>& terms, const std::vector<bool>& estimated,
                               const std::vector<double>& start);

/// Mean exposure of each segment's keyframes; their stamps are those of `sessions`.
std::vector<double> mean_exposures(const std::vector<CoreKept>& kept, const std::vector<Recording>& sessions);

/// One segment's rows, or one sensor's of it, with the column put in, counted from zero.
Rows with_exposure(const Rows& segment, int n_theta, const ExposureColumn& column, double exposure_s);
/// Rows of the segments at `places`, joined.
Rows with_exposure(const Rows& joined, int n_theta, const ExposureColumn& column,
                   const std::vector<std::size_t>& places);
/// Puts it into all rows of a problem that has a piece for each segment.
void add_exposure_column(const std::vector<double>& exposure_s, ExposureColumn* column, Problem* problem);

/// Puts the effect behind the terms, as one more candidate among which the level is shared out.
void add_exposure_offset(SearchedModel* model);

/// A sentence without its full stop; `stated`: of it, what was added to the stamps before.
std::string kappa_in_words(double kappa, double sigma, double stated);
/// What was added to the stamps before counts too.
void count_kappa_from_recording(double added, Diagnosis* out);

/// Fits with these candidates; again, where kappa is among them, until what is left of it is little.
Problem fit_about_kappa(SearchedModel* model, const std::vector<int>& accepted, const std::function<Problem()>& fit);

}  // namespace host::diagnosis
