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

/// All conversions between ROS messages and the core, with the fields and units of the messages and topics. A
/// function that reads a message throws std::runtime_error, naming the field, if the message is wrong.

TrackedHands toMessage(const hand::TrackedFrame& frame);
hand::TrackedFrame toCore(const TrackedHands& message);

/// The message of hands/skin, with the perceptual weight of each sample. It has the fields `tracked_x` to
/// `tracked_area` only if the skin is not the tracked hand's own.
sensor_msgs::PointCloud2Ptr skinCloud(const Skin& skin, const std_msgs::Header& header);
/// Reads the part of hands/skin that the clay needs.
/// @param maximum number of samples that the clay takes (clay::maxSkinSamples)
Skin claySkin(const sensor_msgs::PointCloud2& skin,
              std::size_t maximum = std::numeric_limits<std::size_t>::max());

/// Reads the part of hands/skin that the pressure needs. Skin without `tracked_x` is felt where it is.
Skin pressureSkin(const sensor_msgs::PointCloud2& skin);

/// The message of clay/particles, in the colours of the scene's bodies.
sensor_msgs::PointCloud2Ptr particleCloud(const clay::Clay& clay, const scene::Scene& scene,
                                          const std_msgs::Header& header);

/// The message of clay/contacts: for each touched skin sample the force, the velocity of the sample and the
/// sliding speed of the clay. If the skin has these fields, also hand, region and area of the sample.
/// @param skin the message that the samples came from
sensor_msgs::PointCloud2Ptr contactCloud(const std::vector<SkinForce>& forces, const Skin& samples,
                                         const sensor_msgs::PointCloud2& skin);
std::vector<SkinForce> contactForces(const sensor_msgs::PointCloud2& contacts);
/// Whether each contact that has a position lies at its sample of this skin. If two skins have the same
/// stamp, this is true for only one of them.
bool onSkin(const sensor_msgs::PointCloud2& contacts, const Skin& skin);

/// The message of hands/pressure.
sensor_msgs::PointCloud2Ptr pressureCloud(const std::vector<contact::PressureSample>& samples,
                                          const std_msgs::Header& header);
std::vector<contact::PressureSample> pressureSamples(const sensor_msgs::PointCloud2& pressure);

std::vector<FocalPoint> toMessage(const std::vector<ultrasound::FocalPoint>& points);
std::vector<ultrasound::FocalPoint> toCore(const std::vector<FocalPoint>& points);
/// FocalPointArray::normal of skin samples.
std::vector<geometry_msgs::Vector3> normalsOf(const std::vector<ultrasound::FocalPoint>& samples);

RenderingReport toMessage(const ultrasound::RenderReport& report, double compression_knee);

/// Sets force, vibration and static_force of a report from its granted pressures and from the areas of the
/// points.
void tellForce(const FocalPointArray& points, RenderingReport& report);

}  // namespace tactile_clay::nodes
