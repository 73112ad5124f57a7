#include "nodes/hand_surface.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "hand/hand_check.h"
#include "hand/hand_shape.h"
#include "hand/hand_sides.h"
#include "nodes/cloud.h"
#include "nodes/color_bar.h"
#include "nodes/conversions.h"
#include "nodes/frame_name.h"
#include "nodes/params.h"
#include "nodes/placement.h"
#include "nodes/surface_markers.h"
#include "nodes/topics.h"
#include "surface/cut_mesh.h"
#include "surface/samples_on_mesh.h"
#include "values/text.h"

namespace tactile_clay::nodes {
namespace {

using Eigen::Vector3f;
using visualization_msgs::Marker;

constexpr double cell = 0.0040;  // m, of the hands' meshes
// If samples are 4 to 5 mm apart, a corner has about ten within this reach, with a sum of weights of 3.
constexpr float paint_reach = 0.007f, full_weight = 2.0f;  // m
constexpr float bend_reach = 0.010f;                       // m, for the displacement of a soft hand
// m, by which skin that touches is drawn inside of the hand: the drawn surface of the clay would hide it.
constexpr float inset = 0.003f;
// Of the rest of a hand that touches, from this share of the full scale on. Below, it changes gradually.
constexpr float touching_alpha = 0.30f, transparent_from = 0.10f;
constexpr float tracked_alpha = 0.22f;
// m, of the colour bar: so far beside the table that in the default view of rviz hands seldom cover it.
const Vector3f bar_foot(0.10f, 0.30f, 0.01f);
constexpr float bar_height = 0.13f;

const Vector3f tracked_color(0.35f, 0.50f, 0.95f);

// Further capsules of the heel, for display only: the hand that the clay meets has notches between these
// joints, up to 6 mm deep.
constexpr std::array<std::array<hand::Joint, 2>, 3> heel = {
    {{hand::wrist, hand::little_metacarpal},
     {hand::wrist, hand::thumb_metacarpal},
     {hand::index_metacarpal, hand::thumb_metacarpal}}};

std::vector<hand::Capsule> capsulesOf(const hand::TrackedHand& hand) {
  std::vector<hand::Capsule> capsules;
  const auto add = [&](hand::Joint from, hand::Joint to) {
    if (!hand.missing[from] && !hand.missing[to])
      capsules.push_back(hand::boneCapsule({from, to, hand::palm, hand::palm}, hand));
  };
  for (const hand::Bone& bone : hand::bones) add(bone.from, bone.to);
  for (const auto& [from, to] : heel) add(from, to);
  return capsules;
}

/// Positions of the skin. Those inside of the drawn capsules are moved along their normals to the surface of
/// these.
std::vector<Vector3f> onDrawnSkin(std::vector<Vector3f> places, const std::vector<Vector3f>& normals,
                                  const std::vector<hand::Capsule>& capsules) {
  constexpr int steps = 4;  // each is as long as the distance to the surface, so never too long
  for (std::size_t i = 0; i < places.size(); ++i)
    for (int step = 0; step < steps; ++step) {
      const double distance = hand::distanceToUnion(capsules, places[i].cast<double>());
      if (distance >= 0.0) break;
      places[i] -= static_cast<float>(distance) * normals[i];
    }
  return places;
}

/// Skin samples of one side, at their positions on the tracked hand.
struct Samples {
  std::vector<Vector3f> position, normal, displacement;  // m; unit; m, to the place where the clay meets it
};

Samples samplesOf(const sensor_msgs::PointCloud2& skin, hand::Side side) {
  Samples samples;
  const auto which = column<std::uint32_t>(skin, "hand");
  const Skin all = pressureSkin(skin);
  if (all.isTracked()) return samples;
  for (std::size_t i = 0; i < all.position.size(); ++i) {
    if (which[i] != static_cast<std::uint32_t>(side)) continue;
    samples.position.push_back(all.tracked_position[i]);
    samples.normal.push_back(all.tracked_normal[i]);
    samples.displacement.push_back(all.position[i] - all.tracked_position[i]);
  }
  return samples;
}

/// Markers of the skin of one hand. Skin that touches is opaque, in the colours of its pressure, and drawn a
/// little inside of the hand. While some skin touches, the rest of the hand is transparent, so that contacts
/// are seen through it.
/// @param share of the full scale, at each corner
void addSkin(visualization_msgs::MarkerArray& markers, surface::TriangleMesh mesh,
             const std::vector<float>& share, const std_msgs::Header& header, int side) {
  std::vector<float> touches(mesh.position.size());  // above 0: touches
  float strongest = 0.0f;
  mesh.color.resize(mesh.position.size());
  for (std::size_t c = 0; c < mesh.position.size(); ++c) {
    strongest = std::max(strongest, share[c]);
    mesh.color[c] = painted(share[c], lit(skinColor(), mesh.normal[c]));
    touches[c] = std::min(share[c] / touch_share - 1.0f, 1.0f);
    mesh.position[c] -= std::max(touches[c], 0.0f) * inset * mesh.normal[c];
  }
  const float alpha = 1.0f - (1.0f - touching_alpha) * std::min(1.0f, strongest / transparent_from);
  const auto& [all, rest, touching] = surface::cut(mesh, touches);
  markers.markers.push_back(surfaceMarker(all, all.color, rest, alpha, header, "skin", side));
  markers.markers.push_back(surfaceMarker(all, all.color, touching, 1.0f, header, "skin that touches", side));
}

}  // namespace

HandSurface::HandSurface(ros::NodeHandle nh, ros::NodeHandle private_nh)
    : nh_(nh),
      world_(frameName(param<std::string>(private_nh, "world_frame", frame::world))),
      full_scale_(paramIn(private_nh, "full_scale", 40.0, 0.1, 1000.0)),
      surfaces_{surface::CapsuleSurface(cell), surface::CapsuleSurface(cell)},
      inbox_(private_nh),
      rendered_(nh, private_nh, world_, [this] { news_ = true; }),
      health_(nh, private_nh, "hand surface", [this](auto& status) { diagnose(status); }) {
  publisher_ = nh.advertise<visualization_msgs::MarkerArray>(topic::hands_surface, 1);
  timer_ = nh.createWallTimer(ros::WallDuration(1.0 / paramIn(private_nh, "rate", 30.0, 1.0, 240.0)),
                              [this](const ros::WallTimerEvent&) { look(); });
}

void HandSurface::subscribe() {
  if (tracked_subscriber_) return;
  tracked_subscriber_ =
      inbox_.subscribe<TrackedHands>(nh_, topic::hands_tracked, 1, [this](const auto& message) {
        tracked_ = message;
        news_ = true;
      });
  skin_subscriber_ =
      inbox_.subscribe<Cloud>(nh_, topic::hands_skin, 1, [this](const auto& cloud) { skin_ = cloud; });
  pressure_subscriber_ = inbox_.subscribe<Cloud>(nh_, topic::hands_pressure, 1, [this](const auto& cloud) {
    pressure_ = cloud;
    news_ = true;
  });
}

void HandSurface::look() {
  if (rendered_.wanted())
    rendered_.subscribe(inbox_);
  else
    rendered_.unsubscribe();
  if (publisher_.getNumSubscribers() == 0 && !rendered_.wanted()) {
    for (ros::Subscriber* subscriber : {&tracked_subscriber_, &skin_subscriber_, &pressure_subscriber_})
      subscriber->shutdown();
    tracked_.reset();
    skin_.reset();
    pressure_.reset();
    news_ = false;
    return;
  }
  subscribe();
  if (!news_ || !tracked_ || !pace_.isDue(ros::SteadyTime::now())) return;
  news_ = false;
  try {
    show();
  } catch (const std::exception& error) {
    ROS_WARN_THROTTLE(5.0, "hand_surface: hands left out: %s", values::printableLine(error.what()).c_str());
  }
}

Touch HandSurface::touching() {
  Touch touch;
  if (!pressure_) return touch;
  const auto samples = pressureSamples(*pressure_);
  const auto array =
      samples.empty() ? std::nullopt : transforms_.lookup(world_, frameName(pressure_->header.frame_id));
  for (const contact::PressureSample& sample : samples) {
    if (!array) break;
    touch.position.push_back(array->cast<float>() * sample.position);
    touch.normal.push_back(array->linear().cast<float>() * sample.normal);
    touch.pressure.push_back(sample.pressure);
  }
  return touch;
}

void HandSurface::show() {
  const auto start = ros::SteadyTime::now();
  hand::TrackedFrame frame = toCore(*tracked_);
  placeInWorld(frame, world_, transforms_);
  hand::leaveOutBadHands(frame.hands);
  hand::keepOneHandASide(frame.hands);
  const Touch touch_now = touching();
  const auto full_scale = static_cast<float>(1e3 * full_scale_);
  std_msgs::Header header;
  header.stamp = tracked_->header.stamp;
  header.frame_id = world_;
  std::array<PaintedHand, 2> hands;
  visualization_msgs::MarkerArray markers;
  for (const hand::Side side : {hand::Side::left, hand::Side::right}) {
    const int s = static_cast<int>(side);
    const auto found = std::find_if(frame.hands.begin(), frame.hands.end(),
                                    [side](const hand::TrackedHand& hand) { return hand.side == side; });
    surface::TriangleMesh& mesh = hands[s].mesh;
    const std::vector<hand::Capsule> capsules =
        found != frame.hands.end() ? capsulesOf(*found) : std::vector<hand::Capsule>();
    if (!capsules.empty()) mesh = surfaces_[s].update(capsules);
    hands[s].pressure = surface::sparseMeanAt(
        surface::sampleWeights(mesh, onDrawnSkin(touch_now.position, touch_now.normal, capsules),
                               touch_now.normal, paint_reach),
        touch_now.pressure, full_weight);
    hands[s].pressure.resize(mesh.position.size(), 0.0f);
    if (publisher_.getNumSubscribers() == 0) continue;
    std::vector<float> share = hands[s].pressure;
    for (float& part : share) part /= full_scale;
    const Samples samples = skin_ ? samplesOf(*skin_, side) : Samples();
    surface::TriangleMesh bent = mesh;
    if (!samples.position.empty()) {
      const auto moved = surface::meanAt(
          surface::sampleWeights(mesh, samples.position, samples.normal, bend_reach), samples.displacement);
      for (std::size_t c = 0; c < bent.position.size(); ++c) bent.position[c] += moved[c];
      setNormals(bent);
    }
    addSkin(markers, bent, share, header, s);
    // The tracked hand beside the one that the clay meets.
    surface::TriangleMesh tracked = mesh;
    tracked.color.assign(tracked.position.size(), tracked_color);
    if (samples.position.empty()) tracked.triangles.clear();
    markers.markers.push_back(
        surfaceMarker(tracked, lit(tracked), tracked.triangles, tracked_alpha, header, "tracked hand", s));
  }
  if (publisher_.getNumSubscribers() > 0) {
    addColorBar(
        markers,
        {"pressure, kPa", "pressure on the skin, kPa", full_scale_, bar_foot, Vector3f(-0.006f, 0.013f, 0.0f),
         Vector3f(0.0f, 0.0f, bar_height), bar_foot + Vector3f(0.0f, 0.0f, 1.14f * bar_height)},
        world_);
    publisher_.publish(markers);
  }
  if (rendered_.wanted()) rendered_.publish(hands, touch_now, skin_.get(), header, transforms_);
  const auto end = ros::SteadyTime::now();
  times_.add((end - start).toSec());
  pace_.worked(start, end);
}

void HandSurface::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  status.summary(Level::OK,
                 tracked_subscriber_ ? times_.frames > 0 ? "showing" : "no hands" : "no subscriber");
  times_.report(status);
  times_ = {};
  inbox_.report(status);
}

}  // namespace tactile_clay::nodes
