#include "diagnose/axis_orders.h"

#include <algorithm>
#include <array>

namespace host {

const std::vector<AxisOrder>& axis_orders() {
  static const std::vector<AxisOrder> all = [] {
    std::vector<AxisOrder> out;
    std::array<int, 3> order{0, 1, 2};
    do {
      for (int signs = 0; signs < 8; ++signs) {
        AxisOrder one{Eigen::Matrix3d::Zero(), ""};
        for (int row = 0; row < 3; ++row) {
          const bool negative = (signs >> row) & 1;
          one.P(row, order[static_cast<std::size_t>(row)]) = negative ? -1 : 1;
          one.name += std::string(row ? " " : "") + (negative ? "-" : "") + "xyz"[order[static_cast<std::size_t>(row)]];
        }
        out.push_back(one);
      }
    } while (std::next_permutation(order.begin(), order.end()));
    return out;
  }();
  return all;
}

}  // namespace host
