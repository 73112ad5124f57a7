#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "contact/pressure_field.h"
#include "ultrasound/array_reach.h"
#include "ultrasound/focal_point.h"
#include "ultrasound/modulation.h"
#include "ultrasound/point_ids.h"

namespace tactile_clay::ultrasound {

/// How the pressure of a focal point follows from its samples.
enum class IntensityFit {
  least_squares,  // sum p* g / sum g^2: the minimiser of the objective of Eq. 9
  paper           // sum p* g / sum g: the closed form printed in Eq. 9, a Gaussian mean
};

struct FocalPointConfig {
  std::size_t max_points = 8;     // at least 1
  double min_separation = 0.012;  // m; closer points are felt as one and waste power
  double min_resolution = 2.2;    // minimum separation() (focus_beam.h), so that each point is a peak
  double sigma = 0.0086;          // m, of the Gaussian focus: the wavelength (Eq. 9), 8.6 mm at 40 kHz
  IntensityFit fit = IntensityFit::least_squares;
  bool perceptual_weights = true;  // alpha of Eq. 8; off: 1 everywhere
  /// Pa of the clay that asks for all that the array can give to one focus 0.2 m above its centre (see
  /// render). 95 % of the points of recorded hands are below it (doc/logbook/rendering.md).
  double full_scale_pressure = 450000.0;
  double compression_knee = 0.5;  // 0 to 1, share of full strength up to which pressures stay in proportion
  double side_lobe_floor = 0.25;  // minimum amplitude over the strongest point's; above its side lobes
  double felt_gain = 1.0;         // gain for this person over that for others; above 0
  double felt_threshold = 0.0;    // N of radiation force, below which a person feels no point; 0: not known
  double minimum_pressure = 1.0;  // Pa; samples below it are not rendered
  double minimum_force = 0.001;   // N; contacts that press less in sum get no point
  Modulation modulation = Modulation::amplitude;  // stm: a path over the contact instead of clusters;
                                                  // field: the skin itself
  bool field_weights = false;                     // alpha counts in the error of a field (FocalPoint::weight)
  bool field_normals = false;                     // a field counts the angle of the skin (FocalPoint::normal)
  std::size_t field_samples = 1600;               // maximum number of skin samples in a field, at least 1
  std::size_t path_points = 32;                   // maximum number of points of the path of stm, at least 1
  double path_spacing = 0.006;                    // m, minimum distance of two points of that path
  double follow_distance = 0.02;                  // m; how far a point may move in a frame and keep its id

  /// @throws std::invalid_argument naming the parameter, its value and its range
  void validate() const;
};

/// How the last frame was rendered.
struct RenderReport {
  std::size_t ignored_samples = 0;  // non-finite, or without area or weight
  std::size_t merged_points = 0;    // that have room on the skin, but that the array cannot resolve
  std::size_t raised_points = 0;  // weaker than side lobes, or not felt: rendered stronger than in proportion
  std::size_t compressed_points = 0;  // above the knee: rendered weaker than in proportion
  std::size_t saturated_points = 0;   // compressed points that ask for more than the array can give
  double gain = 0.0;                  // Pa of radiation pressure on the skin per Pa of clay; 0 without array
  std::vector<double> wanted;         // gain x pressure of each point, Pa
  std::vector<double> granted;        // radiation pressure of each point by its intensity, Pa
  std::vector<double> area;  // m^2; granted times area is the force of a point; without array only in fields
  double error = 0.0;        // reconstructionError of the pressure field
  double weighted_error = 0.0;  // the same with each sample counted by its perceptual weight
};

/// Share 0 to 1 that is given if a `share`, not negative, is asked for. Up to the knee k it is the same,
/// above it is k + (1 - k) (1 - exp(-(share - k) / (1 - k))). Its slope is continuous, and it is always below
/// 1. With a knee of 1 the share is cut at 1.
double compress(double share, double knee);

/// Focal points of a contact pressure field: locations by weighted k-means (Eq. 8), pressures by Eq. 9, after
/// Barreiro et al. with perceptual weights. Sums over samples stand for integrals over the skin, so each
/// sample counts by its area; with equal areas this is the paper's formula. Deterministic: the points depend
/// on the set of samples, not on their order, and on the frames since reset().
///
/// A contact gets as many points as have room on it, `min_separation` apart, up to `max_points`: a small
/// contact gets one point. Points that k-means brings closer together are merged, the closest pair first.
/// Points that the array cannot resolve (`min_resolution`) are merged, too, such as two that lie above each
/// other: a focus is 14 mm wide, but 80 mm long.
///
/// With spatiotemporal modulation the points are places of a closed path over the whole contact, in the order
/// in which one focus visits them (samplePath, tour), and their ids count from 0.
///
/// In a field the points are samples of skin, touched or bare, and their ids count from 0 (skinSamples).
///
/// Ids: clustering is done from the points of the frame before and from new seeds. The first result is used
/// if its objective (Eq. 8) is at most 5 % above that of the second. PointIds gives the ids, new ones by
/// rising x, y, z.
class FocalPointRenderer {
 public:
  /// @throws std::invalid_argument as FocalPointConfig::validate
  explicit FocalPointRenderer(const FocalPointConfig& config = {});

