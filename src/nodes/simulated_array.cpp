#include "nodes/simulated_array.h"

#include <tactile_clay/ArrayState.h>

#include <stdexcept>

#include "nodes/conversions.h"
#include "nodes/params.h"
#include "nodes/topics.h"

namespace tactile_clay::nodes {
namespace {

constexpr char simulated[] = "simulated";  // name of the device
const ros::WallDuration wire_period(1.0 / 60.0);

ultrasound::ArrayLayout boards(std::size_t count, const Eigen::Isometry3d& second) {
  ultrasound::ArrayLayout layout = device::SonicSurfaceBoards::layout();
  if (count == 2) layout = ultrasound::joined({layout, ultrasound::placed(layout, second)});
  return layout;
}

}  // namespace

SimulatedArray::SimulatedArray(ros::NodeHandle nh, ros::NodeHandle private_nh) : model_(private_nh) {
  if (param<std::string>(private_nh, "wire", "").empty())
    startGate(nh, private_nh);
  else
    startWire(nh, private_nh);
}

void SimulatedArray::startGate(ros::NodeHandle nh, ros::NodeHandle private_nh) {
  field_ = std::make_unique<SoundField>(nh, private_nh, model_);
  using ultrasound::Modulation;
  GatedArray::Output output;
  output.harmless = true;
  output.model = model_;
  output.scalable = model_.options.amplitude_levels == 0;
  output.solve = [this](const auto& points, const auto* before) { return model_.solve(points, before); };
  output.solve_field = [this](const auto& targets, double amplitude, const auto& before, double effort) {
    return model_.solveField(targets, amplitude, before, effort);
  };
  output.repertoire = {simulated,
                       {Modulation::amplitude, Modulation::lateral, Modulation::spatiotemporal,
                        Modulation::field, Modulation::circle, Modulation::field_circle},
                       0.0,
                       0,
                       true};
  output.emit = [this](const device::Sound& sound, const std_msgs::Header& header) {
    field_->publishDrive(sound, header);
  };
  output.show = [this](const device::Sound& sound, const std_msgs::Header& header) {
    field_->publishFields(sound, header);
  };
  output.silence = [this](const std_msgs::Header& header) {
    // One silent drive for each frame that was refused, and one when the array goes silent by itself.
    if (ros::ok()) field_->publishSilence(header);
  };
  output.fault = [] { return std::string(); };
  array_ = std::make_unique<GatedArray>(nh, private_nh, simulated, false, std::move(output));
}

void SimulatedArray::startWire(ros::NodeHandle nh, ros::NodeHandle private_nh) {
  const auto count = static_cast<std::size_t>(paramIn(private_nh, "wire_boards", 1, 1, 2));
  const auto firmware = param<std::string>(private_nh, "wire_firmware", "stock");
  if (firmware != "stock" && firmware != "tactile")
    throw std::runtime_error("parameter " + private_nh.resolveName("wire_firmware") +
                             ": expected 'stock' or 'tactile', got '" + firmware + "'");
  model_.layout = boards(count, poseParam(private_nh, "wire_second_board", "0.168 0 0 0 0 0"));
  field_ = std::make_unique<SoundField>(nh, private_nh, model_);
  wire_.state = nh.advertise<ArrayState>(topic::wire_state, 10);
  wire_.inbox = std::make_unique<Inbox>(private_nh);
  wire_.focal_points = wire_.inbox->subscribe<FocalPointArray>(
      nh, topic::focal_points, 1, [this](const FocalPointArray::ConstPtr& message) {
        // A message without points is left out: a pattern that is still on its way was made for the points
        // before it.
        if (!message->points.empty()) wire_.commanded = message;
      });
  wire_.terminal = std::make_unique<device::SonicSurfaceTerminal>(param<std::string>(private_nh, "wire", ""),
                                                                  count, firmware == "tactile");
  wire_.timer = nh.createWallTimer(wire_period, [this](const ros::WallTimerEvent&) { listen(); });
}

void SimulatedArray::listen() {
  const device::SonicSurfaceTerminal::State state = wire_.terminal->state();
  const bool sounds = !state.patterns.empty();
  if (!sounds && !wire_.sounds && state.swaps == wire_.swaps) return;
  wire_.swaps = state.swaps;
  std_msgs::Header header;
  header.stamp = ros::Time::now();
  header.frame_id = frame::array;
  device::Sound sound;
  sound.emission.modulation_frequency = state.frequency;
  if (wire_.commanded) sound.emission.points = toCore(wire_.commanded->points);
  for (const auto& pattern : state.patterns) {
    ultrasound::Part part;
    part.points = sound.emission.points;
    for (std::size_t k = 0; k < part.points.size(); ++k) part.which.push_back(k);
    part.instants = {sound.parts.size()};
    part.time = part.power = pattern.share;
    sound.parts.push_back({part, pattern.drive, {}});
  }
  if (sounds || wire_.sounds) field_->publish(sound, header);
  wire_.sounds = sounds;

  ArrayState message;
  message.header = header;
  message.device = "sonic_surface boards";
  message.emitting = sounds;
  if (!sounds) message.silent_reason = "all channels of the boards are off";
  message.frames_sent = static_cast<std::uint32_t>(state.swaps);
  message.frames_rejected = static_cast<std::uint32_t>(state.faults);
  double head = 0.0;
  for (const device::Sound::Part& part : sound.parts)
    head =
        std::max(head, ultrasound::headSpl(model_.layout, model_.acoustics, part.drive, model_.head_point));
  message.head_spl = static_cast<float>(head);
  wire_.state.publish(message);
}

}  // namespace tactile_clay::nodes
