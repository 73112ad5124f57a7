#include "rviz_plugins/acoustic_slice_display.h"

#include <rviz/properties/bool_property.h>
#include <rviz/properties/enum_property.h>
#include <rviz/properties/float_property.h>
#include <rviz/properties/ros_topic_property.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <pluginlib/class_list_macros.hpp>

#include "nodes/array_markers.h"
#include "rviz_plugins/sound_bar.h"
#include "ultrasound/acoustic_field.h"
#include "ultrasound/acoustics.h"

namespace tactile_clay::rviz_plugins {
namespace {

enum Plane { front, side, level };
enum Unit { pascal, decibel };

constexpr float closest = 0.01f;  // m from the plane of the transducers, where upright slices begin
constexpr float height_without_focus = 0.15f;  // m
constexpr int max_points = 250000;             // a tenth of a second on one core
constexpr float quietest = 2e-5f;              // Pa peak that count as silence in dB

}  // namespace

AcousticSliceDisplay::AcousticSliceDisplay() {
  geometry_topic_ = new rviz::RosTopicProperty(
      "Geometry", "array/geometry",
      QString::fromStdString(ros::message_traits::datatype<visualization_msgs::MarkerArray>()),
      "Topic with the positions of the transducers (visualization_msgs/MarkerArray), as array nodes publish "
      "it.",
      this, SLOT(subscribeOthers()));
  points_topic_ = new rviz::RosTopicProperty(
      "Focal points", "array/focal_points",
      QString::fromStdString(ros::message_traits::datatype<tactile_clay::FocalPointArray>()),
      "Topic with the focal points (tactile_clay/FocalPointArray). The slice follows the strongest one.",
      this, SLOT(subscribeOthers()));
  plane_ = new rviz::EnumProperty("Plane", "yz, upright",
                                  "Plane of the slice, in the coordinate frame of the array.", this,
                                  SLOT(changed()));
  plane_->addOption("xz, upright", front);
  plane_->addOption("yz, upright", side);
  plane_->addOption("xy, level", level);
  follow_ = new rviz::BoolProperty(
      "Follow the strongest point", true,
      "If true, the slice goes through the strongest focal point. Otherwise it is at Position.", this,
      SLOT(changed()));
  position_ = new rviz::FloatProperty(
      "Position", 0.0f,
      "Position of the slice along the axis of the array that is perpendicular to the plane, m.", this,
      SLOT(changed()));
  size_ = new rviz::FloatProperty("Size", 0.24f, "Width of the slice, m.", this, SLOT(changed()));
  size_->setMin(0.01f);
  size_->setMax(1.0f);
  step_ = new rviz::FloatProperty(
      "Step", 0.0025f,
      "Distance between the points at which the sound is computed, m. The wavelength at 40 kHz is 8.6 mm.",
      this, SLOT(changed()));
  step_->setMin(0.0005f);
  step_->setMax(0.05f);
  unit_ = new rviz::EnumProperty("Unit", "Pa",
                                 "Pa: the colours show the peak amplitude of the sound pressure. "
                                 "dB: they show its level re 20 uPa rms.",
                                 this, SLOT(changed()));
  unit_->addOption("Pa", pascal);
  unit_->addOption("dB", decibel);
  full_scale_ = new rviz::FloatProperty(
      "Full scale", 1000.0f, "Peak amplitude of the sound pressure at the upper end of the colour bar, Pa.",
      this, SLOT(changed()));
  full_scale_->setMin(1.0f);
  range_ = new rviz::FloatProperty(
      "Range", 40.0f,
      "If the unit is dB: difference between the upper and the lower end of the colour bar, dB.", this,
      SLOT(changed()));
  range_->setMin(1.0f);
  alpha_ = new rviz::FloatProperty("Alpha", 0.85f, "Opacity of the slice, 0 (invisible) to 1 (opaque).", this,
                                   SLOT(changed()));
  alpha_->setMin(0.0f);
  alpha_->setMax(1.0f);
  rate_ = new rviz::FloatProperty("Rate", 10.0f, "Maximum number of slices per second.", this);
  rate_->setMin(0.1f);
  rate_->setMax(60.0f);
}

AcousticSliceDisplay::~AcousticSliceDisplay() = default;

void AcousticSliceDisplay::onInitialize() {
  ArrayDisplay::onInitialize();
  slice_ = std::make_unique<DrawnObject>(*scene_manager_, *scene_node_, "acoustic slice");
  Ogre::Pass& pass = slice_->pass();
  pass.setCullingMode(Ogre::CULL_NONE);
  pass.setSceneBlending(Ogre::SBT_TRANSPARENT_ALPHA);
  pass.setDepthWriteEnabled(false);
  bar_ = std::make_unique<Overlay>(slice_->name() + " bar");
  bar_->place(-12, 12);
}

void AcousticSliceDisplay::onEnable() {
  ArrayDisplay::onEnable();
  bar_->show(true);
  changed();
}

void AcousticSliceDisplay::onDisable() {
  ArrayDisplay::onDisable();
  bar_->show(false);
}

void AcousticSliceDisplay::subscribe() {
  ArrayDisplay::subscribe();
  subscribeOthers();
}

void AcousticSliceDisplay::unsubscribe() {
  ArrayDisplay::unsubscribe();
  geometry_subscriber_.shutdown();
  points_subscriber_.shutdown();
}

void AcousticSliceDisplay::subscribeOthers() {
  if (!isEnabled()) return;
  const auto take_geometry = [this](const visualization_msgs::MarkerArray::ConstPtr& markers) {
    try {
      layout_ = nodes::layoutOf(*markers);
      news_ = true;
    } catch (const std::exception& error) {
      setStatus(rviz::StatusProperty::Error, "Geometry", error.what());
    }
  };
  const auto take_points = [this](const tactile_clay::FocalPointArray::ConstPtr& points) {
    points_ = points;
    news_ = true;
  };
  if (subscribeBeside<visualization_msgs::MarkerArray>(*geometry_topic_, "Geometry", geometry_subscriber_,
                                                       take_geometry))
    subscribeBeside<tactile_clay::FocalPointArray>(*points_topic_, "Geometry", points_subscriber_,
                                                   take_points);
}

void AcousticSliceDisplay::reset() {
  ArrayDisplay::reset();
  played_.clear();
  if (slice_) (*slice_)->clear();
}

void AcousticSliceDisplay::changed() {
  news_ = true;
}

void AcousticSliceDisplay::processMessage(const tactile_clay::ArrayDrive::ConstPtr& message) {
  played_.add(*message);
  header_ = message->header;
  news_ = true;
}

void AcousticSliceDisplay::update(float wall_dt, float) {
  since_drawn_ += wall_dt;
  if (!news_ || since_drawn_ * rate_->getFloat() < 1.0f) return;
  news_ = false;
  since_drawn_ = 0.0f;
  draw();
}

AcousticSliceDisplay::Grid AcousticSliceDisplay::grid() const {
  const int plane = plane_->getOptionInt();
  Eigen::Vector3f through(position_->getFloat(), position_->getFloat(), position_->getFloat());
  if (follow_->getBool()) {
    through = Eigen::Vector3f(0.0f, 0.0f, height_without_focus);
    float strongest = 0.0f;
    for (const auto& point : points_ ? points_->points : std::vector<tactile_clay::FocalPoint>()) {
      const Eigen::Vector3f at =
          Eigen::Vector3d(point.position.x, point.position.y, point.position.z).cast<float>();
      if (!(point.intensity > strongest) || !at.allFinite()) continue;
      strongest = point.intensity;
      through = at;
    }
  }
  const float width = size_->getFloat();
  const float step = std::max(step_->getFloat(), width / std::sqrt(static_cast<float>(max_points)));
  Grid grid;
  grid.columns = grid.rows = static_cast<int>(width / step) + 1;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const float u = static_cast<float>(column) * step - 0.5f * width, v = static_cast<float>(row) * step;
      if (plane == front) grid.points.emplace_back(u, through.y(), closest + v);
      if (plane == side) grid.points.emplace_back(through.x(), u, closest + v);
      if (plane == level) grid.points.emplace_back(u, v - 0.5f * width, through.z());
    }
  }
  return grid;
}

