#pragma once

#include <ros/ros.h>
#include <sensor_msgs/PointCloud2.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "nodes/inbox.h"
#include "nodes/played_drives.h"
#include "nodes/skin_paint.h"
#include "nodes/transforms.h"
#include "ultrasound/acoustics.h"
#include "ultrasound/array_layout.h"

namespace tactile_clay::nodes {

/// Publishes `hands/rendered`, only while somebody subscribes: both hands, drawn three times side by side
/// behind the table, with their palms towards the viewer. One picture shows the perceptual weights of the
/// skin, one the pressure that the clay wants. The third one shows the radiation pressure of the true field
/// of `array/drive` while it sounds (places of the transducers from `array/geometry`, air of `~temperature`,
/// transducers of `~reference_pressure`). Each picture has its colour bar. The error between the two
/// pressures is shown, too, on all skin and on the finger pads.
class RenderedHands {
 public:
  /// @param news called when something else sounds
  /// @throws std::runtime_error with one line if a parameter is wrong
  RenderedHands(ros::NodeHandle nh, const ros::NodeHandle& private_nh, const std::string& world,
                std::function<void()> news);

  /// Whether somebody subscribes.
  bool wanted() const { return publisher_.getNumSubscribers() > 0; }
  void subscribe(Inbox& inbox);
  void unsubscribe();

  /// @param skin hands/skin, or null
  /// @param transforms from which the transform from the world to the array is taken
  void publish(const std::array<PaintedHand, 2>& hands, const Touch& touch,
               const sensor_msgs::PointCloud2* skin, const std_msgs::Header& header, Transforms& transforms);

 private:
  struct Comparison {
    std::array<std::vector<float>, 2> given, weight;    // of each hand: Pa, 0-1
    float highest_wanted = 0.0f, highest_given = 0.0f;  // Pa
    double force = 0.0;                                 // N, on all skin that faces the array
    // Relative RMS errors at the scale that is best for all counted skin.
    double error = 0.0;
    std::optional<double> error_on_pads;  // none if the clay hardly presses on them
  };

  Comparison compare(const std::array<PaintedHand, 2>& hands, const Touch& touch,
                     const sensor_msgs::PointCloud2* skin, Transforms& transforms);
  std::string titleOfGiven(const Comparison& found, bool touches) const;
  visualization_msgs::MarkerArray markers(const std::array<PaintedHand, 2>& hands, const Touch& touch,
                                          const sensor_msgs::PointCloud2* skin,
                                          const std_msgs::Header& header, Transforms& transforms);
  std::vector<float> given(const surface::TriangleMesh& mesh, Transforms& transforms,
                           std::vector<char>& facing);

  ros::NodeHandle nh_;
  std::string world_;
  std::function<void()> news_;
  ultrasound::Acoustics acoustics_;
  ultrasound::ArrayLayout layout_;
  PlayedDrives played_;
  float highest_wanted_ = 0.0f, highest_given_ = 0.0f;      // Pa, maxima of the last moments
  ros::Subscriber drive_subscriber_, geometry_subscriber_;  // exist only while somebody subscribes
  ros::Publisher publisher_;
};

}  // namespace tactile_clay::nodes
