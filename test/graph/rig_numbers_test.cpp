// The numbers that are plotted: each in the unit of its name.
#include "nodes/rig_numbers.h"

#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <cmath>
#include <cstring>

#include "nodes/conversions.h"

namespace tactile_clay::nodes {
namespace {

TEST(RigNumbers, AreNaNUntilTheyAreKnown) {
  const RigNumbers numbers = unknownNumbers();
  // All bytes after the header, as they are sent: no number is forgotten.
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(numbers));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, numbers);
  const std::size_t header = ros::serialization::serializationLength(numbers.header);
  ASSERT_EQ((bytes.size() - header) % 4, 0u);
  for (std::size_t at = header; at < bytes.size(); at += 4) {
    float number = 0.0f;
    std::memcpy(&number, &bytes[at], 4);
    EXPECT_TRUE(std::isnan(number)) << (at - header) / 4;
  }
}

TEST(RigNumbers, OfTheClay) {
  ClayStatus status;
  status.real_time_factor = 0.5f;
  status.stages = {"neighbours", "contact_search", "bonds", "setup", "iterations", "finish", "new"};
  status.stage_ms = {1, 2, 3, 4, 5, 6, 7};
  status.density_error_mean = 0.02f;
  status.active_particles = 11;
  status.contacts = 12;
  status.lumps = 13;
  status.crumbs = 14;
  status.bonds = 15;
  status.strays = 16;
  status.density_error_max = 0.5f;
  status.iterations = 1.5f;
  RigNumbers numbers = unknownNumbers();
  takeNumbers(status, numbers);
  EXPECT_EQ(numbers.real_time_factor, 0.5f);
  EXPECT_EQ(numbers.step_ms, 28.0f);
  EXPECT_EQ(numbers.step_neighbours_ms, 1.0f);
  EXPECT_EQ(numbers.step_contact_search_ms, 2.0f);
  EXPECT_EQ(numbers.step_bonds_ms, 3.0f);
  EXPECT_EQ(numbers.step_setup_ms, 4.0f);
  EXPECT_EQ(numbers.step_iterations_ms, 5.0f);
  EXPECT_EQ(numbers.step_finish_ms, 6.0f);
  EXPECT_EQ(numbers.solver_iterations, 1.5f);
  EXPECT_EQ(numbers.active_particles, 11.0f);
  EXPECT_EQ(numbers.particle_contacts, 12.0f);
  EXPECT_EQ(numbers.lumps, 13.0f);
  EXPECT_EQ(numbers.crumbs, 14.0f);
  EXPECT_EQ(numbers.bonds, 15.0f);
  EXPECT_EQ(numbers.strays, 16.0f);
  EXPECT_FLOAT_EQ(numbers.density_error_percent, 2.0f);
  EXPECT_FLOAT_EQ(numbers.density_error_highest_percent, 50.0f);
}

TEST(RigNumbers, OfTheTouch) {
  std::vector<contact::PressureSample> samples(3);
  samples[0] = {{0, 0, 0}, {0, 0, -1}, 3000.0f, 0.03f, 1e-5f, 1.0f};
  samples[1] = {{0, 0, 0}, {0, 0, -1}, 5000.0f, 0.10f, 2e-5f, 1.0f};
  samples[2] = {{0, 0, 0}, {0, 0, -1}, 0.0f, 0.0f, 4e-5f, 1.0f};  // bare skin around a contact
  RigNumbers numbers = unknownNumbers();
  takeNumbers(*pressureCloud(samples, std_msgs::Header()), numbers);
  EXPECT_FLOAT_EQ(numbers.wanted_pressure_highest_kPa, 5.0f);
  EXPECT_FLOAT_EQ(numbers.wanted_force_N, 0.13f);
  EXPECT_FLOAT_EQ(numbers.touching_skin_cm2, 0.3f);
}

TEST(RigNumbers, OfTheArray) {
  RenderingReport report;
  report.gain = 0.002f;
  report.error = 0.25f;
  report.weighted_error = 0.125f;
  report.saturated_points = 2;
  report.force = 3.0f;
  report.vibration = 8.0f;
  report.static_force = 20.0f;
  report.granted = {1, 2, 3};
  ArrayState state;
  state.header.stamp = ros::Time(7.0);
  state.latency = 0.012f;
  state.head_spl = 98.0f;
  state.emitting = true;
  state.frames_late = 4;
  state.frames_rejected = 5;
  RigNumbers numbers = unknownNumbers();
  takeNumbers(report, numbers);
  takeNumbers(state, numbers);
  EXPECT_FLOAT_EQ(numbers.rendered_gain_Pa_per_kPa, 2.0f);
  EXPECT_FLOAT_EQ(numbers.rendered_error_percent, 25.0f);
  EXPECT_FLOAT_EQ(numbers.weighted_error_percent, 12.5f);
  EXPECT_EQ(numbers.saturated_points, 2.0f);
  EXPECT_EQ(numbers.rendered_force_mN, 3.0f);
  EXPECT_EQ(numbers.vibration_dB, 8.0f);
  EXPECT_EQ(numbers.static_force_mN, 20.0f);
  EXPECT_EQ(numbers.focal_points, 3.0f);
  EXPECT_FLOAT_EQ(numbers.hand_to_array_latency_ms, 12.0f);
  EXPECT_EQ(numbers.head_level_dB, 98.0f);
  EXPECT_EQ(numbers.array_sounds, 1.0f);
  EXPECT_EQ(numbers.frames_late, 4.0f);
  EXPECT_EQ(numbers.frames_rejected, 5.0f);
  EXPECT_EQ(numbers.header.stamp, ros::Time(7.0));
}

}  // namespace
}  // namespace tactile_clay::nodes
