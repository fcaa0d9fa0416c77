// SPDX-License-Identifier: Apache-2.0
#include "apps/bus_options.hpp"

#include "apps/flag_checks.hpp"

namespace voltlap::plant {
namespace {

constexpr double kPaceMin = 0.01, kPaceMax = 1000.0;
constexpr double kLostAfterMin_s = 0.2, kLostAfterMax_s = 3600.0;

}  // namespace

CLI::Option* BusOptions::add_interface(CLI::App& command) {
  return command.add_option("--bus", interface, "CAN interface, such as vcan0 (none here: ./voltlap with-vcan COMMAND)")
      ->type_name("IF")
      ->check(some_name("the name of a CAN interface"));
}

CLI::Option* BusOptions::add_realtime(CLI::App& command) {
  return command.add_flag("--realtime", realtime,
                          "Paced by the wall clock, without lockstep frames; late steps are reported");
}

void BusOptions::add_lockstep(CLI::App& command, CLI::Option* realtime_flag) {
  command.add_option("--pace", pace, "At most X times real time; default: as fast as the bus allows")
      ->type_name("X")
      ->check(number_between(kPaceMin, kPaceMax))
      ->excludes(realtime_flag);
  command.add_option("--lost-after", lost_after_s, "A node that has not answered for so long is lost [s of wall time]")
      ->type_name("S")
      ->check(number_between(kLostAfterMin_s, kLostAfterMax_s))
      ->excludes(realtime_flag)
      ->capture_default_str();
}

}  // namespace voltlap::plant
