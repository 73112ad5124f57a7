#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "contact/pressure_field.h"
#include "ultrasound/array_reach.h"
#include "ultrasound/focal_points.h"
#include "ultrasound/skin_disc.h"
#include "ultrasound/weighted_k_means.h"

namespace tactile_clay::ultrasound {

/// Samples worth rendering, as clustering needs them.
struct ContactField {
  std::vector<Eigen::Vector3d> position;  // m
  std::vector<double> weight;             // alpha p* A (Eq. 8), N
  std::vector<double> pressure;           // Pa
  std::vector<double> area;               // m^2
  std::vector<SkinDisc> skin;
};

/// Whether all that rendering needs of a sample is finite, and it has an area and a weight.
bool usable(const contact::PressureSample& sample);

/// The samples that press at least `minimum_pressure`, in one order for every permutation of them.
/// @param ignored how many were not usable
ContactField contactField(const std::vector<contact::PressureSample>& samples, const FocalPointConfig& config,
                          std::size_t& ignored);

/// Where the focal points of a contact go (Eq. 8): see FocalPointRenderer.
/// @param array null: any resolution
/// @param previous points of the frame before
/// @param unresolved how many points there would be more if the array could tell them apart
Clustering contactClusters(const ContactField& field, const FocalPointConfig& config, const ArrayReach* array,
                           const std::vector<FocalPoint>& previous, std::size_t& unresolved);

}  // namespace tactile_clay::ultrasound
