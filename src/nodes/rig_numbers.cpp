#include "nodes/rig_numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include <tactile_clay/FocalPointArray.h>
#include <tactile_clay/TrackedHands.h>

#include "nodes/conversions.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

constexpr double look_every = 0.1;                            // s
constexpr unsigned queue = 60;                                // a second of frames
constexpr double latency_every = 1.0, latency_window = 60.0;  // s

float sum(const std::vector<float>& values) {
  float total = 0.0f;
  for (const float value : values) total += value;
  return total;
}

}  // namespace

void takeNumbers(const ClayStatus& status, RigNumbers& numbers) {
  numbers.real_time_factor = status.real_time_factor;
  numbers.step_ms = sum(status.stage_ms);
  const std::map<std::string, float RigNumbers::*> stages = {
      {"neighbours", &RigNumbers::step_neighbours_ms},
      {"contact_search", &RigNumbers::step_contact_search_ms},
      {"bonds", &RigNumbers::step_bonds_ms},
      {"setup", &RigNumbers::step_setup_ms},
      {"iterations", &RigNumbers::step_iterations_ms},
      {"finish", &RigNumbers::step_finish_ms}};
  for (std::size_t k = 0; k < std::min(status.stages.size(), status.stage_ms.size()); ++k) {
    const auto stage = stages.find(status.stages[k]);
    if (stage != stages.end()) numbers.*stage->second = status.stage_ms[k];
  }
  numbers.solver_iterations = status.iterations;
  numbers.active_particles = static_cast<float>(status.active_particles);
  numbers.particle_contacts = static_cast<float>(status.contacts);
  numbers.lumps = static_cast<float>(status.lumps);
  numbers.crumbs = static_cast<float>(status.crumbs);
  numbers.bonds = static_cast<float>(status.bonds);
  numbers.strays = static_cast<float>(status.strays);
  numbers.density_error_percent = 100.0f * status.density_error_mean;
  numbers.density_error_highest_percent = 100.0f * status.density_error_max;
}

void takeNumbers(const sensor_msgs::PointCloud2& pressure, RigNumbers& numbers) {
  float highest = 0.0f, force = 0.0f, area = 0.0f;
  for (const contact::PressureSample& sample : pressureSamples(pressure)) {
    highest = std::max(highest, sample.pressure);
    force += sample.force;
    if (sample.pressure > 0.0f) area += sample.area;
  }
  numbers.wanted_pressure_highest_kPa = 1e-3f * highest;
  numbers.wanted_force_N = force;
  numbers.touching_skin_cm2 = 1e4f * area;
}

void takeNumbers(const RenderingReport& report, RigNumbers& numbers) {
  numbers.focal_points = static_cast<float>(report.granted.size());
  numbers.saturated_points = static_cast<float>(report.saturated_points);
  numbers.rendered_force_mN = report.force;
  numbers.rendered_gain_Pa_per_kPa = 1e3f * report.gain;
  numbers.rendered_error_percent = 100.0f * report.error;
  numbers.weighted_error_percent = 100.0f * report.weighted_error;
  numbers.vibration_dB = report.vibration;
  numbers.static_force_mN = report.static_force;
}

void takeNumbers(const ArrayState& state, RigNumbers& numbers) {
  numbers.header = state.header;
  numbers.hand_to_array_latency_ms = 1e3f * state.latency;
  numbers.head_level_dB = state.head_spl;
  numbers.array_sounds = state.emitting != 0 ? 1.0f : 0.0f;
  numbers.frames_late = static_cast<float>(state.frames_late);
  numbers.frames_rejected = static_cast<float>(state.frames_rejected);
}

