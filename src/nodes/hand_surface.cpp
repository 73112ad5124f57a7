#include "nodes/hand_surface.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "hand/hand_check.h"
#include "hand/hand_shape.h"
#include "nodes/cloud.h"
#include "nodes/conversions.h"
#include "nodes/frame_name.h"
#include "nodes/params.h"
#include "nodes/placement.h"
#include "nodes/surface_markers.h"
#include "nodes/throttle.h"
#include "nodes/topics.h"
#include "surface/samples_on_mesh.h"

namespace tactile_clay::nodes {
namespace {

using Eigen::Vector3f;
using visualization_msgs::Marker;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

constexpr double cell = 0.0032;  // m, of the hands' meshes
// Of samples that are 4 to 5 mm apart a corner has some ten within this reach, with weights of 3 together.
constexpr float paint_reach = 0.007f, full_weight = 2.0f;  // m
constexpr float bend_reach = 0.010f;                       // m, of the displacement of a soft hand
constexpr float window_radius = 0.045f;  // m, about skin that touches: thicker than the ball of a thumb
constexpr float window_alpha = 0.30f, tracked_alpha = 0.22f;
constexpr float touch = 0.02f;  // share of the full scale from which skin touches

const Vector3f skin_color(0.89f, 0.70f, 0.58f), tracked_color(0.35f, 0.50f, 0.95f);

/// Stops of the colours of pressure, at equal distances from 0 to the full scale. They grow darker towards
/// it, so that they are also told apart in grey.
const std::array<Vector3f, 4> pressure_colors = {Vector3f(1.0f, 0.93f, 0.45f), Vector3f(1.0f, 0.62f, 0.10f),
                                                 Vector3f(0.86f, 0.14f, 0.16f), Vector3f(0.38f, 0.0f, 0.22f)};

Vector3f pressureColor(float share) {
  const float at = 3.0f * std::clamp(share, 0.0f, 1.0f);
  const int below = std::min(2, static_cast<int>(at));
  const float t = at - static_cast<float>(below);
  return (1.0f - t) * pressure_colors[below] + t * pressure_colors[below + 1];
}

std::vector<hand::Capsule> capsulesOf(const hand::TrackedHand& hand) {
  std::vector<hand::Capsule> capsules;
  for (const hand::Bone& bone : hand::bones)
    if (!hand.missing[bone.from] && !hand.missing[bone.to]) capsules.push_back(hand::boneCapsule(bone, hand));
  return capsules;
}

/// Samples of the skin of one side, where the tracked hand has them.
struct Samples {
  std::vector<Vector3f> position, normal, displacement;  // m, unit, m: to where the clay meets them
};

Samples samplesOf(const sensor_msgs::PointCloud2& skin, hand::Side side) {
  Samples samples;
  const auto which = column<std::uint32_t>(skin, "hand");
  const PressureSkin all = pressureSkin(skin);
  if (!all.felt) return samples;
  for (std::size_t i = 0; i < all.position.size(); ++i) {
    if (which[i] != static_cast<std::uint32_t>(side)) continue;
    samples.position.push_back(all.felt->position[i]);
    samples.normal.push_back(all.felt->normal[i]);
    samples.displacement.push_back(all.position[i] - all.felt->position[i]);
  }
  return samples;
}

struct Pressure {
  std::vector<Vector3f> position, normal;  // m, unit, in world
  std::vector<float> share;                // of the full scale
};

Marker label(const std_msgs::Header& header, int id, const Vector3f& at, const std::string& text) {
  Marker marker;
  marker.header = header;
  marker.ns = "pressure, kPa";
  marker.id = id;
  marker.type = Marker::TEXT_VIEW_FACING;
  marker.pose.position.x = at.x(), marker.pose.position.y = at.y(), marker.pose.position.z = at.z();
  marker.pose.orientation.w = 1.0;
  marker.scale.z = 0.012;
  marker.color.r = marker.color.g = marker.color.b = 0.1f;
  marker.color.a = 1.0f;
  marker.text = text;
  return marker;
}

/// An upright bar beside the table with the colours of pressure, and numbers in kPa.
void addColorBar(visualization_msgs::MarkerArray& markers, double full_scale, std_msgs::Header header) {
  constexpr int pieces = 48, numbers = 5;
  const Vector3f foot(0.10f, 0.205f, 0.01f), width(-0.006f, 0.013f, 0.0f), height(0.0f, 0.0f, 0.13f);
  header.stamp = ros::Time();
  surface::TriangleMesh bar;
  for (int k = 0; k <= pieces; ++k) {
    const float share = static_cast<float>(k) / pieces;
    for (const float side : {-0.5f, 0.5f}) {
      bar.position.push_back(foot + side * width + share * height);
      bar.color.push_back(pressureColor(share));
    }
    if (k == 0) continue;
    const auto n = static_cast<std::uint32_t>(2 * k);
    bar.triangles.push_back({n - 2, n - 1, n});
    bar.triangles.push_back({n - 1, n + 1, n});
  }
  markers.markers.push_back(surfaceMarker(bar, bar.color, bar.triangles, 1.0f, header, "pressure, kPa", 0));
  for (int k = 0; k < numbers; ++k) {
    const float share = static_cast<float>(k) / (numbers - 1);
    char text[32];
    std::snprintf(text, sizeof text, "%g", full_scale * static_cast<double>(share));
    markers.markers.push_back(label(header, 1 + k, foot + 1.5f * width + share * height, text));
  }
  markers.markers.push_back(label(header, 1 + numbers, foot + 1.14f * height, "pressure on the skin, kPa"));
}

/// Skin of one hand: opaque where it touches and far from there, a window between.
void addSkin(visualization_msgs::MarkerArray& markers, const surface::TriangleMesh& mesh,
             const std::vector<float>& pressure, const Pressure& touching, const std_msgs::Header& header,
             int side) {
  std::vector<Vector3f> color(mesh.position.size());
  std::vector<char> touched(mesh.position.size(), 0), near(mesh.position.size(), 0);
  for (std::size_t c = 0; c < mesh.position.size(); ++c) {
    const float share = c < pressure.size() ? pressure[c] : 0.0f;
    touched[c] = share > touch;
    // The colours of pressure rise out of the skin's.
    const float blend = std::min(1.0f, share / (4.0f * touch));
    color[c] = (1.0f - blend) * lit(skin_color, mesh.normal[c]) + blend * pressureColor(share);
  }
  std::vector<std::size_t> seeds;
  for (std::size_t s = 0; s < touching.position.size(); ++s)
    if (touching.share[s] > touch) seeds.push_back(s);
  for (std::size_t c = 0; !seeds.empty() && c < mesh.position.size(); ++c)
    near[c] = std::any_of(seeds.begin(), seeds.end(), [&](std::size_t s) {
      return (touching.position[s] - mesh.position[c]).squaredNorm() < window_radius * window_radius;
    });
  Triangles opaque, window;
  for (const auto& t : mesh.triangles) {
    const bool touches = touched[t[0]] || touched[t[1]] || touched[t[2]];
    (!touches && near[t[0]] && near[t[1]] && near[t[2]] ? window : opaque).push_back(t);
  }
  markers.markers.push_back(surfaceMarker(mesh, color, opaque, 1.0f, header, "skin", side));
  markers.markers.push_back(
      surfaceMarker(mesh, color, window, window_alpha, header, "skin over a contact", side));
}

}  // namespace

HandSurface::HandSurface(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : nh_(nh),
      world_(frameName(param<std::string>(private_nh, "world_frame", frame::world))),
      full_scale_(paramIn(private_nh, "full_scale", 40.0, 0.1, 1000.0)),
      surfaces_{surface::CapsuleSurface(cell), surface::CapsuleSurface(cell)},
      inbox_(private_nh),
      health_(nh, private_nh, "hand surface", [this](auto& status) { diagnose(status); }) {
  publisher_ = nh.advertise<visualization_msgs::MarkerArray>(topic::hands_surface, 1);
  timer_ = nh.createWallTimer(ros::WallDuration(1.0 / paramIn(private_nh, "rate", 30.0, 1.0, 240.0)),
                              [this](const ros::WallTimerEvent&) { look(); });
}

void HandSurface::look() {
  if (publisher_.getNumSubscribers() == 0) {
    for (ros::Subscriber* subscriber : {&tracked_subscriber_, &skin_subscriber_, &pressure_subscriber_})
      subscriber->shutdown();
    tracked_.reset(), skin_.reset(), pressure_.reset();
    news_ = false;
    return;
  }
  if (!tracked_subscriber_) {
    tracked_subscriber_ = inbox_.subscribe<TrackedHands>(
        nh_, topic::hands_tracked, 1, [this](const auto& message) { tracked_ = message, news_ = true; });
    skin_subscriber_ =
        inbox_.subscribe<Cloud>(nh_, topic::hands_skin, 1, [this](const auto& cloud) { skin_ = cloud; });
    pressure_subscriber_ = inbox_.subscribe<Cloud>(
        nh_, topic::hands_pressure, 1, [this](const auto& cloud) { pressure_ = cloud, news_ = true; });
  }
  if (!news_ || !tracked_) return;
  news_ = false;
  try {
    show();
  } catch (const std::exception& error) {
    ROS_WARN_THROTTLE(5.0, "hand_surface: hands left out: %s", oneLine(error.what()).c_str());
  }
}

void HandSurface::show() {
  const auto start = ros::SteadyTime::now();
  hand::TrackedFrame frame = toCore(*tracked_);
  placeInWorld(frame, world_, transforms_);
  hand::leaveOutBadHands(frame.hands);
  hand::keepOneHandASide(frame.hands);
  Pressure touching;
  if (pressure_) {
    const auto samples = pressureSamples(*pressure_);
    const auto array =
        samples.empty() ? std::nullopt : transforms_.lookup(world_, frameName(pressure_->header.frame_id));
    for (const contact::PressureSample& sample : samples) {
      if (!array) break;
      touching.position.push_back(array->cast<float>() * sample.position);
      touching.normal.push_back(array->linear().cast<float>() * sample.normal);
      touching.share.push_back(sample.pressure / static_cast<float>(1e3 * full_scale_));
    }
  }
  std_msgs::Header header;
  header.stamp = tracked_->header.stamp;
  header.frame_id = world_;
  visualization_msgs::MarkerArray markers;
  for (const hand::Side side : {hand::Side::left, hand::Side::right}) {
    const int s = static_cast<int>(side);
    const auto found = std::find_if(frame.hands.begin(), frame.hands.end(),
                                    [side](const hand::TrackedHand& hand) { return hand.side == side; });
    surface::TriangleMesh mesh, bent;
    if (found != frame.hands.end()) mesh = surfaces_[s].update(capsulesOf(*found));
    const auto pressure =
        surface::sparseMeanAt(surface::sampleWeights(mesh, touching.position, touching.normal, paint_reach),
                              touching.share, full_weight);
    const Samples samples = skin_ ? samplesOf(*skin_, side) : Samples();
    if (samples.position.empty()) {
      addSkin(markers, mesh, pressure, touching, header, s);
    } else {
      bent = mesh;
      const auto moved = surface::meanAt(
          surface::sampleWeights(mesh, samples.position, samples.normal, bend_reach), samples.displacement);
      for (std::size_t c = 0; c < bent.position.size(); ++c) bent.position[c] += moved[c];
      setNormals(bent);
      addSkin(markers, bent, pressure, touching, header, s);
    }
    // The tracked hand beside the one that the clay meets.
    mesh.color.assign(mesh.position.size(), tracked_color);
    if (samples.position.empty()) mesh.triangles.clear();
    markers.markers.push_back(
        surfaceMarker(mesh, lit(mesh), mesh.triangles, tracked_alpha, header, "tracked hand", s));
  }
  addColorBar(markers, full_scale_, header);
  publisher_.publish(markers);
  ++frames_;
  time_ += (ros::SteadyTime::now() - start).toSec();
}

void HandSurface::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  status.summary(Level::OK, tracked_subscriber_ ? frames_ > 0 ? "showing" : "no hands" : "nobody looks");
  status.add("frames", frames_);
  status.add("time for a frame, mean, ms", frames_ > 0 ? 1e3 * time_ / frames_ : 0.0);
  frames_ = 0;
  time_ = 0.0;
  inbox_.report(status);
}

}  // namespace tactile_clay::nodes
