#pragma once

// The constants and types of the AUTD3 library that the stand-in beside this file has.

#include <cstdint>

namespace autd3::native_methods {

constexpr std::uint32_t NUM_TRANS_IN_UNIT = 249, NUM_TRANS_IN_X = 18, NUM_TRANS_IN_Y = 14;
constexpr float TRANS_SPACING_MM = 10.16f;

enum class AUTDStatus : std::uint8_t { AUTDTrue = 0, AUTDFalse = 1, AUTDErr = 2 };
enum class GainSTMMode : std::uint8_t { PhaseIntensityFull = 0, PhaseFull = 1, PhaseHalf = 2 };

struct Point3 {
  float x, y, z;
};
struct Quaternion {
  float w, i, j, k;
};
struct Phase {
  std::uint8_t _0;
};
struct Intensity {
  std::uint8_t _0;
};
struct Drive {
  Phase phase;
  Intensity intensity;
};
struct Duration {
  std::uint64_t nanos;
};
struct OptionDuration {
  bool has_value;
  Duration value;
};
struct SenderOption {
  OptionDuration send_interval, receive_interval, timeout;
};
struct RemoteOption {
  OptionDuration timeout;
};
struct FixedCompletionSteps {
  std::uint16_t intensity, phase;
  bool strict;
};
struct GainSTMOption {
  GainSTMMode mode;
};
struct SamplingConfigWrap {
  float frequency;  // the library has another form of it
};
struct LinkPtr {
  const void* _0;
};
struct ControllerPtr {
  const void* _0;
};
struct GeometryPtr {
  const void* _0;
};
struct DevicePtr {
  const void* _0;
};
struct TransducerPtr {
  const void* _0;
};
struct SenderPtr {
  const void* _0;
};
struct GainPtr {
  const void* _0;
};
struct GainSTMPtr {
  const void* _0;
};
struct ModulationPtr {
  const void* _0;
};
struct DatagramPtr {
  const void* _0;
};
struct ResultLink {
  LinkPtr result;
  std::uint32_t err_len;
  const void* err;
};
struct ResultController {
  ControllerPtr result;
  std::uint32_t err_len;
  const void* err;
};
struct ResultStatus {
  AUTDStatus result;
  std::uint32_t err_len;
  const void* err;
};

}  // namespace autd3::native_methods
