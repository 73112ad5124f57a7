#pragma once

// Stands in for the header of the AUTD3 library (version 38, autd3/native_methods.hpp of shinolab/autd3-cpp):
// the names that our device uses, with the meaning that its documentation gives them, over boards that exist
// only in the test.

#include <cmath>
#include <cstdint>
#include <cstring>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "types.hpp"

namespace autd3::native_methods {

/// Patterns, or a modulation, on their way to the boards.
struct Datagram {
  std::vector<std::vector<Drive>> patterns;
  std::vector<std::uint8_t> modulation;
  float frequency = 0.0f;  // of patterns a second, or samples
};

/// What the boards do.
struct Boards {
  bool server = true, good = true, open = false;
  float shift = 0.0f;  // mm, by which transducers are off
  std::vector<Point3> places;
  std::vector<Quaternion> turns;
  Datagram playing;
  std::vector<std::uint8_t> modulation;
  float sample_rate = 0.0f;
  int sends = 0;
};

class StandIn {
 public:
  Boards now() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return boards_;
  }
  template <class Change>
  void change(Change change) {
    const std::lock_guard<std::mutex> lock(mutex_);
    change(boards_);
  }
  /// Kept for the rest of the test.
  const void* keep(Datagram datagram) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return &kept_.emplace_back(std::move(datagram));
  }
  void reset() {
    const std::lock_guard<std::mutex> lock(mutex_);
    boards_ = {};
  }

 private:
  std::mutex mutex_;
  Boards boards_;
  std::deque<Datagram> kept_;
};

inline StandIn& standIn() {
  static StandIn stand_in;
  return stand_in;
}

inline const Datagram& datagramOf(const void* kept) {
  return *static_cast<const Datagram*>(kept);
}

inline constexpr char no_server[] = "no server", lost[] = "link closed";

inline void AUTDGetErr(const void* error, char* text) {
  const auto* words = static_cast<const char*>(error);
  std::memcpy(text, words, std::strlen(words));
}

inline ResultLink AUTDLinkRemote(const char*, RemoteOption) {
  return {{nullptr}, 0, nullptr};
}

inline ResultController AUTDControllerOpen(const Point3* places, const Quaternion* turns, std::uint16_t count,
                                           LinkPtr, SenderOption) {
  bool there = false;
  standIn().change([&](Boards& boards) {
    there = boards.server;
    if (!there) return;
    boards.open = true;
    boards.places.assign(places, places + count);
    boards.turns.assign(turns, turns + count);
  });
  if (!there) return {{nullptr}, sizeof no_server - 1, no_server};
  return {{&standIn()}, 0, nullptr};
}

inline ResultStatus AUTDControllerClose(ControllerPtr) {
  standIn().change([](Boards& boards) {
    boards.open = false;
    boards.playing = {};
  });
  return {AUTDStatus::AUTDTrue, 0, nullptr};
}

inline GeometryPtr AUTDGeometry(ControllerPtr) {
  return {nullptr};
}

/// Boards and transducers are identified by a number, 1 + board * 1000 + transducer.
inline DevicePtr AUTDDevice(GeometryPtr, std::uint16_t board) {
  return {reinterpret_cast<const void*>(std::uintptr_t{board} * 1000 + 1)};
}
inline TransducerPtr AUTDTransducer(DevicePtr board, std::uint8_t transducer) {
  return {reinterpret_cast<const void*>(reinterpret_cast<std::uintptr_t>(board._0) + transducer)};
}

