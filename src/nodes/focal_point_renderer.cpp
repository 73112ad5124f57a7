#include "nodes/focal_point_renderer.h"

#include <tactile_clay/FocalPointArray.h>
#include <tactile_clay/RenderingReport.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "nodes/array_model.h"
#include "nodes/conversions.h"
#include "nodes/params.h"
#include "nodes/topics.h"
#include "ultrasound/slip.h"

namespace tactile_clay::nodes {
namespace {

/// Names of the settings that have another value than usual, although a field does not use them.
std::string unusedByField(const ultrasound::FocalPointConfig& config) {
  const ultrasound::FocalPointConfig usual;
  std::string names;
  const auto add = [&names](bool given, const char* name) {
    if (given) names += (names.empty() ? "" : ", ") + std::string(name);
  };
  add(config.max_points != usual.max_points, "max_points");
  add(config.perceptual_weights != usual.perceptual_weights, "perceptual_weights");
  add(config.felt_threshold != usual.felt_threshold, "felt_threshold (of a person)");
  return names;
}

}  // namespace

ultrasound::FocalPointConfig focalPointConfig(Settings& s) {
  ultrasound::FocalPointConfig config;
  constexpr double any = std::numeric_limits<double>::infinity();  // the core checks ranges
  const auto count = [&](const char* name, std::size_t& value, int maximum, const char* meaning) {
    value = static_cast<std::size_t>(s.whole(name, static_cast<int>(value), 1, maximum, meaning));
  };
  const auto number = [&](const char* name, double& value, double maximum, const char* meaning) {
    value = s.number(name, value, 0.0, maximum, meaning);
  };
  count("max_points", config.max_points, 256, "maximum number of focal points at a time");
  config.modulation = ultrasound::modulation(
      s.text("modulation", "am", "how points are made felt", ultrasound::modulationNames()));
  number("full_scale_pressure", config.full_scale_pressure, any,
         "pressure of the clay for which the array plays at full strength, Pa");
  number("compression_knee", config.compression_knee, 1.0,
         "share of the maximum up to which the sound is proportional to the pressure");
  number("side_lobe_floor", config.side_lobe_floor, 1.0, "minimum amplitude of a point, over the strongest");
  number("minimum_pressure", config.minimum_pressure, any, "samples with less pressure are not rendered, Pa");
  number("minimum_force", config.minimum_force, any, "contacts with less force get no point, N");
  number("min_separation", config.min_separation, any, "minimum distance of two points, m");
  number("min_resolution", config.min_resolution, any, "minimum separation of two points for the array");
  number("sigma", config.sigma, any, "standard deviation of the Gaussian that represents a focus, m");
  number("follow_distance", config.follow_distance, any,
         "how far a point may move in a frame and keep its id, m");
  config.perceptual_weights =
      s.truth("perceptual_weights", config.perceptual_weights, "whether sensitive skin is favoured");
  count("path_points", config.path_points, 256, "of stm: maximum number of places of its path");
  number("path_spacing", config.path_spacing, any, "of stm: minimum distance of two places of its path, m");
  config.field_weights = s.truth("field_weights", config.field_weights,
                                 "of field: whether the error of sensitive skin counts more");
  config.field_normals =
      s.truth("field_normals", config.field_normals,
              "of field: whether the pressure is that on rigid skin at its angle to the sound");
  count("field_samples", config.field_samples, 2000, "of field: maximum number of skin samples");
  const std::string fit = s.text("intensity_fit", "least_squares",
                                 "how a point's pressure follows from samples", {"least_squares", "paper"});
  config.fit = fit == "paper" ? ultrasound::IntensityFit::paper : ultrasound::IntensityFit::least_squares;
  readPerson(s, config);
  config.validate();
  return config;
}

void readPerson(Settings& s, ultrasound::FocalPointConfig& config) {
  constexpr double milli = 1e-3;
  config.felt_gain =
      s.number("felt_gain", config.felt_gain, 0.1, 10.0, "gain of a person, over that of others");
  config.felt_threshold =
      milli * s.number("felt_threshold", config.felt_threshold / milli, 0.0, 50.0,
                       "minimum force of a focal point that a person feels, mN; 0: not known");
}

double modulationFrequency(Settings& settings) {
  return settings.number("modulation_frequency", 0.0, 0.0, 1000.0,
                         "frequency of the modulation, Hz; 0: its usual one");
}

double slipGain(Settings& settings) {
  return settings.number("slip_gain", 0.0, 0.0, 1000.0,
                         "share of the pressure that vibrates, per m/s at which clay slides, s/m; 0: none");
}

LiveParameters::Apply FocalPointRenderer::read(Settings& settings) {
  using ultrasound::isField;
  const ultrasound::FocalPointConfig config = focalPointConfig(settings);
  const double frequency = modulationFrequency(settings), slip_gain = slipGain(settings);
  const ultrasound::Modulation now = renderer_.config().modulation;
  if (settings.running() && isField(now) != isField(config.modulation))
    throw std::runtime_error(
        settings.nameOf("modulation") +
        ": points cannot become a field, or a field points, while the rig runs: start it "
        "with another modulation");
  const std::string unused = isField(config.modulation) ? unusedByField(config) : "";
  if (!settings.running() && !unused.empty())
    ROS_WARN("focal_point_renderer: a field does not use %s; focal points do, with modulation:=am",
             unused.c_str());
  return [this, config, frequency, slip_gain] {
    renderer_.configure(config);
    slip_gain_ = slip_gain;
    modulation_frequency_ = static_cast<float>(frequency);
  };
}

FocalPointRenderer::FocalPointRenderer(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : live_(nh, private_nh, [this](Settings& settings) { return read(settings); }),
      inbox_(private_nh),
      health_(nh, private_nh, "focal points", [this](auto& status) { diagnose(status); }) {
  const ArrayModel array(private_nh);
  renderer_.setArray(ultrasound::ArrayReach(array.layout, array.acoustics));
  const unsigned queue = param(private_nh, "lockstep", false) ? 0 : 1;
  subscriber_ = inbox_.subscribe<sensor_msgs::PointCloud2>(
      nh, topic::hands_pressure, queue, [this](const auto& pressure) { receive(pressure); });
  publisher_ = nh.advertise<FocalPointArray>(topic::focal_points, queue);
  // For a field the array publishes the report, because it solves the field.
  if (!ultrasound::isField(renderer_.config().modulation))
    report_publisher_ = nh.advertise<RenderingReport>(topic::rendering, queue);
}

double FocalPointRenderer::frequency(const std::vector<ultrasound::FocalPoint>& points) const {
  if (modulation_frequency_ > 0.0f) return modulation_frequency_;
  switch (renderer_.config().modulation) {
    case ultrasound::Modulation::lateral:
      return 10.0;
    case ultrasound::Modulation::circle:
    case ultrasound::Modulation::field_circle:
      return 5.0;
    case ultrasound::Modulation::spatiotemporal:
      return ultrasound::spatiotemporalFrequency(points);
    default:
      return 200.0;
  }
}

void FocalPointRenderer::receive(const sensor_msgs::PointCloud2::ConstPtr& pressure) {
  live_.begin(pressure->header.stamp);
  auto message = boost::make_shared<FocalPointArray>();
  message->header = pressure->header;
  message->modulation = static_cast<std::uint8_t>(renderer_.config().modulation);
  message->modulation_frequency = static_cast<float>(frequency({}));
  auto report = boost::make_shared<RenderingReport>();
  ++frames_;
  try {
    const auto samples = pressureSamples(*pressure);
    const auto points = renderer_.render(samples);
    message->slip = static_cast<float>(ultrasound::slipShare(samples, slip_gain_));
    message->points = toMessage(points);
    message->modulation_frequency = static_cast<float>(frequency(points));
    if (renderer_.config().field_weights)
      for (const auto& point : points) message->weight.push_back(static_cast<float>(point.weight));
    if (renderer_.config().field_normals && ultrasound::isField(renderer_.config().modulation))
      message->normal = normalsOf(points);
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
