#pragma once

#include <ros/ros.h>

#include <QComboBox>
#include <functional>
#include <string>

namespace tactile_clay::rviz_plugins {

/// The quality with which the clay is solved, as a list of presets. Disabled until the clay tells its
/// quality.
class QualityBox : public QComboBox {
 public:
  /// @param ask asks the clay for another quality
  explicit QualityBox(const std::function<void(const std::string& quality)>& ask);

  /// Shows the quality of a node from now on.
  /// @param clay name of the node
  /// @throws ros::Exception if it is no name
  void follow(const std::string& clay);
  /// Shows the present quality again, after another one was refused.
  void showHeld() { setCurrentText(held_); }

 private:
  ros::NodeHandle nh_;
  ros::Subscriber values_;  // its callback runs in the thread that draws
  QString held_;
};

}  // namespace tactile_clay::rviz_plugins
