#include "nodes/hand_surface.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "hand/hand_check.h"
#include "hand/hand_shape.h"
#include "nodes/array_markers.h"
#include "nodes/array_model.h"
#include "nodes/cloud.h"
#include "nodes/color_bar.h"
#include "nodes/conversions.h"
#include "nodes/frame_name.h"
#include "nodes/params.h"
#include "nodes/placement.h"
#include "nodes/surface_markers.h"
#include "nodes/throttle.h"
#include "nodes/topics.h"
#include "surface/samples_on_mesh.h"
#include "ultrasound/acoustic_field.h"
#include "ultrasound/field_solver.h"

namespace tactile_clay::nodes {
namespace {

using Eigen::Vector3f;
using visualization_msgs::Marker;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

constexpr double cell = 0.0040;  // m, of the hands' meshes
// Of samples that are 4 to 5 mm apart a corner has some ten within this reach, with weights of 3 together.
constexpr float paint_reach = 0.007f, full_weight = 2.0f;  // m
constexpr float bend_reach = 0.010f;                       // m, of the displacement of a soft hand
constexpr float window_radius = 0.045f;  // m, about skin that touches: thicker than the ball of a thumb
constexpr float window_alpha = 0.30f, tracked_alpha = 0.22f;
constexpr float touch = 0.02f;  // share of the full scale from which skin touches

// Where hands/rendered stands, in world, m: wanted on the left of who sits at the table, given on the right.
const Vector3f rendered_about(0.0f, 0.0f, 0.03f), rendered_at(0.28f, 0.0f, 0.17f);
constexpr float rendered_aside = 0.17f;
constexpr float counted = 0.06f;    // m from a contact, of the skin that the error is about
constexpr float forgotten = 0.98f;  // what a frame leaves of the highest pressure of those before

const Vector3f skin_color(0.89f, 0.70f, 0.58f), tracked_color(0.35f, 0.50f, 0.95f);

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

/// \param share of the full scale; the colours of pressure rise out of the skin's
Vector3f painted(float share, const Vector3f& skin) {
  const float blend = std::min(1.0f, share / (4.0f * touch));
  return (1.0f - blend) * skin + blend * pressureColor(share);
}

bool isNear(const Vector3f& at, const std::vector<Vector3f>& places, float reach) {
  return std::any_of(places.begin(), places.end(),
                     [&](const Vector3f& place) { return (place - at).squaredNorm() < reach * reach; });
}

/// 1, 2 or 5 times a power of ten, the smallest that is not below the value.
double roundScale(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(std::max(value, 1e-3))));
  for (const double step : {1.0, 2.0, 5.0})
    if (value <= step * power) return step * power;
  return 10.0 * power;
}

/// Skin of one hand: opaque where it touches and far from there, a window between.
void addSkin(visualization_msgs::MarkerArray& markers, const surface::TriangleMesh& mesh,
             const std::vector<float>& pressure, const std::vector<Vector3f>& touching,
             const std_msgs::Header& header, int side) {
  std::vector<Vector3f> color(mesh.position.size());
  std::vector<char> touched(mesh.position.size(), 0), near(mesh.position.size(), 0);
  for (std::size_t c = 0; c < mesh.position.size(); ++c) {
    touched[c] = pressure[c] > touch;
    color[c] = painted(pressure[c], lit(skin_color, mesh.normal[c]));
    near[c] = isNear(mesh.position[c], touching, window_radius);
  }
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
  Settings settings(private_nh);
  acoustics_ = acousticsOf(settings);
  publisher_ = nh.advertise<visualization_msgs::MarkerArray>(topic::hands_surface, 1);
  rendered_publisher_ = nh.advertise<visualization_msgs::MarkerArray>(topic::hands_rendered, 1);
  timer_ = nh.createWallTimer(ros::WallDuration(1.0 / paramIn(private_nh, "rate", 30.0, 1.0, 240.0)),
                              [this](const ros::WallTimerEvent&) { look(); });
}

