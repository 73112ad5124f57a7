#pragma once

#include <ros/ros.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "nodes/inbox.h"
#include "nodes/played_drives.h"
#include "nodes/skin_paint.h"
#include "nodes/transforms.h"
#include "ultrasound/acoustics.h"
#include "ultrasound/array_layout.h"

namespace tactile_clay::nodes {

/// `hands/rendered`, only while somebody subscribes: both hands twice side by side behind the table, their
/// palms towards who looks. One has the pressure that the clay wants, the other the radiation pressure that
/// the true field of `array/drive` gives while it sounds (`array/geometry` tells where the transducers are;
/// air of `~temperature`, transducers of `~reference_pressure`), each with its colour bar, and the error
/// between them.
class RenderedHands {
 public:
  /// @param news called when something else sounds
  /// @throws std::runtime_error with one line where a parameter is wrong
  RenderedHands(ros::NodeHandle nh, const ros::NodeHandle& private_nh, const std::string& world,
                std::function<void()> news);

  /// Whether somebody looks.
  bool wanted() const { return publisher_.getNumSubscribers() > 0; }
  void subscribe(Inbox& inbox);
  void unsubscribe();

  /// @param transforms from the world to the array
  void publish(const std::array<PaintedHand, 2>& hands, const Touch& touch, const std_msgs::Header& header,
               Transforms& transforms);

 private:
  visualization_msgs::MarkerArray markers(const std::array<PaintedHand, 2>& hands, const Touch& touch,
                                          const std_msgs::Header& header, Transforms& transforms);
  std::vector<float> given(const surface::TriangleMesh& mesh, Transforms& transforms,
                           std::vector<char>& facing);

  ros::NodeHandle nh_;
  std::string world_;
  std::function<void()> news_;
  ultrasound::Acoustics acoustics_;
  ultrasound::ArrayLayout layout_;
  PlayedDrives played_;
  float highest_wanted_ = 0.0f, highest_given_ = 0.0f;      // Pa, of the last moments
  ros::Subscriber drive_subscriber_, geometry_subscriber_;  // only while somebody looks
  ros::Publisher publisher_;
};

}  // namespace tactile_clay::nodes
