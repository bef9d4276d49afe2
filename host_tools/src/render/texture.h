// A picture that repeats in both directions, with its smaller copies (mip levels) against aliasing.
#pragma once

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace host::render {

class Texture {
 public:
  /// `picture`: 8-bit grey, square, its side a power of two.
  explicit Texture(const cv::Mat& picture);

  int levels() const { return static_cast<int>(levels_.size()); }

  /// Grey value, 0 to 255, at (s, t) in texels of level 0, where
  /// texel k covers k - 0.5 to k + 0.5; bilinear in `level`.
  float at(float s, float t, int level) const {
    const Level& picture = levels_[static_cast<std::size_t>(level)];
    const float scale = picture.scale;
    const float x = (s + 0.5f) * scale - 0.5f, y = (t + 0.5f) * scale - 0.5f;
    int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    x0 -= x < static_cast<float>(x0);
    y0 -= y < static_cast<float>(y0);
    const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
    const int left = x0 & picture.mask, right = (x0 + 1) & picture.mask;
    const std::uint8_t* const upper =
        picture.texels.data() + static_cast<std::size_t>(y0 & picture.mask) * picture.side;
    const std::uint8_t* const lower =
        picture.texels.data() + static_cast<std::size_t>((y0 + 1) & picture.mask) * picture.side;
    const float a = upper[left], b = upper[right], c = lower[left], d = lower[right];
    const float top = a + fx * (b - a), bottom = c + fx * (d - c);
    return top + fy * (bottom - top);
  }

 private:
  struct Level {
    std::vector<std::uint8_t> texels;
    std::size_t side;
    int mask;
    float scale;  ///< texels of this level per texel of level 0
  };
  std::vector<Level> levels_;
};

}  // namespace host::render
