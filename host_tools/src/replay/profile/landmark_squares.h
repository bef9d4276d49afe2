// The squares of a segment's image rows, whitened, with its landmarks eliminated.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <memory>
#include <vector>

#include "segments/elimination.h"

namespace host {
namespace SEGCAL_NS {

namespace core = ::SEGCAL_NS;

class LandmarkSquares {
  using Index = Eigen::Index;

 public:
  LandmarkSquares(const core::Segment<double>& segment, const core::Calibration<double>& theta,
                  const core::MeasurementModel<double>& model, const core::ReducedLayout& layout,
                  const core::Term* camera_terms)
      : segment_(segment), theta_(theta), model_(model), layout_(layout), camera_terms_(camera_terms) {}

  /// Over [states | theta | terms | rhs], zero before. Returns the number of rows, less what the landmarks take.
  double add_to(Eigen::MatrixXd* form) {
    columns_ = form->cols();
    std::vector<int> from;  // columns of the core's layout, and where they stand here
    std::vector<Index> to;
    for (int c = 0; c < core::kPoseColumns * layout_.keyframes; ++c) {
      from.push_back(c);
      to.push_back(core::kStateColumns * (c / core::kPoseColumns) + c % core::kPoseColumns);
    }
    for (int c = 0; c <= layout_.wide_theta(); ++c) {
      const int column = c < layout_.wide_theta() ? layout_.column_of(c) : layout_.rhs();
      if (column < layout_.cameras()) continue;
      from.push_back(column);
      to.push_back(core::kStateColumns * layout_.keyframes + c);
    }
    double measured = 0;
    for (int j = 0; j < segment_.n_landmarks; ++j) measured += add_landmark(j, from, to, form);
    form->triangularView<Eigen::StrictlyLower>() = form->transpose();
    return measured;
  }

 private:
  /// The squares of the landmark's rows B less what its own three columns A explain,
  /// B'B - B'A (A'A)^-1 A'B; of the upper triangle. The landmark's prior is no
  /// measurement: of an unknown that is known by the prior alone nothing is fitted.
  double add_landmark(int j, const std::vector<int>& from, const std::vector<Index>& to, Eigen::MatrixXd* form) {
    const core::LandmarkFit<double> fit = block_->build(segment_, j, theta_, model_, layout_, camera_terms_, 0);
    if (fit.used < 2) return 0;
    const int first = layout_.pose(fit.first_keyframe);
    using Own = Eigen::Matrix<double, core::kLandmarkColumns, 1>;
    Eigen::Matrix3d own_square = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, core::kLandmarkColumns, Eigen::Dynamic> mixed =
        decltype(mixed)::Zero(core::kLandmarkColumns, columns_);
    double prior = 0;
    for (int i = 0; i < fit.rows; ++i) {
      const double* row = block_->tied_rows() - core::kLandmarkColumns + i * block_->stride();
      const Own own = Eigen::Map<const Own>(row + first);
      if (i == 0) prior = own(2) * own(2);
      own_square += own * own.transpose();
      std::vector<std::pair<Index, double>> entries;
      for (std::size_t c = 0; c < from.size(); ++c) {
        const double value = from[c] < first ? 0 : row[core::kLandmarkColumns + from[c]];
        if (value != 0) entries.emplace_back(to[c], value);
      }
      for (const auto& [c, value] : entries) {
        mixed.col(c) += value * own;
        for (const auto& [b, other] : entries) {
          if (b <= c) (*form)(b, c) += value * other;
        }
      }
    }
    const Eigen::LLT<Eigen::Matrix3d> own_factor(own_square);
    own_factor.matrixL().solveInPlace(mixed);
    for (const Index c : to) {
      for (const Index b : to) {
        if (b > c) break;
        (*form)(b, c) -= mixed.col(b).dot(mixed.col(c));
      }
    }
    const double depth_root = own_factor.matrixLLT()(2, 2);
    return 2 * fit.used - core::kLandmarkColumns + prior / (depth_root * depth_root);
  }

  const core::Segment<double>& segment_;
  const core::Calibration<double>& theta_;
  const core::MeasurementModel<double>& model_;
  const core::ReducedLayout& layout_;
  const core::Term* camera_terms_;
  Index columns_ = 0;
  std::unique_ptr<core::LandmarkBlock<double>> block_ = std::make_unique<core::LandmarkBlock<double>>();
};

}  // namespace SEGCAL_NS
}  // namespace host