void HandSurface::subscribe(bool rendered) {
  if (!tracked_subscriber_) {
    tracked_subscriber_ = inbox_.subscribe<TrackedHands>(
        nh_, topic::hands_tracked, 1, [this](const auto& message) { tracked_ = message, news_ = true; });
    skin_subscriber_ =
        inbox_.subscribe<Cloud>(nh_, topic::hands_skin, 1, [this](const auto& cloud) { skin_ = cloud; });
    pressure_subscriber_ = inbox_.subscribe<Cloud>(
        nh_, topic::hands_pressure, 1, [this](const auto& cloud) { pressure_ = cloud, news_ = true; });
  }
  if (rendered && !drive_subscriber_) {
    drive_subscriber_ = inbox_.subscribe<ArrayDrive>(nh_, topic::array_drive, ultrasound::most_patterns,
                                                     [this](const auto& message) {
                                                       played_.add(*message);
                                                       news_ = true;
                                                     });
    geometry_subscriber_ = inbox_.subscribe<visualization_msgs::MarkerArray>(
        nh_, topic::array_geometry, 1, [this](const auto& markers) { layout_ = layoutOf(*markers); });
  } else if (!rendered) {
    drive_subscriber_.shutdown();
    geometry_subscriber_.shutdown();
    played_.clear();
  }
}

void HandSurface::look() {
  const bool rendered = rendered_publisher_.getNumSubscribers() > 0;
  if (publisher_.getNumSubscribers() == 0 && !rendered) {
    for (ros::Subscriber* subscriber : {&tracked_subscriber_, &skin_subscriber_, &pressure_subscriber_,
                                        &drive_subscriber_, &geometry_subscriber_})
      subscriber->shutdown();
    tracked_.reset(), skin_.reset(), pressure_.reset();
    played_.clear();
    news_ = false;
    return;
  }
  subscribe(rendered);
  if (!news_ || !tracked_) return;
  news_ = false;
  try {
    show();
  } catch (const std::exception& error) {
    ROS_WARN_THROTTLE(5.0, "hand_surface: hands left out: %s", oneLine(error.what()).c_str());
  }
}

