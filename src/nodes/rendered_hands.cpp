#include "nodes/rendered_hands.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>

#include "nodes/array_markers.h"
#include "nodes/array_model.h"
#include "nodes/cloud.h"
#include "nodes/color_bar.h"
#include "nodes/conversions.h"
#include "nodes/frame_name.h"
#include "nodes/surface_markers.h"
#include "nodes/topics.h"
#include "surface/samples_on_mesh.h"
#include "ultrasound/acoustic_field.h"
#include "ultrasound/perceptual_weight.h"

namespace tactile_clay::nodes {
namespace {

using Eigen::Vector3f;

// Place of hands/rendered in world, m: for the person at the table the wanted pressure is on the left, the
// given one on the right, and the weights are left of both.
const Vector3f rendered_about(0.0f, 0.0f, 0.03f), rendered_at(0.28f, 0.0f, 0.17f);
constexpr float rendered_aside = 0.17f, weight_aside = 0.51f;
constexpr float bar_aside = 0.155f, title_above = 0.15f;  // m, from the middle of a picture
constexpr float counted = 0.06f;        // m from a contact: skin within it counts for the error
constexpr float forgotten = 0.98f;      // factor per frame by which the kept highest pressure decays
constexpr float pad_reach = 0.010f;     // m, from a corner to the samples of the skin around it
constexpr float far_from_pads = 1.0f;   // m
constexpr double least_on_pads = 0.01;  // share of the wanted pressure: with less there is no error on pads

/// 1, 2, 3, 4, 6 or 8 times a power of ten, the smallest that is not below the value.
double roundScale(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(std::max(value, 1e-3))));
  for (const double step : {1.0, 2.0, 3.0, 4.0, 6.0, 8.0})
    if (value <= step * power) return step * power;
  return 10.0 * power;
}

/// Area of the skin around each corner, m^2: a third of each of its triangles.
std::vector<float> cornerAreas(const surface::TriangleMesh& mesh) {
  std::vector<float> area(mesh.position.size(), 0.0f);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3f &x = mesh.position[a], &y = mesh.position[b], &z = mesh.position[c];
    const float third = (y - x).cross(z - x).norm() / 6.0f;
    for (const std::uint32_t corner : {a, b, c}) area[corner] += third;
  }
  return area;
}

/// Samples of the skin of all hands, and for each its distance to the nearest finger pad, m, and 1.
struct PadSamples {
  std::vector<Vector3f> position, normal, known;
};

/// @param skin hands/skin, or null: there are no samples
PadSamples padSamples(const sensor_msgs::PointCloud2* skin) {
  if (skin == nullptr) return {};
  const Skin all = pressureSkin(*skin);
  const auto distance = column<float>(*skin, "pad_distance");
  PadSamples samples{all.isTracked() ? all.position : all.tracked_position,
                     all.isTracked() ? all.normal : all.tracked_normal, std::vector<Vector3f>(all.size())};
  for (std::size_t i = 0; i < samples.known.size(); ++i) samples.known[i] = {distance[i], 1.0f, 0.0f};
  return samples;
}

/// Distance of each corner to the nearest finger pad along the skin, m.
std::vector<float> padDistances(const surface::TriangleMesh& mesh, const PadSamples& samples) {
  const auto weights = surface::sampleWeights(mesh, samples.position, samples.normal, pad_reach);
  std::vector<float> out;
  for (const Vector3f& mean : surface::meanAt(weights, samples.known))
    out.push_back(mean.y() > 0.0f ? mean.x() : far_from_pads);
  return out;
}

/// The factor that brings `gives` closest to `wants`.
double bestScale(const std::vector<double>& wants, const std::vector<double>& gives) {
  const double both = std::inner_product(wants.begin(), wants.end(), gives.begin(), 0.0);
  const double square = std::inner_product(gives.begin(), gives.end(), gives.begin(), 0.0);
  return square > 0.0 ? both / square : 0.0;
}

/// Relative RMS difference of both at a scale. 0 if nothing is wanted.
double errorOf(const std::vector<double>& wants, const std::vector<double>& gives, double scale) {
  double difference = 0.0, square = 0.0;
  for (std::size_t k = 0; k < wants.size(); ++k) {
    difference += (scale * gives[k] - wants[k]) * (scale * gives[k] - wants[k]);
    square += wants[k] * wants[k];
  }
  return square > 0.0 ? std::sqrt(difference / square) : 0.0;
}

/// What is drawn of the hands: one of several pictures side by side.
struct Picture {
  std::string name, title;
  double scale, unit;  // at the upper end of the bar; of the values, in that unit
  float aside;         // m
};

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
                            const sensor_msgs::PointCloud2* skin, const std_msgs::Header& header,
                            Transforms& transforms) {
  publisher_.publish(markers(hands, touch, skin, header, transforms));
}

/// Radiation pressure at the corners, Pa.
/// @param[out] facing whether a corner faces the array; the others lie in the shadow of the hand
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

