#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <tactile_clay/FocalPointArray.h>
#include <tactile_clay/RenderingReport.h>
#include <tactile_clay/TrackedHands.h>

#include <limits>
#include <string>
#include <vector>

#include "clay/clay.h"
#include "contact/pressure_field.h"
#include "hand/tracked_hand.h"
#include "nodes/stamps.h"
#include "scene/scene.h"
#include "ultrasound/focal_point.h"
#include "ultrasound/focal_points.h"
#include "values/skin.h"

namespace tactile_clay::nodes {

/// Every conversion between ROS messages and the core, with the fields and units of the messages and topics.
/// What reads a message throws std::runtime_error, naming the field, where the message is not what it should
/// be.

TrackedHands toMessage(const hand::TrackedFrame& frame);
hand::TrackedFrame toCore(const TrackedHands& message);

/// hands/skin, with the perceptual weight of each sample. With `tracked_x` to `tracked_area` only where the
/// skin is not the tracked hand's own.
sensor_msgs::PointCloud2Ptr skinCloud(const Skin& skin, const std_msgs::Header& header);
/// The same as the clay needs it.
/// @param maximum samples that the clay takes (clay::maxSkinSamples)
Skin claySkin(const sensor_msgs::PointCloud2& skin,
              std::size_t maximum = std::numeric_limits<std::size_t>::max());

/// hands/skin as the pressure needs it. Skin without `tracked_x` is felt where it is.
Skin pressureSkin(const sensor_msgs::PointCloud2& skin);

/// clay/particles, in the colours of the scene's bodies.
sensor_msgs::PointCloud2Ptr particleCloud(const clay::Clay& clay, const scene::Scene& scene,
                                          const std_msgs::Header& header);

/// clay/contacts: the force on each touched skin sample, how it moves, how the clay slides there, and, where
/// the skin tells them, its hand, region and area.
/// @param skin the message that the samples came from
sensor_msgs::PointCloud2Ptr contactCloud(const std::vector<SkinForce>& forces, const Skin& samples,
                                         const sensor_msgs::PointCloud2& skin);
std::vector<SkinForce> contactForces(const sensor_msgs::PointCloud2& contacts);
/// Whether the contacts, where they tell their places, are on their samples of that skin. Of two skins with
/// one stamp only one is.
bool onSkin(const sensor_msgs::PointCloud2& contacts, const Skin& skin);

/// hands/pressure.
sensor_msgs::PointCloud2Ptr pressureCloud(const std::vector<contact::PressureSample>& samples,
                                          const std_msgs::Header& header);
std::vector<contact::PressureSample> pressureSamples(const sensor_msgs::PointCloud2& pressure);

std::vector<FocalPoint> toMessage(const std::vector<ultrasound::FocalPoint>& points);
std::vector<ultrasound::FocalPoint> toCore(const std::vector<FocalPoint>& points);

RenderingReport toMessage(const ultrasound::RenderReport& report, double compression_knee);

/// Sets force, vibration and static_force of a report by its granted pressures and the points that have them.
void tellForce(const FocalPointArray& points, RenderingReport& report);

}  // namespace tactile_clay::nodes
