#include "nodes/focal_point_renderer.h"

#include <tactile_clay/FocalPointArray.h>
#include <tactile_clay/RenderingReport.h>

#include <limits>
#include <stdexcept>

#include "nodes/array_model.h"
#include "nodes/conversions.h"
#include "nodes/params.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

ultrasound::FocalPointConfig config(const ros::NodeHandle& nh) {
  ultrasound::FocalPointConfig config;
  constexpr double any = std::numeric_limits<double>::max();  // the core checks ranges
  config.max_points =
      static_cast<std::size_t>(paramIn(nh, "max_points", static_cast<int>(config.max_points), 1, 256));
  config.min_separation = paramIn(nh, "min_separation", config.min_separation, 0.0, any);
  config.min_resolution = paramIn(nh, "min_resolution", config.min_resolution, 0.0, any);
  config.side_lobe_floor = paramIn(nh, "side_lobe_floor", config.side_lobe_floor, 0.0, 1.0);
  config.sigma = paramIn(nh, "sigma", config.sigma, 0.0, any);
  config.perceptual_weights = param(nh, "perceptual_weights", config.perceptual_weights);
  config.full_scale_pressure = paramIn(nh, "full_scale_pressure", config.full_scale_pressure, 0.0, any);
  config.minimum_pressure = paramIn(nh, "minimum_pressure", config.minimum_pressure, 0.0, any);
  config.minimum_force = paramIn(nh, "minimum_force", config.minimum_force, 0.0, any);
  config.follow_distance = paramIn(nh, "follow_distance", config.follow_distance, 0.0, any);
  config.compression_knee = paramIn(nh, "compression_knee", config.compression_knee, 0.0, 1.0);
  config.modulation = ultrasound::modulation(param<std::string>(nh, "modulation", "am"));
  config.path_points =
      static_cast<std::size_t>(paramIn(nh, "path_points", static_cast<int>(config.path_points), 1, 256));
  config.field_samples =
      static_cast<std::size_t>(paramIn(nh, "field_samples", static_cast<int>(config.field_samples), 1, 2000));
  config.path_spacing = paramIn(nh, "path_spacing", config.path_spacing, 0.0, any);
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
          static_cast<float>(paramIn(private_nh, "modulation_frequency", 0.0, 0.0, 1000.0))),
      inbox_(private_nh),
      health_(nh, private_nh, "focal points", [this](auto& status) { diagnose(status); }) {
  const ArrayModel array(private_nh);
  renderer_.setArray(ultrasound::ArrayReach(array.layout, array.acoustics));
  const unsigned queue = param(private_nh, "lockstep", false) ? 0 : 1;
  subscriber_ = inbox_.subscribe<sensor_msgs::PointCloud2>(
      nh, topic::hands_pressure, queue, [this](const auto& pressure) { receive(pressure); });
  publisher_ = nh.advertise<FocalPointArray>(topic::focal_points, queue);
  // Of a field the array tells it, which solves it.
  if (renderer_.config().modulation != ultrasound::Modulation::field)
    report_publisher_ = nh.advertise<RenderingReport>(topic::rendering, queue);
}

double FocalPointRenderer::frequency(const std::vector<ultrasound::FocalPoint>& points) const {
  if (modulation_frequency_ > 0.0f) return modulation_frequency_;
  switch (renderer_.config().modulation) {
    case ultrasound::Modulation::lateral:
      return 10.0;
    case ultrasound::Modulation::spatiotemporal:
      return ultrasound::spatiotemporalFrequency(points);
    default:
      return 200.0;
  }
}

void FocalPointRenderer::receive(const sensor_msgs::PointCloud2::ConstPtr& pressure) {
  auto message = boost::make_shared<FocalPointArray>();
  message->header = pressure->header;
  message->modulation = static_cast<std::uint8_t>(renderer_.config().modulation);
  message->modulation_frequency = static_cast<float>(frequency({}));
  auto report = boost::make_shared<RenderingReport>();
  ++frames_;
  try {
    const auto points = renderer_.render(pressureSamples(*pressure));
    message->points = toMessage(points);
    message->modulation_frequency = static_cast<float>(frequency(points));
    message->area.assign(renderer_.report().area.begin(), renderer_.report().area.end());
    *report = toMessage(renderer_.report(), renderer_.config().compression_knee);
    tellForce(*message, *report);
    compressed_ += report->compressed_points;
    saturated_ += report->saturated_points;
    merged_ += report->merged_points;
    raised_ += report->raised_points;
    ignored_ += report->ignored_samples;
    error_ = report->error;
    weighted_error_ = report->weighted_error;
  } catch (const std::exception& error) {
    ++bad_frames_;
    ROS_WARN_THROTTLE(1.0, "focal_point_renderer: pressure left out: %s", error.what());
  }
  points_ = message->points.size();
  publisher_.publish(message);
  report->header = pressure->header;
  if (report_publisher_) report_publisher_.publish(report);
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
  status.add("points compressed", compressed_);
  status.add("points that the array cannot give", saturated_);
  status.add("points that the array cannot tell apart", merged_);
  status.add("points raised above side lobes", raised_);
  status.add("error of the pressure field", error_);
  status.add("error, weighted", weighted_error_);
  inbox_.report(status);
  frames_ = bad_frames_ = 0;
  compressed_ = saturated_ = merged_ = raised_ = ignored_ = 0;
}

}  // namespace tactile_clay::nodes