/// Both pressures on the skin that faces the array, and how far they are apart.
RenderedHands::Comparison RenderedHands::compare(const std::array<PaintedHand, 2>& hands, const Touch& touch,
                                                 const sensor_msgs::PointCloud2* skin,
                                                 Transforms& transforms) {
  Comparison found;
  const PadSamples pads = padSamples(skin);
  std::vector<double> wants, gives, wants_on_pads, gives_on_pads;  // Pa, of the skin around contacts
  for (std::size_t s = 0; s < hands.size(); ++s) {
    const surface::TriangleMesh& mesh = hands[s].mesh;
    std::vector<char> facing;
    found.given[s] = given(mesh, transforms, facing);
    const std::vector<float> area = cornerAreas(mesh);
    const std::vector<float> from_pad = padDistances(mesh, pads);
    for (std::size_t c = 0; c < mesh.position.size(); ++c) {
      found.weight[s].push_back(
          static_cast<float>(ultrasound::perceptualWeight(static_cast<double>(from_pad[c]))));
      found.highest_wanted = std::max(found.highest_wanted, hands[s].pressure[c]);
      found.highest_given = std::max(found.highest_given, found.given[s][c]);
      found.force += static_cast<double>(found.given[s][c]) * area[c];
      if (!facing[c] || !isNear(mesh.position[c], touch.position, counted)) continue;
      wants.push_back(static_cast<double>(hands[s].pressure[c]));
      gives.push_back(static_cast<double>(found.given[s][c]));
      if (static_cast<double>(from_pad[c]) > ultrasound::pad_radius) continue;
      wants_on_pads.push_back(wants.back());
      gives_on_pads.push_back(gives.back());
    }
  }
  const double scale = bestScale(wants, gives);
  found.error = errorOf(wants, gives, scale);
  const auto sum = [](const std::vector<double>& pressure) {
    return std::accumulate(pressure.begin(), pressure.end(), 0.0);
  };
  if (sum(wants_on_pads) > least_on_pads * sum(wants))
    found.error_on_pads = errorOf(wants_on_pads, gives_on_pads, scale);
  return found;
}

std::string RenderedHands::titleOfGiven(const Comparison& found, bool touches) const {
  std::string title = "given by the array, Pa";
  if (played_.drives().empty()) return title + ": silent";
  if (!touches) return title;
  char all[64], pads[48] = "";
  std::snprintf(all, sizeof all, "\nerror %.0f %%", 100.0 * found.error);
  if (found.error_on_pads)
    std::snprintf(pads, sizeof pads, ", on finger pads %.0f %%", 100.0 * *found.error_on_pads);
  char force[32];
  std::snprintf(force, sizeof force, "; %.1f mN", 1e3 * found.force);
  return title + all + pads + force;
}

visualization_msgs::MarkerArray RenderedHands::markers(const std::array<PaintedHand, 2>& hands,
                                                       const Touch& touch,
                                                       const sensor_msgs::PointCloud2* skin,
                                                       const std_msgs::Header& header,
                                                       Transforms& transforms) {
  const Comparison found = compare(hands, touch, skin, transforms);
  highest_wanted_ = std::max(forgotten * highest_wanted_, found.highest_wanted);
  highest_given_ = std::max(forgotten * highest_given_, found.highest_given);
  // Tipped up about the axis from left to right, so that palms and not backs are seen.
  const Eigen::Matrix3f up =
      Eigen::AngleAxisf(static_cast<float>(M_PI_2), Vector3f::UnitY()).toRotationMatrix();
  visualization_msgs::MarkerArray markers;
  const auto draw = [&](const Picture& picture, const std::array<std::vector<float>, 2>& value) {
    const Vector3f at = rendered_at + Vector3f(0.0f, picture.aside, 0.0f);
    for (std::size_t s = 0; s < hands.size(); ++s) {
      surface::TriangleMesh mesh = hands[s].mesh;
      mesh.color.resize(mesh.position.size());
      for (std::size_t c = 0; c < mesh.position.size(); ++c) {
        mesh.position[c] = at + up * (mesh.position[c] - rendered_about);
        mesh.normal[c] = up * mesh.normal[c];
        mesh.color[c] = painted(value[s][c] / static_cast<float>(picture.scale * picture.unit),
                                lit(skinColor(), mesh.normal[c]));
      }
      markers.markers.push_back(
          surfaceMarker(mesh, mesh.color, mesh.triangles, 1.0f, header, picture.name, static_cast<int>(s)));
    }
    const float side = picture.aside < 0.0f ? -1.0f : 1.0f;
    addColorBar(markers,
                {picture.name + ", bar", picture.title, picture.scale,
                 at + Vector3f(0.0f, side * bar_aside, -0.09f), Vector3f(0.0f, side * 0.014f, 0.0f),
                 Vector3f(0.0f, 0.0f, 0.16f), at + Vector3f(0.0f, 0.0f, title_above)},
                world_);
  };
  draw({"weight", "weight of the skin", 1.0, 1.0, weight_aside}, found.weight);
  draw({"wanted", "wanted by the clay, kPa", roundScale(1e-3 * static_cast<double>(highest_wanted_)), 1e3,
        rendered_aside},
       {hands[0].pressure, hands[1].pressure});
  draw({"given", titleOfGiven(found, !touch.position.empty()),
        roundScale(static_cast<double>(highest_given_)), 1.0, -rendered_aside},
       found.given);
  return markers;
}

}  // namespace tactile_clay::nodes