  /// Replaces the settings; points keep their ids.
  /// @throws std::invalid_argument as FocalPointConfig::validate, and keeps the settings as they were
  void configure(const FocalPointConfig& config);
  const FocalPointConfig& config() const { return config_; }

  /// Sets the array by whose limits intensities are computed.
  void setArray(const ArrayReach& array);

  /// Focal points of one frame, by rising id. A point lies at the weighted mean of its samples if that place
  /// is on the skin, otherwise beside it on the skin (ontoSkin). If the mean is farther than sigma from each
  /// sample, the point lies at the closest sample.
  ///
  /// Pressure of the clay, many kPa, is mapped to radiation pressure on the skin, some 100 Pa. The gain is
  /// the same at all places and for any number of points M: full_scale_pressure is rendered as the pressure
  /// of one focus 0.2 m above the centre of the array. A focus at x can have the pressure R(x)^2 / M, where
  /// R(x) is the amplitude of the whole array there, and radiation pressure is the square of amplitudes
  /// (radiationPressure). So a point asks for the share (p / full_scale_pressure) R(0, 0, 0.2)^2 M / R(x)^2,
  /// is given compress(share), and has intensity sqrt(compress(share)). `felt_gain` is a factor of the gain.
  ///
  /// If several points sound at the same time, a point that is weaker than the side lobes of the others could
  /// not be distinguished from them. It is raised to `side_lobe_floor`. Except with stm
  /// and in fields, a point with less force than `felt_threshold` is raised to that force, as far as the
  /// array can give it. report() counts all such changes. In a field each sample asks for its own pressure,
  /// and M is 1: solveField finds what the array can give to all samples together. Without setArray, R(x)^2 /
  /// M counts as the same everywhere.
  /// @param samples of all hands, in the frame of the array
  std::vector<FocalPoint> render(const std::vector<contact::PressureSample>& samples);

  const RenderReport& report() const { return report_; }

  /// Forgets the frames so far; ids start from 0.
  void reset();

 private:
  std::vector<FocalPoint> path(const std::vector<Eigen::Vector3d>& position,
                               const std::vector<double>& weight, const std::vector<double>& pressure) const;
  std::vector<FocalPoint> field(const std::vector<contact::PressureSample>& samples);
  void setIntensities(std::vector<FocalPoint>& points);
  void raiseWeak(const std::vector<double>& limit, double strongest, std::vector<FocalPoint>& points);
  void finish(const std::vector<contact::PressureSample>& samples, std::vector<FocalPoint>& points);

  FocalPointConfig config_;
  RenderReport report_;
  std::optional<ArrayReach> array_;
  double reference_ = 0.0;  // Pa, amplitude of one focus at the reference point
  PointIds ids_;
};

/// Relative RMS difference between the pressure field and its reconstruction from focal points (Fig. 4):
/// sqrt(sum A (p_k g - p*)^2 / sum A p*^2), where p_k is the pressure of the point closest to the sample, d
/// its distance, and g = exp(-d^2 / (2 sigma^2)).
/// @param weighted counts each sample by its perceptual weight as well
/// @return 0 without samples, 1 without points
double reconstructionError(const std::vector<contact::PressureSample>& samples,
                           const std::vector<FocalPoint>& points, double sigma, bool weighted = false);

}  // namespace tactile_clay::ultrasound
