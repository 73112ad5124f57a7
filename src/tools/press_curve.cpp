#include "tools/press_curve.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <stdexcept>

#include "files/input_file.h"
#include "tools/tool_arguments.h"

namespace tactile_clay::tools {
namespace {

constexpr double frame = 1.0 / 60.0;   // s, of the clay and of the windows
constexpr double settling = 0.2;       // s, in which the sample comes to rest under its weight
constexpr double longest = 120.0;      // s, of a curve: 7200 frames per evaluation
constexpr std::size_t fewest = 5;      // moments of a curve
constexpr double largest = 1e9;        // of any number in a file
constexpr double deepest_share = 0.8;  // of the height of the sample
constexpr double latest_share = 0.05;  // of the maximum depth: a curve must not begin deeper
constexpr std::size_t few = 3000;      // particles: for fewer, threads cost more than they gain
constexpr double max_particles = 2e5;  // of a sample

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

bool isHeading(const std::string& line) {
  return line.find_first_of("0123456789") == std::string::npos;
}

/// Index of the last moment that is not after t, but at most that of the last moment but one.
std::size_t before(const PressCurve& curve, double t) {
  const auto later = std::upper_bound(curve.begin(), curve.end(), t,
                                      [](double at, const PressSample& s) { return at < s.time; });
  const auto index = std::distance(curve.begin(), later) - 1;
  return static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(index, 0, static_cast<std::ptrdiff_t>(curve.size()) - 2));
}

double shareAt(const PressCurve& curve, std::size_t k, double t) {
  return std::clamp((t - curve[k].time) / (curve[k + 1].time - curve[k].time), 0.0, 1.0);
}

double depthAt(const PressCurve& curve, double t) {
  const std::size_t k = before(curve, t);
  return curve[k].depth + shareAt(curve, k, t) * (curve[k + 1].depth - curve[k].depth);
}

double forceAt(const PressCurve& curve, double t) {
  const std::size_t k = before(curve, t);
  return curve[k].force + shareAt(curve, k, t) * (curve[k + 1].force - curve[k].force);
}

clay::Solid table() {
  clay::Solid solid;
  solid.shape = clay::Solid::Shape::box;
  solid.size = {1.0, 1.0, 0.1};
  solid.pose.translation().z() = -0.1;
  return solid;
}

clay::Solid toolOf(const PressSetup& setup) {
  clay::Solid solid;
  switch (setup.tool) {
    case PressSetup::Tool::disc:
      solid.shape = clay::Solid::Shape::cylinder;
      solid.size = {setup.radius, setup.height(), 0.0};
      break;
    case PressSetup::Tool::sphere:
      solid.shape = clay::Solid::Shape::sphere;
      solid.size = {setup.radius, 0.0, 0.0};
      break;
    case PressSetup::Tool::plate:
      solid.shape = clay::Solid::Shape::box;
      solid.size = {1.0, 1.0, 0.1};
      break;
  }
  return solid;
}

/// Distance from the lowest point of a tool up to its origin, m.
double originOver(const clay::Solid& tool) {
  switch (tool.shape) {
    case clay::Solid::Shape::cylinder:
      return tool.size.y();
    case clay::Solid::Shape::box:
      return tool.size.z();
    default:
      return tool.size.x();
  }
}

}  // namespace

PressCurve readPressCurve(const std::string& file) {
  std::istringstream text(files::readWhole(file, files::maximum::text));
  PressCurve curve;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    const auto fail = [&](const std::string& what) {
      throw std::runtime_error(file + ":" + std::to_string(number) + ": " + what);
    };
    line.erase(std::min(line.find('#'), line.size()));
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.find_first_not_of(" \t") == std::string::npos) continue;
    if (curve.empty() && isHeading(line)) continue;
    const std::vector<std::string> cells = cellsOf(line);
    if (cells.size() != 3)
      fail("has " + std::to_string(cells.size()) +
           " values, expected three: time in s, depth in m, force in N");
    PressSample sample{};
    try {
      sample = {numberOf("time", cells[0], -largest, largest), numberOf("depth", cells[1], -largest, largest),
                numberOf("force", cells[2], -largest, largest)};
    } catch (const std::runtime_error& e) {
      fail(e.what());
    }
    if (!curve.empty() && !(sample.time > curve.back().time))
      fail("time " + cells[0] + " s is not after the one before, expected ascending times");
    if (!curve.empty() && sample.time - curve.front().time > longest)
      fail("time " + cells[0] + " s is more than " + std::to_string(static_cast<int>(longest)) +
           " s after the first, expected a shorter curve");
    curve.push_back(sample);
  }
  if (curve.size() < fewest)
    throw std::runtime_error(file + ": has " + std::to_string(curve.size()) + " moments, expected " +
                             std::to_string(fewest) + " or more");
  return curve;
}