/// The grid of a board, along x and then y, without (1, 1), (2, 1) and (16, 1).
inline Point3 AUTDTransducerPosition(TransducerPtr transducer) {
  const std::uintptr_t number = reinterpret_cast<std::uintptr_t>(transducer._0) - 1;
  std::uintptr_t left = number % 1000;
  float x = 0.0f, y = 0.0f;
  for (std::uint32_t row = 0; row < NUM_TRANS_IN_Y; ++row)
    for (std::uint32_t column = 0; column < NUM_TRANS_IN_X; ++column) {
      if (row == 1 && (column == 1 || column == 2 || column == 16)) continue;
      if (left-- == 0) {
        x = TRANS_SPACING_MM * static_cast<float>(column);
        y = TRANS_SPACING_MM * static_cast<float>(row);
      }
    }
  const Boards boards = standIn().now();
  const Point3 at = boards.places.at(number / 1000);
  const Quaternion q = boards.turns.at(number / 1000);
  // q (x, y, 0) q*
  const float tx = 2.0f * (-q.k * y), ty = 2.0f * (q.k * x), tz = 2.0f * (q.i * y - q.j * x);
  return {at.x + x + q.w * tx + q.j * tz - q.k * ty + boards.shift, at.y + y + q.w * ty + q.k * tx - q.i * tz,
          at.z + q.w * tz + q.i * ty - q.j * tx};
}

inline GainPtr AUTDGainNull() {
  const std::size_t boards = standIn().now().places.size();
  return {standIn().keep({{std::vector<Drive>(boards * NUM_TRANS_IN_UNIT, Drive{})}, {}, 0.0f})};
}

inline GainPtr AUTDGainCustom(const void* function, const void* context, GeometryPtr geometry) {
  using Fill = void (*)(const void*, GeometryPtr, std::uint16_t, std::uint8_t, Drive*);
  const auto fill = reinterpret_cast<Fill>(function);
  std::vector<Drive> drives;
  for (std::size_t board = 0; board < standIn().now().places.size(); ++board)
    for (std::uint32_t n = 0; n < NUM_TRANS_IN_UNIT; ++n)
      fill(context, geometry, static_cast<std::uint16_t>(board), static_cast<std::uint8_t>(n),
           &drives.emplace_back());
  return {standIn().keep({{drives}, {}, 0.0f})};
}

inline DatagramPtr AUTDGainIntoDatagram(GainPtr gain) {
  return {gain._0};
}

inline SamplingConfigWrap AUTDSamplingConfigFromFreq(float frequency) {
  return {frequency};
}
inline SamplingConfigWrap AUTDSamplingConfigIntoNearest(SamplingConfigWrap config) {
  return config;
}
inline SamplingConfigWrap AUTDSTMConfigFromFreqNearest(float frequency, std::uint16_t count) {
  return {frequency * static_cast<float>(count)};
}

inline GainSTMPtr AUTDSTMGain(SamplingConfigWrap config, const GainPtr* gains, std::uint16_t count,
                              GainSTMOption) {
  Datagram patterns;
  for (std::uint16_t k = 0; k < count; ++k)
    patterns.patterns.push_back(datagramOf(gains[k]._0).patterns.front());
  patterns.frequency = config.frequency;
  return {standIn().keep(patterns)};
}

inline DatagramPtr AUTDSTMGainIntoDatagram(GainSTMPtr patterns) {
  return {patterns._0};
}

inline ModulationPtr AUTDModulationCustom(const std::uint8_t* samples, std::uint16_t count,
                                          SamplingConfigWrap config) {
  return {standIn().keep({{}, {samples, samples + count}, config.frequency})};
}

inline DatagramPtr AUTDModulationIntoDatagram(ModulationPtr modulation) {
  return {modulation._0};
}

inline DatagramPtr AUTDDatagramSilencerFromCompletionSteps(FixedCompletionSteps) {
  return {standIn().keep({})};
}

inline SenderPtr AUTDSender(ControllerPtr, SenderOption) {
  return {nullptr};
}

inline ResultStatus AUTDSenderSend(SenderPtr, DatagramPtr datagram) {
  const Datagram& sent = datagramOf(datagram._0);
  bool good = false;
  standIn().change([&](Boards& boards) {
    good = boards.good;
    ++boards.sends;
    if (!good) return;
    if (!sent.modulation.empty()) {
      boards.modulation = sent.modulation;
      boards.sample_rate = sent.frequency;
    }
    if (!sent.patterns.empty()) boards.playing = sent;
  });
  if (!good) return {AUTDStatus::AUTDErr, sizeof lost - 1, lost};
  return {AUTDStatus::AUTDTrue, 0, nullptr};
}

}  // namespace autd3::native_methods
