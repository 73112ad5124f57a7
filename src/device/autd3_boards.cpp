#include "device/autd3_boards.h"

#include <autd3/native_methods.hpp>

#include <cmath>
#include <stdexcept>

namespace tactile_clay::device {
namespace {

namespace sdk = ::autd3::native_methods;

constexpr double metres = 1e-3;                 // a mm
constexpr double elsewhere = 0.2e-3;            // m, by which a transducer may be off its place
constexpr std::uint64_t millisecond = 1000000;  // ns

/// The library's word for what went wrong.
/// @throws std::runtime_error
template <class Result>
[[noreturn]] void fail(const Result& result, const std::string& what) {
  std::string text(result.err_len, ' ');
  if (result.err_len > 0) sdk::AUTDGetErr(result.err, text.data());
  while (!text.empty() && (text.back() == '\0' || text.back() == ' ' || text.back() == '\n')) text.pop_back();
  throw std::runtime_error("autd3: " + what + ": " + text);
}

template <class Result>
auto valueOf(const Result& result, const std::string& what) {
  if (result.err_len != 0) fail(result, what);
  return result.result;
}

void require(const sdk::ResultStatus& status, const std::string& what) {
  if (status.result == sdk::AUTDStatus::AUTDErr) fail(status, what);
}

/// From the centre of a board to its first transducer, m.
Eigen::Vector3d firstTransducer() {
  constexpr double pitch = metres * sdk::TRANS_SPACING_MM;
  return {-0.5 * pitch * (sdk::NUM_TRANS_IN_X - 1), -0.5 * pitch * (sdk::NUM_TRANS_IN_Y - 1), 0.0};
}

sdk::Drive driveOf(const ultrasound::Drive& drive, std::size_t n) {
  const double turns = drive.phase[n] * 0.5 / M_PI;
  const auto level = std::lround((turns - std::floor(turns)) * Autd3Boards::phase_levels);
  constexpr double rounding = 1e-3;  // of a level: what is one already stays it
  const double amplitude = std::floor(drive.amplitude[n] * Autd3Boards::amplitude_levels + rounding);
  sdk::Drive out{};
  out.phase._0 = static_cast<std::uint8_t>(level % Autd3Boards::phase_levels);
  out.intensity._0 = static_cast<std::uint8_t>(amplitude);
  return out;
}

/// Called by the library for each transducer while a pattern is sent.
void fill(const void* drive, sdk::GeometryPtr, std::uint16_t board, std::uint8_t transducer,
          sdk::Drive* out) {
  *out = driveOf(*static_cast<const ultrasound::Drive*>(drive),
                 std::size_t{board} * sdk::NUM_TRANS_IN_UNIT + transducer);
}

sdk::SamplingConfigWrap samplingOf(double frequency) {
  return sdk::AUTDSamplingConfigIntoNearest(sdk::AUTDSamplingConfigFromFreq(static_cast<float>(frequency)));
}

}  // namespace

struct Autd3Boards::Library {
  sdk::ControllerPtr controller{nullptr};
  sdk::GeometryPtr geometry{nullptr};

  void send(sdk::DatagramPtr what, const char* name) const {
    const sdk::OptionDuration pause{true, {millisecond}};
    const sdk::SenderOption option{pause, pause, {false, {0}}};
    require(sdk::AUTDSenderSend(sdk::AUTDSender(controller, option), what), name);
  }

