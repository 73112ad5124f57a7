#include "nodes/rendered_hands.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "nodes/array_markers.h"
#include "nodes/array_model.h"
#include "nodes/color_bar.h"
#include "nodes/frame_name.h"
#include "nodes/surface_markers.h"
#include "nodes/topics.h"
#include "ultrasound/acoustic_field.h"
#include "ultrasound/field_solver.h"

namespace tactile_clay::nodes {
namespace {

using Eigen::Vector3f;

// Where hands/rendered stands, in world, m: wanted on the left of who sits at the table, given on the right.
const Vector3f rendered_about(0.0f, 0.0f, 0.03f), rendered_at(0.28f, 0.0f, 0.17f);
constexpr float rendered_aside = 0.17f;
constexpr float counted = 0.06f;    // m from a contact, of the skin that the error is about
constexpr float forgotten = 0.98f;  // what a frame leaves of the highest pressure of those before

/// 1, 2 or 5 times a power of ten, the smallest that is not below the value.
double roundScale(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(std::max(value, 1e-3))));
  for (const double step : {1.0, 2.0, 5.0})
    if (value <= step * power) return step * power;
  return 10.0 * power;
}

/// Skin around each corner, m^2: a third of each of its triangles.
std::vector<float> cornerAreas(const surface::TriangleMesh& mesh) {
  std::vector<float> area(mesh.position.size(), 0.0f);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3f &x = mesh.position[a], &y = mesh.position[b], &z = mesh.position[c];
    const float third = (y - x).cross(z - x).norm() / 6.0f;
    for (const std::uint32_t corner : {a, b, c}) area[corner] += third;
  }
  return area;
}

}  // namespace

RenderedHands::RenderedHands(ros::NodeHandle nh, const ros::NodeHandle& private_nh, const std::string& world,
                             std::function<void()> news)
    : nh_(nh), world_(world), news_(std::move(news)) {
  Settings settings(private_nh);
  acoustics_ = acousticsOf(settings);
  publisher_ = nh.advertise<visualization_msgs::MarkerArray>(topic::hands_rendered, 1);
}

void RenderedHands::subscribe(Inbox& inbox) {
  if (drive_subscriber_) return;
  drive_subscriber_ = inbox.subscribe<ArrayDrive>(nh_, topic::array_drive, ultrasound::max_patterns,
                                                  [this](const auto& message) {
                                                    played_.add(*message);
                                                    news_();
                                                  });
  geometry_subscriber_ = inbox.subscribe<visualization_msgs::MarkerArray>(
      nh_, topic::array_geometry, 1, [this](const auto& markers) { layout_ = layoutOf(*markers); });
}

void RenderedHands::unsubscribe() {
  drive_subscriber_.shutdown();
  geometry_subscriber_.shutdown();
  played_.clear();
}

void RenderedHands::publish(const std::array<PaintedHand, 2>& hands, const Touch& touch,
                            const std_msgs::Header& header, Transforms& transforms) {
  publisher_.publish(markers(hands, touch, header, transforms));
}

/// Radiation pressure at the corners, Pa.
/// @param facing set to whether a corner faces the array; the others lie in the shadow of the hand
std::vector<float> RenderedHands::given(const surface::TriangleMesh& mesh, Transforms& transforms,
                                        std::vector<char>& facing) {
  std::vector<float> pressure(mesh.position.size(), 0.0f);
  facing.assign(mesh.position.size(), 0);
  if (played_.drives().empty() || mesh.position.empty()) return pressure;
  const auto pose = transforms.lookup(frameName(played_.frame()), world_);
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

visualization_msgs::MarkerArray RenderedHands::markers(const std::array<PaintedHand, 2>& hands,
                                                       const Touch& touch_now, const std_msgs::Header& header,
                                                       Transforms& transforms) {
  std::array<std::vector<float>, 2> gives;
  std::vector<double> wants_amplitude, gives_amplitude;  // of the skin around contacts, for the error
  double force = 0.0;                                    // N, on all skin that faces the array
  highest_wanted_ *= forgotten;
  highest_given_ *= forgotten;
  for (std::size_t s = 0; s < hands.size(); ++s) {
    std::vector<char> facing;
    gives[s] = given(hands[s].mesh, transforms, facing);
    const std::vector<float> area = cornerAreas(hands[s].mesh);
    for (std::size_t c = 0; c < gives[s].size(); ++c) {
      highest_wanted_ = std::max(highest_wanted_, hands[s].pressure[c]);
      highest_given_ = std::max(highest_given_, gives[s][c]);
      force += static_cast<double>(gives[s][c]) * area[c];
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
            painted(pressure[c] / static_cast<float>(scale * unit), lit(skinColor(), mesh.normal[c]));
      }
      markers.markers.push_back(
          surfaceMarker(mesh, mesh.color, mesh.triangles, 1.0f, header, name, static_cast<int>(s)));
    }
    std::string title = is_given ? "given by the array, Pa" : "wanted by the clay, kPa";
    if (is_given && played_.drives().empty()) {
      title += ": silent";
    } else if (is_given && !touch_now.position.empty()) {
      char words[64];
      std::snprintf(words, sizeof words, ": %.0f %% error, %.1f mN",
                    100.0 * ultrasound::fieldFit(wants_amplitude, gives_amplitude).error, 1e3 * force);
      title += words;
    }
    addColorBar(markers,
                {name, title, scale, at + Vector3f(0.0f, is_given ? -0.19f : 0.19f, -0.09f),
                 Vector3f(0.0f, is_given ? -0.014f : 0.014f, 0.0f), Vector3f(0.0f, 0.0f, 0.16f)},
                world_);
  }
  return markers;
}

}  // namespace tactile_clay::nodes