void AcousticSliceDisplay::draw() {
  if (!slice_ || !isEnabled()) return;
  DrawnObject& object = *slice_;
  object->clear();
  drawBar(full_scale_->getFloat());
  context_->queueRender();
  if (header_.frame_id.empty() || !place(header_)) return;
  const bool fits =
      std::all_of(played_.drives().begin(), played_.drives().end(), [&](const ultrasound::Drive& drive) {
        return drive.phase.size() == layout_.size() && drive.amplitude.size() == layout_.size();
      });
  if (layout_.size() == 0 || !fits) {
    setStatus(rviz::StatusProperty::Error, "Geometry",
              QString("%1 transducers of %2, another number than in the drive")
                  .arg(layout_.size())
                  .arg(geometry_topic_->getTopic()));
    return;
  }
  setStatus(rviz::StatusProperty::Ok, "Geometry", QString("%1 transducers").arg(layout_.size()));

  const auto start = std::chrono::steady_clock::now();
  const Grid slice = grid();
  const auto amplitude =
      ultrasound::meanAmplitudesAt(layout_, ultrasound::Acoustics(), played_.drives(), slice.points);
  const float top = full_scale_->getFloat(), alpha = alpha_->getFloat();
  const auto level_of = [](float pascals) {
    return static_cast<float>(
        ultrasound::soundPressureLevel(static_cast<double>(std::max(pascals, quietest))));
  };
  const bool in_decibels = unit_->getOptionInt() == decibel;
  object.begin();
  for (std::size_t k = 0; k < slice.points.size(); ++k) {
    const float share = in_decibels ? 1.0f + (level_of(amplitude[k]) - level_of(top)) / range_->getFloat()
                                    : amplitude[k] / top;
    Ogre::ColourValue color = soundColor(share);
    color.a = alpha;
    object->position(slice.points[k].x(), slice.points[k].y(), slice.points[k].z());
    object->colour(color);
  }
  for (int row = 0; row + 1 < slice.rows; ++row) {
    for (int column = 0; column + 1 < slice.columns; ++column) {
      const auto at = static_cast<Ogre::uint32>(row * slice.columns + column);
      const auto above = at + static_cast<Ogre::uint32>(slice.columns);
      object->quad(at, at + 1, above + 1, above);
    }
  }
  object->end();
  const double ms = 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto highest = std::max_element(amplitude.begin(), amplitude.end());
  setStatus(rviz::StatusProperty::Ok, "Field",
            played_.drives().empty() ? QString("the array is silent")
                                     : QString("maximum %1 Pa, %2 dB; %3 points computed in %4 ms")
                                           .arg(static_cast<double>(*highest), 0, 'f', 0)
                                           .arg(static_cast<double>(level_of(*highest)), 0, 'f', 0)
                                           .arg(slice.points.size())
                                           .arg(ms, 0, 'f', 1));
}

void AcousticSliceDisplay::drawBar(float full_scale) {
  const bool in_decibels = unit_->getOptionInt() == decibel;
  const double top = in_decibels ? ultrasound::soundPressureLevel(static_cast<double>(full_scale))
                                 : static_cast<double>(full_scale);
  const double length = in_decibels ? static_cast<double>(range_->getFloat()) : top;
  const std::string what = std::to_string(top) + " " + std::to_string(length) + (in_decibels ? "dB" : "Pa");
  if (what == bar_drawn_) return;
  bar_drawn_ = what;
  paintSoundBar(*bar_, in_decibels ? "sound, dB re 20 µPa" : "sound, Pa peak", top, length);
}

}  // namespace tactile_clay::rviz_plugins

PLUGINLIB_EXPORT_CLASS(tactile_clay::rviz_plugins::AcousticSliceDisplay, rviz::Display)
