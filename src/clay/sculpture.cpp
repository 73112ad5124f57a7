#include "clay/sculpture.h"

#include <cmath>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <type_traits>

#include "clay/sculpture_file.h"
#include "files/input_file.h"
#include "files/output_file.h"

namespace tactile_clay::clay {
namespace {

// Numbers are written as the processor stores them: little-endian on every processor that ROS 1 runs on.
constexpr char magic[] = "tactile_clay sculpture 5\n";

[[noreturn]] void fail(const std::string& file, const std::string& what) {
  throw std::runtime_error("sculpture '" + file + "' " + what);
}

template <typename T>
void put(std::string& out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}
template <typename T>
void put(std::string& out, const std::vector<T>& values) {
  put(out, static_cast<std::uint64_t>(values.size()));
  for (const T& value : values) put(out, value);
}
void put(std::string& out, const Eigen::Vector3f& v) {
  for (int a = 0; a < 3; ++a) put(out, v[a]);
}

/// Reads one number after the other from the bytes of a file. A count that needs more bytes than are left is
/// refused, so that a damaged count asks for no more memory than the file has.
class Reader {
 public:
  Reader(std::string bytes, std::size_t at, std::string file)
      : bytes_(std::move(bytes)), at_(at), file_(std::move(file)) {}

  template <typename T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    if (left() < sizeof value) fail(file_, "ends early");
    std::memcpy(&value, &bytes_[at_], sizeof value);
    at_ += sizeof value;
    return value;
  }
  template <typename T>
  T in(T low, T high, const char* what) {
    const T value = get<T>();
    if (!(value >= low && value <= high))
      fail(file_, "is damaged: " + std::string(what) + " " + std::to_string(value) + ", expected " +
                      std::to_string(low) + " to " + std::to_string(high));
    return value;
  }
  Eigen::Vector3f vector(float maximum, const char* what) {
    const float x = in(-maximum, maximum, what), y = in(-maximum, maximum, what),
                z = in(-maximum, maximum, what);
    return {x, y, z};
  }
  std::uint64_t count(std::size_t bytes_of_each) {
    const auto n = get<std::uint64_t>();
    require(n, bytes_of_each);
    return n;
  }
  void require(std::uint64_t n, std::size_t bytes_of_each) const {
    if (n > left() / bytes_of_each)
      fail(file_, "is damaged: a count of " + std::to_string(n) + ", with " + std::to_string(left()) +
                      " bytes left");
  }
  template <typename T>
  std::vector<T> values() {
    std::vector<T> all(count(sizeof(T)));
    for (T& value : all) value = get<T>();
    return all;
  }
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  std::string bytes_;
  std::size_t at_;
  std::string file_;
};

// Limits that no simulated clay comes near. Larger numbers would ask for an endless number of steps, or for
// cells of the neighbour search whose index fits into no integer.
constexpr double longest_time = 1e9;    // s
constexpr double longest_carry = 1.0;   // s; a real carry is shorter than a step
constexpr float max_coordinate = 1e6f;  // m
constexpr float fastest = 1e6f;         // m/s
constexpr float max_density = 1e6f;
constexpr float longest_bond = 1.0f;       // m
constexpr float strongest = 1e9f;          // N, and N/m
constexpr int longest_window = 1'000'000;  // steps

constexpr std::size_t vector_bytes = 12, bond_bytes = 8, contact_bytes = 65;  // in the file

void loadBonds(Reader& reader, const std::string& file, Sculpture& s) {
  const std::size_t n = s.material.size();
  s.bond_begin = reader.values<std::uint32_t>();
  s.bonds.resize(reader.count(bond_bytes));
  for (Bond& bond : s.bonds) {
    bond.other = reader.get<std::uint32_t>();
    bond.rest_length = reader.in(0.0f, longest_bond, "a bond of");
    if (bond.other >= n) fail(file, "is damaged: a bond to particle " + std::to_string(bond.other));
  }
  bool rising = s.bond_begin.empty() ? s.bonds.empty() : s.bond_begin.size() == n + 1;
  for (std::size_t i = 0; rising && i + 1 < s.bond_begin.size(); ++i)
    rising = s.bond_begin[i] <= s.bond_begin[i + 1];
  if (!rising ||
      (!s.bond_begin.empty() && (s.bond_begin.front() != 0 || s.bond_begin.back() != s.bonds.size())))
    fail(file, "is damaged: its bonds are not those of " + std::to_string(n) + " particles");
}

void loadContacts(Reader& reader, const std::string& file, Sculpture& s) {
  s.contacts.resize(reader.count(contact_bytes));
  for (Contact& c : s.contacts) {
    c.particle = reader.get<std::uint32_t>();
    c.solid = reader.get<std::uint32_t>();
    const auto state = reader.get<std::uint8_t>();
    if (c.particle >= s.material.size() || state > static_cast<std::uint8_t>(Contact::State::stick))
      fail(file, "is damaged: a contact");
    c.state = static_cast<Contact::State>(state);
    c.normal = reader.vector(2.0f, "a normal of");
    c.anchor = reader.vector(max_coordinate, "an anchor at");
    c.stiffness = reader.in(0.0f, strongest, "a stiffness of");
    c.density = reader.in(-max_density, max_density, "a density of");
    c.friction = reader.vector(strongest, "a friction of");
    c.force = reader.vector(strongest, "a force of");
  }
}

}  // namespace

