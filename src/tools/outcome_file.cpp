#include "tools/outcome_file.h"

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <type_traits>

#include "clay/material.h"
#include "files/input_file.h"
#include "files/output_file.h"

namespace tactile_clay::tools {
namespace {

constexpr const char* heading = "tactile_clay outcome 2";
constexpr std::uint64_t max_bytes = 1U << 30U;  // of a file; a million particles are some 50 MB

/// FNV-1a.
class Hash {
 public:
  template <typename T>
  void add(const T& number) {
    static_assert(std::is_arithmetic_v<T>);
    const auto* bytes = reinterpret_cast<const unsigned char*>(&number);
    for (std::size_t k = 0; k < sizeof number; ++k) value_ = (value_ ^ bytes[k]) * 0x100000001b3U;
  }
  void add(const Eigen::Vector3f& v) {
    for (int k = 0; k < 3; ++k) add(v[k]);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

// Writes "position 3", for instance, then the numbers of a list.
template <typename List, typename Write>
void writeList(std::ostream& out, const char* name, const List& list, const Write& write) {
  out << name << ' ' << list.size() << '\n';
  for (std::size_t i = 0; i < list.size(); ++i) write(list, i);
}

void expect(std::istream& in, const std::string& name) {
  std::string word;
  if (!(in >> word) || word != name) throw std::runtime_error("expected '" + name + "'");
}

std::size_t sizeOf(std::istream& in, const std::string& name) {
  constexpr std::size_t maximum = 100'000'000;
  expect(in, name);
  std::size_t size = 0;
  if (!(in >> size) || size > maximum) throw std::runtime_error("expected the number of '" + name + "'");
  return size;
}

template <typename T>
T numberIn(std::istream& in) {
  T number{};
  if (!(in >> number)) throw std::runtime_error("expected a number");
  return number;
}

Outcome read(std::istream& in) {
  Outcome outcome;
  outcome.ms.resize(sizeOf(in, "ms"));
  for (double& ms : outcome.ms) ms = numberIn<double>(in);
  outcome.position.resize(sizeOf(in, "position"));
  for (std::size_t i = 0; i < outcome.position.size(); ++i) {
    const float x = numberIn<float>(in), y = numberIn<float>(in), z = numberIn<float>(in);
    outcome.position.set(i, {x, y, z});
  }
  outcome.force.resize(sizeOf(in, "force"));
  for (Load& load : outcome.force)
    for (int k = 0; k < load.size(); ++k) load[k] = numberIn<double>(in);
  for (double Outcome::*value : {&Outcome::height, &Outcome::mean_force, &Outcome::density, &Outcome::densest,
                                 &Outcome::volume_change})
    outcome.*value = numberIn<double>(in);
  outcome.rendered.resize(sizeOf(in, "rendered"));
  for (RenderedPressure& rendered : outcome.rendered) {
    rendered.error = numberIn<double>(in);
    rendered.ms = numberIn<double>(in);
  }
  expect(in, "end");
  return outcome;
}

void write(std::ostream& out, const Outcome& outcome) {
  out.precision(std::numeric_limits<double>::max_digits10);
  writeList(out, "ms", outcome.ms, [&](const auto& list, std::size_t i) { out << list[i] << '\n'; });
  writeList(out, "position", outcome.position, [&](const auto& list, std::size_t i) {
    const Eigen::Vector3f x = list.at(i);
    out << x.x() << ' ' << x.y() << ' ' << x.z() << '\n';
  });
  writeList(out, "force", outcome.force,
            [&](const auto& list, std::size_t i) { out << list[i].transpose() << '\n'; });
  out << outcome.height << ' ' << outcome.mean_force << ' ' << outcome.density << ' ' << outcome.densest
      << ' ' << outcome.volume_change << '\n';
  writeList(out, "rendered", outcome.rendered,
            [&](const auto& list, std::size_t i) { out << list[i].error << ' ' << list[i].ms << '\n'; });
  out << "end\n";
}

}  // namespace

std::string fingerprint(const scene::Scene& scene, const std::vector<HandSample>& samples) {
  Hash hash;
  for (const clay::InitialParticle& particle : scene.particles) {
    hash.add(particle.position);
    hash.add(particle.velocity);
    hash.add(particle.material);
  }
  for (const clay::Material& material : scene.materials)
    for (const clay::Coefficient& coefficient : clay::coefficients) hash.add(material.*coefficient.value);
  for (const double value :
       {scene.config.spacing, scene.config.frame, scene.config.gravity.x(), scene.config.gravity.y(),
        scene.config.gravity.z(), scene.config.world, scene.config.tolerance})
    hash.add(value);
  for (const char c : scene.urdf) hash.add(c);
  for (const HandSample& sample : samples) {
    hash.add(sample.duration);
    for (const Eigen::Vector3f& position : sample.skin.position) hash.add(position);
  }
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash.value()));
  return text;
}

void saveOutcome(const std::string& file, const std::string& key, const Outcome& outcome) {
  std::ostringstream out;
  out << heading << '\n' << key << '\n';
  write(out, outcome);
  files::writeWhole(file, out.str(), files::Existing::replace);
}

std::optional<Outcome> loadOutcome(const std::string& file, const std::string& key) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  std::istringstream in(files::readWhole(file, max_bytes));
  std::string first, second;
  std::getline(in, first);
  std::getline(in, second);
  if (first != heading || second != key) return std::nullopt;
  try {
    return read(in);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("outcome '" + file + "' is incomplete: " + error.what() + "; remove it");
  }
}

}  // namespace tactile_clay::tools