double PressSetup::height() const {
  return sample.size.z();
}

double PressSetup::fittedSpacing() const {
  return height() / std::max(1.0, std::round(height() / spacing));
}

double PressSetup::area(double depth) const {
  switch (tool) {
    case Tool::disc:
      return M_PI * radius * radius;
    case Tool::sphere: {
      const double deep = std::clamp(depth, 0.0, radius);
      return M_PI * deep * (2.0 * radius - deep);
    }
    case Tool::plate:
      break;
  }
  return sample.kind == scene::Shape::Kind::box ? sample.size.x() * sample.size.y()
                                                : M_PI * sample.size.x() * sample.size.x();
}

void check(const PressSetup& setup, const PressCurve& curve) {
  const auto fail = [](const std::string& what) { throw std::runtime_error(what); };
  const auto deepest =
      std::max_element(curve.begin(), curve.end(),
                       [](const PressSample& a, const PressSample& b) { return a.depth < b.depth; });
  std::ostringstream line;
  if (!(deepest->depth > 0.0)) fail("the tool never touches the clay, expected a depth above 0 m");
  if (curve.front().depth > latest_share * deepest->depth) {
    line << "the curve begins " << curve.front().depth
         << " m deep, expected it to begin where the tool touches, at 0 m";
    fail(line.str());
  }
  if (deepest->depth > deepest_share * setup.height()) {
    line << "the tool goes " << deepest->depth << " m deep, expected at most " << deepest_share
         << " times the height of the sample, " << setup.height() << " m";
    fail(line.str());
  }
  if (std::none_of(curve.begin(), curve.end(), [](const PressSample& s) { return s.force > 0.0; }))
    fail("the clay never presses the tool, expected a force above 0 N: upward, on the tool");
  if (setup.height() < 2.0 * setup.spacing) {
    line << "spacing " << setup.spacing << " m, expected at most half of the height of the sample, "
         << setup.height() << " m";
    fail(line.str());
  }
  const double particles = scene::cellsAround(setup.sample, setup.fittedSpacing());
  if (particles > max_particles) {
    line << "spacing " << setup.spacing << " m makes " << std::lround(particles)
         << " particles, expected at most " << std::lround(max_particles);
    fail(line.str());
  }
}

std::vector<Window> windowsOf(const PressCurve& curve) {
  std::vector<Window> windows;
  const double first = curve.front().time, duration = curve.back().time - first;
  const int count = std::max(1, static_cast<int>(std::floor(duration / frame + 1e-6)));
  for (int k = 0; k < count; ++k) windows.push_back({first + k * frame, first + (k + 1) * frame});
  return windows;
}

std::vector<double> measuredForces(const PressCurve& curve, const std::vector<Window>& windows) {
  std::vector<double> forces;
  for (const Window& w : windows) {
    double sum = 0.0, at = w.from;
    for (std::size_t k = before(curve, w.from) + 1; at < w.to; ++k) {
      const double next = k < curve.size() ? std::min(curve[k].time, w.to) : w.to;
      sum += 0.5 * (forceAt(curve, at) + forceAt(curve, next)) * (next - at);
      at = next;
    }
    forces.push_back(sum / (w.to - w.from));
  }
  return forces;
}

std::vector<double> modelForces(const PressSetup& setup, const clay::Material& material,
                                const PressCurve& curve, const std::vector<Window>& windows) {
  clay::ClayConfig config;
  config.spacing = setup.fittedSpacing();
  config.budget = setup.budget;
  config.sleeping = false;
  std::vector<clay::InitialParticle> particles;
  for (const Eigen::Vector3d& point : scene::latticeIn(setup.sample, config.spacing))
    particles.push_back({point.cast<float>(), Eigen::Vector3f::Zero(), 0, 0});
  if (particles.size() < few) config.threads = 1;
  clay::Clay clay(config, {material}, particles);
  const clay::Solid tool = toolOf(setup);
  const double lead = std::ceil(settling / frame) * frame, first = windows.front().from;
  const clay::SolidMotion motion = [&](double t, std::vector<Eigen::Isometry3d>& poses) {
    poses.assign({table().pose, tool.pose});
    const double depth = depthAt(curve, first + std::max(t - lead, 0.0));
    poses[1].translation().z() = setup.height() - depth + originOver(tool);
  };
  while (clay.time() < lead - 0.5 * frame) clay.advance({}, {table(), tool}, std::cref(motion), frame);
  std::vector<double> forces;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    clay.advance({}, {table(), tool}, std::cref(motion), frame);
    forces.push_back(clay.solidForces()[1].z());
  }
  return forces;
}

}  // namespace tactile_clay::tools