Sculpture woken(Sculpture sculpture) {
  std::fill(sculpture.sleep.lump.begin(), sculpture.sleep.lump.end(), 0u);
  sculpture.sleep.mark = sculpture.position;
  sculpture.sleep.watched = 0.0;
  return sculpture;
}

void save(const Sculpture& s, const std::string& file) {
  save(s, file, files::Existing::replace);
}

void save(const Sculpture& s, const std::string& file, files::Existing existing) {
  std::string out = magic;
  put(out, s.time);
  put(out, s.carry);
  put(out, s.step);
  put(out, s.spacing);
  put(out, s.sleep.watched);
  put(out, s.window_steps);
  put(out, s.material);
  put(out, s.body);
  put(out, s.sleep.lump);
  put(out, s.compression);
  for (const VectorField* field : {&s.position, &s.velocity, &s.window_start, &s.sleep.mark})
    for (std::size_t i = 0; i < field->size(); ++i) put(out, field->at(i));
  put(out, s.bond_begin);
  put(out, static_cast<std::uint64_t>(s.bonds.size()));
  for (const Bond& bond : s.bonds) {
    put(out, bond.other);
    put(out, bond.rest_length);
  }
  put(out, static_cast<std::uint64_t>(s.contacts.size()));
  for (const Contact& c : s.contacts) {
    put(out, c.particle);
    put(out, c.solid);
    put(out, static_cast<std::uint8_t>(c.state));
    put(out, c.normal);
    put(out, c.anchor);
    put(out, c.stiffness);
    put(out, c.density);
    put(out, c.friction);
    put(out, c.force);
  }
  try {
    files::writeWhole(file, out, existing);
  } catch (const std::runtime_error& error) {
    fail(file, std::string(error.what()).substr(file.size() + 2));
  }
}

Sculpture loadSculpture(const std::string& file) {
  const std::size_t head = sizeof magic - 1;
  std::optional<std::string> bytes;
  try {
    bytes = files::readWholeWith(magic, file, files::maximum::sculpture);
  } catch (const std::runtime_error& error) {
    fail(file, std::string(error.what()).substr(file.size() + 2));
  }
  if (!bytes)
    fail(file, "is not a sculpture of this version, expected a file that begins with \"" +
                   std::string(magic, head - 1) + "\"");
  Reader reader(std::move(*bytes), head, file);
  Sculpture s;
  s.time = reader.in(0.0, longest_time, "a time of");
  s.carry = reader.in(-longest_carry, longest_carry, "a rest of");
  s.step = reader.get<std::uint64_t>();
  s.spacing = reader.in(0.0, 1.0, "a spacing of");
  s.sleep.watched = reader.in(0.0, longest_time, "a watch of");
  s.window_steps = reader.in<std::int32_t>(0, longest_window, "a window of steps");
  s.material = reader.values<std::uint8_t>();
  s.body = reader.values<std::uint16_t>();
  s.sleep.lump = reader.values<std::uint32_t>();
  s.compression = reader.values<float>();
  const std::size_t n = s.material.size();
  if (s.body.size() != n || s.compression.size() != n || s.sleep.lump.size() != n)
    fail(file, "is damaged: its particles are not " + std::to_string(n) + " in all its lists");
  for (VectorField* field : {&s.position, &s.velocity, &s.window_start, &s.sleep.mark}) {
    reader.require(n, vector_bytes);
    field->resize(n);
    const bool velocity = field == &s.velocity;
    for (std::size_t i = 0; i < n; ++i)
      field->set(i,
                 reader.vector(velocity ? fastest : max_coordinate, velocity ? "a speed of" : "a place at"));
  }
  // A compression is infinite if no step was simulated yet.
  for (const float c : s.compression)
    if (!(c >= 0.0f)) fail(file, "is damaged: a compression of " + std::to_string(c));
  for (const std::uint32_t lump : s.sleep.lump)
    if (lump > n) fail(file, "is damaged: sleeping lump " + std::to_string(lump));
  loadBonds(reader, file, s);
  loadContacts(reader, file, s);
  if (reader.left() > 0) fail(file, "is damaged: " + std::to_string(reader.left()) + " bytes after its end");
  return s;
}

}  // namespace tactile_clay::clay
