#include "nodes/focal_point_renderer.h"

#include <tactile_clay/FocalPointArray.h>

#include <limits>
#include <stdexcept>

#include "nodes/conversions.h"
#include "nodes/params.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

constexpr std::uint8_t amplitude_modulation = 0;

ultrasound::FocalPointConfig config(const ros::NodeHandle& nh) {
  ultrasound::FocalPointConfig config;
  constexpr double any = std::numeric_limits<double>::max();  // the core checks ranges
  config.max_points =
      static_cast<std::size_t>(paramIn(nh, "max_points", static_cast<int>(config.max_points), 1, 256));
  config.min_separation = paramIn(nh, "min_separation", config.min_separation, 0.0, any);
  config.sigma = paramIn(nh, "sigma", config.sigma, 0.0, any);
  config.perceptual_weights = param(nh, "perceptual_weights", config.perceptual_weights);
  config.full_scale_pressure = paramIn(nh, "full_scale_pressure", config.full_scale_pressure, 0.0, any);
  config.minimum_pressure = paramIn(nh, "minimum_pressure", config.minimum_pressure, 0.0, any);
  config.minimum_force = paramIn(nh, "minimum_force", config.minimum_force, 0.0, any);
  config.follow_distance = paramIn(nh, "follow_distance", config.follow_distance, 0.0, any);
  const auto fit = param<std::string>(nh, "intensity_fit", "least_squares");
  if (fit != "least_squares" && fit != "paper")
    throw std::runtime_error("parameter " + nh.resolveName("intensity_fit") +
                             ": expected 'least_squares' or 'paper', got '" + fit + "'");
  config.fit = fit == "paper" ? ultrasound::IntensityFit::paper : ultrasound::IntensityFit::least_squares;
  return config;
}

}  // namespace

FocalPointRenderer::FocalPointRenderer(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : renderer_(config(private_nh)),
      modulation_frequency_(
          static_cast<float>(paramIn(private_nh, "modulation_frequency", 200.0, 1.0, 1000.0))),
      health_(nh, private_nh, "focal points", [this](auto& status) { diagnose(status); }) {
  const unsigned queue = param(private_nh, "lockstep", false) ? 0 : 1;
  subscriber_ = nh.subscribe(topic::hands_pressure, queue, &FocalPointRenderer::receive, this,
                             ros::TransportHints().tcpNoDelay());
  publisher_ = nh.advertise<FocalPointArray>(topic::focal_points, queue);
}

void FocalPointRenderer::receive(const sensor_msgs::PointCloud2::ConstPtr& pressure) {
  auto message = boost::make_shared<FocalPointArray>();
  message->header = pressure->header;
  message->modulation = amplitude_modulation;
  message->modulation_frequency = modulation_frequency_;
  ++frames_;
  try {
    message->points = toMessage(renderer_.render(pressureSamples(*pressure)));
    clipped_ += renderer_.report().clipped_points;
    ignored_ += renderer_.report().ignored_samples;
  } catch (const std::exception& error) {
    ++bad_frames_;
    ROS_WARN_THROTTLE(1.0, "focal_point_renderer: pressure left out: %s", error.what());
  }
  points_ = message->points.size();
  publisher_.publish(message);
}

void FocalPointRenderer::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  if (bad_frames_ > 0 || ignored_ > 0)
    status.summary(Level::WARN, "pressure left out");
  else
    status.summary(Level::OK, frames_ > 0 ? "rendering" : "no frames");
  status.add("frames", frames_);
  status.add("frames left out", bad_frames_);
  status.add("samples left out", ignored_);
  status.add("focal points", points_);
  status.add("points at full scale", clipped_);
  frames_ = bad_frames_ = 0;
  clipped_ = ignored_ = 0;
}

}  // namespace tactile_clay::nodes
