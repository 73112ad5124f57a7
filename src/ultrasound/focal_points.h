#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "contact/pressure_field.h"
#include "ultrasound/array_reach.h"
#include "ultrasound/focal_point.h"
#include "ultrasound/modulation.h"

namespace tactile_clay::ultrasound {

/// How the pressure of a focal point follows from its samples.
enum class IntensityFit {
  least_squares,  // sum p* g / sum g^2: the minimiser of the objective of Eq. 9
  paper           // sum p* g / sum g: the closed form printed in Eq. 9, a Gaussian mean
};

struct FocalPointConfig {
  std::size_t max_points = 8;     // at least 1
  double min_separation = 0.012;  // m; closer points are felt as one and waste power
  double min_resolution = 2.2;    // minimum separation for the array (focus_beam.h), so that each is a peak
  double sigma = 0.0086;          // m, of the Gaussian focus: the wavelength (Eq. 9), 8.6 mm at 40 kHz
  IntensityFit fit = IntensityFit::least_squares;
  bool perceptual_weights = true;  // alpha of Eq. 8; off: 1 everywhere
  double full_scale_pressure =
      450000.0;  // Pa of the clay that ask for all that the array can give (see render): what
                 // 95 % of the points of recorded hands stay below (doc/logbook/rendering.md)
  double compression_knee = 0.5;  // share of that up to which pressures stay in proportion, 0 to 1
  double side_lobe_floor = 0.25;  // minimum amplitude of a point, over the strongest: above their side lobes
  double felt_gain = 1.0;         // of a person, over that of others; above 0
  double felt_threshold = 0.0;    // N of radiation force, below which a person feels no point; 0: not known
  double minimum_pressure = 1.0;  // Pa; samples below it are not rendered
  double minimum_force = 0.001;   // N; contacts that press less in sum get no point
  Modulation modulation = Modulation::amplitude;  // stm: a path over the contact instead of clusters;
                                                  // field: the skin itself
  bool field_weights = false;                     // alpha counts in the error of a field (FocalPoint::weight)
  std::size_t field_samples = 1600;  // of skin, at most, that stand for all of it in a field; at least 1
  std::size_t path_points = 32;      // most points of that path, at least 1
  double path_spacing = 0.006;       // m, minimum distance of two of them
  double follow_distance = 0.02;     // m; how far a point may move in a frame and keep its id

  /// @throws std::invalid_argument naming the parameter, its value and its range
  void validate() const;
};

/// What became of the last frame.
struct RenderReport {
  std::size_t ignored_samples = 0;    // non-finite, or of no area or weight
  std::size_t merged_points = 0;      // that have room on the skin, but that the array cannot tell apart
  std::size_t raised_points = 0;      // weaker than side lobes, or not felt: stronger than in proportion
  std::size_t compressed_points = 0;  // above the knee: rendered weaker than in proportion
  std::size_t saturated_points = 0;   // of those, the ones that ask for more than the array can give
  double gain = 0.0;            // Pa of radiation pressure on the skin for a Pa of clay; 0 without array
  std::vector<double> wanted;   // gain x pressure of each point, Pa
  std::vector<double> granted;  // radiation pressure that its intensity stands for, Pa
  std::vector<double> area;     // m^2, granted times this is the force of each; empty without array
  double error = 0.0;           // reconstructionError of the pressure field
  double weighted_error = 0.0;  // the same with each sample counted by its perceptual weight
};

/// Share 0 to 1 of what can be had for a `share` that is asked, not negative: the same up to `knee`, then
/// k + (1 - k) (1 - exp(-(share - k) / (1 - k))), of continuous slope and always below 1. A knee of 1 cuts
/// at 1.
double compress(double share, double knee);

/// Focal points of a contact pressure field: locations by weighted k-means (Eq. 8), pressures by Eq. 9, after
/// Barreiro et al. with perceptual weights. Sums over samples stand for integrals over the skin, so each
/// sample counts by its area; where areas are equal that is the paper's formula. Deterministic: the points
/// depend on the set of samples, not on their order, and on the frames since reset().
///
/// As many points as there is room for on the contact, `min_separation` apart, up to `max_points`: a small
/// contact gets one, no contact none. Points that k-means brings closer than that are merged, the closest
/// pair first. So are points that the array cannot tell apart (`min_resolution`), such as two that lie above
/// each other: a focus is 14 mm wide, but 80 mm long.
///
/// With spatiotemporal modulation the points are places of a closed path over the whole contact, in the order
/// in which one focus visits them (samplePath, tour), and their ids count from 0.
///
/// Of a field the points are samples of skin, touched and not, and their ids count from 0 (skinSamples).
///
/// Ids: clustering starts from the points of the frame before as well as from new seeds, and keeps to the
/// former while its objective (Eq. 8) is within 5 % of the latter's. Then old and new points are paired,
/// closest first (ties: lower id, then lower index), and a pair not farther apart than `follow_distance`
/// keeps its id. Points left over get the next unused ids by rising x, y, z; an id that dies does not come
/// back.
class FocalPointRenderer {
 public:
  /// @throws std::invalid_argument as FocalPointConfig::validate
  explicit FocalPointRenderer(const FocalPointConfig& config = {});