HandSurface::Touch HandSurface::touching() {
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
  std::vector<Vector3f> pressed;
  for (std::size_t s = 0; s < touch_now.position.size(); ++s)
    if (touch_now.pressure[s] > touch * full_scale) pressed.push_back(touch_now.position[s]);
  std_msgs::Header header;
  header.stamp = tracked_->header.stamp;
  header.frame_id = world_;
  std::array<Painted, 2> hands;
  visualization_msgs::MarkerArray markers;
  for (const hand::Side side : {hand::Side::left, hand::Side::right}) {
    const int s = static_cast<int>(side);
    const auto found = std::find_if(frame.hands.begin(), frame.hands.end(),
                                    [side](const hand::TrackedHand& hand) { return hand.side == side; });
    surface::TriangleMesh& mesh = hands[s].mesh;
    if (found != frame.hands.end()) mesh = surfaces_[s].update(capsulesOf(*found));
    hands[s].pressure =
        surface::sparseMeanAt(surface::sampleWeights(mesh, touch_now.position, touch_now.normal, paint_reach),
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
    addSkin(markers, bent, share, pressed, header, s);
    // The tracked hand beside the one that the clay meets.
    surface::TriangleMesh tracked = mesh;
    tracked.color.assign(tracked.position.size(), tracked_color);
    if (samples.position.empty()) tracked.triangles.clear();
    markers.markers.push_back(
        surfaceMarker(tracked, lit(tracked), tracked.triangles, tracked_alpha, header, "tracked hand", s));
  }
  if (publisher_.getNumSubscribers() > 0) {
    addColorBar(markers,
                {"pressure, kPa", "pressure on the skin, kPa", full_scale_, Vector3f(0.10f, 0.205f, 0.01f),
                 Vector3f(-0.006f, 0.013f, 0.0f), Vector3f(0.0f, 0.0f, 0.13f)},
                world_);
    publisher_.publish(markers);
  }
  if (rendered_publisher_.getNumSubscribers() > 0)
    rendered_publisher_.publish(rendered(hands, touch_now, header));
  ++frames_;
  time_ += (ros::SteadyTime::now() - start).toSec();
}

/// Radiation pressure at the corners, Pa. \param facing set to whether a corner faces the array; the others
/// lie in the shadow of the hand
std::vector<float> HandSurface::given(const surface::TriangleMesh& mesh, std::vector<char>& facing) {
  std::vector<float> pressure(mesh.position.size(), 0.0f);
  facing.assign(mesh.position.size(), 0);
  if (played_.drives().empty() || mesh.position.empty()) return pressure;
  const auto pose = transforms_.lookup(frameName(played_.frame()), world_);
  if (!pose) return pressure;
  const Eigen::Isometry3f to_array = pose->cast<float>();
  std::vector<Vector3f> places;
  std::vector<std::size_t> which;
  for (std::size_t c = 0; c < mesh.position.size(); ++c) {
    const Vector3f at = to_array * mesh.position[c];
    facing[c] = at.dot(to_array.linear() * mesh.normal[c]) < 0.0f;
    if (!facing[c]) continue;
    places.push_back(at);
    which.push_back(c);
  }
  const auto amplitude = ultrasound::meanAmplitudesAt(layout_, acoustics_, played_.drives(), places);
  for (std::size_t k = 0; k < which.size(); ++k)
    pressure[which[k]] =
        static_cast<float>(ultrasound::radiationPressure(acoustics_, static_cast<double>(amplitude[k])));
  return pressure;
}

visualization_msgs::MarkerArray HandSurface::rendered(const std::array<Painted, 2>& hands,
                                                      const Touch& touch_now,
                                                      const std_msgs::Header& header) {
  std::array<std::vector<float>, 2> gives;
  std::vector<double> wants_amplitude, gives_amplitude;  // of the skin around contacts, for the error
  highest_wanted_ *= forgotten, highest_given_ *= forgotten;
  for (std::size_t s = 0; s < hands.size(); ++s) {
    std::vector<char> facing;
    gives[s] = given(hands[s].mesh, facing);
    for (std::size_t c = 0; c < gives[s].size(); ++c) {
      highest_wanted_ = std::max(highest_wanted_, hands[s].pressure[c]);
      highest_given_ = std::max(highest_given_, gives[s][c]);
      if (!facing[c] || !isNear(hands[s].mesh.position[c], touch_now.position, counted)) continue;
      wants_amplitude.push_back(std::sqrt(static_cast<double>(hands[s].pressure[c])));
      gives_amplitude.push_back(std::sqrt(static_cast<double>(gives[s][c])));
    }
  }
  // Tipped up about the axis from left to right, so that palms and not backs are seen.
  const Eigen::Matrix3f up =
      Eigen::AngleAxisf(static_cast<float>(M_PI_2), Vector3f::UnitY()).toRotationMatrix();
  const double kilo = 1e-3 * static_cast<double>(highest_wanted_);
  visualization_msgs::MarkerArray markers;
  for (const bool is_given : {false, true}) {
    const std::string name = is_given ? "given" : "wanted";
    const Vector3f at = rendered_at + Vector3f(0.0f, is_given ? -rendered_aside : rendered_aside, 0.0f);
    const double scale = roundScale(is_given ? static_cast<double>(highest_given_) : kilo);
    const double unit = is_given ? 1.0 : 1e3;
    for (std::size_t s = 0; s < hands.size(); ++s) {
      surface::TriangleMesh mesh = hands[s].mesh;
      const std::vector<float>& pressure = is_given ? gives[s] : hands[s].pressure;
      mesh.color.resize(mesh.position.size());
      for (std::size_t c = 0; c < mesh.position.size(); ++c) {
        mesh.position[c] = at + up * (mesh.position[c] - rendered_about);
        mesh.normal[c] = up * mesh.normal[c];
        mesh.color[c] =
            painted(pressure[c] / static_cast<float>(scale * unit), lit(skin_color, mesh.normal[c]));
      }
      markers.markers.push_back(
          surfaceMarker(mesh, mesh.color, mesh.triangles, 1.0f, header, name, static_cast<int>(s)));
    }
    std::string title = is_given ? "given by the array, Pa" : "wanted by the clay, kPa";
    if (is_given && played_.drives().empty())
      title += ": silent";
    else if (is_given && !touch_now.position.empty())
      title +=
          ": " +
          std::to_string(std::lround(100.0 * ultrasound::fieldFit(wants_amplitude, gives_amplitude).error)) +
          " % error";
    addColorBar(markers,
                {name, title, scale, at + Vector3f(0.0f, is_given ? -0.19f : 0.19f, -0.09f),
                 Vector3f(0.0f, is_given ? -0.014f : 0.014f, 0.0f), Vector3f(0.0f, 0.0f, 0.16f)},
                world_);
  }
  return markers;
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
