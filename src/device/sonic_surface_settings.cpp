#include "device/sonic_surface_settings.h"

#include <stdexcept>

#include "device/options.h"
#include "device/sonic_surface_corrections.h"
#include "values/pose.h"

namespace tactile_clay::device::sonic_surface {
namespace {

/// What the user should know about the boards that the options name.
std::vector<std::string> remarksOn(const std::map<std::string, std::string>& options, Firmware firmware) {
  const auto given = [&](const char* key) { return options.count(key) > 0 && !options.at(key).empty(); };
  if (firmware != Firmware::tactile || given("corrections") || given("firmware_corrections")) return {};
  return {
      "sonic_surface: the tactile firmware as published adds phase corrections of its authors' board to "
      "what it is sent, which leave a tenth of the pressure on another board; expected "
      "firmware_corrections, the file with what yours adds, or none, or corrections of a calibration"};
}

}  // namespace

Settings settingsOf(const std::map<std::string, std::string>& options) {
  Settings settings;
  const auto port = options.find("port");
  if (port == options.end() || port->second.empty())
    throw std::runtime_error("sonic_surface: no port, expected the device file of a serial port");
  settings.path = port->second;
  settings.boards = boardsOf(options);
  settings.hold = holdOf(options, self);
  settings.wait = std::chrono::duration<double>(number(options, self, "wait", 0.0, 0.0, 600.0));
  settings.guarded = choice(options, self, "guard", "true", {"true", "false"}) == "true";
  Playable& array = settings.array;
  array.firmware = settings.boards.firmware;
  array.layout =
      layoutOf(settings.boards.count,
               values::poseOf(numbers(options, self, "second_board", {0.168, 0, 0, 0, 0, 0}, -10.0, 10.0)));
  array.acoustics.temperature =
      number(options, self, "temperature", array.acoustics.temperature, -20.0, 60.0);
  array.added = addedPhases(options, settings.boards.count);
  settings.remarks = remarksOn(options, array.firmware);
  return settings;
}

}  // namespace tactile_clay::device::sonic_surface
