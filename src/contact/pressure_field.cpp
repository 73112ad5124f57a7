#include "contact/pressure_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace tactile_clay::contact {
namespace {

void checkArray(const Eigen::Vector3f& position) {
  if (!position.allFinite())
    throw std::invalid_argument("pressure field: position of the array is not finite");
}

void checkSkin(const Skin& skin) {
  const std::size_t n = skin.position.size();
  if (skin.normal.size() != n || skin.area.size() != n || skin.weight.size() != n) {
    throw std::invalid_argument(
        "pressure field: skin has " + std::to_string(n) + " positions, " +
        std::to_string(skin.normal.size()) + " normals, " + std::to_string(skin.area.size()) + " areas and " +
        std::to_string(skin.weight.size()) + " weights; expected one of each per sample");
  }
  const std::size_t positions = skin.tracked_position.size(), normals = skin.tracked_normal.size(),
                    areas = skin.tracked_area.size(), expected = skin.isTracked() ? 0 : n;
  if (positions != expected || normals != expected || areas != expected) {
    throw std::invalid_argument("pressure field: skin of " + std::to_string(n) + " samples is felt at " +
                                std::to_string(positions) + " positions, " + std::to_string(normals) +
                                " normals and " + std::to_string(areas) +
                                " areas; expected one of each per sample, or none");
  }
}

/// Where a sample is felt.
struct Place {
  Eigen::Vector3f position, normal;
  float area;
};

Place placeOf(const Skin& skin, std::size_t i) {
  if (skin.isTracked()) return {skin.position[i], skin.normal[i], skin.area[i]};
  return {skin.tracked_position[i], skin.tracked_normal[i], skin.tracked_area[i]};
}

bool usable(const Skin& skin, std::size_t i) {
  const Place place = placeOf(skin, i);
  return skin.position[i].allFinite() && skin.normal[i].allFinite() && std::isfinite(skin.area[i]) &&
         skin.area[i] >= 0.0f && std::isfinite(skin.weight[i]) && place.position.allFinite() &&
         place.normal.allFinite() && std::isfinite(place.area) && place.area >= 0.0f;
}

bool facesArray(const Place& place, const Eigen::Vector3f& array_position) {
  return place.normal.dot(array_position - place.position) > 0.0f;
}

}  // namespace

std::vector<PressureSample> pressureField(const Skin& skin, const std::vector<SkinForce>& contacts,
                                          const Eigen::Vector3f& array_position, std::size_t* dropped) {
  checkSkin(skin);
  checkArray(array_position);

  // Contacts are few beside the skin: sorting them avoids a pass over all samples. Stable, so that forces on
  // one sample add up in the order given.
  std::size_t left_out = 0;
  std::vector<SkinForce> sorted;
  sorted.reserve(contacts.size());
  for (const SkinForce& contact : contacts) {
    if (contact.index >= skin.position.size()) {
      throw std::out_of_range("pressure field: contact on skin sample " + std::to_string(contact.index) +
                              ", expected less than " + std::to_string(skin.position.size()));
    }
    const bool slides = std::isfinite(contact.slip) && contact.slip >= 0.0f;
    if (contact.force.allFinite() && slides && usable(skin, contact.index)) {
      sorted.push_back(contact);
    } else {
      ++left_out;
    }
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const SkinForce& a, const SkinForce& b) { return a.index < b.index; });
  if (dropped != nullptr) *dropped = left_out;

  std::vector<PressureSample> samples;
  for (auto contact = sorted.begin(); contact != sorted.end();) {
    const std::uint32_t i = contact->index;
    // In double, because the sum of finite forces may overflow a float.
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    double size = 0.0, slip = 0.0;
    for (; contact != sorted.end() && contact->index == i; ++contact) {
      const Eigen::Vector3d here = contact->force.cast<double>();
      force += here;
      size += here.norm();
      slip += here.norm() * contact->slip;
    }

    const Place place = placeOf(skin, i);
    const double normal_force = std::max(-skin.normal[i].cast<double>().dot(force), 0.0);
    // A sample without area is covered by other skin.
    if (!facesArray(place, array_position) || !(normal_force > 0.0) || !(skin.area[i] > 0.0f) ||
        !(place.area > 0.0f))
      continue;
    const double pressure = normal_force / skin.area[i];
    if (!(std::max(pressure, normal_force) <= std::numeric_limits<float>::max())) {
      if (dropped != nullptr) ++*dropped;
      continue;
    }
    samples.push_back({place.position, place.normal, static_cast<float>(pressure),
                       static_cast<float>(normal_force), place.area, skin.weight[i],
                       size > 0.0 ? static_cast<float>(slip / size) : 0.0f});
  }
  return samples;
}

std::vector<PressureSample> skinAround(const Skin& skin, const std::vector<PressureSample>& pressed,
                                       const Eigen::Vector3f& array_position, float reach) {
  checkSkin(skin);
  checkArray(array_position);
  if (!std::isfinite(reach))
    throw std::invalid_argument("pressure field: reach of the skin around contacts is not finite");
  std::vector<PressureSample> around;
  auto next = pressed.begin();
  for (std::size_t i = 0; i < skin.position.size(); ++i) {
    if (!usable(skin, i)) continue;
    const Place place = placeOf(skin, i);
    // Pressed samples are in skin order.
    if (next != pressed.end() && next->position == place.position) {
      ++next;
      continue;
    }
    if (!(skin.area[i] > 0.0f && place.area > 0.0f) || !facesArray(place, array_position)) continue;
    const auto near = [&](const PressureSample& sample) {
      return (sample.position - place.position).squaredNorm() <= reach * reach;
    };
    if (std::any_of(pressed.begin(), pressed.end(), near))
      around.push_back({place.position, place.normal, 0.0f, 0.0f, place.area, skin.weight[i]});
  }
  return around;
}

}  // namespace tactile_clay::contact