  /// Replaces the settings; points keep their ids.
  /// @throws std::invalid_argument as FocalPointConfig::validate, and keeps the settings as they were
  void configure(const FocalPointConfig& config);
  const FocalPointConfig& config() const { return config_; }

  /// The array whose limits intensities keep to.
  void setArray(const ArrayReach& array);

  /// Focal points of one frame, by rising id. A point lies at the weighted mean of its samples where that is
  /// on the skin, or else beside it on the skin (ontoSkin); where it is farther than sigma from each of them,
  /// at the closest sample.
  ///
  /// Pressure of the clay, many kPa, is mapped to radiation pressure on the skin, some 100 Pa, with one gain
  /// for all places and any number of points M: full_scale_pressure is rendered as what one focus has 0.2 m
  /// above the centre of the array. What a focus at x can have is R(x)^2 / M, R(x) being the amplitude of the
  /// whole array there and radiation pressure the square of amplitudes (radiationPressure); so a point asks
  /// for the share (p / full_scale_pressure) R(0, 0, 0.2)^2 M / R(x)^2 of it, is given compress(share), and
  /// has intensity sqrt(compress(share)). Where other points are there at the same time, one that is weaker
  /// than their side lobes could not be told from these, and is raised to side_lobe_floor; one that presses
  /// less than felt_threshold is raised to that. felt_gain is a factor of the gain. Nothing is cut without a
  /// word: see report(). In a field each sample asks for its own pressure, and M is 1: what the array can
  /// give them together is the solver's matter (solveField). Without setArray, R(x)^2 / M counts as the same
  /// everywhere.
  /// @param samples of all hands, in the frame of the array
  std::vector<FocalPoint> render(const std::vector<contact::PressureSample>& samples);

  const RenderReport& report() const { return report_; }

  /// Forgets the frames so far; ids start from 0.
  void reset();

 private:
  std::vector<FocalPoint> path(const std::vector<Eigen::Vector3d>& position,
                               const std::vector<double>& weight, const std::vector<double>& pressure) const;
  std::vector<FocalPoint> field(const std::vector<contact::PressureSample>& samples);
  void assignIds(std::vector<FocalPoint>& points);
  void setIntensities(std::vector<FocalPoint>& points);
  void raiseWeak(const std::vector<double>& limit, double strongest, std::vector<FocalPoint>& points);
  void finish(const std::vector<contact::PressureSample>& samples, std::vector<FocalPoint>& points);

  FocalPointConfig config_;
  RenderReport report_;
  std::optional<ArrayReach> array_;
  double reference_ = 0.0;  // Pa, amplitude of one focus at the reference point
  std::vector<FocalPoint> previous_;
  std::uint32_t next_id_ = 0;
};

/// Relative RMS difference between the pressure field and its reconstruction from focal points (Fig. 4):
/// sqrt(sum A (p_k g - p*)^2 / sum A p*^2), where each sample sees the closest point, g = exp(-d^2 / 2
/// sigma^2).
/// @param weighted counts each sample by its perceptual weight as well
/// @return 0 without samples, 1 without points
double reconstructionError(const std::vector<contact::PressureSample>& samples,
                           const std::vector<FocalPoint>& points, double sigma, bool weighted = false);

}  // namespace tactile_clay::ultrasound
