#include "hand/rigid_motion.h"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace tactile_clay::hand {

Eigen::Isometry3d rigidMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  return Eigen::Isometry3d(Eigen::umeyama(from, to, false));
}

}  // namespace tactile_clay::hand
