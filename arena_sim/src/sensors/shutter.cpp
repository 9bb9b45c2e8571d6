#include "sensors/shutter.h"

#include <algorithm>

namespace rubble::arena_sim {

Shutter::Shutter(double seconds, double exposure, double readout, int rows, int samples,
                 const PoseAt& T_world_camera)
    : parts_(samples + 1), rows_(readout > 0.0 ? rows : 1) {
  for (int row = 0; row < rows_; ++row) {
    const double middle =
        readout > 0.0 ? seconds + readout * (static_cast<double>(row) / rows - 0.5) : seconds;
    for (int part = 0; part < parts_; ++part) {
      const double share = static_cast<double>(part) / samples - 0.5;
      const Eigen::Matrix<float, 3, 4> T =
          T_world_camera(middle + exposure * share).matrix().topRows<3>().cast<float>();
      Pose& pose = poses_.emplace_back();
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j) {
          pose[4 * i + j] = T(i, j);
        }
      }
    }
  }
}

const Shutter::Pose* Shutter::row(int row) const { return &poses_[parts_ * std::min(row, rows_ - 1)]; }

}  // namespace rubble::arena_sim
