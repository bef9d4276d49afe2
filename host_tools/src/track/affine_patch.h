// What a corner looked like, and how that is bent in a later image.
#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>

namespace host {

/// Where a patch is seen: the point, px, and how its surroundings are bent (1: as in the patch's own image).
struct PatchPose {
  Eigen::Vector2f point;
  Eigen::Matrix2f shape = Eigen::Matrix2f::Identity();
};

/// A square of an image around a point, and its affine map to other images, with gain and offset of
/// brightness. As a corner moves through the image, lens and perspective bend what is around it. A
/// tracker that only shifts its patch errs by what that does to the pattern. Inverse compositional
/// (Baker, Matthews: Lucas-Kanade 20 years on, IJCV 56, 2004, section 3.2): the derivatives are the
/// patch's own, so that a step is one product with a matrix that is known beforehand.
class AffinePatch {
 public:
  /// `image`: 8-bit grey. `side_px` is odd; a patch over the image's edge repeats the rim.
  AffinePatch(const cv::Mat& image, const Eigen::Vector2f& point, int side_px);

  /// Moves `pose`, a guess within some 2 px, onto the patch in `image`.
  /// False, and `pose` as it was, where the patch does not look like that.
  bool align(const cv::Mat& image, PatchPose& pose) const;

 private:
  static constexpr int kUnknowns = 8, kGain = 6;  // of the map 6, gain, offset

  /// From the square, px from its middle, to an image, px.
  struct Map {
    Eigen::Matrix2f A;
    Eigen::Vector2f t;
  };
  void sample(const cv::Mat& image, const Map& W, Eigen::VectorXf& seen) const;
  bool step(const Eigen::VectorXf& seen, Map& W) const;
  bool looks_like(Eigen::VectorXf& seen) const;

  int half_;                                              ///< of the square's side without its middle, px
  Eigen::Vector2f offset_;                                ///< from the middle of the square to the point, px
  Eigen::VectorXf grey_;                                  ///< mean 0
  Eigen::Matrix<float, kUnknowns, Eigen::Dynamic> step_;  ///< from the grey values in an image to the unknowns
};

}  // namespace host
