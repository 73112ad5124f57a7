// The emulator of SonicSurface boards: bytes of the wire. Whatever came, silence afterwards silences all
// boards, which is what the driver relies on.
#include <cmath>
#include <cstdlib>

#include "device/sonic_surface_boards.h"
#include "device/sonic_surface_protocol.h"
#include "fuzz/fuzz.h"

namespace tactile_clay::fuzz {

std::vector<std::string> seeds() {
  using device::sonic_surface::Boards;
  using device::sonic_surface::Firmware;
  std::vector<std::string> all;
  for (const Boards& boards : {Boards{Firmware::stock, 1, 0}, Boards{Firmware::stock, 1, 1},
                               Boards{Firmware::stock, 2, 0}, Boards{Firmware::tactile, 1, 0}}) {
    ultrasound::Drive drive;
    drive.phase.assign(256 * boards.count, 1.0f);
    drive.amplitude.assign(256 * boards.count, 1.0f);
    for (const auto& bytes :
         {device::sonic_surface::frame(drive, boards), device::sonic_surface::silence(boards)})
      all.emplace_back(bytes.begin(), bytes.end());
  }
  return all;
}

}  // namespace tactile_clay::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactile_clay::device;
  using sonic_surface::Boards;
  using sonic_surface::Firmware;
  for (const Boards& boards :
       {Boards{Firmware::stock, 1, 0}, Boards{Firmware::stock, 2, 0}, Boards{Firmware::tactile, 1, 0}}) {
    SonicSurfaceBoards emulated(boards.count, boards.firmware == Firmware::tactile, boards.first);
    for (std::size_t i = 0; i < size; ++i) emulated.feed(data[i]);
    const auto drive = emulated.drive();
    if (drive.phase.size() != 256 * boards.count || !std::isfinite(emulated.modulation())) std::abort();
    for (const float phase : drive.phase)
      if (!std::isfinite(phase)) std::abort();
    for (const std::uint8_t byte : sonic_surface::silence(boards)) emulated.feed(byte);
    if (emulated.sounds() || emulated.may_sound()) std::abort();
  }
  return 0;
}
