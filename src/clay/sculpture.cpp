#include "clay/sculpture.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <type_traits>

namespace tactile_clay::clay {
namespace {

// Numbers stand as the processor has them: little-endian on all that ROS 1 runs on.
constexpr char magic[] = "tactile_clay sculpture 5\n";

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw std::runtime_error("sculpture '" + file + "' " + what);
}

template <typename T>
void put(std::ostream& out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  out.write(reinterpret_cast<const char*>(&value), sizeof value);
}
template <typename T>
void put(std::ostream& out, const std::vector<T>& values) {
  put(out, static_cast<std::uint64_t>(values.size()));
  for (const T& value : values) put(out, value);
}
void put(std::ostream& out, const Eigen::Vector3f& v) {
  for (int a = 0; a < 3; ++a) put(out, v[a]);
}

class Reader {
 public:
  Reader(std::istream& in, const std::string& file) : in_(in), file_(file) {}

  template <typename T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    if (!in_.read(reinterpret_cast<char*>(&value), sizeof value)) fail(file_, "ends early");
    return value;
  }
  float number() {
    const float value = get<float>();
    if (!std::isfinite(value)) fail(file_, "holds a number that is not finite");
    return value;
  }
  Eigen::Vector3f vector() {
    const float x = number(), y = number(), z = number();
    return {x, y, z};
  }
  /// A count, at most `most`: a damaged one must not ask for all memory.
  std::uint64_t count(std::uint64_t most) {
    const auto n = get<std::uint64_t>();
    if (n > most) fail(file_, "is damaged: a count of " + std::to_string(n));
    return n;
  }
  template <typename T>
  std::vector<T> values(std::uint64_t most) {
    std::vector<T> all(count(most));
    for (T& value : all) value = get<T>();
    return all;
  }

 private:
  std::istream& in_;
  const std::string& file_;
};

}  // namespace

void save(const Sculpture& s, const std::string& file) {
  const std::string part = file + ".part";
  std::ofstream out(part, std::ios::binary);
  if (!out) fail(file, "cannot be written");
  out << magic;
  put(out, s.time), put(out, s.carry), put(out, s.step), put(out, s.spacing);
  put(out, s.sleep.watched), put(out, s.window_steps);
  put(out, s.material), put(out, s.body), put(out, s.sleep.lump);
  put(out, s.compression);
  for (const VectorField* field : {&s.position, &s.velocity, &s.window_start, &s.sleep.mark})
    for (std::size_t i = 0; i < field->size(); ++i) put(out, field->at(i));
  put(out, s.bond_begin), put(out, static_cast<std::uint64_t>(s.bonds.size()));
  for (const Bond& bond : s.bonds) put(out, bond.other), put(out, bond.rest_length);
  put(out, static_cast<std::uint64_t>(s.contacts.size()));
  for (const Contact& c : s.contacts) {
    put(out, c.particle), put(out, c.solid), put(out, static_cast<std::uint8_t>(c.state));
    put(out, c.normal), put(out, c.anchor), put(out, c.stiffness), put(out, c.density);
    put(out, c.friction), put(out, c.force);
  }
  out.close();
  if (!out || std::rename(part.c_str(), file.c_str()) != 0) {
    std::remove(part.c_str());
    fail(file, "cannot be written");
  }
}

Sculpture loadSculpture(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) fail(file, "cannot be read");
  std::string head(sizeof magic - 1, '\0');
  if (!in.read(head.data(), static_cast<std::streamsize>(head.size())) || head != magic)
    fail(file, "is not a sculpture of this version");
  Reader reader(in, file);
  constexpr std::uint64_t most = 1u << 28;
  Sculpture s;
  s.time = reader.get<double>(), s.carry = reader.get<double>();
  s.step = reader.get<std::uint64_t>(), s.spacing = reader.get<double>();
  s.sleep.watched = reader.get<double>(), s.window_steps = reader.get<std::int32_t>();
  s.material = reader.values<std::uint8_t>(most);
  s.body = reader.values<std::uint16_t>(most);
  s.sleep.lump = reader.values<std::uint32_t>(most);
  s.compression = reader.values<float>(most);
  const std::size_t n = s.material.size();
  if (s.body.size() != n || s.compression.size() != n || s.sleep.lump.size() != n || !std::isfinite(s.time) ||
      !std::isfinite(s.carry) || !(s.sleep.watched >= 0.0) || s.window_steps < 0)
    fail(file, "is damaged");
  for (VectorField* field : {&s.position, &s.velocity, &s.window_start, &s.sleep.mark}) {
    field->resize(n);
    for (std::size_t i = 0; i < n; ++i) field->set(i, reader.vector());
  }
  for (const float c : s.compression)
    if (!(c >= 0.0f)) fail(file, "is damaged: a compression of " + std::to_string(c));
  for (const std::uint32_t lump : s.sleep.lump)
    if (lump > n) fail(file, "is damaged: sleeping lump " + std::to_string(lump));
  s.bond_begin = reader.values<std::uint32_t>(most);
  s.bonds.resize(reader.count(most));
  for (Bond& bond : s.bonds) {
    bond.other = reader.get<std::uint32_t>(), bond.rest_length = reader.number();
    if (bond.other >= n) fail(file, "is damaged: a bond to particle " + std::to_string(bond.other));
  }
  bool rising = s.bond_begin.empty() ? s.bonds.empty() : s.bond_begin.size() == n + 1;
  for (std::size_t i = 0; rising && i + 1 < s.bond_begin.size(); ++i)
    rising = s.bond_begin[i] <= s.bond_begin[i + 1];
  if (!rising ||
      (!s.bond_begin.empty() && (s.bond_begin.front() != 0 || s.bond_begin.back() != s.bonds.size())))
    fail(file, "is damaged: its bonds are not those of " + std::to_string(n) + " particles");
  s.contacts.resize(reader.count(most));
  for (Contact& c : s.contacts) {
    c.particle = reader.get<std::uint32_t>(), c.solid = reader.get<std::uint32_t>();
    const auto state = reader.get<std::uint8_t>();
    if (c.particle >= n || state > static_cast<std::uint8_t>(Contact::State::stick))
      fail(file, "is damaged: a contact");
    c.state = static_cast<Contact::State>(state);
    c.normal = reader.vector(), c.anchor = reader.vector(), c.stiffness = reader.number();
    c.density = reader.number();
    c.friction = reader.vector(), c.force = reader.vector();
  }
  return s;
}

}  // namespace tactile_clay::clay