  sdk::GainPtr gainOf(const ultrasound::Drive& drive) const {
    return sdk::AUTDGainCustom(reinterpret_cast<const void*>(&fill), &drive, geometry);
  }
};

ultrasound::ArrayLayout Autd3Boards::layoutOf(const std::vector<Eigen::Isometry3d>& boards) {
  std::vector<ultrasound::ArrayLayout> layouts;
  for (const Eigen::Isometry3d& board : boards)
    layouts.push_back(ultrasound::placed(ultrasound::arrayLayout("autd3"), board));
  return ultrasound::joined(layouts);
}

Autd3Boards::Autd3Boards(const std::string& address, const std::vector<Eigen::Isometry3d>& boards)
    : library_(std::make_unique<Library>()) {
  std::vector<sdk::Point3> places;
  std::vector<sdk::Quaternion> turns;
  for (const Eigen::Isometry3d& board : boards) {
    const Eigen::Vector3f at = (board * firstTransducer() / metres).cast<float>();
    const Eigen::Quaternionf turn(Eigen::Quaterniond(board.linear()).cast<float>());
    places.push_back({at.x(), at.y(), at.z()});
    turns.push_back({turn.w(), turn.x(), turn.y(), turn.z()});
  }
  const sdk::LinkPtr link =
      valueOf(sdk::AUTDLinkRemote(address.c_str(), {{false, {0}}}), "address '" + address + "'");
  const sdk::OptionDuration pause{true, {millisecond}};
  library_->controller =
      valueOf(sdk::AUTDControllerOpen(places.data(), turns.data(), static_cast<std::uint16_t>(boards.size()),
                                      link, {pause, pause, {false, {0}}}),
              std::to_string(boards.size()) + " boards at '" + address + "' do not open");
  library_->geometry = sdk::AUTDGeometry(library_->controller);
  const ultrasound::ArrayLayout layout = layoutOf(boards);
  for (std::size_t n = 0; n < layout.size(); ++n) {
    const sdk::DevicePtr board =
        sdk::AUTDDevice(library_->geometry, static_cast<std::uint16_t>(n / sdk::NUM_TRANS_IN_UNIT));
    const sdk::Point3 at = sdk::AUTDTransducerPosition(
        sdk::AUTDTransducer(board, static_cast<std::uint8_t>(n % sdk::NUM_TRANS_IN_UNIT)));
    const Eigen::Vector3d place = metres * Eigen::Vector3d(at.x, at.y, at.z);
    if (!((place - layout.position[n].cast<double>()).norm() < elsewhere)) {
      (void)sdk::AUTDControllerClose(library_->controller);
      throw std::runtime_error("autd3: the library has transducer " + std::to_string(n) +
                               " at another place, expected version 38 of it");
    }
  }
  silence();  // whatever the boards played before
  // Patterns may change as fast as they are asked to.
  library_->send(sdk::AUTDDatagramSilencerFromCompletionSteps({1, 1, false}), "the silencer");
}

Autd3Boards::~Autd3Boards() {
  try {
    silence();
  } catch (const std::exception&) {
    // Closing silences as well, where the boards are there.
  }
  (void)sdk::AUTDControllerClose(library_->controller);
}

void Autd3Boards::modulate(const std::vector<std::uint8_t>& samples) {
  library_->send(sdk::AUTDModulationIntoDatagram(sdk::AUTDModulationCustom(
                     samples.data(), static_cast<std::uint16_t>(samples.size()), samplingOf(sample_rate))),
                 "the modulation");
}

void Autd3Boards::play(const std::vector<ultrasound::Drive>& patterns, double frequency) {
  if (patterns.size() == 1) {
    library_->send(sdk::AUTDGainIntoDatagram(library_->gainOf(patterns.front())), "a pattern");
    return;
  }
  std::vector<sdk::GainPtr> gains;
  for (const ultrasound::Drive& pattern : patterns) gains.push_back(library_->gainOf(pattern));
  const auto count = static_cast<std::uint16_t>(gains.size());
  const sdk::SamplingConfigWrap rate =
      sdk::AUTDSTMConfigFromFreqNearest(static_cast<float>(frequency), count);
  library_->send(sdk::AUTDSTMGainIntoDatagram(
                     sdk::AUTDSTMGain(rate, gains.data(), count, {sdk::GainSTMMode::PhaseIntensityFull})),
                 "patterns");
}

void Autd3Boards::silence() {
  library_->send(sdk::AUTDGainIntoDatagram(sdk::AUTDGainNull()), "silence");
}

}  // namespace tactile_clay::device