RigNumbers unknownNumbers() {
  constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
  RigNumbers numbers;
  for (float RigNumbers::*number : {&RigNumbers::real_time_factor,
                                    &RigNumbers::hand_to_array_latency_ms,
                                    &RigNumbers::step_ms,
                                    &RigNumbers::step_neighbours_ms,
                                    &RigNumbers::step_contact_search_ms,
                                    &RigNumbers::step_bonds_ms,
                                    &RigNumbers::step_setup_ms,
                                    &RigNumbers::step_iterations_ms,
                                    &RigNumbers::step_finish_ms,
                                    &RigNumbers::solver_iterations,
                                    &RigNumbers::active_particles,
                                    &RigNumbers::particle_contacts,
                                    &RigNumbers::lumps,
                                    &RigNumbers::crumbs,
                                    &RigNumbers::bonds,
                                    &RigNumbers::strays,
                                    &RigNumbers::density_error_percent,
                                    &RigNumbers::density_error_highest_percent,
                                    &RigNumbers::wanted_pressure_highest_kPa,
                                    &RigNumbers::wanted_force_N,
                                    &RigNumbers::touching_skin_cm2,
                                    &RigNumbers::focal_points,
                                    &RigNumbers::saturated_points,
                                    &RigNumbers::rendered_force_mN,
                                    &RigNumbers::rendered_gain_Pa_per_kPa,
                                    &RigNumbers::rendered_error_percent,
                                    &RigNumbers::weighted_error_percent,
                                    &RigNumbers::vibration_dB,
                                    &RigNumbers::static_force_mN,
                                    &RigNumbers::head_level_dB,
                                    &RigNumbers::array_sounds,
                                    &RigNumbers::frames_late,
                                    &RigNumbers::frames_rejected})
    numbers.*number = unknown;
  return numbers;
}

RigNumbersNode::RigNumbersNode(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : nh_(nh), numbers_(unknownNumbers()), inbox_(private_nh) {
  publisher_ = nh.advertise<RigNumbers>(topic::rig_numbers, queue);
  latency_publisher_ = nh.advertise<RigLatency>(topic::rig_latency, 2);
  timer_ = nh.createWallTimer(ros::WallDuration(look_every), [this](const ros::WallTimerEvent&) { look(); });
  latency_timer_ = nh.createWallTimer(ros::WallDuration(latency_every),
                                      [this](const ros::WallTimerEvent&) { lookAtLatency(); });
}

template <typename Message>
void RigNumbersNode::follow(const char* topic) {
  subscribers_.push_back(inbox_.subscribe<Message>(
      nh_, topic, queue,
      [this](const typename Message::ConstPtr& message) { takeNumbers(*message, numbers_); }));
}

template <typename Message>
void RigNumbersNode::time(std::size_t topic) {
  timed_.push_back(inbox_.subscribe<Message>(
      nh_, latency_topics.at(topic), queue, [this, topic](const typename Message::ConstPtr& message) {
        latency_->arrived(topic, message->header.stamp, ros::Time::now());
      }));
}

void RigNumbersNode::lookAtLatency() {
  if (latency_publisher_.getNumSubscribers() == 0) {
    timed_.clear();
    latency_.reset();
  } else if (!latency_) {
    latency_.emplace(latency_window);
    time<TrackedHands>(0);
    time<sensor_msgs::PointCloud2>(1);
    time<sensor_msgs::PointCloud2>(2);
    time<sensor_msgs::PointCloud2>(3);
    time<FocalPointArray>(4);
    time<ArrayState>(5);
  } else {
    latency_publisher_.publish(latency_->message());
  }
}

void RigNumbersNode::look() {
  if (publisher_.getNumSubscribers() == 0) {
    subscribers_.clear();
    numbers_ = unknownNumbers();
  } else if (subscribers_.empty()) {
    follow<ClayStatus>(topic::clay_status);
    follow<sensor_msgs::PointCloud2>(topic::hands_pressure);
    follow<RenderingReport>(topic::rendering);
    subscribers_.push_back(inbox_.subscribe<ArrayState>(nh_, topic::array_state, queue,
                                                        [this](const ArrayState::ConstPtr& state) {
                                                          takeNumbers(*state, numbers_);
                                                          publisher_.publish(numbers_);
                                                        }));
  }
}

}  // namespace tactile_clay::nodes
